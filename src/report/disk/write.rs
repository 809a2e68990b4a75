//! The files of a disk.

use super::page::render;
use super::summary::DiskSummary;
use crate::report::error::ReportError;
use crate::report::run::stored_run::StoredRun;
use crate::report::write::write_texts;
use std::path::Path;

/// Name of the numbers of a disk.
pub const DISK_NUMBERS: &str = "disk.json";

/// Writes `disk.json` and `disk.html` into `folder`, both or none.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(folder: &Path, disk: &DiskSummary, runs: &[StoredRun]) -> Result<(), ReportError> {
    let json = serde_json::to_string_pretty(disk)?;
    let page = render(disk, runs)?;
    write_texts(folder, &[(DISK_NUMBERS, json), ("disk.html", page)])?;
    Ok(())
}
