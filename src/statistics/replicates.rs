//! Error of a mean from independent replicates of a quasi-random design.
//!
//! Points of one replicate are not independent, so their scatter over √n says nothing about the error; the scatter of the
//! replicates' means does (Owen 1998).

use std::collections::BTreeMap;

/// Mean over all replicates and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ReplicateMean {
    /// Mean of the replicates' means.
    pub mean: f64,
    /// Standard deviation of the replicates' means over the root of their number.
    pub standard_error: f64,
    /// Number of replicates.
    pub replicates: usize,
    /// Failed samples, which neither number knows of.
    pub failed: usize,
}

/// Mean and standard error of values with the number of their replicate; `None` with fewer than two replicates.
///
/// A value that is not finite is a failed sample: counted, and left out. A replicate without any other has no mean.
#[must_use]
pub fn replicate_mean(values: impl IntoIterator<Item = (u64, f64)>) -> Option<ReplicateMean> {
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
    let n = means.len() as f64;
    if means.len() < 2 {
        return None;
    }
    let mean = means.iter().sum::<f64>() / n;
    let squares: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
    Some(ReplicateMean {
        mean,
        standard_error: (squares / (n - 1.0) / n).sqrt(),
        replicates: means.len(),
        failed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means 1, 2, 6: mean 3, variance 7, standard error √(7/3). Seen to fail with n in place of n − 1.
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
        let found = replicate_mean(values).unwrap();
        assert_eq!((found.mean, found.replicates, found.failed), (3.0, 3, 2));
        assert!((found.standard_error - (7.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(replicate_mean([(3, 1.0), (3, 2.0)]), None);
    }
}
