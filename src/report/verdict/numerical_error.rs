//! The enclosures of the results that verdicts are judged on: what the solver may have wrong in each sample.
//!
//! Amplitude: the estimate of the harmonics left out, and the part of the work that the balance misses. Frequency: the place
//! of the peak, and the harmonics left out again (`peak_error`). Further lines of the error budget enter as they stand there, the amplitude
//! that a finer contact grid changes level by level; what nobody estimated is named, never 0.

use crate::ensemble::outcome::PeakRecord;
use crate::report::numbers::error_budget::{self, ErrorLine};
use crate::report::numbers::peak_error::{
    half_power_ratio, harmonics_shift, place_error, work_imbalance,
};
use crate::report::run::input::ReportInput;
use crate::statistics::Enclosed;

/// Errors of the peaks of a study.
#[derive(Debug, Clone)]
pub(in crate::report) struct NumericalErrors {
    /// Relative error of the place of a peak.
    place: f64,
    damping_ratio: Option<f64>,
    /// Lines that are the same for all peaks: frequency (Hz), amplitude (relative).
    common: [f64; 2],
    /// What a finer contact grid changes of the amplitude (relative), by level; empty where nobody estimated it.
    grid: Vec<f64>,
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
    pub(in crate::report) fn of(input: &ReportInput, budget: &[ErrorLine]) -> Self {
        let about_results =
            |line: &&ErrorLine| !error_budget::NO_NUMERICAL_ERROR.contains(&line.source);
        let lines: Vec<&ErrorLine> = budget.iter().filter(about_results).collect();
        let columns: [fn(&ErrorLine) -> Option<f64>; 2] =
            [|line| line.frequency_hz, |line| line.amplitude_relative];
        let shared = |line: &&&ErrorLine| !error_budget::OF_EACH_PEAK.contains(&line.source);
        let of_all_levels = |line: &&&ErrorLine| line.source != error_budget::CONTACT_GRID;
        let frequency = lines.iter().filter(shared).filter_map(|l| l.frequency_hz);
        let amplitude = lines.iter().filter(shared).filter(of_all_levels);
        let amplitude = amplitude.filter_map(|line| line.amplitude_relative);
        // who gives no budget, such as a comparison of designs on one grid, wants the errors of each peak alone
        let finer = input.record.finer_grid.as_ref();
        let finer = finer.filter(|_| !lines.is_empty());
        let unknown = |of: fn(&ErrorLine) -> Option<f64>| {
            let lines = lines.iter().filter(|line| of(line).is_none());
            lines.map(|line| line.source).collect()
        };
        Self {
            place: place_error(input.record),
            damping_ratio: half_power_ratio(&input.record.free),
            common: [frequency.sum(), amplitude.sum()],
            grid: finer.map_or(Vec::new(), |finer| {
                let changes = finer.amplitude_change.iter();
                changes.map(|change| change.unwrap_or(0.0).abs()).collect()
            }),
            not_estimated: columns.map(unknown),
        }
    }

    /// Sources of error that nobody estimated.
    pub(super) fn not_estimated(&self, result: Solved) -> &[&'static str] {
        &self.not_estimated[result as usize]
    }

    /// Ends of the frequency of a peak (Hz).
    pub(in crate::report) fn frequency(&self, peak: &PeakRecord) -> Enclosed {
        let harmonics = harmonics_shift(self.damping_ratio, peak).unwrap_or(0.0);
        let relative = self.place + harmonics;
        let error = relative * peak.frequency_hz + self.common[0];
        Enclosed {
            lower: peak.frequency_hz - error,
            value: peak.frequency_hz,
            upper: peak.frequency_hz + error,
        }
    }

    /// Ends of the amplitude of a peak at a level of this index (m).
    pub(in crate::report) fn amplitude(&self, level: usize, peak: &PeakRecord) -> Enclosed {
        let grid = self.grid.get(level).copied();
        let known = [peak.truncation_error.get(), work_imbalance(peak), grid];
        let relative = known.into_iter().flatten().sum::<f64>() + self.common[1];
        Enclosed {
            lower: peak.amplitude_m * (1.0 - relative).max(0.0),
            value: peak.amplitude_m,
            upper: peak.amplitude_m * (1.0 + relative),
        }
    }
}
