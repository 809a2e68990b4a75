//! The peaks of the samples that count as solutions.

use crate::ensemble::outcome::{LevelOutcome, Maximum, PeakRecord, SampleOutcome};
use crate::hb::{ContactFractions, Status};
use crate::report::run::record::RunRecord;
use crate::statistics::{Sorted, moments};

/// The peak of a level if it solves the balance equations and its numbers are finite.
pub(in crate::report) fn usable_peak(level: &LevelOutcome) -> Option<PeakRecord> {
    let peak = level.solved_peak()?;
    let finite = peak.frequency_hz.is_finite() && peak.amplitude_m.is_finite();
    finite.then_some(peak)
}

/// The peak of a level if it may stand for the blade.
pub(in crate::report) fn trusted_peak(level: &LevelOutcome) -> Option<PeakRecord> {
    usable_peak(level).filter(|_| level.status.is_trusted())
}

/// Amplitude that a sweep meets over that of the peak from which on it is above the peak: three times the error of a curve.
const HIGHER: f64 = 1.01;

/// The largest amplitude that sweeps through the band meet, if it is above the peak and away from it by more than half the width of the
/// resonance: a maximum that was not found, or an end of the band. At the peak itself sweeps differ by the harmonics that they lack.
/// Where the peak is that of one mode, another one may be higher, and nothing is said.
pub(in crate::report) fn above_peak(record: &RunRecord, level: &LevelOutcome) -> Option<Maximum> {
    if record.provenance.peak_mode.is_some() {
        return None;
    }
    let (peak, sweeps) = (usable_peak(level)?, level.around.sweeps()?);
    let [up, down] = [sweeps.upward, sweeps.downward];
    let top = if up.amplitude_m > down.amplitude_m {
        up
    } else {
        down
    };
    let half_width = peak.damping_ratio.get().unwrap_or(0.0);
    let away = (top.frequency_hz / peak.frequency_hz - 1.0).abs() > half_width;
    (away && top.amplitude_m > HIGHER * peak.amplitude_m).then_some(top)
}

/// The status under which a level is counted: a claimed solution without a usable peak is no solution.
pub(super) fn counted_status(level: &LevelOutcome) -> Status {
    if level.status.has_solution() && usable_peak(level).is_none() {
        Status::NonFinite
    } else {
        level.status
    }
}

/// One value per sample at level `i`, NaN where it failed.
pub(in crate::report) fn values(
    outcomes: &[SampleOutcome],
    i: usize,
    value: impl Fn(&PeakRecord) -> f64,
) -> Vec<f64> {
    let of = |o: &SampleOutcome| usable_peak(&o.levels[i]).map_or(f64::NAN, |p| value(&p));
    outcomes.iter().map(of).collect()
}

/// Mean shares of the contact states at level `i` over the samples of one population; `None` without a solution.
pub(super) fn mean_fractions<'a>(
    outcomes: impl Iterator<Item = &'a SampleOutcome> + Clone,
    i: usize,
) -> Option<ContactFractions> {
    let mean = |value: fn(&PeakRecord) -> f64| {
        let of = |o: &SampleOutcome| Some(value(&usable_peak(&o.levels[i])?));
        moments(&Sorted::finite(outcomes.clone().filter_map(of))).map(|m| m.mean)
    };
    Some(ContactFractions {
        stick: mean(|p| p.stick_fraction)?,
        slip: mean(|p| p.slip_fraction)?,
        separated: mean(|p| p.separated_fraction)?,
    })
}
