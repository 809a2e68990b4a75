//! The binomial distribution, by the beta distribution: P(B ≥ k) = I_p(k, n − k + 1).

use super::beta_tails;

/// Relative difference below which two probabilities are equal but for rounding. Without it the quantile would be one of two
/// neighbours by chance where a tail is exactly what was asked for, as with p = 1/2.
pub const TIE: f64 = 1e-12;

/// Number of hits B in independent trials with the same probability of a hit.
///
/// Both tails come from p itself, not from 1 − p, which has lost digits of a small p. For up to 1e8 trials tails above 1e-9 are
/// off by less than 1e-11 of themselves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Binomial {
    trials: usize,
    hit: f64,
}

impl Binomial {
    /// So many trials with the probability `hit`; `None` unless it lies in [0, 1].
    #[must_use]
    pub fn new(trials: usize, hit: f64) -> Option<Self> {
        (0.0..=1.0).contains(&hit).then_some(Self { trials, hit })
    }

    /// P(B < k).
    #[must_use]
    pub(crate) fn fewer_than(&self, k: usize) -> f64 {
        let [fewer, _] = self.tails(k);
        fewer
    }

    /// P(B ≥ k).
    #[must_use]
    pub fn at_least(&self, k: usize) -> f64 {
        let [_, as_many] = self.tails(k);
        as_many
    }

    /// Least k with P(B ≤ k) ≥ `tail`: the quantile of that order.
    #[must_use]
    pub fn lower_quantile(&self, tail: f64) -> usize {
        self.least(|k| self.fewer_than(k + 1) >= tail * (1.0 - TIE))
    }

    /// Least k with P(B > k) ≤ `tail`: the quantile of the order 1 − `tail`, which is not rounded here.
    #[must_use]
    pub fn upper_quantile(&self, tail: f64) -> usize {
        self.least(|k| self.at_least(k + 1) <= tail * (1.0 + TIE))
    }

    /// P(B < k) and P(B ≥ k).
    fn tails(&self, k: usize) -> [f64; 2] {
        match k {
            0 => [0.0, 1.0],
            k if k > self.trials => [1.0, 0.0],
            k => {
                let [as_many, fewer] =
                    beta_tails(k as f64, (self.trials - k) as f64 + 1.0, self.hit);
                [fewer, as_many]
            }
        }
    }

