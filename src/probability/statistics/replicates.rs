//! Means and quantiles from independent replicates of a quasi-random design.
//!
//! Points of one replicate are not independent, so their scatter over √n says nothing about the error; the scatter between
//! replicates does (Owen 1998). Few replicates know it badly: intervals take Student's factor for their number.

use super::limit::Interval;
use super::mean::{SampleMean, student};
use std::collections::BTreeMap;

/// Mean over all replicates with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ReplicateMean {
    /// Mean of the replicates' means.
    pub mean: f64,
    /// Standard deviation of the replicates' means over the root of their number.
    pub standard_error: f64,
    /// Confidence interval: the hull of Student's and of Hall's for skewed laws; unbounded with failed samples, which may have had any
    /// value.
    pub interval: Interval,
    /// Number of replicates.
    pub replicates: usize,
    /// Failed samples, which the mean does not know of.
    pub failed: usize,
}

/// Interval of a quantile from the scatter of replicates.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ReplicateQuantile {
    /// Probability of the quantile.
    pub probability: f64,
    /// Confidence interval, failed samples at −∞ for the lower and at +∞ for the upper limit.
    pub interval: Interval,
}

/// Mean with its error of values with the number of their replicate; `None` with fewer than two replicates.
///
/// A value that is not finite is a failed sample: counted, and left out of the mean, which has no bounds then. A replicate without any
/// other has no mean.
#[must_use]
pub fn replicate_mean(
    values: impl IntoIterator<Item = (u64, f64)>,
    confidence: f64,
) -> Option<ReplicateMean> {
    let mut sums: BTreeMap<u64, (f64, f64)> = BTreeMap::new();
    let mut failed = 0;
    for (replicate, value) in values {
        if !value.is_finite() {
            failed += 1;
            continue;
        }
        let (sum, count) = sums.entry(replicate).or_default();
        *sum += value;
        *count += 1.0;
    }
    let means: Vec<f64> = sums.values().map(|(sum, count)| sum / count).collect();
    if means.len() < 2 {
        return None;
    }
    let sample = SampleMean::of(&means);
    let (lower, upper) = sample.interval(confidence);
    Some(ReplicateMean {
        mean: sample.mean,
        standard_error: sample.error,
        interval: match failed {
            0 => Interval::between(lower, upper),
            _ => Interval::UNBOUNDED,
        },
        replicates: means.len(),
        failed,
    })
}

/// Interval of the p-quantile from values with the number of their replicate; `None` with fewer than two replicates, or
/// unless both probabilities lie in (0, 1).
///
/// All x at which the replicates' shares of values ≤ x have p in Student's interval of their mean. At a fixed x a share has
/// no bias, which a replicate's own quantile has. What one value more or less changes in the share of a replicate, half of
/// it to each side, is added: replicates that all round the same way show no scatter. Values that are not finite are failed
/// samples.
#[must_use]
pub fn replicate_quantile(
    values: impl IntoIterator<Item = (u64, f64)>,
    probability: f64,
    confidence: f64,
) -> Option<ReplicateQuantile> {
    let inside = |p: f64| p > 0.0 && p < 1.0;
    let mut places = BTreeMap::new();
    let (mut valid, mut failed, mut sizes) = (Vec::new(), Vec::new(), Vec::new());
    for (replicate, value) in values {
        let next = places.len();
        let place = *places.entry(replicate).or_insert(next);
        if place == sizes.len() {
            sizes.push(0.0);
            failed.push(0.0);
        }
        sizes[place] += 1.0;
        match value.is_finite() {
            true => valid.push((value, place)),
            false => failed[place] += 1.0,
        }
    }
    if sizes.len() < 2 || !inside(probability) || !inside(confidence) {
        return None;
    }
    valid.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    let level = Level {
        probability,
        factor: student(sizes.len() as f64 - 1.0, confidence),
        resolution: 0.5 / smallest,
        sizes,
    };
    let [first, last] = level.ranks(&valid, failed);
    let value = |rank: usize| valid.get(rank.checked_sub(1)?).map(|(v, _)| *v);
    Some(ReplicateQuantile {
        probability,
        interval: Interval {
            lower: first.and_then(value).into(),
            upper: last.and_then(|k| value(k + 1)).into(),
        },
    })
}

/// A probability against the shares of replicates.
struct Level {
    probability: f64,
    factor: f64,
    resolution: f64,
    sizes: Vec<f64>,
}

