//! Quantiles and exceedance probabilities of weighted samples, as re-weighting to another input law needs them.
//!
//! Weights are normalised by their sum. An interval takes the effective sample size (Kish, Survey Sampling 1965) for n,
//! so it is asymptotic and worth little where few samples carry the weight: read it beside that size.

use super::limit::{Interval, Limit};
use super::order_statistic::order_statistic_interval;
use super::proportion::share_limits;

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
    /// Woodruff's interval: quantiles at the confidence limits of p, the weight of failed samples at ±∞. A side that so
    /// many unweighted samples would not bound is open.
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

/// Valid values in ascending order with their share of the whole weight, and the share of the failed samples.
struct Shares {
    valid: Vec<(f64, f64)>,
    failed: f64,
    effective_samples: f64,
}

impl Shares {
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
        Some(Self {
            valid,
            failed: failed.iter().map(|(_, w)| w).sum(),
            effective_samples,
        })
    }

    /// Smallest valid value whose cumulative share reaches `level`; `None` outside (0, valid share].
    fn at(&self, level: f64) -> Option<f64> {
        let mut cumulative = 0.0;
        let slack = 1e-12;
        let reaches = |&&(_, w): &&(f64, f64)| {
            cumulative += w;
            cumulative >= level - slack
        };
        (level > 0.0)
            .then(|| self.valid.iter().find(reaches).map(|(v, _)| *v))
            .flatten()
    }
}

/// The p-quantile of weighted samples; a value that is not finite is a failed sample.
///
/// Shape: one weight per value. `None` without valid weight, for weights that are negative or not finite, or unless both
/// probabilities lie in (0, 1). Source: Woodruff, J. Amer. Statist. Assoc. 47 (1952) 635–646.
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
    let shares = Shares::of(values, weights)?;
    let n = shares.effective_samples;
    let (low, high) = share_limits(probability * n, (1.0 - probability) * n, confidence)?;
    // The limits of p alone would let the first and the last sample bound anything.
    let whole = (n + 1e-9).floor() as usize;
    let ((first, last), _) = order_statistic_interval(whole, probability, confidence)?;
    let bounded = |holds: bool, value: Option<f64>| match holds {
        true => value.into(),
        false => Limit::Unbounded,
    };
    Some(WeightedQuantile {
        probability,
        estimate: shares.at(probability * (1.0 - shares.failed))?,
        interval: Interval {
            lower: bounded(first > 0, shares.at(low - shares.failed)),
            upper: bounded(last <= whole, shares.at(high)),
        },
        effective_samples: n,
    })
}

/// P(value > threshold) of weighted samples, Clopper–Pearson with the effective sample size; a value that is not finite
/// is a failed sample.
///
/// Shape: one weight per value. `None` for weights that are negative, not finite or all zero, or with confidence outside
/// (0, 1). Source: Korn & Graubard, Survey Methodology 24 (1998) 193–201.
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
    let shares = Shares::of(values, weights)?;
    let n = shares.effective_samples;
    let above = shares.valid.iter().filter(|(v, _)| *v > threshold);
    let above: f64 = above.map(|(_, w)| w).sum();
    let limits = |p: f64| share_limits(p * n, (1.0 - p).max(0.0) * n, confidence);
    let valid = 1.0 - shares.failed;
    Some(WeightedExceedance {
        threshold,
        estimate: (valid > 0.0).then(|| above / valid),
        lower: limits(above)?.0,
        upper: limits((above + shares.failed).min(1.0))?.1,
        effective_samples: n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 50 equal weights bound the median on both sides, the 5 % quantile from above only and the 95 % one from below
    /// only, as 50 samples do. Seen to fail with the first sample as the lower limit of the 5 % quantile.
    #[test]
    fn sides_that_the_samples_do_not_bound_are_open() {
        let values: Vec<f64> = (0..50).map(f64::from).collect();
        for (p, sides) in [
            (0.05, [false, true]),
            (0.5, [true, true]),
            (0.95, [true, false]),
        ] {
            let interval = weighted_quantile(&values, &[0.02; 50], p, 0.95)
                .unwrap()
                .interval;
            let found = [interval.lower, interval.upper].map(|limit| limit.value().is_some());
            assert_eq!(found, sides, "{p}");
        }
    }
}
