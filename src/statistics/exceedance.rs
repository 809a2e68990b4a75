//! Probability that a result exceeds a threshold.

use super::observed::Observed;
use super::proportion::{Share, share};

/// Probability of exceeding a threshold.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Exceedance {
    /// Threshold, in the unit of the result.
    pub threshold: f64,
    /// Samples above (yes), at or below (no) and failed (unknown), with the interval of P(result > threshold).
    pub probability: Share,
}

/// P(result > threshold) with its Clopper–Pearson interval: failed samples count as not exceeding for the lower limit
/// and as exceeding for the upper one, so that a failure never lowers the probability.
///
/// `None` without samples, for a threshold that is NaN, or with confidence outside (0, 1).
#[must_use]
pub fn exceedance(observed: &Observed, threshold: f64, confidence: f64) -> Option<Exceedance> {
    if threshold.is_nan() {
        return None;
    }
    let values = observed.valid().values();
    let below = values.partition_point(|&v| v <= threshold);
    let probability = share(values.len() - below, below, observed.failed(), confidence)?;
    Some(Exceedance {
        threshold,
        probability,
    })
}
