//! How many peaks were assessed by their Floquet multipliers, and how many of them are unstable.

use super::peaks::usable_peak;
use crate::ensemble::outcome::SampleOutcome;
use crate::hb::stability::assessment::MARGIN;
use serde::Serialize;

/// Peaks of one excitation level by their stability.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StabilityCounts {
    /// All peaks.
    pub peaks: usize,
    /// Peaks whose multipliers were computed.
    pub assessed: usize,
    /// Of these the unstable ones.
    pub unstable: usize,
    /// Largest modulus of a multiplier; absent where none was computed.
    pub largest_multiplier: Option<f64>,
}

impl StabilityCounts {
    /// Of level `i`.
    pub(in crate::report) fn of(outcomes: &[SampleOutcome], i: usize) -> Self {
        let mut counts = Self::default();
        for peak in outcomes.iter().filter_map(|o| usable_peak(&o.levels[i])) {
            counts.peaks += 1;
            let Some(modulus) = peak.multiplier_modulus() else {
                continue;
            };
            counts.assessed += 1;
            counts.unstable += usize::from(modulus > 1.0 + MARGIN);
            let largest = counts.largest_multiplier.unwrap_or(0.0);
            counts.largest_multiplier = Some(largest.max(modulus));
        }
        counts
    }

    /// The same of several levels together.
    pub(in crate::report) fn and(self, other: Self) -> Self {
        let largest = [self.largest_multiplier, other.largest_multiplier];
        Self {
            peaks: self.peaks + other.peaks,
            assessed: self.assessed + other.assessed,
            unstable: self.unstable + other.unstable,
            largest_multiplier: largest.into_iter().flatten().reduce(f64::max),
        }
    }
}
