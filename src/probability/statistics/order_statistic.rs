//! Quantiles as order statistics, with distribution-free confidence intervals.
//!
//! The p-quantile of n values is x₍ₖ₎ with k = ⌈np⌉ (inverse of the empirical distribution function, type 1 of
//! Hyndman & Fan, "Sample quantiles in statistical packages", The American Statistician 50 (1996) 361–365).
//! It is always a value that was observed, and its confidence interval and failure bounds are ranks too.

use super::limit::Interval;
use super::observed::{Observed, Sorted};
use crate::special::Binomial;

/// A quantile with its confidence interval and with what failed samples leave open.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct QuantileEstimate {
    /// Probability p of the quantile.
    pub probability: f64,
    /// x₍⌈np⌉₎ of the samples that did not fail.
    pub estimate: f64,
    /// Range of the estimate over all values that the failed samples could have had: the estimate itself without any.
    pub failure_bounds: Interval,
    /// Confidence interval, failed samples at −∞ for the lower and at +∞ for the upper limit.
    pub interval: Interval,
    /// 1-based ranks of the limits among all n samples; 0 and n + 1 stand for limits for which n is too small.
    pub ranks: (usize, usize),
    /// Probability with which the interval covers the quantile, not less than what was asked for.
    pub coverage: f64,
}

/// Rank ⌈np⌉ of the p-quantile, at least 1. The tiny slack keeps products such as 100 · 0.07 from rounding up.
#[must_use]
pub fn quantile_rank(n: usize, probability: f64) -> usize {
    ((n as f64 * probability - 1e-9).ceil() as usize).clamp(1, n.max(1))
}

/// The p-quantile x₍⌈np⌉₎; `None` without values.
#[must_use]
pub fn quantile(sorted: &Sorted, probability: f64) -> Option<f64> {
    sorted.order_statistic(quantile_rank(sorted.values().len(), probability))
}

/// Ranks (l, u) and coverage of the distribution-free confidence interval [x₍ₗ₎, x₍ᵤ₎] of the p-quantile.
///
/// P(x₍ₗ₎ ≤ q < x₍ᵤ₎) = P(l ≤ B < u) with B binomial(n, p); l is the α/2 quantile of B and u − 1 its 1 − α/2 quantile.
/// l = 0 and u = n + 1 stand for absent limits. `None` unless n > 0 and both probabilities lie in (0, 1).
///
/// Source: David & Nagaraja, Order Statistics, 3rd ed. 2003, section 7.1.
#[must_use]
pub fn order_statistic_interval(
    n: usize,
    probability: f64,
    confidence: f64,
) -> Option<((usize, usize), f64)> {
    let inside = |p: f64| p > 0.0 && p < 1.0;
    if n == 0 || !inside(probability) || !inside(confidence) {
        return None;
    }
    let count = Binomial::new(n, probability)?;
    let tail = (1.0 - confidence) / 2.0;
    let (lower, upper) = (count.lower_quantile(tail), count.upper_quantile(tail) + 1);
    let coverage = 1.0 - (count.fewer_than(lower) + count.at_least(upper));
    Some(((lower, upper), coverage))
}

/// The p-quantile with its confidence interval; `None` unless a sample is valid and both probabilities lie in (0, 1).
///
/// With n samples of which f failed, the limit of rank l is x₍ₗ₋f₎ and that of rank u is x₍ᵤ₎ of the valid ones.
#[must_use]
pub fn quantile_estimate(
    observed: &Observed,
    probability: f64,
    confidence: f64,
) -> Option<QuantileEstimate> {
    let n = observed.total();
    let (ranks, coverage) = order_statistic_interval(n, probability, confidence)?;
    let rank = quantile_rank(n, probability);
    let range = |(lower, upper)| Interval {
        lower: observed.lowest(lower),
        upper: observed.highest(upper),
    };
    Some(QuantileEstimate {
        probability,
        estimate: quantile(observed.valid(), probability)?,
        failure_bounds: range((rank, rank)),
        interval: range(ranks),
        ranks,
        coverage,
    })
}

#[cfg(test)]
mod tests {
    use super::super::limit::Limit;
    use super::*;

    /// Reference: exact binomial probabilities. Seen to fail with u = inverse_cdf(1 − α/2) without the + 1.
    #[test]
    fn confidence_ranks_match_the_binomial() {
        for (n, ranks, coverage) in [(1000, (936, 964), 0.9581), (10_000, (9457, 9543), 0.9515)] {
            let (found, achieved) = order_statistic_interval(n, 0.95, 0.95).unwrap();
            assert_eq!(found, ranks);
            assert!((achieved - coverage).abs() < 5e-5, "{achieved}");
        }
    }

