//! Performance curves: numbers of the resonance over the ratio of excitation to centrifugal load, sample by sample and as
//! fans.
//!
//! Excitation and load of a sample are its own: inputs may scale both. A sample is a line through its levels, straight on
//! logarithmic axes (so that it is the same line in damping ratio and Q factor) and interrupted where a level has no solution; the fan at a ratio has the quantiles of all
//! lines there.

use super::outer_points::{chosen, outer_groups};
use super::peaks::usable_peak;
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::report::run::input::ReportInput;
use crate::report::run::record::RunRecord;
use crate::sampling::Input;
use crate::statistics::{Sorted, hull, quantile};

/// Share of the samples whose lines reach the first and the last place of a fan, at least.
const REACHING: f64 = 0.95;

/// A number of a resonance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum Measure {
    /// Resonance frequency (Hz).
    Frequency,
    /// Amplitude over the excitation (m per unit level).
    AmplitudePerExcitation,
    /// Q factor 1 / (2 ζ).
    QFactor,
    /// Equivalent damping ratio ζ.
    DampingRatio,
}

impl Measure {
    /// All, in the order of the page.
    pub(in crate::report) const ALL: [Self; 4] = [
        Self::Frequency,
        Self::AmplitudePerExcitation,
        Self::QFactor,
        Self::DampingRatio,
    ];

    /// NaN where the peak does not have it.
    fn of(self, peak: &PeakRecord, excitation: f64) -> f64 {
        let ratio = peak.damping_ratio.get().unwrap_or(f64::NAN);
        match self {
            Self::Frequency => peak.frequency_hz,
            Self::AmplitudePerExcitation => peak.amplitude_m / excitation,
            Self::QFactor => q_factor(ratio),
            Self::DampingRatio => ratio,
        }
    }
}

/// Q factor of a damping ratio.
pub(in crate::report) fn q_factor(damping_ratio: f64) -> f64 {
    0.5 / damping_ratio
}

/// A line (ratio, number), ascending; NaN where a level has no solution.
pub(in crate::report) type Line = Vec<(f64, f64)>;

/// Quantiles of the lines at one ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) struct FanPlace {
    /// Ratio of excitation to centrifugal load; the excitation where the model has no such load.
    pub(in crate::report) ratio: f64,
    /// From the 5 % to the 95 % quantile; over outer points from the lowest to the highest.
    pub(in crate::report) outer: [f64; 2],
    /// From the 25 % to the 75 % quantile; over outer points from the lowest to the highest median.
    pub(in crate::report) inner: [f64; 2],
    /// Absent over outer points.
    pub(in crate::report) median: Option<f64>,
}

/// The ratio at one level for one sample.
#[derive(Debug, Clone, Copy)]
struct Loading {
    /// Excitation, in the unit of the levels.
    excitation: f64,
    ratio: f64,
}

/// Loading at `level` with the inputs of a sample; nominal where there are none.
fn loading(record: &RunRecord, inputs: &[f64], level: f64) -> Loading {
    let (mut excitation, mut load) = (level, record.static_load.map_or(1.0, |load| load.load_n));
    for (input, value) in record.inputs.iter().zip(inputs) {
        match (Input::of_column(&input.name), record.static_load) {
            (Some(Input::ExcitationScale), _) => excitation *= value,
            (Some(Input::StaticLoadScale), Some(_)) => load *= value,
            (Some(Input::StripThickness), Some(nominal)) => {
                load *= value / nominal.strip_thickness_mm;
            }
            _ => {}
        }
    }
    Loading {
        excitation,
        ratio: excitation / load,
    }
}

/// The line of a sample.
pub(in crate::report) fn line(
    record: &RunRecord,
    measure: Measure,
    sample: &SampleOutcome,
) -> Line {
    let point = |(i, level): (usize, &f64)| {
        let at = loading(record, &sample.inputs, *level);
        let peak = usable_peak(&sample.levels[i]);
        let value = peak.map_or(f64::NAN, |peak| measure.of(&peak, at.excitation));
        (at.ratio, value)
    };
    let mut line: Line = record.levels.iter().enumerate().map(point).collect();
    line.sort_by(|a, b| a.0.total_cmp(&b.0));
    line
}

