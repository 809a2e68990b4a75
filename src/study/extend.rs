//! More samples for a finished run.

use std::path::Path;

use super::document::Document;
use super::output::OutputFolder;
use super::read::Study;
use super::run::{RunResult, run_after};
use super::solve::Progress;
use crate::Error;
use crate::ensemble::Solved;
use crate::ensemble::backend::BackendSettings;
use crate::ensemble::resume::{ATLAS_FILE, read_solved, read_study};
use crate::file::FileError;
use crate::report::RunRecord;
use crate::report::asked::Stopping;
use crate::report::run::require_unchanged;
use crate::sampling::Growth;

/// Solves the samples that `folder`, the results of a run, lacks of `samples`, and writes all result files anew.
///
/// The files are then bit for bit those of a run with so many samples, but for the wall time in summary and report. The
/// study is the one that the run was made from, whatever its file says now. Where its samples grow until a rule is met, `samples`
/// is how many there are at most.
///
/// # Errors
/// [`Error::Command`] if the folder holds no results of `run` or one of its files was changed, the design cannot grow, its
/// rule was met or would be judged at other looks, there are not more samples than before, or the kept samples are not what this program would give; and those of [`super::run()`].
pub fn extend(
    folder: &Path,
    samples: u64,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let refused = |message: String| Error::Command {
        path: folder.to_owned(),
        message,
    };
    let unreadable =
        |error: FileError| refused(format!("no results that can be extended: {error}"));
    if !folder.join(ATLAS_FILE).is_file() {
        return Err(refused(format!(
            "holds no {ATLAS_FILE}: no results of `run`"
        )));
    }
    require_unchanged(folder).map_err(unreadable)?;
    let kept = read_study(folder).map_err(unreadable)?;
    let path = folder.join(&kept.path);
    let old = Study::parse(&path, &kept.text)?;
    if old.design.growth() == Growth::Fixed {
        let kind = old.design.kind().name();
        return Err(refused(format!(
            "a design of kind {kind:?} cannot be extended: all its samples depend on their number; `run` it with {samples}"
        )));
    }
    let stopping = RunRecord::of_folder(folder)?.stopping;
    refuse_other_looks(stopping.as_ref(), samples).map_err(refused)?;
    let n = old.samples;
    if samples <= n {
        return Err(refused(format!(
            "--samples {samples}: must be more than the {n} there are"
        )));
    }
    let key = match stopping {
        Some(_) => "samples.at_most",
        None => "samples",
    };
    let text = Document::parse(&path, &kept.text)?.with_number(key, samples);
    let study = Study::parse(&path, &text)?;
    let solved = read_solved(folder, &study.design).map_err(unreadable)?;
    refuse_other_samples(&study, &old, &solved).map_err(refused)?;
    let folder = OutputFolder::open(folder)?;
    run_after(
        &study,
        &folder,
        solved,
        &BackendSettings::default(),
        progress,
    )
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

/// The samples must be those of the design: a file of samples may have changed since.
fn refuse_other_samples(study: &Study, old: &Study, solved: &Solved) -> Result<(), String> {
    if solved.outcomes.len() as u64 != old.samples {
        let (found, expected) = (solved.outcomes.len(), old.samples);
        return Err(format!(
            "samples.parquet has {found} samples, its study {expected}"
        ));
    }
    let differs = |outcome: &&crate::ensemble::outcome::SampleOutcome| {
        outcome.inputs != study.design.sample(outcome.index)
    };
    match solved.outcomes.iter().find(differs) {
        None => Ok(()),
        Some(outcome) => Err(format!(
            "sample {} has other inputs now: the file of samples or the program has changed; `run` anew",
            outcome.index
        )),
    }
}
