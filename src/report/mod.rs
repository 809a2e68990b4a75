//! What the designer reads: `summary.json` and `report.json` for programs, `report.html` for people.
//!
//! The page shows the numbers of [`Summary`] and [`Assessment`] and adds figures. A sample without a solution is counted, shown
//! and bounded, never dropped in silence. The page is one file: no network, no script.
//! Knows how results look, not how they were computed. Start reading in [`mod@summary`].

pub mod assessment;
mod axis;
mod block;
pub mod comparison;
mod comparison_page;
mod display;
pub mod epistemic;
pub mod error_budget;
mod figure;
pub mod ignorance;
pub mod judgement;
mod level_mark;
pub mod margins;
mod numerical_error;
pub mod over_box;
mod page;
pub mod population;
pub mod record;
pub mod requirement;
pub mod reweighting;
mod section;
pub mod sensitivity;
pub mod sentence;
pub mod stopping;
pub mod summary;
pub mod surrogate;
mod view;
pub mod worst_case;

pub use assessment::Assessment;
pub use record::{RunRecord, StoredRun};
pub use summary::Summary;

use crate::ensemble::outcome::{LevelOutcome, PeakRecord, SampleOutcome};
use crate::file::{self, FileError};
use crate::hb::Status;
use std::io::Write;
use std::path::Path;

/// Everything a report is made from.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// All of the run beside its samples.
    pub record: &'a RunRecord,
    /// The samples of the population, failed ones included.
    pub outcomes: &'a [SampleOutcome],
    /// The mixed samples of a pick-freeze design, for its indices alone.
    pub mixed: &'a [SampleOutcome],
    /// Tables of the run whose content has changed since.
    pub changed: &'a [String],
}

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file cannot be read back or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The numbers cannot be written as JSON.
    #[error("report: {0}")]
    Json(#[from] serde_json::Error),
    /// The page template is broken.
    #[error("report page: {0}")]
    Page(#[from] minijinja::Error),
}

/// Writes the report of the run in `folder` from its files alone, and returns the summary with the samples.
///
/// # Errors
/// [`ReportError`] if a file cannot be read or written.
pub fn render(folder: &Path) -> Result<(Summary, StoredRun), ReportError> {
    let run = StoredRun::read(folder)?;
    let summary = write(folder, &run.input())?;
    Ok((summary, run))
}

/// Writes `summary.json`, `report.json` and `report.html` into `folder`, each whole or not at all, and returns the summary.
///
/// Shape: every outcome, and the nominal one, has one record per level of the record.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(folder: &Path, input: &ReportInput) -> Result<Summary, ReportError> {
    let summary = Summary::of(input);
    let json = serde_json::to_string_pretty(&summary)?;
    let assessment = Assessment::of(input, &summary);
    let report = serde_json::to_string_pretty(&assessment)?;
    let page = page::render(input, &summary, &assessment)?;
    let files = [
        ("summary.json", json),
        ("report.json", report),
        ("report.html", page),
    ];
    for (name, text) in files {
        file::replace(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
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
