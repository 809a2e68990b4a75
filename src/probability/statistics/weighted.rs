//! Quantiles and exceedance probabilities of weighted samples, as re-weighting to another input law needs them.
//!
//! Weights are normalised by their sum. An interval takes for n what the share itself shows: p (1 − p) over its linearised
//! variance, so that a tail that carries the weight counts for the few samples that it has (Korn & Graubard 1998). The
//! sample that was not drawn is the danger. For each limit one observation more counts against it (as in Fay & Feuer 1997
//! for weighted Poisson counts), with the heaviest weight that twice as many samples would show, by the Pareto tail of the
//! weights (Hill 1975). With equal weights these are the limits of Clopper & Pearson.

use super::limit::Interval;
use crate::special::beta_quantile;

/// n_e = (Σw)² / Σw²; 0 unless the weights are finite, not negative and not all zero.
#[must_use]
pub fn effective_sample_size(weights: &[f64]) -> f64 {
    let sum: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let sound = weights.iter().all(|w| w.is_finite() && *w >= 0.0);
    if sound && squares > 0.0 {
        sum * sum / squares
    } else {
        0.0
    }
}

/// A quantile of weighted samples.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct WeightedQuantile {
    /// Probability of the quantile.
    pub probability: f64,
    /// Smallest valid value that the share p of the valid weight does not exceed.
    pub estimate: f64,
    /// Values at which the interval of P(result ≤ value) holds p, the weight of failed samples at ±∞.
    pub interval: Interval,
    /// Effective sample size n_e, failed samples included.
    pub effective_samples: f64,
}

/// An exceedance probability of weighted samples.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct WeightedExceedance {
    /// Threshold.
    pub threshold: f64,
    /// Share of the valid weight above the threshold; absent without valid weight.
    pub estimate: Option<f64>,
    /// Lower limit, failed samples as not exceeding.
    pub lower: f64,
    /// Upper limit, failed samples as exceeding.
    pub upper: f64,
    /// Effective sample size n_e, failed samples included.
    pub effective_samples: f64,
}

/// Weight of the samples that a share counts, within the weight of all.
#[derive(Debug, Clone, Copy)]
struct Share {
    /// Counted weight and the sum of its squares.
    yes: [f64; 2],
    /// The same of all samples.
    all: [f64; 2],
    /// Weight of an observation that is missing.
    missing: f64,
}

/// Where a share counts observations of unknown value: the failed samples, and the one that is missing.
#[derive(Debug, Clone, Copy)]
enum Unknown {
    Counted,
    NotCounted,
}

/// Shares of the weight below which rounding hides a sample.
const ROUNDING: f64 = 1e-12;

impl Share {
    /// Parameters of the beta law of the share with the missing observation.
    fn with_one_more(&self, missing: Unknown) -> [f64; 2] {
        let (h, [yes, yes_squares], [all, squares]) = (self.missing, self.yes, self.all);
        let [counted, not_counted] = match missing {
            Unknown::Counted => [1.0, 0.0],
            Unknown::NotCounted => [0.0, 1.0],
        };
        let p = (yes + h * counted) / (all + h);
        let counted_squares = yes_squares + h * h * counted;
        let others = (squares - yes_squares).max(0.0) + h * h * not_counted;
        let variance = (counted_squares * (1.0 - p).powi(2) + others * p * p) / (all + h).powi(2);
        let n = p * (1.0 - p) / variance;
        [p * n, (1.0 - p) * n]
    }

    /// Quantile of the beta law; `None` where it has none.
    fn quantile([yes, no]: [f64; 2], probability: f64) -> Option<f64> {
        let is_law = |v: f64| v.is_finite() && v > 0.0;
        (is_law(yes) && is_law(no)).then(|| beta_quantile(yes, no, probability))
    }

    fn lower(&self, tail: f64) -> Option<f64> {
        match self.yes[0] <= ROUNDING * self.all[0] {
            true => Some(0.0),
            false => Self::quantile(self.with_one_more(Unknown::NotCounted), tail),
        }
    }

    fn upper(&self, tail: f64) -> Option<f64> {
        match self.all[0] - self.yes[0] <= ROUNDING * self.all[0] {
            true => Some(1.0),
            false => Self::quantile(self.with_one_more(Unknown::Counted), 1.0 - tail),
        }
    }
}

