//! The parts of several folders put together, and the results made of them.

use std::path::Path;

use super::output::OutputFolder;
use super::progress::Progress;
use super::read::Study;
use super::run::run;
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use super::status::FolderStatus;
use crate::Error;
use crate::ensemble::parts::{PartFolder, RunIdentity};

/// Copies the parts in `folders` into those of `output` and makes the results there. Every sample must be in one of them.
///
/// # Errors
/// [`Error::Command`] if a folder has no parts, has parts of another run, or a sample is missing; [`Error::File`] on a damaged part,
/// or one that contradicts another; and those of [`run`].
pub fn merge(
    folders: &[&Path],
    output: &OutputFolder,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let refused = |path: &Path, message: String| Error::Command {
        path: path.to_owned(),
        message,
    };
    let target = PartFolder::of(output.path());
    let mut study: Option<(RunIdentity, Study)> = None;
    for folder in folders {
        let parts = PartFolder::of(folder).list()?;
        if parts.is_empty() {
            let message = "holds no parts of a run: `run --shard` or `run --only-atlas` write such";
            return Err(refused(folder, message.to_owned()));
        }
        for part in parts {
            let part = part?;
            let (identity, _) = match &study {
                Some(known) => known,
                None => {
                    let path = folder.join(&part.identity.study.path);
                    let own = Study::parse(&path, &part.identity.study.text)?;
                    study.insert((part.identity.clone(), own))
                }
            };
            if let Some(difference) = identity.difference(&part.identity) {
                let message = format!(
                    "holds samples of {difference} than {}: leave one of the two out",
                    folders[0].display()
                );
                return Err(refused(folder, message));
            }
            if *folder != output.path() {
                part.copy_to(target.path())?;
            }
        }
    }
    let Some((_, study)) = study else {
        return Err(refused(output.path(), "no folder was given".to_owned()));
    };
    let status = FolderStatus::of(output.path())?;
    if let Some(fault) = status.faults.first() {
        return Err(refused(output.path(), fault.clone()));
    }
    if let Some(unfinished) = status.unfinished.filter(|run| run.done < run.samples) {
        let message = format!(
            "{} of {} samples are there; {} are missing: solve their shards, or `run` the study with this --output",
            unfinished.done,
            unfinished.samples,
            unfinished.missing_in_words()
        );
        return Err(refused(output.path(), message));
    }
    run(&study, output, settings, progress)
}
