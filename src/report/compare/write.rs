//! The files of a comparison.

use super::comparison::DesignComparison;
use super::page::render;
use crate::report::error::ReportError;
use crate::report::run::stored_run::StoredRun;
use crate::report::write::write_texts;
use std::path::Path;

/// Writes `comparison.json` and `comparison.html` of the compared `runs` into `folder`, both or none.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(
    folder: &Path,
    comparison: &DesignComparison,
    runs: &[StoredRun],
) -> Result<(), ReportError> {
    let json = serde_json::to_string_pretty(comparison)?;
    let page = render(comparison, runs)?;
    write_texts(
        folder,
        &[("comparison.json", json), ("comparison.html", page)],
    )?;
    Ok(())
}