/// Heaviest weight to be expected among twice as many samples: the heaviest of these times 2^ξ, with Hill's exponent ξ of
/// the tail of the weights, at most 1 (beyond, weights have no mean). With the heaviest weight itself the limits held the
/// truth in 87 to 92 % of the cases where a tail of the new law had hardly a sample.
fn heaviest_of_twice(weights: &[f64]) -> f64 {
    let mut positive: Vec<f64> = weights.iter().copied().filter(|w| *w > 0.0).collect();
    positive.sort_by(|a, b| b.total_cmp(a));
    let n = positive.len() as f64;
    // As many as for Pareto smoothed importance sampling: Vehtari et al., J. Mach. Learn. Res. 25 (2024) 72.
    let tail = (n / 5.0).min(3.0 * n.sqrt()) as usize;
    let (Some(heaviest), Some(start)) = (positive.first(), positive.get(tail)) else {
        return 0.0;
    };
    let above: f64 = positive[..tail].iter().map(|w| (w / start).ln()).sum();
    heaviest * (above / tail.max(1) as f64).min(1.0).exp2()
}

/// Valid values in ascending order with the weight up to each.
struct Weighted {
    valid: Vec<f64>,
    /// Weight and sum of squares of the first so many valid values. Shape: valid + 1.
    sums: Vec<[f64; 2]>,
    /// The same of the failed samples.
    failed: [f64; 2],
    missing: f64,
    effective_samples: f64,
}

impl Weighted {
    /// `None` for weights without an effective sample.
    fn of(values: &[f64], weights: &[f64]) -> Option<Self> {
        assert_eq!(values.len(), weights.len(), "one weight per sample");
        let effective_samples = effective_sample_size(weights);
        if effective_samples <= 0.0 {
            return None;
        }
        let sum: f64 = weights.iter().sum();
        let pairs = values.iter().zip(weights).map(|(&v, &w)| (v, w / sum));
        let (mut valid, failed): (Vec<_>, Vec<_>) = pairs.partition(|(v, _)| v.is_finite());
        valid.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let add = |sum: [f64; 2], w: f64| [sum[0] + w, sum[1] + w * w];
        let mut sums = vec![[0.0, 0.0]];
        for (i, (_, w)) in valid.iter().enumerate() {
            sums.push(add(sums[i], *w));
        }
        Some(Self {
            valid: valid.into_iter().map(|(v, _)| v).collect(),
            sums,
            failed: failed.iter().fold([0.0, 0.0], |sum, (_, w)| add(sum, *w)),
            missing: heaviest_of_twice(weights) / sum,
            effective_samples,
        })
    }

    /// Weight of the valid samples.
    fn valid_weight(&self) -> f64 {
        self.sums[self.valid.len()][0]
    }

    /// Share of the first `k` valid samples, and of the failed ones where these are counted.
    fn up_to(&self, k: usize, failed: Unknown) -> Share {
        let plus = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b + d];
        let yes = self.sums[k];
        Share {
            yes: match failed {
                Unknown::Counted => plus(yes, self.failed),
                Unknown::NotCounted => yes,
            },
            all: plus(self.sums[self.valid.len()], self.failed),
            missing: self.missing,
        }
    }

    /// Smallest valid value up to which the weight reaches `level`; `None` for a level beyond it.
    fn at(&self, level: f64) -> Option<f64> {
        let reached = self.sums.partition_point(|sum| sum[0] < level - ROUNDING);
        self.valid.get(reached.checked_sub(1)?).copied()
    }
}

/// The p-quantile of weighted samples; a value that is not finite is a failed sample.
///
/// Shape: one weight per value. The interval inverts that of P(result ≤ value). `None` without valid weight, for weights
/// that are negative or not finite, or unless both probabilities lie in (0, 1).
#[must_use]
pub fn weighted_quantile(
    values: &[f64],
    weights: &[f64],
    probability: f64,
    confidence: f64,
) -> Option<WeightedQuantile> {
    let inside = |p: f64| p > 0.0 && p < 1.0;
    if !inside(probability) || !inside(confidence) {
        return None;
    }
    let weighted = Weighted::of(values, weights)?;
    let tail = (1.0 - confidence) / 2.0;
    let steps: Vec<usize> = (0..=weighted.valid.len()).collect();
    // Between value k and the next, P(result <= value) is the share of the first k.
    let below = |k: &usize| {
        let upper = weighted.up_to(*k, Unknown::Counted).upper(tail);
        upper.is_some_and(|upper| upper < probability)
    };
    let not_above = |k: &usize| {
        let lower = weighted.up_to(*k, Unknown::NotCounted).lower(tail);
        lower.is_none_or(|lower| lower <= probability)
    };
    let first = steps.partition_point(below);
    let last = steps.partition_point(not_above);
    let value = |rank: usize| weighted.valid.get(rank.checked_sub(1)?).copied();
    Some(WeightedQuantile {
        probability,
        estimate: weighted.at(probability * weighted.valid_weight())?,
        interval: Interval {
            lower: value(first).into(),
            upper: value(last).into(),
        },
        effective_samples: weighted.effective_samples,
    })
}