impl Level {
    /// First and last rank k, with all shares constant between value k and the next, at which the shares have the probability in
    /// their interval; `valid` are the ascending values with the places of their replicates, `failed` counts the others.
    fn ranks(&self, valid: &[(f64, usize)], failed: Vec<f64>) -> [Option<usize>; 2] {
        let (mut with, mut without) = (failed, vec![0.0; self.sizes.len()]);
        // Between value k and the next: all shares are constant.
        let (mut first, mut last) = (None, None);
        for k in 0..=valid.len() {
            if let Some((_, place)) = k.checked_sub(1).map(|k| valid[k]) {
                with[place] += 1.0;
                without[place] += 1.0;
            }
            // Within equal values there is no such place.
            let tied = k > 0 && valid.get(k).is_some_and(|next| next.0 == valid[k - 1].0);
            if tied {
                continue;
            }
            if first.is_none() && self.reached(&with) {
                first = Some(k);
            }
            if !self.passed(&without) {
                last = Some(k);
            }
        }
        [first, last]
    }

    /// Mean share of the counts, and half its interval.
    fn share(&self, counts: &[f64]) -> (f64, f64) {
        let shares = counts.iter().zip(&self.sizes).map(|(count, n)| count / n);
        let sample = SampleMean::of(&shares.collect::<Vec<_>>());
        (sample.mean, self.factor * sample.error + self.resolution)
    }

    /// Whether the share may be as large as the probability.
    fn reached(&self, counts: &[f64]) -> bool {
        let (mean, half) = self.share(counts);
        mean + half >= self.probability
    }

    /// Whether the share is surely larger than it.
    fn passed(&self, counts: &[f64]) -> bool {
        let (mean, half) = self.share(counts);
        mean - half > self.probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means 1, 2, 6: mean 3, variance 7, standard error √(7/3), Student's factor 4.3027 of 3 replicates for the lower limit;
    /// the upper one is that of skewed laws. Seen to fail with n in place of n − 1, and with the factor 1.96.
    #[test]
    fn means_of_unequal_replicates_by_hand() {
        let values = [
            (0, 0.5),
            (1, 2.0),
            (0, 1.5),
            (7, 6.0),
            (7, f64::NAN),
            (9, f64::NAN),
        ];
        let found = replicate_mean(values, 0.95).unwrap();
        assert_eq!((found.mean, found.replicates, found.failed), (3.0, 3, 2));
        assert_eq!(found.interval, Interval::UNBOUNDED, "failed samples");
        let solved = values.into_iter().filter(|(_, value)| value.is_finite());
        let found = replicate_mean(solved, 0.95).unwrap();
        assert_eq!((found.mean, found.replicates, found.failed), (3.0, 3, 0));
        let error = (7.0_f64 / 3.0).sqrt();
        assert!((found.standard_error - error).abs() < 1e-15);
        let [lower, upper] =
            [found.interval.lower, found.interval.upper].map(|l| l.value().unwrap());
        let half = 4.302_652_73 * error;
        assert!((lower - (3.0 - half)).abs() < 1e-6, "{lower}");
        assert!(upper > 3.0 + half, "{upper}");
        assert_eq!(replicate_mean([(3, 1.0), (3, 2.0)], 0.95), None);
    }

    /// Four replicates of the same eight values: the shares do not scatter, and the median lies where 3.5 to 4.5 of 8 are
    /// below, the 45 % quantile where 3.1 to 4.1 are. A failed sample may lie on either side. Seen to fail without the resolution of a share.
    #[test]
    fn quantile_of_equal_replicates() {
        let value = |replicate: u64, k: u32| (replicate, f64::from(k));
        let all = || (0..4).flat_map(|r| (1..9).map(move |k| value(r, k)));
        let found = replicate_quantile(all(), 0.5, 0.95).unwrap();
        assert_eq!(found.interval, Interval::between(4.0, 5.0));
        let found = replicate_quantile(all(), 0.45, 0.95).unwrap();
        assert_eq!(found.interval, Interval::between(4.0, 5.0));
        let holed = all().map(|(r, v)| (r, if v == 8.0 { f64::NAN } else { v }));
        let found = replicate_quantile(holed, 0.5, 0.95).unwrap();
        assert_eq!(found.interval, Interval::between(3.0, 5.0));
        assert_eq!(replicate_quantile([(1, 1.0), (1, 2.0)], 0.5, 0.95), None);
    }
}
