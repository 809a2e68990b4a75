//! The parts of several folders put together, and the results made of them.

use std::path::Path;

use super::progress::Progress;
use super::resume::accepted;
use super::run::{check_folder, run};
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use super::session::unwritten;
use super::status::RunStatus;
use crate::Error;
use crate::ensemble::parts::{PartFolder, StoredPart};
use crate::study::output::OutputFolder;
use crate::study::settings::read::Study;

/// Copies the parts in `folders` into those of `output` and makes the results there. Every sample must be in one of them, or in a
/// part that is in `output` already; nothing is written before that is known.
///
/// # Errors
/// [`Error::Results`] if a folder has no parts, has a damaged part or parts of another run, a part contradicts another one, or a sample
/// is missing; and those of [`run`].
pub fn merge(
    folders: &[&Path],
    output: &OutputFolder,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let target = PartFolder::of(output.path());
    let mut parts = Vec::new();
    for folder in folders {
        let before = parts.len();
        add_parts(&mut parts, folder, settings, "leave one of the two out")?;
        if parts.len() == before {
            let message = "holds no parts of a run: `run --shard` or `run --only-atlas` write such";
            return Err(Error::results(folder, message));
        }
    }
    if !folders.contains(&output.path()) {
        let other = "take another --output, or delete what is there";
        add_parts(&mut parts, output.path(), settings, other)?;
    }
    let Some(first) = parts.first() else {
        return Err(Error::results(output.path(), "no folder was given"));
    };
    let path = folders[0].join(&first.identity.study.path);
    let study = Study::parse(&path, &first.identity.study.text)?;
    let there = RunStatus::of_parts(&study, &parts, None);
    let there = there.map_err(|fault| Error::results(output.path(), fault.to_string()))?;
    if there.done < there.samples {
        let message = format!(
            "{} of {} samples are there; {} are missing: solve their shards, then merge again",
            there.done,
            there.samples,
            there.missing_in_words()
        );
        return Err(Error::results(output.path(), message));
    }
    // a copy that the run then refuses would be in the way of the results there
    let replaced = check_folder(&study, output, settings)?;
    for part in &parts {
        if part.paths()[0].parent() != Some(target.path()) {
            part.copy_to(target.path()).map_err(unwritten)?;
        }
    }
    let result = run(&study, output, settings, progress)?;
    Ok(RunResult {
        notes: [replaced, result.notes].concat(),
        ..result
    })
}

/// Adds the parts in `folder`, all of the same run as those before; if they are not, `advice` says what to do.
fn add_parts(
    parts: &mut Vec<StoredPart>,
    folder: &Path,
    settings: &RunSettings,
    advice: &str,
) -> Result<(), Error> {
    for part in PartFolder::of(folder).list()? {
        let part = part.map_err(|fault| {
            let message = "copy it again, or delete it and solve its shard again";
            Error::results(folder, format!("{fault}: {message}"))
        })?;
        let first = parts.first().unwrap_or(&part);
        if let Err(difference) = accepted(&first.identity, &part.identity, settings) {
            let program = difference.advice_on_program(", or take it over with --any-program");
            let other = first.paths()[0].display();
            let message = format!("holds samples of {difference} than {other}: {advice}{program}");
            return Err(Error::results(folder, message));
        }
        parts.push(part);
    }
    Ok(())
}