    /// n = 5, p = 1/2: coverage of (1, 5) is 1 − 2/32, below 95 %, so both limits must be absent.
    /// First-order tolerance bound: 0.95ⁿ falls below 5 % at n = 59, so only then is the minimum a lower 95 % limit.
    /// Seen to fail with l − 1 in place of l.
    #[test]
    fn limits_are_absent_where_the_sample_is_too_small() {
        let few = Observed::of([3.0, 1.0, 2.0, 5.0, 4.0]);
        let q = quantile_estimate(&few, 0.5, 0.95).unwrap();
        assert_eq!(q.interval, Interval::UNBOUNDED);
        assert_eq!((q.estimate, q.ranks), (3.0, (0, 6)));
        assert!((q.coverage - 1.0).abs() < 1e-12);
        for (n, first_rank) in [(58, 0), (59, 1)] {
            let (ranks, _) = order_statistic_interval(n, 0.05, 0.9).unwrap();
            assert_eq!(ranks.0, first_rank, "n = {n}");
        }
    }

    /// Coverage counted over all n and p must never be below what was asked for. Seen to fail with the upper rank one less.
    #[test]
    fn coverage_is_never_below_the_confidence() {
        for n in 1..200 {
            for p in [0.05, 0.3, 0.5, 0.95, 0.999] {
                let (ranks, coverage) = order_statistic_interval(n, p, 0.95).unwrap();
                assert!(coverage >= 0.95, "n = {n}, p = {p}: {coverage}");
                assert!(ranks.0 < ranks.1 && ranks.1 <= n + 1, "{ranks:?}");
            }
        }
    }

    /// Reference: binomial tails by 45 digits of arithmetic (mpmath 1.4).
    ///
    /// Seen to fail with the binomial of `statrs` 0.19: it panics in the search for the ranks at (1e8, 0.95, 0.1), and the
    /// coverage is 2.9e-9 off at (1e8, 0.95, 0.95).
    #[test]
    fn ranks_of_many_samples_match_the_binomial() {
        let cases = [
            (
                1_000_000,
                0.5,
                0.95,
                (499_020, 500_981),
                0.950_121_031_347_632,
            ),
            (
                100_000_000,
                0.95,
                0.95,
                (94_995_728, 95_004_272),
                0.950_019_174_751_373,
            ),
            (
                100_000_000,
                0.95,
                0.1,
                (94_999_726, 95_000_275),
                0.100_227_892_466_717,
            ),
        ];
        for (n, p, confidence, ranks, coverage) in cases {
            let (found, achieved) = order_statistic_interval(n, p, confidence).unwrap();
            assert_eq!(found, ranks, "n = {n}, confidence {confidence}");
            assert!((achieved - coverage).abs() < 1e-11, "n = {n}: {achieved}");
        }
    }

    /// Seen to fail with ⌊np⌋.
    #[test]
    fn quantiles_are_order_statistics() {
        let sorted = Sorted::finite((1..=100).rev().map(f64::from));
        for (p, value) in [
            (0.05, 5.0),
            (0.07, 7.0),
            (0.5, 50.0),
            (0.951, 96.0),
            (1.0, 100.0),
        ] {
            assert_eq!(quantile(&sorted, p), Some(value), "p = {p}");
        }
        assert_eq!(quantile(&Sorted::default(), 0.5), None);
    }

    /// Seen to fail without the filter (NaN sorts last and becomes the 95 % quantile).
    #[test]
    fn non_finite_values_never_enter() {
        let sorted = Sorted::finite([f64::NAN, 2.0, f64::INFINITY, 1.0, -f64::NAN]);
        assert_eq!(sorted.values(), [1.0, 2.0]);
        assert_eq!(quantile(&sorted, 0.95), Some(2.0));
    }

    /// Bounds must equal the quantiles of the samples with failures replaced by ±1e300.
    /// Seen to fail with the rank ⌈n p⌉ of the valid samples alone.
    #[test]
    fn bounds_are_the_quantiles_of_imputed_samples() {
        let valid: Vec<f64> = (0..70).map(|i| f64::from((i * 37) % 70)).collect();
        for failed in [0, 1, 3, 20] {
            let imputed = |at: f64| {
                Sorted::finite(valid.iter().copied().chain(std::iter::repeat_n(at, failed)))
            };
            let observed = Observed::with_failed(Sorted::finite(valid.clone()), failed);
            for p in [0.05, 0.5, 0.95] {
                let bounds = quantile_estimate(&observed, p, 0.95)
                    .unwrap()
                    .failure_bounds;
                let known = |v: Option<f64>| Limit::from(v.filter(|v| v.abs() < 1e299));
                assert_eq!(bounds.lower, known(quantile(&imputed(-1e300), p)));
                assert_eq!(bounds.upper, known(quantile(&imputed(1e300), p)));
            }
        }
        let none = Observed::with_failed(Sorted::default(), 5);
        assert_eq!(quantile_estimate(&none, 0.5, 0.95), None);
    }

    /// n = 1000, p = 0.95, 30 failures: levels 920/970 to 950/970 of the valid samples. Seen to fail with the lower limit
    /// from the upper ends.
    #[test]
    fn thirty_failures_blur_the_upper_quantile() {
        let valid = Sorted::finite((1..=970).map(f64::from));
        let q = quantile_estimate(&Observed::with_failed(valid, 30), 0.95, 0.95).unwrap();
        assert_eq!(q.failure_bounds, Interval::between(920.0, 950.0));
        assert_eq!(q.estimate, 922.0);
    }
}
