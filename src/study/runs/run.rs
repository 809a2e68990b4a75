//! All samples of a study: what `run` computes and writes.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

use super::control_variate::control_samples;
use super::profile::RunStage;
use super::progress::{Meter, Progress};
use super::replacement::{admitted, refuse_own_inputs, replaced};
use super::resume::{Resumed, add_results_there, finished, resumed};
use super::run_record::{self, first_record};
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use super::session::{Begun, Session, at_work, unwritten};
use super::worst_cases::worst_cases;
use crate::Error;
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::parts::{PartFolder, RunIdentity};
use crate::ensemble::store::{ATLAS_FILE, SolvedFiles, write_samples};
use crate::ensemble::{Known, Solved};
use crate::file::{FileRecord, FolderLock, Together};
use crate::report::run::{CONTROL_VARIATE, FURTHER_POINTS, StoredRun, TABLES};
use crate::report::{self, RunRecord, Summary};
use crate::study::output::{OPTIONAL_TABLES, OutputFolder, write_arrow_tables};
use crate::study::reweight::REWEIGHTED;
use crate::study::settings::read::Study;

/// Computes every sample and writes `samples.parquet`, `curves.parquet` (as Arrow files too, where the study wants them),
/// `atlas.parquet` (for an extension), `further_points.parquet` where worst cases are searched, `run.json`, and the report
/// made from these. They replace older results together, at the end.
///
/// What is solved is written to `parts` on the way, and a later call goes on from there. Where `folder` holds the whole results
/// of this study already, only the report is made anew; where they differ only in what is asked of the samples, these are taken over. Those of
/// another study are replaced; [`check_folder`] says so before.
///
/// Runs on the current rayon thread pool; `progress` is called before the first sample and after each.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Study`] if the nominal model is no harmonic balance problem;
/// [`Error::Unfit`] if it has no resonance in the band. [`Error::Results`] if `folder` holds parts of another run, or results of this study with more
/// samples. [`Error::Threads`] if the system gives no more threads; [`Error::File`] if another process works in the folder. [`Error::Store`] or [`Error::Report`] if
/// a result cannot be written; [`Error::Stopped`] if the run was stopped. Older results are then as they were.
pub fn run(
    study: &Study,
    folder: &OutputFolder,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    refuse_own_inputs(study, folder)?;
    let _lock = FolderLock::alone(folder.path())?;
    run_alone(study, folder, settings, progress)
}

/// Refuses the folders that [`run`] refuses before it solves anything: those with more samples of the study, and with its own files
/// where results would come. Gives what a user should know before, one line each: that results of another study will be replaced.
///
/// # Errors
/// [`Error::Results`] and [`Error::File`], as those of [`run`].
pub fn check_folder(
    study: &Study,
    folder: &OutputFolder,
    settings: &RunSettings,
) -> Result<Vec<String>, Error> {
    refuse_own_inputs(study, folder)?;
    let identity = admitted(study, folder)?;
    Ok(replaced(folder, &identity, settings).into_iter().collect())
}

/// Refuses a study in whose band no peak can be, before anything is solved.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Unfit`] as that of [`run`].
pub fn check_band(study: &Study) -> Result<(), Error> {
    run_record::check_band(&study.prepared()?)
}

/// The same where no other process works in the folder.
///
/// # Errors
/// Those of [`run`].
pub(super) fn run_alone(
    study: &Study,
    folder: &OutputFolder,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let identity = admitted(study, folder)?;
    let mut resumed = resumed(study, folder, &identity, settings)?;
    if let Some(result) = finished(study, folder, &identity, settings)? {
        PartFolder::of(folder.path()).remove()?;
        return Ok(result);
    }
    add_results_there(&mut resumed, study, folder, &identity, settings)?;
    run_after(study, folder, identity, resumed, settings, progress)
}

/// The same where samples are known already.
///
/// # Errors
/// Those of [`run`], and [`Error::Unfit`] if sample 0 is not what it was.
pub(super) fn run_after(
    study: &Study,
    folder: &OutputFolder,
    identity: RunIdentity,
    mut resumed: Resumed,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let clock = Instant::now();
    let taken_over = resumed.known.indices.range(..study.samples).count() as u64;
    let meter = Meter::start(taken_over, study.samples, progress);
    let begun = Begun::with(&resumed, study, folder, settings, identity);
    at_work(begun, meter, |session| {
        let ensemble = session.ensemble;
        let mut record = first_record(session.prepared, ensemble)?;
        let samples = solve_samples(session, &mut resumed, &mut record)?;
        record.provenance.other_programs = std::mem::take(&mut resumed.other_programs);
        let anchors = resumed.known.anchors_before(samples);
        resumed.forget();
        let alone = study.output.one_at_a_time;
        let profiler = &session.profiler;
        record.one_at_a_time = alone
            .then(|| profiler.stage(RunStage::OneAtATime, || ensemble.one_at_a_time(&anchors)));
        let further = match study.design.outer() {
            None => Vec::new(),
            Some(_) => {
                let outcomes = resumed.outcomes(study, samples)?;
                let solved = Solved { outcomes, anchors };
                profiler.stage(RunStage::WorstCases, || {
                    worst_cases(ensemble, &record, &solved, session.meter)
                })
            }
        };
        let control = match &study.control_variate {
            None => Vec::new(),
            Some(wanted) => profiler.stage(RunStage::ControlVariate, || {
                control_samples(session, *wanted)
            })?,
        };
        record.backend = session.backend.report();
        record.wall_time_s = clock.elapsed().as_secs_f64();
        let extra = ExtraSamples { further, control };
        let placed = place_results(session, &resumed, samples, &extra, &mut record);
        let (summary, stored) = placed.map_err(unwritten)?;
        session.parts.remove()?;
        Ok(RunResult {
            stored,
            summary,
            unfolded: study.unfolded(),
            taken_over,
            profile: profiler.read(),
            notes: (session.notes.iter().chain(&resumed.notes).cloned())
                .chain(study.without_damping(&session.prepared.linear))
                .collect(),
        })
    })
}

