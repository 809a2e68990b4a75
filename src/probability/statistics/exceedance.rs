//! Probability that a result exceeds a threshold.

use super::observed::Observed;
use super::proportion::{Share, share};

/// Probability of exceeding a threshold.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Exceedance {
    /// Threshold, in the unit of the result.
    pub threshold: f64,
    /// Samples above (yes), at or below (no) and failed or with the threshold in their enclosure (unknown), with the
    /// interval of P(result > threshold).
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
    let beyond = |ends: &[f64]| ends.len() - ends.partition_point(|&v| v <= threshold);
    let above = beyond(observed.lower_ends());
    let below = observed.valid().values().len() - beyond(observed.upper_ends());
    let unknown = observed.total() - above - below;
    let probability = share(above, below, unknown, confidence)?;
    Some(Exceedance {
        threshold,
        probability,
    })
}
