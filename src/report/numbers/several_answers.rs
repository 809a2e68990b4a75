//! How many curves have several solutions at one frequency, and how far the sweeps from both sides are then apart.

use super::outer_points::{nested, outer_groups};
use crate::ensemble::outcome::{SampleOutcome, SweepRecord};
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
    /// The outer point with the largest share; absent without outer points, and without curves.
    pub worst_point: Option<CurvesOfPoint>,
    /// Widest range of frequencies with several solutions (Hz); absent where there is none.
    pub widest_hz: Option<f64>,
    /// Smallest ratio of the largest amplitudes that the two sweeps of a sample meet, the lower over the higher one; absent
    /// without curves.
    pub lowest_ratio: Option<f64>,
}

/// Curves of one outer point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct CurvesOfPoint {
    /// Number of the outer point.
    pub outer: u64,
    /// Its samples whose curve runs from one end of the band to the other.
    pub curves: usize,
    /// Those with several solutions at some frequency.
    pub several: usize,
}

impl SeveralAnswers {
    /// Of the samples at level `i`.
    pub(in crate::report) fn of(outcomes: &[SampleOutcome], i: usize, confidence: f64) -> Self {
        let sweeps = || outcomes.iter().filter_map(|o| o.levels[i].around.sweeps());
        let widths = || {
            sweeps()
                .filter_map(|s| s.several_hz)
                .map(|[low, high]| high - low)
        };
        let (curves, several) = (sweeps().count(), widths().count());
        let share = proportion(several, curves, confidence);
        let of_points = outer_groups(outcomes).into_iter();
        let of_points = of_points.filter_map(|(outer, members)| {
            let sweeps = members
                .iter()
                .filter_map(|&s| outcomes[s].levels[i].around.sweeps());
            let several = sweeps.clone().filter(|s| s.several_hz.is_some()).count();
            Some(CurvesOfPoint {
                outer: outer?,
                curves: sweeps.count(),
                several,
            })
        });
        // of equal shares the first point
        let more = |most: CurvesOfPoint, next: CurvesOfPoint| match next.several * most.curves
            > most.several * next.curves
        {
            true => next,
            false => most,
        };
        Self {
            curves,
            several,
            share: share.filter(|_| !nested(outcomes)),
            worst_point: of_points.filter(|of| of.curves > 0).reduce(more),
            widest_hz: widths().reduce(f64::max),
            lowest_ratio: sweeps().map(ratio).reduce(f64::min),
        }
    }

    /// `several answers on 3 of 30 curves`.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self.worst_point {
            None => several_in_words(self.several, self.curves),
            Some(CurvesOfPoint {
                curves, several, ..
            }) => several_in_words(several, curves) + " of the worst outer point",
        }
    }
}

/// `several answers on 3 of 30 curves`.
pub(in crate::report) fn several_in_words(several: usize, curves: usize) -> String {
    match curves {
        0 => "several answers not looked for: no curves".to_owned(),
        curves => format!("several answers on {several} of {curves} curves"),
    }
}

/// The lower over the higher of the largest amplitudes that both sweeps meet.
fn ratio(sweeps: &SweepRecord) -> f64 {
    let [a, b] = [sweeps.upward.amplitude_m, sweeps.downward.amplitude_m];
    a.min(b) / a.max(b)
}
