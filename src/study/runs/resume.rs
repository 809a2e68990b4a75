//! What a result folder holds of a run already.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use super::profile::{Profiler, RunStage};
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use crate::Error;
use crate::ensemble::atlas::Atlas;
use crate::ensemble::outcome::{LevelOutcome, SampleOutcome};
use crate::ensemble::parts::{
    Difference, Merged, MergedSource, PartFolder, RunIdentity, StoredPart,
};
use crate::ensemble::program::Program;
use crate::ensemble::runner::MOST_ANCHORS;
use crate::ensemble::store::{ATLAS_FILE, StoredStudy, read_indices, read_study};
use crate::ensemble::{Ensemble, Known};
use crate::file::{FileError, finish_placing};
use crate::report::run::{TABLES, require_unchanged};
use crate::report::{self, RunRecord};
use crate::study::output::OutputFolder;
use crate::study::settings::read::Study;

/// Samples that need not be solved again.
#[derive(Default)]
pub(in crate::study) struct Resumed {
    /// The samples.
    pub known: Known,
    /// Sample 0, if it is among them.
    pub first: Option<SampleOutcome>,
    /// Where they stand: whole results, and parts.
    results: Vec<MergedSource>,
    parts: Vec<MergedSource>,
    /// Parts whose hashes were compared.
    compared: Vec<StoredPart>,
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
    pub(in crate::study) fn add_results(
        &mut self,
        folder: &Path,
        study: &Study,
        settings: &RunSettings,
        stored: Option<Program>,
    ) -> Result<(), FileError> {
        let results = results_source(folder);
        let stood = read_indices(&results.paths[0])?;
        let before = RunRecord::of_folder(folder)?.provenance.other_programs;
        self.add_programs(before.into_iter().chain(stored));
        self.results.push(results);
        self.add(stood, study, settings)
    }

    fn add_programs(&mut self, programs: impl Iterator<Item = Program>) {
        for program in programs {
            if !self.other_programs.contains(&program) {
                self.other_programs.push(program);
            }
        }
    }

    /// Takes over the samples that stand in the sources, each with whether it has a solution.
    fn add(
        &mut self,
        stood: Vec<(u64, bool)>,
        study: &Study,
        settings: &RunSettings,
    ) -> Result<(), FileError> {
        let mut twice = false;
        for (index, solved) in stood {
            if solved || !settings.retry_failed {
                twice |= !self.known.indices.insert(index);
            }
        }
        let mut samples = self.samples(study);
        while let Some(sample) = samples.take()? {
            let index = sample.outcome.index;
            // what stands twice must be the same, which is compared on the way
            if index >= MOST_ANCHORS && !twice {
                break;
            }
            if !self.known.indices.contains(&index) {
                continue;
            }
            self.known
                .anchors
                .extend(sample.anchor.map(|anchor| (index, anchor)));
            if index == 0 {
                self.first = Some(sample.outcome);
            }
        }
        Ok(())
    }

    /// All samples that stand in results and parts, ascending.
    pub(super) fn samples<'d>(&self, study: &'d Study) -> Merged<'d> {
        let sources = self.results.iter().chain(&self.parts);
        Merged::new(sources.cloned().collect(), &study.design)
    }

    /// The outcomes of the samples 0 ... `samples` - 1 of them.
    ///
    /// # Errors
    /// [`FileError`] if a table cannot be read.
    pub(super) fn outcomes(
        &self,
        study: &Study,
        samples: u64,
    ) -> Result<Vec<SampleOutcome>, FileError> {
        let (mut outcomes, mut all) = (Vec::new(), self.samples(study));
        while let Some(sample) = all.take()? {
            if sample.outcome.index >= samples {
                break;
            }
            outcomes.push(sample.outcome);
        }
        Ok(outcomes)
    }

    /// The tables of samples of the parts that were read.
    pub(super) fn tables(&self) -> BTreeSet<PathBuf> {
        let tables = self.compared.iter().map(|part| part.paths()[0].clone());
        tables.collect()
    }

    /// Forgets all but where the samples stand: the report of a million samples has the memory.
    pub(super) fn forget(&mut self) {
        self.known = Known::default();
        self.compared = Vec::new();
    }

    /// Looks again which samples stand in results and in the parts of `folder`. Somebody may have deleted or damaged some.
    ///
    /// # Errors
    /// As [`resumed`].
    pub(super) fn look_again(
        &mut self,
        folder: &PartFolder,
        identity: &RunIdentity,
        settings: &RunSettings,
    ) -> Result<(), Error> {
        let mut stood = self.list_parts(folder, identity, settings)?;
        for results in &self.results {
            stood.extend(read_indices(&results.paths[0])?);
        }
        self.known.indices = stood.into_iter().map(|(index, _)| index).collect();
        Ok(())
    }

    /// Notes that so many samples were solved and are in no part that can be used.
    pub(super) fn say_missing(&mut self, samples: u64) {
        let parts = "parts that were deleted or damaged during the run";
        self.notes.push(format!(
            "{samples} samples stood in {parts}, and are solved again"
        ));
    }

    /// Notes the parts of `folder` as they are now, and gives their samples, each with whether it has a solution. A damaged part is
    /// left out. Each part is hashed once, unless its files were changed.
    fn list_parts(
        &mut self,
        folder: &PartFolder,
        identity: &RunIdentity,
        settings: &RunSettings,
    ) -> Result<Vec<(u64, bool)>, Error> {
        let mut stood = Vec::new();
        self.parts.clear();
        let compared = std::mem::take(&mut self.compared);
        for part in folder.list_again(compared)? {
            match part {
                Ok(part) => {
                    let other = accepted_part(folder, &part, identity, settings)?;
                    self.add_programs(other.into_iter());
                    self.parts.push(MergedSource::of(&part));
                    stood.extend(&part.samples);
                    self.compared.push(part);
                }
                Err(damaged) => {
                    let note = format!("{damaged}; its samples are solved again");
                    if !self.notes.contains(&note) {
                        self.notes.push(note);
                    }
                }
            }
        }
        Ok(stood)
    }
}

