//! The files of a report: `summary.json`, `report.json` and `report.html`.

use super::assessment::Assessment;
use super::error::ReportError;
use crate::file::{self, Content, FileError};
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

/// Writes `summary.json`, `report.json` and `report.html` into `folder`, all or none, and returns the summary.
///
/// Shape: every outcome, and the nominal one, has one record per level of the record.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(folder: &Path, input: &ReportInput) -> Result<Summary, ReportError> {
    let (summary, texts) = texts(input)?;
    let files: Vec<(&str, String)> = REPORT_FILES.into_iter().zip(texts).collect();
    write_texts(folder, &files)?;
    Ok(summary)
}

/// Writes files of `folder`, all or none: they say the same in numbers and on a page.
pub(super) fn write_texts(folder: &Path, files: &[(&str, String)]) -> Result<(), FileError> {
    let writers: Vec<_> = (files.iter())
        .map(|(_, text)| move |out: &mut dyn Write| out.write_all(text.as_bytes()))
        .collect();
    let mut contents: Vec<Content<'_>> = Vec::new();
    for ((name, _), writer) in files.iter().zip(&writers) {
        contents.push((name, writer));
    }
    file::replace_all(folder, &contents)?;
    Ok(())
}

/// Names of the report's files in `folder` that are not what this program makes of the tables there; absent ones among them.
///
/// # Errors
/// [`ReportError`] if tables or record cannot be read.
pub fn outdated(folder: &Path) -> Result<Vec<&'static str>, ReportError> {
    let run = StoredRun::read(folder)?;
    let (_, texts) = texts(&run.input())?;
    let differs = |(name, text): (&'static str, String)| {
        let there = file::read_bytes(&folder.join(name), text.len() as u64).ok();
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
