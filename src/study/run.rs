//! All samples of a study: what `run` computes and writes.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

use super::output::{OutputFolder, write_arrow_tables};
use super::read::Study;
use super::resume::{Resumed, add_solved_results, finished, identity, resumed};
use super::run_record::first_record;
use super::run_result::RunResult;
use super::run_settings::RunSettings;
use super::search::worst_cases;
use super::session::{Begun, at_work};
use super::solve::{Meter, Progress};
use crate::Error;
use crate::ensemble::backend::OpenBackend;
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::parts::{PartFolder, PartHead, RunIdentity};
use crate::ensemble::resume::{ATLAS_FILE, write_anchors};
use crate::ensemble::runner::{Stopped, Watch};
use crate::ensemble::store::{write_curves, write_samples};
use crate::ensemble::{Ensemble, Known, Solved};
use crate::file::{FolderLock, Together};
use crate::report::run::{FURTHER_POINTS, TABLES};
use crate::report::{self, RunRecord, Summary};

/// Computes every sample and writes `samples.parquet`, `curves.parquet` (as Arrow files too, where the study wants them),
/// `atlas.parquet` (for an extension), `further_points.parquet` where worst cases are searched, `run.json`, and the report
/// made from these. They replace older results together, at the end.
///
/// What is solved is written to `parts` on the way, and a later call goes on from there. Where `folder` holds the whole results
/// of this study already, only the report is made anew.
///
/// Runs on the current rayon thread pool; `progress` is called before the first sample and after each.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Problem`] if the nominal model is no harmonic balance problem;
/// [`Error::Command`] if it has no resonance in the band, or `folder` holds parts of another run; [`Error::Threads`] if the
/// system gives no more threads; [`Error::File`] if another process works in the folder; [`Error::Store`] or [`Error::Report`] if
/// a result cannot be written; [`Error::Stopped`] if the run was stopped. Older results are then as they were.
pub fn run(
    study: &Study,
    folder: &OutputFolder,
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let _lock = FolderLock::alone(folder.path())?;
    run_alone(study, folder, settings, progress)
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
    let identity = identity(study, folder)?;
    let mut resumed = resumed(study, folder, &identity, settings)?;
    if let Some(result) = finished(study, folder, &identity, settings)? {
        PartFolder::of(folder.path()).remove()?;
        return Ok(result);
    }
    add_solved_results(&mut resumed, study, folder, &identity, settings)?;
    run_after(study, folder, (identity, resumed), settings, progress)
}

/// The same where samples are known already.
///
/// # Errors
/// Those of [`run`], and [`Error::Command`] if sample 0 is not what it was.
pub(super) fn run_after(
    study: &Study,
    folder: &OutputFolder,
    (identity, resumed): (RunIdentity, Resumed),
    settings: &RunSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let clock = Instant::now();
    let Resumed {
        mut known,
        other_programs,
        notes,
    } = resumed;
    let taken_over = known.range(..study.samples).count() as u64;
    let meter = Meter::start(taken_over, study.samples, progress);
    let begun = Begun::with(&known, study, folder, settings, identity);
    at_work(begun, meter, |session| {
        let ensemble = session.ensemble;
        let mut record = first_record(session.prepared, ensemble)?;
        record.provenance.other_programs = other_programs;
        let mut solved = Solved::default();
        session.written(study.samples, |watch| {
            let looks = Looks {
                study,
                ensemble,
                backend: session.backend,
                watch,
            };
            looks.solve(&mut solved, &mut known, &mut record)
        })?;
        let alone = study.output.one_at_a_time;
        record.one_at_a_time = alone.then(|| ensemble.one_at_a_time(&solved.anchors));
        let further = worst_cases(ensemble, &record, &solved, &session.meter);
        record.backend = session.backend.report();
        record.wall_time_s = clock.elapsed().as_secs_f64();
        let all = (&solved, &further[..]);
        let summary = place_results((study, folder), &session.head, all, &mut record)?;
        session.parts.remove()?;
        Ok(RunResult {
            outcomes: solved.outcomes,
            summary,
            unfolded: study.unfolded(),
            stopping: record.stopping,
            taken_over,
            notes,
        })
    })
}

/// Writes all files of the results, which then replace older ones together.
fn place_results(
    (study, folder): (&Study, &OutputFolder),
    head: &PartHead,
    (Solved { outcomes, anchors }, further): (&Solved, &[SampleOutcome]),
    record: &mut RunRecord,
) -> Result<Summary, Error> {
    let results = Together::begin(folder.path())?;
    let [samples_name, curves_name] = TABLES;
    let path = |name: &str| results.path().join(name);
    let (provenance, names) = (&record.provenance, &head.input_names);
    record.tables = vec![
        write_samples(&path(samples_name), provenance, names, outcomes)?,
        write_curves(&path(curves_name), provenance, outcomes)?,
        write_anchors(&path(ATLAS_FILE), &head.identity.study, anchors)?,
    ];
    write_further_points(&path(FURTHER_POINTS), names, further, record)?;
    let there = |name: &Path| folder.path().join(name).exists();
    let arrow = study.output.arrow;
    write_arrow_tables(results.path(), |name| arrow || there(name))?;
    record.write(results.path())?;
    // From the files alone, so that `report` gives the same bytes.
    let (summary, _) = report::render(results.path())?;
    let arrow = Path::new(FURTHER_POINTS).with_extension("arrow");
    results.place(&[FURTHER_POINTS, &arrow.to_string_lossy()])?;
    Ok(summary)
}

/// The samples of a study: all, or as many as its rule takes, judged at one look after the other.
struct Looks<'a> {
    study: &'a Study,
    ensemble: &'a Ensemble<'a>,
    backend: &'a OpenBackend,
    watch: &'a dyn Watch,
}

impl Looks<'_> {
    /// Solves the samples that are not `known`; the record then says how many these are.
    fn solve(
        &self,
        solved: &mut Solved,
        known: &mut Known,
        record: &mut RunRecord,
    ) -> Result<(), Stopped> {
        let study = self.study;
        let Some(plan) = &study.stopping else {
            return self
                .ensemble
                .extend(solved, known, study.samples, self.watch);
        };
        for (&samples, look) in plan.looks.iter().zip(1..) {
            self.ensemble.extend(solved, known, samples, self.watch)?;
            record.backend = self.backend.report();
            let stopping = report::at_look(plan, look, record, &solved.outcomes);
            let met = stopping.met;
            record.stopping = Some(stopping);
            record.design.description = study.design.first(samples).description();
            if met {
                break;
            }
        }
        Ok(())
    }
}

/// Writes the samples of further points, if there are such, and notes them in the record.
fn write_further_points(
    path: &Path,
    input_names: &[String],
    further: &[SampleOutcome],
    record: &mut RunRecord,
) -> Result<(), Error> {
    if further.is_empty() {
        return Ok(());
    }
    let table = write_samples(path, &record.provenance, input_names, further)?;
    record.tables.push(table);
    let points: BTreeSet<Option<u64>> = further.iter().map(|o| o.group.outer).collect();
    record.design.further_points = points.len() as u64;
    Ok(())
}