/// The tables of whole results.
pub(super) fn results_source(folder: &Path) -> MergedSource {
    let [samples, curves] = TABLES;
    MergedSource {
        paths: [samples, curves, ATLAS_FILE].map(|name| folder.join(name)),
        first: 0,
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
pub(in crate::study) fn identity_of_results(folder: &Path) -> Result<RunIdentity, FileError> {
    require_unchanged(folder)?;
    stated_identity(folder)
}

/// The same as the results say it, whether or not a file was changed.
pub(super) fn stated_identity(folder: &Path) -> Result<RunIdentity, FileError> {
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
/// [`Error::Results`] if a part belongs to another run; [`Error::File`] if parts cannot be read or contradict each other.
pub(super) fn resumed(
    study: &Study,
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Result<Resumed, Error> {
    finish_placing(folder.path())?;
    let mut resumed = Resumed::default();
    let stood = resumed.list_parts(&PartFolder::of(folder.path()), identity, settings)?;
    resumed.add(stood, study, settings)?;
    Ok(resumed)
}

/// The identity of complete results as if their study had asked what that of `identity` asks, and whether it asked other things.
pub(in crate::study) fn as_asked(
    identity: &RunIdentity,
    stored: RunIdentity,
) -> (RunIdentity, bool) {
    match identity.has_other_requirements(&stored) {
        false => (stored, false),
        true => {
            let study = identity.study.clone();
            (RunIdentity { study, ..stored }, true)
        }
    }
}

/// Takes samples of this run over from complete results in the folder: all of them where only the questions of the study changed, and
/// those with a solution where the others are to be solved again.
///
/// # Errors
/// [`Error::File`] if they cannot be read.
pub(super) fn add_results_there(
    resumed: &mut Resumed,
    study: &Study,
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Result<(), Error> {
    let Ok(stored) = identity_of_results(folder.path()) else {
        return Ok(());
    };
    let (stored, asked_other) = as_asked(identity, stored);
    if let Ok(other) = accepted(identity, &stored, settings)
        && (asked_other || settings.retry_failed)
    {
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

/// The same of a part in `folder`.
///
/// # Errors
/// [`Error::Results`] if its samples may not: why, and what to do.
pub(super) fn accepted_part(
    folder: &PartFolder,
    part: &StoredPart,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> Result<Option<Program>, Error> {
    let refused = |difference: Difference| {
        let program = difference.advice_on_program(", take its samples over with --any-program");
        let message = format!(
            "holds samples of {difference}: finish that run{program}, take another --output, or delete this folder with its samples"
        );
        Error::results(folder.path(), message)
    };
    accepted(identity, &part.identity, settings).map_err(refused)
}

/// Why whole results are not taken over, and what to do.
pub(in crate::study) fn results_refusal(difference: &Difference) -> String {
    let program = difference.advice_on_program(", or take them over with --any-program");
    format!("are results of {difference}: `run` anew{program}")
}

/// Whether the whole results of this run lie in `folder`, and nothing of them is to be solved again. What cannot be read is replaced.
pub(super) fn has_results(
    folder: &OutputFolder,
    identity: &RunIdentity,
    settings: &RunSettings,
) -> bool {
    let whole = || {
        let stored = identity_of_results(folder.path()).ok()?;
        accepted(identity, &stored, settings).ok()?;
        let samples = read_indices(&folder.path().join(TABLES[0])).ok()?;
        Some(!settings.retry_failed || samples.iter().all(|(_, solved)| *solved))
    };
    whole() == Some(true)
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
    if !has_results(folder, identity, settings) {
        return Ok(None);
    }
    let profiler = Profiler::default();
    let rendered = profiler.stage(RunStage::Report, || report::render(folder.path()));
    let (summary, stored) = rendered?;
    Ok(Some(RunResult {
        profile: profiler.read(),
        taken_over: (stored.outcomes.len() + stored.mixed.len()) as u64,
        stored,
        summary,
        unfolded: study.unfolded(),
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
        let of =
            |level: &LevelOutcome| (level.status, level.solved_peak(), level.newton_iterations);
        outcome.levels.iter().map(of).collect()
    };
    if numbers(first) == numbers(&again) {
        return Ok(());
    }
    Err(Error::unfit(
        &study.path,
        "sample 0 solved again is not that of the results: the model's files, the program or the processor's \
                  instruction set has changed; `run` anew",
    ))
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

/// The relative path from `start` to `path`, both without symbolic links; `path` itself where they have no root in common.
fn relative(path: &Path, start: &Path) -> PathBuf {
    let common = path.components().zip(start.components());
    let n = common.take_while(|(a, b)| a == b).count();
    if n == 0 {
        return path.to_owned();
    }
    let up = start.components().skip(n).map(|_| Component::ParentDir);
    up.chain(path.components().skip(n)).collect()
}
