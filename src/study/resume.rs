//! What a result folder holds of a run already.

use std::path::{Component, Path, PathBuf};

use super::output::OutputFolder;
use super::read::Study;
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use crate::Error;
use crate::ensemble::atlas::Atlas;
use crate::ensemble::outcome::{LevelOutcome, SampleOutcome};
use crate::ensemble::parts::{Difference, PartFolder, RunIdentity, StoredPart, samples_of};
use crate::ensemble::program::Program;
use crate::ensemble::resume::{StoredStudy, read_solved, read_study};
use crate::ensemble::store::read_samples;
use crate::ensemble::{Ensemble, Known};
use crate::file::{FileError, finish_placing};
use crate::report::run::{TABLES, require_unchanged};
use crate::report::{self, RunRecord};

/// Samples that need not be solved again.
pub(super) struct Resumed {
    /// The samples.
    pub known: Known,
    /// Who solved some of them, beside this program.
    pub other_programs: Vec<Program>,
    /// What a user should know, one line each.
    pub notes: Vec<String>,
}

impl Resumed {
    /// Takes over the samples of the results in `folder`, which the program `stored` wrote if it is another one.
    ///
    /// # Errors
    /// [`FileError`] if they cannot be read.
    pub(super) fn add_results(
        &mut self,
        folder: &Path,
        study: &Study,
        settings: &RunSettings,
        stored: Option<Program>,
    ) -> Result<(), FileError> {
        for (index, sample) in read_solved(folder, &study.design)? {
            if !settings.retry_failed || sample.outcome.is_solved() {
                self.known.entry(index).or_insert(sample);
            }
        }
        let before = RunRecord::of_folder(folder)?.provenance.other_programs;
        for program in before.into_iter().chain(stored) {
            if !self.other_programs.contains(&program) {
                self.other_programs.push(program);
            }
        }
        Ok(())
    }
}

/// The run that `study` makes in `folder` with this program.
///
/// # Errors
/// [`Error::File`] if a file of the study cannot be read.
pub(super) fn identity(study: &Study, folder: &OutputFolder) -> Result<RunIdentity, Error> {
    Ok(RunIdentity {
        study: stored_study(study, folder)?,
        files: study.file_records()?,
        program: Program::this(),
    })
}

/// The run whose whole results lie in `folder`.
///
/// # Errors
/// [`FileError`] if there are none, or a file was changed.
pub(super) fn identity_of_results(folder: &Path) -> Result<RunIdentity, FileError> {
    require_unchanged(folder)?;
    let record = RunRecord::of_folder(folder)?;
    let provenance = record.provenance;
    Ok(RunIdentity {
        study: read_study(folder)?,
        files: record.files,
        program: Program {
            version: provenance.version,
            commit: provenance.commit,
            instruction_set: provenance.instruction_set,
        },
    })
}

