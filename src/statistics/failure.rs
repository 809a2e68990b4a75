//! What failed samples leave open: failure rate with confidence, and quantiles with failures at ±∞.

use super::quantile::{Interval, Sorted, quantile_rank};
use statrs::distribution::{Beta, ContinuousCDF};

/// Share of failed samples with its Clopper–Pearson confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FailureRate {
    /// failed / n.
    pub estimate: f64,
    /// Lower limit.
    pub lower: f64,
    /// Upper limit.
    pub upper: f64,
}

/// Failure rate of `failed` out of `n` samples; `None` unless n > 0, failed ≤ n and confidence in (0, 1).
///
/// Limits are beta quantiles, so the coverage is at least `confidence` for every true rate.
/// Source: Clopper & Pearson, Biometrika 26 (1934) 404–413.
#[must_use]
pub fn failure_rate(failed: usize, n: usize, confidence: f64) -> Option<FailureRate> {
    if n == 0 || failed > n || confidence <= 0.0 || confidence >= 1.0 {
        return None;
    }
    let tail = (1.0 - confidence) / 2.0;
    let (f, valid) = (failed as f64, (n - failed) as f64);
    let lower = match failed {
        0 => 0.0,
        _ => Beta::new(f, valid + 1.0).ok()?.inverse_cdf(tail),
    };
    let upper = match n - failed {
        0 => 1.0,
        _ => Beta::new(f + 1.0, valid).ok()?.inverse_cdf(1.0 - tail),
    };
    Some(FailureRate {
        estimate: f / n as f64,
        lower,
        upper,
    })
}

/// Range of the p-quantile over all values that the `failed` samples could have had.
///
/// With n samples in all, failures at −∞ give x₍⌈np⌉₋failed₎ of the valid ones, failures at +∞ give x₍⌈np⌉₎;
/// a rank without a valid sample leaves that side open. Without failures both limits are the quantile itself.
#[must_use]
pub fn quantile_bounds(valid: &Sorted, failed: usize, probability: f64) -> Interval {
    let rank = quantile_rank(valid.values().len() + failed, probability);
    Interval {
        lower: valid.order_statistic(rank.saturating_sub(failed)),
        upper: valid.order_statistic(rank),
    }
}

#[cfg(test)]
mod tests {
    use super::super::quantile::quantile;
    use super::*;
    use statrs::distribution::{Binomial, DiscreteCDF};

    /// Closed form: no failure in n gives the upper limit 1 − (α/2)^(1/n). Seen to fail with α in place of α/2.
    #[test]
    fn no_failure_has_the_closed_form_limit() {
        for n in [1, 10, 1000, 100_000] {
            let rate = failure_rate(0, n, 0.95).unwrap();
            let exact = -((0.025_f64).ln() / n as f64).exp_m1();
            assert_eq!((rate.estimate, rate.lower), (0.0, 0.0));
            assert!(
                (rate.upper / exact - 1.0).abs() < 1e-8,
                "n = {n}: {}",
                rate.upper
            );
            let all = failure_rate(n, n, 0.95).unwrap();
            assert!((all.lower - (1.0 - exact)).abs() < 1e-8 * all.lower.max(1e-3));
            assert_eq!(all.upper, 1.0);
        }
    }

    /// Defining property: at the limits the binomial tails are α/2 each. Seen to fail with Beta(f + 1, n − f + 1).
    #[test]
    fn limits_cut_the_binomial_tails() {
        for (failed, n) in [(1, 10), (30, 1000), (1, 100_000), (999, 1000)] {
            let rate = failure_rate(failed, n, 0.95).unwrap();
            let below = Binomial::new(rate.upper, n as u64)
                .unwrap()
                .cdf(failed as u64);
            let above = Binomial::new(rate.lower, n as u64)
                .unwrap()
                .sf(failed as u64 - 1);
            assert!((below - 0.025).abs() < 1e-6, "{failed}/{n}: {below}");
            assert!((above - 0.025).abs() < 1e-6, "{failed}/{n}: {above}");
        }
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
            for p in [0.05, 0.5, 0.95] {
                let bounds = quantile_bounds(&Sorted::finite(valid.clone()), failed, p);
                let known = |v: Option<f64>| v.filter(|v| v.abs() < 1e299);
                assert_eq!(bounds.lower, known(quantile(&imputed(-1e300), p)));
                assert_eq!(bounds.upper, known(quantile(&imputed(1e300), p)));
            }
        }
        let none = quantile_bounds(&Sorted::default(), 5, 0.5);
        assert_eq!((none.lower, none.upper), (None, None));
    }

    /// n = 1000, p = 0.95, 30 failures: levels 920/970 to 950/970 of the valid samples.
    #[test]
    fn thirty_failures_blur_the_upper_quantile() {
        let valid = Sorted::finite((1..=970).map(f64::from));
        let bounds = quantile_bounds(&valid, 30, 0.95);
        assert_eq!((bounds.lower, bounds.upper), (Some(920.0), Some(950.0)));
        assert_eq!(quantile(&valid, 0.95), Some(922.0));
    }
}
