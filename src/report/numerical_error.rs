//! What the solver may have wrong in the result of one sample: the enclosures that verdicts are judged on.
//!
//! Amplitude: the estimate of the harmonics left out, and the part of the work that the balance misses. Frequency: the place
//! of the peak, and the harmonics left out again. A force that is missing changes the amplitude at resonance by the share e
//! if it acts in phase with the velocity; acting in phase with the displacement it moves the resonance by about e times
//! the half-power half-width, that is by e ζ of the frequency. ζ is that of the linear structure times input over viscous
//! work. Further lines of the error budget enter as they stand there; what nobody estimated is named, never 0.

use super::error_budget::{self, ErrorLine};
use super::input::ReportInput;
use super::record::RunRecord;
use crate::ensemble::outcome::{CurvePoint, PeakRecord};
use crate::statistics::Enclosed;

/// Errors of the peaks of a study.
#[derive(Debug, Clone)]
pub(super) struct NumericalErrors {
    frequency_tolerance: f64,
    damping_ratio: Option<f64>,
    /// Lines that are the same for all peaks: frequency (Hz), amplitude (relative).
    common: [f64; 2],
    not_estimated: [Vec<&'static str>; 2],
}

/// Results that a verdict may be about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Solved {
    /// Resonance frequency.
    Frequency,
    /// Amplitude at resonance.
    Amplitude,
}

impl NumericalErrors {
    /// Errors of the peaks of a study with the given budget.
    pub(super) fn of(input: &ReportInput, budget: &[ErrorLine]) -> Self {
        let about_results =
            |line: &&ErrorLine| !error_budget::NO_NUMERICAL_ERROR.contains(&line.source);
        let lines: Vec<&ErrorLine> = budget.iter().filter(about_results).collect();
        let columns: [fn(&ErrorLine) -> Option<f64>; 2] =
            [|line| line.frequency_hz, |line| line.amplitude_relative];
        let common = |of: fn(&ErrorLine) -> Option<f64>| {
            let shared = lines
                .iter()
                .filter(|l| !error_budget::OF_EACH_PEAK.contains(&l.source));
            shared.filter_map(|line| of(line)).sum()
        };
        let unknown = |of: fn(&ErrorLine) -> Option<f64>| {
            let lines = lines.iter().filter(|line| of(line).is_none());
            lines.map(|line| line.source).collect()
        };
        Self {
            frequency_tolerance: input.record.frequency_tolerance,
            damping_ratio: damping_ratio(input.record),
            common: columns.map(common),
            not_estimated: columns.map(unknown),
        }
    }

    /// Sources of error that nobody estimated.
    pub(super) fn not_estimated(&self, result: Solved) -> &[&'static str] {
        &self.not_estimated[result as usize]
    }

    /// Ends of the frequency of a peak (Hz).
    pub(super) fn frequency(&self, peak: &PeakRecord) -> Enclosed {
        let harmonics = harmonics_shift(self.damping_ratio, peak).unwrap_or(0.0);
        let relative = self.frequency_tolerance + harmonics;
        let error = relative * peak.frequency_hz + self.common[0];
        Enclosed {
            lower: peak.frequency_hz - error,
            value: peak.frequency_hz,
            upper: peak.frequency_hz + error,
        }
    }

    /// Ends of the amplitude of a peak (m).
    pub(super) fn amplitude(&self, peak: &PeakRecord) -> Enclosed {
        let known = [peak.truncation_error, work_imbalance(peak)];
        let relative = known.into_iter().flatten().sum::<f64>() + self.common[1];
        Enclosed {
            lower: peak.amplitude_m * (1.0 - relative).max(0.0),
            value: peak.amplitude_m,
            upper: peak.amplitude_m * (1.0 + relative),
        }
    }
}

/// Share of the input work that the balance misses; absent where there is no work.
pub(super) fn work_imbalance(peak: &PeakRecord) -> Option<f64> {
    let dissipated = peak.work_viscous_j + peak.work_friction_j;
    let imbalance = (peak.work_input_j - dissipated).abs() / peak.work_input_j.abs();
    imbalance.is_finite().then_some(imbalance)
}

/// Relative change of the frequency of a peak by the harmonics left out; absent where it cannot be estimated.
pub(super) fn harmonics_shift(damping_ratio: Option<f64>, peak: &PeakRecord) -> Option<f64> {
    let losses = peak.work_input_j / peak.work_viscous_j;
    let shift = peak.truncation_error? * damping_ratio? * losses;
    (shift.is_finite() && shift >= 0.0).then_some(shift)
}

/// Damping ratio of the linear structure without contacts: half-power half-width of its resonance over the frequency;
/// absent where the stored curve does not show both flanks.
pub(super) fn damping_ratio(record: &RunRecord) -> Option<f64> {
    let curve = &record.free.curve;
    let higher = |a: &usize, b: &usize| curve[*a].amplitude_m.total_cmp(&curve[*b].amplitude_m);
    let top = (0..curve.len()).max_by(higher)?;
    let level = curve[top].amplitude_m / 2f64.sqrt();
    let crossing = |[inner, outer]: [&CurvePoint; 2]| {
        let share = (inner.amplitude_m - level) / (inner.amplitude_m - outer.amplitude_m);
        (outer.amplitude_m < level)
            .then_some(inner.frequency_hz + share * (outer.frequency_hz - inner.frequency_hz))
    };
    let pair = |i: usize, j: usize| crossing([&curve[i], &curve[j]]);
    let below = (0..top).rev().find_map(|i| pair(i + 1, i))?;
    let above = (top + 1..curve.len()).find_map(|i| pair(i - 1, i))?;
    let ratio = 0.5 * (above - below) / curve[top].frequency_hz;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio)
}