/// P(value > threshold) of weighted samples with its interval; a value that is not finite is a failed sample.
///
/// Shape: one weight per value. `None` for weights that are negative, not finite or all zero, or with confidence outside
/// (0, 1). Sources: Korn & Graubard, Survey Methodology 24 (1998) 193–201; Fay & Feuer, Stat. Med. 16 (1997) 791–801.
#[must_use]
pub fn weighted_exceedance(
    values: &[f64],
    weights: &[f64],
    threshold: f64,
    confidence: f64,
) -> Option<WeightedExceedance> {
    if threshold.is_nan() || confidence <= 0.0 || confidence >= 1.0 {
        return None;
    }
    let weighted = Weighted::of(values, weights)?;
    let below = weighted.valid.partition_point(|v| *v <= threshold);
    let tail = (1.0 - confidence) / 2.0;
    let valid = weighted.valid_weight();
    let above = valid - weighted.sums[below][0];
    Some(WeightedExceedance {
        threshold,
        estimate: (valid > 0.0).then(|| (above / valid).clamp(0.0, 1.0)),
        lower: 1.0 - weighted.up_to(below, Unknown::Counted).upper(tail)?,
        upper: 1.0 - weighted.up_to(below, Unknown::NotCounted).lower(tail)?,
        effective_samples: weighted.effective_samples,
    })
}

#[cfg(test)]
mod tests {
    use super::super::observed::Observed;
    use super::super::order_statistic::quantile_estimate;
    use super::super::proportion::proportion;
    use super::*;
    use crate::special::{normal_cdf, normal_quantile};

    /// Of ten weights the largest two are the tail: 2 and 1 over 1 have ξ = ln 2/2; a weight of 100 would have 2.3, taken as 1.
    /// Weights of 0 are no part of it. Seen to fail with all weights as the tail, without the bound of ξ,
    /// and with the heaviest weight itself.
    #[test]
    fn missing_weight_by_hand() {
        let with = |first: f64| [vec![first], vec![1.0; 9], vec![0.0; 30]].concat();
        let two = heaviest_of_twice(&with(2.0));
        assert!((two - 2.0 * (2_f64.ln() / 2.0).exp2()).abs() < 1e-14);
        assert_eq!(heaviest_of_twice(&with(1.0)), 1.0);
        assert_eq!(heaviest_of_twice(&with(100.0)), 200.0);
        assert_eq!(heaviest_of_twice(&[0.0, 3.0]), 3.0);
    }

    /// A new law two deviations above that of 10 000 normal samples: few, light samples lie below the limit, and the beta law of their share
    /// has an exponent above 10⁷. Seen to fail with the quantile of `statrs` 0.19, which never ends.
    #[test]
    fn a_light_tail_has_limits() {
        let n = 10_000;
        let values: Vec<f64> = (0..n)
            .map(|i| normal_quantile((f64::from(i) + 0.5) / f64::from(n)))
            .collect();
        let weights: Vec<f64> = values.iter().map(|z| (2.0 * z).exp()).collect();
        for limit in [-3.0, -2.7] {
            let below = weighted_exceedance(&values, &weights, limit, 0.95).unwrap();
            let truth = normal_cdf(2.0 - limit);
            assert!(below.lower < truth && truth < below.upper, "{below:?}");
        }
    }

    /// Equal weights are samples without weights: the intervals are those of order statistics and of Clopper & Pearson,
    /// open sides and failed samples included. Seen to fail with the missing observation on the side of its limit.
    #[test]
    fn equal_weights_give_the_intervals_without_weights() {
        for (n, failed) in [(50, 0), (200, 0), (200, 3)] {
            let values: Vec<f64> = (0..n).map(|i| f64::from((i * 37) % n)).collect();
            let holed = |i: usize, v: f64| if i < failed { f64::NAN } else { v };
            let values: Vec<f64> = (0..).zip(values).map(|(i, v)| holed(i, v)).collect();
            let (observed, weights) = (Observed::of(values.clone()), vec![0.3; values.len()]);
            for p in [0.05, 0.5, 0.95] {
                let found = weighted_quantile(&values, &weights, p, 0.95).unwrap();
                let plain = quantile_estimate(&observed, p, 0.95).unwrap();
                assert_eq!(found.interval, plain.interval, "{n} {failed} {p}");
            }
            for limit in [-1.0, 20.0, 190.0, 1e3] {
                let found = weighted_exceedance(&values, &weights, limit, 0.95).unwrap();
                let yes = values.iter().filter(|v| **v > limit).count();
                let plain = |yes: usize| proportion(yes, values.len(), 0.95).unwrap();
                let differs = [
                    found.lower - plain(yes).lower,
                    found.upper - plain(yes + failed).upper,
                ];
                assert!(
                    differs.iter().all(|d| d.abs() < 1e-9),
                    "{limit} {differs:?}"
                );
            }
        }
    }
}