/// Solves the samples of a study: all, or as many as its rule takes, judged at one look after the other. The record then says how
/// many these are.
fn solve_samples<F: Fn(Progress) + Sync>(
    session: &Session<'_, F>,
    resumed: &mut Resumed,
    record: &mut RunRecord,
) -> Result<u64, Error> {
    let study = &session.prepared.study;
    let Some(plan) = &study.stopping else {
        session.solve(resumed, study.samples)?;
        return Ok(study.samples);
    };
    let mut judged = 0;
    for (&samples, look) in plan.looks.iter().zip(1..) {
        session.solve(resumed, samples)?;
        judged = samples;
        record.backend = session.backend.report();
        let outcomes = resumed.outcomes(study, samples)?;
        let stopping = report::at_look(plan, look, record, &outcomes);
        let met = stopping.met;
        record.stopping = Some(stopping);
        record.design.description = study.design.first(samples).description();
        if met {
            break;
        }
    }
    Ok(judged)
}

impl<F: Fn(Progress) + Sync> Session<'_, F> {
    /// Solves what is missing of the first `samples` until all of them stand in parts or results.
    fn solve(&self, resumed: &mut Resumed, samples: u64) -> Result<(), Error> {
        let missing = |known: &Known| samples - known.indices.range(..samples).count() as u64;
        self.kept(resumed, missing, |known, watch| {
            self.ensemble.extend(known, samples, watch)
        })
    }
}

/// Samples beside those of the design.
struct ExtraSamples {
    /// At further points of the epistemic inputs.
    further: Vec<SampleOutcome>,
    /// Of the control variate.
    control: Vec<SampleOutcome>,
}

/// Writes all files of the results, which then replace older ones together.
fn place_results<F>(
    session: &Session<'_, F>,
    resumed: &Resumed,
    samples: u64,
    extra: &ExtraSamples,
    record: &mut RunRecord,
) -> Result<(Summary, StoredRun), Error> {
    let (study, folder) = (&session.prepared.study, session.folder.path());
    let results = Together::begin(folder)?;
    let names = &session.head.input_names;
    let tables = session.profiler.stage(RunStage::Tables, || {
        write_tables(results.path(), session, resumed, samples, record)
    });
    record.tables = tables?.to_vec();
    write_extra(results.path(), names, extra, record)?;
    let there = |name: &Path| folder.join(name).exists();
    let arrow = study.output.arrow;
    write_arrow_tables(results.path(), |name| arrow || there(name))?;
    record.write(results.path())?;
    // From the files alone, so that `report` gives the same bytes.
    let profiler = &session.profiler;
    let rendered = profiler.stage(RunStage::Report, || report::render(results.path()))?;
    let arrow = OPTIONAL_TABLES.map(|name| name.replace(".parquet", ".arrow"));
    let optional: Vec<&str> = (OPTIONAL_TABLES.into_iter())
        .chain(arrow.iter().map(String::as_str))
        // it is of the samples before
        .chain([REWEIGHTED])
        .collect();
    results.place(&optional)?;
    Ok(rendered)
}

/// Writes the tables of samples, curves and anchors.
fn write_tables<F>(
    folder: &Path,
    session: &Session<'_, F>,
    resumed: &Resumed,
    samples: u64,
    record: &RunRecord,
) -> Result<[FileRecord; 3], Error> {
    let study = &session.prepared.study;
    let [of_samples, curves] = TABLES.map(|name| folder.join(name));
    let anchors = folder.join(ATLAS_FILE);
    let mut files = SolvedFiles::begin(
        [&of_samples, &curves, &anchors],
        &record.provenance,
        &session.head.input_names,
        study.design.group(0),
        &session.head.identity.study,
    )?;
    let mut all = resumed.samples(study);
    for index in 0..samples {
        let next = all.take()?.filter(|sample| sample.outcome.index == index);
        let sample = next.ok_or_else(|| {
            Error::results(
                session.parts.path(),
                format!("sample {index} is missing: `run` again"),
            )
        })?;
        files.write(sample)?;
    }
    Ok(files.finish()?)
}

/// Writes the samples beside those of the design, where there are such, and notes them in the record.
fn write_extra(
    folder: &Path,
    input_names: &[String],
    extra: &ExtraSamples,
    record: &mut RunRecord,
) -> Result<(), Error> {
    let tables = [
        (FURTHER_POINTS, &extra.further),
        (CONTROL_VARIATE, &extra.control),
    ];
    for (name, samples) in tables.into_iter().filter(|(_, s)| !s.is_empty()) {
        let path = folder.join(name);
        let table = write_samples(&path, &record.provenance, input_names, samples)?;
        record.tables.push(table);
    }
    let points: BTreeSet<Option<u32>> = extra.further.iter().map(|o| o.group.outer).collect();
    record.design.further_points = points.len() as u64;
    Ok(())
}
