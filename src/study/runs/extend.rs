//! More samples for a finished run.

use std::path::Path;

use super::progress::Progress;
use super::resume::{
    accepted, identity, identity_of_results, results_refusal, results_source, resumed,
};
use super::run::run_after;
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use crate::Error;
use crate::ensemble::parts::{Merged, RunIdentity};
use crate::ensemble::store::ATLAS_FILE;
use crate::file::{FileError, FolderLock, finish_placing};
use crate::report::RunRecord;
use crate::report::asked::Stopping;
use crate::sampling::Growth;
use crate::sampling::design_settings::MOST_SAMPLES;
use crate::study::output::OutputFolder;
use crate::study::settings::document::Document;
use crate::study::settings::read::Study;

/// Solves the samples that `folder`, the results of a run, lacks of `samples`, and writes all result files anew.
///
/// The files are then bit for bit those of a run with so many samples, but for the wall time in summary and report. The
/// study is the one that the run was made from, whatever its file says now. Where its samples grow until a rule is met, `samples`
/// is how many there are at most. What is solved is written on the way: the same call goes on after a process that died.
///
/// # Errors
/// Those of [`super::run::run`]. Also [`Error::Results`] if the folder holds no results of `run` or one of its files was changed, the design cannot grow, its
/// rule was met or would be judged at other looks, there are not more samples than before, or the samples there are are not what this program would give.
pub fn extend(
    folder: &Path,
    samples: u64,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let refused = |message: String| Error::results(folder, message);
    let unreadable =
        |error: FileError| refused(format!("no results that can be extended: {error}"));
    let none = || refused(format!("holds no {ATLAS_FILE}: no results of `run`"));
    if !folder.is_dir() {
        return Err(none());
    }
    let folder = OutputFolder::open(folder)?;
    let _lock = FolderLock::alone(folder.path())?;
    finish_placing(folder.path())?;
    if !folder.path().join(ATLAS_FILE).is_file() {
        return Err(none());
    }
    let stored = identity_of_results(folder.path()).map_err(unreadable)?;
    let path = folder.path().join(&stored.study.path);
    let old = Study::parse(&path, &stored.study.text)?;
    if old.design.growth() == Growth::Fixed {
        let kind = old.design.kind().name();
        return Err(refused(format!(
            "a design of kind {kind:?} cannot be extended: all its samples depend on their number; `run` it with {samples}"
        )));
    }
    let stopping = RunRecord::of_folder(folder.path())?.stopping;
    refuse_other_looks(stopping.as_ref(), samples).map_err(refused)?;
    let n = old.samples;
    refuse_number(samples, n).map_err(refused)?;
    let key = match stopping {
        Some(_) => "samples.at_most",
        None => "samples",
    };
    let text = Document::parse(&path, &stored.study.text)?.with_value(key, &samples.to_string());
    let study = Study::parse(&path, &text)?;
    let identity = identity(&study, &folder)?;
    let mut resumed = resumed(&study, &folder, &identity, settings)?;
    let same_study = RunIdentity {
        study: identity.study.clone(),
        ..stored
    };
    let other = accepted(&identity, &same_study, settings);
    let other = other.map_err(|difference| refused(results_refusal(&difference)))?;
    let added = resumed.add_results(folder.path(), &study, settings, other);
    added.map_err(unreadable)?;
    refuse_other_samples(&study, &old, folder.path()).map_err(refused)?;
    run_after(&study, &folder, identity, resumed, settings, progress)
}

/// More samples than there are, and no more than a design has.
fn refuse_number(samples: u64, there: u64) -> Result<(), String> {
    match samples {
        _ if samples <= there => Err(format!(
            "--samples {samples}: must be more than the {there} there are"
        )),
        _ if samples > MOST_SAMPLES => Err(format!(
            "--samples {samples}: must be at most {MOST_SAMPLES}"
        )),
        _ => Ok(()),
    }
}

/// A rule that was met takes no more samples, and one that was not is judged at the looks of the whole run.
fn refuse_other_looks(stopping: Option<&Stopping>, samples: u64) -> Result<(), String> {
    let Some(stopping) = stopping else {
        return Ok(());
    };
    if stopping.met {
        let n = stopping.looks.last().copied().unwrap_or_default();
        let goal = stopping.goal();
        return Err(format!(
            "its rule was met with {n} samples ({goal}); `run` it with another one for more"
        ));
    }
    match stopping.growth(samples) {
        Some(n) if n == samples => Ok(()),
        _ => Err(format!(
            "--samples {samples}: must be {} times 2, 4, 8, ..., so that the looks stay those of the whole run",
            stopping.at_most
        )),
    }
}

/// The samples of the results must be those of the design: a file of samples may have changed since.
fn refuse_other_samples(study: &Study, old: &Study, folder: &Path) -> Result<(), String> {
    let mut samples = Merged::new(vec![results_source(folder)], &study.design);
    let mut found = 0;
    while let Some(sample) = samples.take().map_err(|error| error.to_string())? {
        let (index, inputs) = (sample.outcome.index, sample.outcome.inputs);
        if *inputs != *study.design.sample(index) {
            return Err(format!(
                "sample {index} has other inputs now: the file of samples or the program has changed; `run` anew"
            ));
        }
        found += 1;
    }
    match old.samples {
        expected if expected == found => Ok(()),
        expected => Err(format!(
            "samples.parquet has {found} samples, its study {expected}"
        )),
    }
}