/// The line at `ratio`; NaN beyond its ends and beside a level without a solution.
fn at(line: &[(f64, f64)], ratio: f64) -> f64 {
    let after = line.partition_point(|point| point.0 < ratio);
    match (after.checked_sub(1).map(|i| line[i]), line.get(after)) {
        (_, Some(&(x, value))) if x == ratio => value,
        (Some((low, a)), Some(&(high, b))) => {
            let share = libm::log(ratio / low) / libm::log(high / low);
            a * libm::exp(share * libm::log(b / a))
        }
        _ => f64::NAN,
    }
}

/// Ratios at which a fan is shown: the medians of the levels, the outermost ones moved inwards to where nearly all samples have
/// a line. Ascending; empty where the lines of the samples have no ratio in common.
fn places(input: &ReportInput) -> Vec<f64> {
    let record = input.record;
    let mut levels = record.levels.clone();
    levels.sort_by(f64::total_cmp);
    let last = levels.len().saturating_sub(1);
    let place = |(i, level): (usize, &f64)| {
        let ratios = input
            .outcomes
            .iter()
            .map(|o| loading(record, &o.inputs, *level).ratio);
        let share = match i {
            0 => REACHING,
            i if i == last => 1.0 - REACHING,
            _ => 0.5,
        };
        quantile(&Sorted::finite(ratios), share)
    };
    let found: Vec<f64> = levels.iter().enumerate().filter_map(place).collect();
    let (Some(&low), Some(&high)) = (found.first(), found.last()) else {
        return found;
    };
    let mut within: Vec<f64> = found
        .into_iter()
        .filter(|r| (low..=high).contains(r))
        .collect();
    within.dedup();
    within
}

/// The fan of all samples. Places without a solution are left out.
pub(in crate::report) fn fan(input: &ReportInput, measure: Measure) -> Vec<FanPlace> {
    let places = places(input);
    // the values at the places are fewer than the points of the lines
    let mut columns = vec![Vec::with_capacity(input.outcomes.len()); places.len()];
    for sample in input.outcomes {
        let line = line(input.record, measure, sample);
        for (values, ratio) in columns.iter_mut().zip(&places) {
            values.push(at(&line, *ratio));
        }
    }
    let groups = outer_groups(input.outcomes);
    let nested = groups.iter().any(|(outer, _)| outer.is_some());
    let place = |(ratio, values): (f64, Vec<f64>)| {
        let populations = groups
            .iter()
            .map(|(_, members)| Sorted::finite(chosen(&values, members)));
        let populations: Vec<Sorted> = populations.collect();
        let range = |p: f64| hull(populations.iter().filter_map(|all| quantile(all, p)));
        let from_to = |[low, high]: [f64; 2]| Some([range(low)?[0], range(high)?[1]]);
        let medians = range(0.5)?;
        Some(FanPlace {
            ratio,
            outer: from_to([0.05, 0.95])?,
            inner: if nested {
                medians
            } else {
                from_to([0.25, 0.75])?
            },
            median: (!nested).then_some(medians[0]),
        })
    };
    places.into_iter().zip(columns).filter_map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Straight on logarithmic axes, nothing beyond the ends and beside a gap, and the value itself at a point beside one.
    #[test]
    fn lines_are_straight_on_logarithmic_axes() {
        let line = [(1.0, 2.0), (4.0, 8.0), (16.0, f64::NAN), (64.0, 8.0)];
        for (ratio, expected) in [(1.0, 2.0), (2.0, 4.0), (4.0, 8.0), (64.0, 8.0)] {
            let found = at(&line, ratio);
            assert!((found - expected).abs() < 1e-12, "{ratio}: {found}");
        }
        for ratio in [0.5, 8.0, 16.0, 32.0, 65.0] {
            assert!(at(&line, ratio).is_nan(), "{ratio}");
        }
        assert!(at(&[], 1.0).is_nan(), "no line");
    }
}
