//! How many curves have several solutions at one frequency, and how far the sweeps from both sides are then apart.

use super::outer_points::{nested, outer_groups};
use crate::ensemble::outcome::{SampleOutcome, SweepRecord};
use crate::page::display::count;
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
        let sweeps = outcomes.iter().filter_map(|o| o.levels[i].around.sweeps());
        let (curves, several) = counted(sweeps.clone());
        let ends = sweeps.clone().filter_map(|s| s.several_hz);
        Self {
            curves,
            several,
            share: proportion(several, curves, confidence).filter(|_| !nested(outcomes)),
            worst_point: worst_point(outcomes, i),
            widest_hz: ends.map(|[low, high]| high - low).reduce(f64::max),
            lowest_ratio: sweeps.map(ratio).reduce(f64::min),
        }
    }

    /// `several answers on 3 of 30 curves`; with outer points those of the worst one.
    #[must_use]
    pub fn in_words(&self) -> String {
        let (curves, several, of) = match self.worst_point {
            None => (self.curves, self.several, ""),
            Some(point) => (point.curves, point.several, " of the worst outer point"),
        };
        match curves {
            0 => "several answers not looked for: no curves".to_owned(),
            curves => format!(
                "several answers on {several} of {}{of}",
                count(curves, "curve")
            ),
        }
    }
}

/// Number of curves, and of those with several solutions at some frequency.
fn counted<'a>(sweeps: impl Iterator<Item = &'a SweepRecord>) -> (usize, usize) {
    sweeps.fold((0, 0), |(curves, several), sweeps| {
        (
            curves + 1,
            several + usize::from(sweeps.several_hz.is_some()),
        )
    })
}

/// The outer point with the largest share of several answers at level `i`; of equal shares the first.
fn worst_point(outcomes: &[SampleOutcome], i: usize) -> Option<CurvesOfPoint> {
    let of_point = |(outer, members): (Option<u64>, Vec<usize>)| {
        let records = members.iter().map(|&sample| &outcomes[sample].levels[i]);
        let (curves, several) = counted(records.filter_map(|level| level.around.sweeps()));
        let outer = outer.filter(|_| curves > 0)?;
        Some(CurvesOfPoint {
            outer,
            curves,
            several,
        })
    };
    let is_worse =
        |a: &CurvesOfPoint, b: &CurvesOfPoint| a.several * b.curves > b.several * a.curves;
    let points = outer_groups(outcomes).into_iter().filter_map(of_point);
    points.reduce(|worst, next| if is_worse(&next, &worst) { next } else { worst })
}

/// The lower over the higher of the largest amplitudes that both sweeps meet.
fn ratio(sweeps: &SweepRecord) -> f64 {
    let [a, b] = [sweeps.upward.amplitude_m, sweeps.downward.amplitude_m];
    a.min(b) / a.max(b)
}
