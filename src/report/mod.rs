//! What the designer reads: `summary.json` for programs and `report.html` for people.
//!
//! Both are made from the same [`Summary`]; the page adds figures. A sample without a solution is counted, shown
//! and bounded, never dropped in silence. The page is one file: no network, no script.
//! Knows how results look, not how they were computed. Start reading in [`mod@summary`].

mod axis;
mod display;
mod figure;
mod figures;
mod page;
pub mod summary;

pub use summary::Summary;

use crate::ensemble::backend::BackendReport;
use crate::ensemble::outcome::{CurvePoint, LevelOutcome, PeakRecord, SampleOutcome};
use crate::ensemble::store::{Provenance, replace_file};
use crate::hb::Status;
use std::io::Write;
use std::path::Path;

/// Everything a report is made from.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// Study, seed, version, law and settings.
    pub provenance: &'a Provenance,
    /// Names of the sampled inputs, in the order of [`SampleOutcome::inputs`].
    pub input_names: &'a [String],
    /// Excitation levels, in the order of [`SampleOutcome::levels`].
    pub levels: &'a [f64],
    /// Unit of the excitation levels, such as `N`.
    pub level_unit: &'a str,
    /// Resonance frequency without contact forces, nominal inputs (Hz).
    pub free_frequency_hz: f64,
    /// Resonance frequency with all contacts stuck, nominal inputs (Hz).
    pub stuck_frequency_hz: f64,
    /// Linear response without contact forces; amplitude per unit level. May be empty.
    pub free_curve: &'a [CurvePoint],
    /// Linear response with all contacts stuck, nominal inputs; amplitude per unit level. May be empty.
    pub stuck_curve: &'a [CurvePoint],
    /// Outcome at the nominal inputs, if computed.
    pub nominal: Option<&'a SampleOutcome>,
    /// The samples, failed ones included.
    pub outcomes: &'a [SampleOutcome],
    /// Wall time of the study (s).
    pub wall_time_s: f64,
    /// Who evaluated the contacts.
    pub backend: &'a BackendReport,
}

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The operating system refused.
    #[error("report: {0}")]
    File(#[from] std::io::Error),
    /// The page template is broken.
    #[error("report page: {0}")]
    Page(#[from] minijinja::Error),
}

/// Writes `summary.json` and `report.html` into `folder`, each whole or not at all, and returns the summary.
///
/// Shape: every outcome, and the nominal one, has one record per entry of `input.levels`.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(folder: &Path, input: &ReportInput) -> Result<Summary, ReportError> {
    let summary = Summary::of(input);
    let json = serde_json::to_string_pretty(&summary).map_err(std::io::Error::from)?;
    let page = page::render(input, &summary)?;
    for (name, text) in [("summary.json", json), ("report.html", page)] {
        replace_file(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(summary)
}

/// The peak of a level if it solves the balance equations and its numbers are finite.
fn usable_peak(level: &LevelOutcome) -> Option<PeakRecord> {
    let peak = level.peak.filter(|_| level.status.has_solution())?;
    let finite = peak.frequency_hz.is_finite() && peak.amplitude_m.is_finite();
    finite.then_some(peak)
}

/// The status under which a level is counted: a claimed solution without a usable peak is no solution.
fn counted_status(level: &LevelOutcome) -> Status {
    if level.status.has_solution() && usable_peak(level).is_none() {
        Status::NonFinite
    } else {
        level.status
    }
}