    /// Least number of hits from which on `holds` is true; all hits if it never is.
    fn least(&self, holds: impl Fn(usize) -> bool) -> usize {
        let (mut least, mut enough) = (0, self.trials);
        while least < enough {
            let middle = usize::midpoint(least, enough);
            match holds(middle) {
                true => enough = middle,
                false => least = middle + 1,
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of C(n, j) pʲ (1 − p)ⁿ⁻ʲ over the numbers of hits j.
    fn sum(n: i32, p: f64, hits: impl Iterator<Item = i32>) -> f64 {
        let ways = |j: i32| (1..=j).fold(1.0, |w, i| w * f64::from(n + 1 - i) / f64::from(i));
        hits.map(|j| ways(j) * p.powi(j) * (1.0 - p).powi(n - j))
            .sum()
    }

    /// Each tail keeps its digits, also where it is 1e-236: its logarithm is rounded by 1e-13. Seen to fail with n − k in place
    /// of n − k + 1, and with the tails swapped.
    #[test]
    fn tails_are_the_sums_of_the_probabilities() {
        for n in [1, 2, 7, 59] {
            for p in [1e-4, 0.05, 0.5, 0.9, 0.999] {
                let hits = Binomial::new(n as usize, p).unwrap();
                for k in 0..=n + 1 {
                    let found = [hits.fewer_than(k as usize), hits.at_least(k as usize)];
                    let exact = [sum(n, p, 0..k), sum(n, p, k..n + 1)];
                    for (found, exact) in found.into_iter().zip(exact) {
                        let error = (found - exact).abs();
                        assert!(
                            error <= 1e-12 * exact,
                            "{n}, {p}, {k}: {found}, not {exact}"
                        );
                    }
                }
            }
        }
    }

    /// Seen to fail without the match of no hits and of more hits than trials.
    #[test]
    fn ends_are_exact() {
        for (p, always) in [(0.0, 0), (0.3, 0), (1.0, 10)] {
            let hits = Binomial::new(10, p).unwrap();
            assert_eq!((hits.fewer_than(0), hits.at_least(0)), (0.0, 1.0));
            assert_eq!((hits.fewer_than(11), hits.at_least(11)), (1.0, 0.0));
            assert_eq!((hits.fewer_than(always), hits.at_least(always)), (0.0, 1.0));
        }
        let never = Binomial::new(10, 0.0).unwrap();
        assert_eq!((never.fewer_than(1), never.at_least(1)), (1.0, 0.0));
        let none = Binomial::new(0, 0.3).unwrap();
        assert_eq!((none.fewer_than(1), none.lower_quantile(0.5)), (1.0, 0));
        assert!([-0.1, 1.1, f64::NAN].map(|p| Binomial::new(10, p)) == [None; 3]);
    }

    /// Trials, probability of a hit, k, P(B < k) and P(B ≥ k) by 45 digits of arithmetic (mpmath 1.4): the smaller tail as a sum
    /// of terms, each from the one before, the first by ln Γ. The probability of a hit is that of the floating-point number.
    const MANY: [(usize, f64, usize, [f64; 2]); 10] = [
        (
            1_000_000,
            0.5,
            500_000,
            [0.499_601_057_819_334_1, 0.500_398_942_180_665_9],
        ),
        (
            1_000_000,
            0.05,
            49_573,
            [0.024_795_629_737_508_336, 0.975_204_370_262_491_7],
        ),
        (
            100_000_000,
            0.5,
            50_000_000,
            [0.499_960_105_772_059_6, 0.500_039_894_227_940_4],
        ),
        (
            100_000_000,
            0.5,
            49_975_000,
            [2.865_027_884_829_888_5e-7, 0.999_999_713_497_211_5],
        ),
        (
            100_000_000,
            0.95,
            95_000_000,
            [0.499_881_019_277_013_8, 0.500_118_980_722_986_2],
        ),
        (
            100_000_000,
            0.95,
            95_010_000,
            [0.999_997_778_097_762_8, 2.221_902_237_189_648e-6],
        ),
        (
            100_000_000,
            1e-6,
            53,
            [9.411_949_450_115_556e-8, 0.999_999_905_880_505_5],
        ),
        (
            100_000_000,
            0.999_999,
            99_999_949,
            [0.999_999_952_001_485_6, 4.799_851_437_925_358_6e-8],
        ),
        (
            100_000_000,
            3e-8,
            1,
            [0.049_787_066_127_445_89, 0.950_212_933_872_554_1],
        ),
        (
            100_000_000,
            3e-8,
            12,
            [0.999_928_613_397_539_8, 7.138_660_246_017_135e-5],
        ),
    ];

    /// Seen to fail with the binomial of `statrs` 0.19: 0.500 79 in place of 0.499 60 at (1e6, 0.5, 500 000), and a probability of
    /// 1.54 at (1e8, 0.5, 5e7). With the continued fraction 8.17.22 of the Digital Library of Mathematical Functions: 1.3e-9
    /// off at (1e8, 3e-8, 1). With x (a + b) − a of two roundings: 4.6e-9 off at (1e8, 0.999999, 99 999 949).
    #[test]
    fn tails_of_many_trials() {
        for (n, p, k, exact) in MANY {
            let hits = Binomial::new(n, p).unwrap();
            let found = [hits.fewer_than(k), hits.at_least(k)];
            for (found, exact) in found.into_iter().zip(exact) {
                let error = (found / exact - 1.0).abs();
                assert!(error < 1e-11, "({n}, {p}, {k}): {found}, not {exact}");
            }
        }
    }

    /// The first k of all, by search. With p = 1/2 and an odd n the tail 1/2 is reached exactly: no rounding may move that.
    ///
    /// Seen to fail with k in place of k + 1, and without `TIE` (n = 5).
    #[test]
    fn quantiles_are_the_first_that_leave_the_tail() {
        for n in 1..60 {
            for (p, tail) in [
                (0.05, 0.025),
                (0.3, 0.1),
                (0.5, 0.5),
                (0.95, 0.025),
                (1.0, 0.5),
            ] {
                let hits = Binomial::new(n as usize, p).unwrap();
                let first = |holds: &dyn Fn(i32) -> bool| (0..=n).find(|k| holds(*k)).unwrap();
                let lower = first(&|k| sum(n, p, 0..k + 1) > tail - 1e-9);
                let upper = first(&|k| sum(n, p, k + 1..n + 1) < tail + 1e-9);
                let found = (hits.lower_quantile(tail), hits.upper_quantile(tail));
                assert_eq!(found, (lower as usize, upper as usize), "{n}, {p}");
            }
        }
    }
}
