//! How many curves have several solutions at one frequency, and how far the sweeps from both sides are then apart.

use crate::ensemble::outcome::{LevelOutcome, SweepRecord};
use crate::statistics::{Proportion, proportion};
use schemars::JsonSchema;
use serde::Serialize;

/// Samples with several solutions at some frequency of the band, at one excitation level. Known of samples with a curve only.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SeveralAnswers {
    /// Samples whose curve runs from one end of the band to the other.
    pub curves: usize,
    /// Those with several solutions at some frequency.
    pub several: usize,
    /// Their share, with confidence limits; absent without curves, and where the samples belong to outer points.
    pub share: Option<Proportion>,
    /// Widest range of frequencies with several solutions (Hz); absent where there is none.
    pub widest_hz: Option<f64>,
    /// Smallest ratio of the largest amplitudes that the two sweeps of a sample meet, the lower over the higher one; absent
    /// without curves.
    pub lowest_ratio: Option<f64>,
}

impl SeveralAnswers {
    /// Of the samples of one level; `population` tells whether they are draws of one population.
    pub(super) fn of(records: &[&LevelOutcome], population: bool, confidence: f64) -> Self {
        let sweeps = || records.iter().filter_map(|record| record.around.sweeps());
        let widths = || {
            sweeps()
                .filter_map(|s| s.several_hz)
                .map(|[low, high]| high - low)
        };
        let (curves, several) = (sweeps().count(), widths().count());
        let share = proportion(several, curves, confidence);
        Self {
            curves,
            several,
            share: share.filter(|_| population),
            widest_hz: widths().reduce(f64::max),
            lowest_ratio: sweeps().map(ratio).reduce(f64::min),
        }
    }

    /// `several answers on 3 of 30 curves`; nothing where curves have no share.
    pub(in crate::report) fn in_words(&self) -> String {
        match (self.curves, self.share) {
            (0, _) => "several answers not looked for: no curves".to_owned(),
            (_, None) => String::new(),
            (curves, Some(_)) => format!("several answers on {} of {curves} curves", self.several),
        }
    }
}

/// The lower over the higher of the largest amplitudes that both sweeps meet.
fn ratio(sweeps: &SweepRecord) -> f64 {
    let [a, b] = [sweeps.upward.amplitude_m, sweeps.downward.amplitude_m];
    a.min(b) / a.max(b)
}
