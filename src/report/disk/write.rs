//! The files of a disk.

use super::page::render;
use super::summary::DiskSummary;
use crate::file;
use crate::report::error::ReportError;
use crate::report::run::stored_run::StoredRun;
use std::io::Write;
use std::path::Path;

/// Name of the numbers of a disk.
pub const DISK_NUMBERS: &str = "disk.json";

/// Writes `disk.json` and `disk.html` into `folder`, each whole or not at all.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(folder: &Path, disk: &DiskSummary, runs: &[StoredRun]) -> Result<(), ReportError> {
    let json = serde_json::to_string_pretty(disk)?;
    let page = render(disk, runs)?;
    for (name, text) in [(DISK_NUMBERS, json), ("disk.html", page)] {
        file::replace(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(())
}