/// The samples in the parts of `folder`. A damaged part is left out.
///
/// # Errors
/// [`Error::Command`] if a part belongs to another run; [`Error::File`] if parts cannot be read or contradict each other.
pub(super) fn resumed(
    study: &Study,
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Result<Resumed, Error> {
    finish_placing(folder.path())?;
    let parts = PartFolder::of(folder.path());
    let (mut notes, mut other_programs) = (Vec::new(), Vec::new());
    let mut own: Vec<StoredPart> = Vec::new();
    for part in parts.list()? {
        match part {
            Ok(part) => {
                let other = accepted(identity, &part.identity, settings);
                let other = other.map_err(|difference| Error::Command {
                    path: parts.path().to_owned(),
                    message: refusal(&difference),
                })?;
                let new = other.filter(|program| !other_programs.contains(program));
                other_programs.extend(new);
                own.push(part);
            }
            Err(damaged) => notes.push(format!("{damaged}; its samples are solved again")),
        }
    }
    let mut known = samples_of(&own, &study.design)?;
    if settings.retry_failed {
        known.retain(|_, sample| sample.outcome.is_solved());
    }
    Ok(Resumed {
        known,
        other_programs,
        notes,
    })
}

/// Takes over the results in the folder that have a solution, where the others are to be solved again.
///
/// # Errors
/// [`Error::File`] if they cannot be read.
pub(super) fn add_solved_results(
    resumed: &mut Resumed,
    study: &Study,
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Result<(), Error> {
    let stored = identity_of_results(folder.path());
    let (true, Ok(stored)) = (settings.retry_failed, stored) else {
        return Ok(());
    };
    if let Ok(other) = accepted(identity, &stored, settings) {
        resumed.add_results(folder.path(), study, settings, other)?;
    }
    Ok(())
}

/// Whether samples of the run `other` may go into this one; if another program made them, which.
pub(super) fn accepted(
    identity: &RunIdentity,
    other: &RunIdentity,
    settings: &RunSettings,
) -> Result<Option<Program>, Difference> {
    match identity.difference(other) {
        None => Ok(None),
        Some(Difference::Program(program)) if settings.any_program => Ok(Some(program)),
        Some(difference) => Err(difference),
    }
}

/// Why parts are not taken over, and what to do.
pub(super) fn refusal(difference: &Difference) -> String {
    let program = match difference {
        Difference::Program(_) => ", take its samples over with --any-program",
        _ => "",
    };
    format!(
        "holds samples of {difference}: finish that run{program}, take another --output, or delete this folder with its samples"
    )
}

/// The outcomes of the whole results that lie in `folder`, if they are those of this run and nothing of them is to be solved again.
/// What cannot be read is replaced.
pub(super) fn whole_results(
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Option<Vec<SampleOutcome>> {
    let stored = identity_of_results(folder.path()).ok()?;
    accepted(identity, &stored, settings).ok()?;
    let samples = read_samples(&folder.path().join(TABLES[0])).ok()?;
    let done = !settings.retry_failed || samples.outcomes.iter().all(SampleOutcome::is_solved);
    done.then_some(samples.outcomes)
}

/// The result of a run whose whole results lie in `folder` already, with its report made anew; nothing if there are none.
///
/// # Errors
/// [`Error::Report`] if the report cannot be written.
pub(super) fn finished(
    study: &Study,
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Result<Option<RunResult>, Error> {
    let Some(outcomes) = whole_results(folder, identity, settings) else {
        return Ok(None);
    };
    let (summary, run) = report::render(folder.path())?;
    Ok(Some(RunResult {
        taken_over: outcomes.len() as u64,
        outcomes,
        summary,
        unfolded: study.unfolded(),
        stopping: run.record.stopping,
        notes: Vec::new(),
    }))
}

/// Refuses samples that this program and this model would not give again: the `first` one is solved anew.
pub(super) fn refuse_other_results(
    study: &Study,
    ensemble: &Ensemble,
    first: &SampleOutcome,
) -> Result<(), Error> {
    let (again, _) = ensemble.sample(0, &Atlas::default());
    let numbers = |outcome: &SampleOutcome| -> Vec<_> {
        let peak = |level: &LevelOutcome| level.peak.filter(|_| level.status.has_solution());
        let of = |level: &LevelOutcome| (level.status, peak(level), level.newton_iterations);
        outcome.levels.iter().map(of).collect()
    };
    if numbers(first) == numbers(&again) {
        return Ok(());
    }
    Err(Error::Command {
        path: study.path.clone(),
        message: "sample 0 solved again is not that of the results: the model's files, the program or the processor's \
                  instruction set has changed; `run` anew"
            .to_owned(),
    })
}

/// The study as it is stored with its samples. Its path is relative to the results wherever there is such a path, so that both
/// can move together.
fn stored_study(study: &Study, folder: &OutputFolder) -> Result<StoredStudy, Error> {
    let whole = |path: &Path| {
        let path = if path == Path::new("") {
            Path::new(".")
        } else {
            path
        };
        path.canonicalize()
            .map_err(|source| Error::file(path, source))
    };
    let from = relative(&whole(study.folder())?, &whole(folder.path())?);
    let path = from.join(study.path.file_name().unwrap_or_default());
    Ok(StoredStudy {
        text: study.text.clone(),
        path: path.to_string_lossy().into_owned(),
    })
}

/// The way from `start` to `path`, both without symbolic links; `path` itself where they have no root in common.
fn relative(path: &Path, start: &Path) -> PathBuf {
    let common = path.components().zip(start.components());
    let n = common.take_while(|(a, b)| a == b).count();
    if n == 0 {
        return path.to_owned();
    }
    let up = start.components().skip(n).map(|_| Component::ParentDir);
    up.chain(path.components().skip(n)).collect()
}
