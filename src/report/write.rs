//! The files of a report: `summary.json`, `report.json` and `report.html`.

use super::assessment::Assessment;
use super::error::ReportError;
use crate::file;
use crate::report::numbers::summary::Summary;
use crate::report::page::document::study_page;
use crate::report::run::input::ReportInput;
use crate::report::run::stored_run::StoredRun;
use std::io::Write;
use std::path::Path;

/// The files of a report.
pub const REPORT_FILES: [&str; 3] = ["summary.json", "report.json", "report.html"];

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
    let (summary, texts) = texts(input)?;
    for (name, text) in REPORT_FILES.into_iter().zip(texts) {
        file::replace(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(summary)
}

/// Names of the report's files in `folder` that are not what this program makes of the tables there; absent ones among them.
///
/// # Errors
/// [`ReportError`] if tables or record cannot be read.
pub fn outdated(folder: &Path) -> Result<Vec<&'static str>, ReportError> {
    let run = StoredRun::read(folder)?;
    let (_, texts) = texts(&run.input())?;
    let differs = |(name, text): (&'static str, String)| {
        let there = std::fs::read(folder.join(name)).ok();
        (there.as_deref() != Some(text.as_bytes())).then_some(name)
    };
    let files = REPORT_FILES.into_iter().zip(texts);
    Ok(files.filter_map(differs).collect())
}

/// What stands in [`REPORT_FILES`], and the summary.
fn texts(input: &ReportInput) -> Result<(Summary, [String; 3]), ReportError> {
    let summary = Summary::of(input);
    let json = serde_json::to_string_pretty(&summary)?;
    let assessment = Assessment::of(input, &summary);
    let report = serde_json::to_string_pretty(&assessment)?;
    let page = study_page(input, &summary, &assessment)?;
    Ok((summary, [json, report, page]))
}
