//! Quantiles as order statistics, with distribution-free confidence intervals.
//!
//! The p-quantile of n values is x₍ₖ₎ with k = ⌈np⌉ (inverse of the empirical distribution function, type 1 of
//! Hyndman & Fan, "Sample quantiles in statistical packages", The American Statistician 50 (1996) 361–365).
//! It is always a value that was observed, and its confidence interval and failure bounds are ranks too.

use statrs::distribution::{Binomial, DiscreteCDF};

/// Finite values in ascending order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sorted(Vec<f64>);

impl Sorted {
    /// Sorts the finite ones of `values`; the caller counts the others as failed.
    #[must_use]
    pub fn finite(values: impl IntoIterator<Item = f64>) -> Self {
        let mut kept: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
        kept.sort_by(f64::total_cmp);
        Self(kept)
    }

    /// The values, ascending.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.0
    }

    /// The order statistic x₍ᵣₐₙₖ₎, 1-based; `None` outside 1..=n.
    #[must_use]
    pub fn order_statistic(&self, rank: usize) -> Option<f64> {
        self.0.get(rank.checked_sub(1)?).copied()
    }
}

/// A range with an open end where a limit is absent.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Interval {
    /// Lower limit; absent = not bounded by the samples.
    pub lower: Option<f64>,
    /// Upper limit; absent = not bounded by the samples.
    pub upper: Option<f64>,
}

/// A quantile with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct QuantileEstimate {
    /// Probability p of the quantile.
    pub probability: f64,
    /// x₍⌈np⌉₎.
    pub estimate: f64,
    /// Confidence interval; a limit is absent where n is too small for it.
    pub interval: Interval,
    /// 1-based ranks of the limits; 0 and n + 1 stand for absent limits.
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
    sorted.order_statistic(quantile_rank(sorted.0.len(), probability))
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
    let count = Binomial::new(probability, n as u64).ok()?;
    let tail = (1.0 - confidence) / 2.0;
    let lower = count.inverse_cdf(tail);
    let upper = count.inverse_cdf(1.0 - tail).min(n as u64) + 1;
    let below = if lower == 0 {
        0.0
    } else {
        count.cdf(lower - 1)
    };
    let coverage = count.cdf(upper - 1) - below;
    Some(((lower as usize, upper as usize), coverage))
}

/// The p-quantile with its confidence interval; `None` without values.
#[must_use]
pub fn quantile_estimate(
    sorted: &Sorted,
    probability: f64,
    confidence: f64,
) -> Option<QuantileEstimate> {
    let (ranks, coverage) = order_statistic_interval(sorted.0.len(), probability, confidence)?;
    Some(QuantileEstimate {
        probability,
        estimate: quantile(sorted, probability)?,
        interval: Interval {
            lower: sorted.order_statistic(ranks.0),
            upper: sorted.order_statistic(ranks.1),
        },
        ranks,
        coverage,
    })
}

#[cfg(test)]
mod tests {
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
        let few = Sorted::finite([3.0, 1.0, 2.0, 5.0, 4.0]);
        let q = quantile_estimate(&few, 0.5, 0.95).unwrap();
        assert_eq!((q.interval.lower, q.interval.upper), (None, None));
        assert_eq!((q.estimate, q.ranks), (3.0, (0, 6)));
        assert!((q.coverage - 1.0).abs() < 1e-12);
        for (n, first_rank) in [(58, 0), (59, 1)] {
            let (ranks, _) = order_statistic_interval(n, 0.05, 0.9).unwrap();
            assert_eq!(ranks.0, first_rank, "n = {n}");
        }
    }

    /// Coverage counted over all n and p must never be below what was asked for.
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
}
