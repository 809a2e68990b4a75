//! The engine orders of a tuned disk, from the results of their runs.

use std::path::Path;

use super::output::OutputFolder;
use crate::Error;
use crate::report::StoredRun;
use crate::report::disk::{self, DiskSummary};

/// Gathers the runs in `folders`, one per engine order of one disk, and writes `disk.json` and `disk.html` into `output`.
///
/// Nothing is solved. The runs must have the same sector, number of sectors, levels, random inputs and speeds, and an engine order each; their
/// tables must be those that they wrote.
///
/// # Errors
/// [`Error::Report`] if a folder holds no results; [`Error::Results`] on the first run that is not of the disk of the first of
/// them, or has the engine order of another; [`Error::File`] or [`Error::Report`] if the results cannot be written.
pub fn disk(folders: &[&Path], output: &OutputFolder) -> Result<DiskSummary, Error> {
    let read = |folder: &&Path| {
        let run = StoredRun::read(folder)?.without_search();
        // what decides is to be done in the folder of this order
        let folder = folder.display().to_string();
        Ok::<_, Error>(StoredRun { folder, ..run })
    };
    let runs: Vec<StoredRun> = folders.iter().map(read).collect::<Result<_, _>>()?;
    let refused = |place: usize, message: String| {
        Error::results(
            folders.get(place).map_or(output.path(), |folder| *folder),
            message,
        )
    };
    let summary = DiskSummary::of(folders, &runs).map_err(|(place, why)| refused(place, why))?;
    disk::write(output.path(), &summary, &runs)?;
    Ok(summary)
}
