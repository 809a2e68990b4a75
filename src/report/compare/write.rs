//! The files of a comparison.

use super::comparison::DesignComparison;
use super::page::render;
use crate::file;
use crate::report::error::ReportError;
use crate::report::run::stored_run::StoredRun;
use std::io::Write;
use std::path::Path;

/// Writes `comparison.json` and `comparison.html` of the compared `runs` into `folder`, each whole or not at all.
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
    for (name, text) in [("comparison.json", json), ("comparison.html", page)] {
        file::replace(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(())
}
