//! All samples of a study: what `run` computes and writes.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::time::Instant;

use super::model::ModelSettings;
use super::output::{OutputFolder, write_arrow_tables};
use super::prepared::{FREQUENCY_TOLERANCE, PreparedStudy};
use super::read::Study;
use super::search::worst_cases;
use super::solve::{Meter, Progress};
use crate::Error;
use crate::ensemble::atlas::Atlas;
use crate::ensemble::backend::{BackendReport, BackendSettings, OpenBackend};
use crate::ensemble::outcome::{CurvePoint, LevelOutcome, SampleOutcome};
use crate::ensemble::resume::{ATLAS_FILE, StoredStudy, write_anchors};
use crate::ensemble::store::{Provenance, write_curves, write_samples};
use crate::ensemble::{Ensemble, Solved};
use crate::hb::structure::resonance::{Band, linear_resonance, linear_response};
use crate::hb::{LinearModel, Problem};
use crate::model::two_blade::ComponentSummary;
use crate::report::asked::Stopping;
use crate::report::run::{
    ComponentRecord, ContactGridRecord, DesignRecord, FURTHER_POINTS, FileRecord, InputRecord,
    LinearRecord, TABLES,
};
use crate::report::{self, RunRecord, Summary};
use crate::sampling::DesignKind;
use crate::units::rad_s_to_hz;

/// Points of the linear curves in the report.
const LINEAR_POINTS: usize = 600;

/// What a run gives, beside its files.
#[derive(Debug)]
pub struct RunResult {
    /// Outcomes in the order of the samples.
    pub outcomes: Vec<SampleOutcome>,
    /// Statistics as in `summary.json`.
    pub summary: Summary,
    /// Why the model was not folded although `mirror` allows it.
    pub unfolded: Option<String>,
    /// How the number of samples came out of the results; absent where it was given.
    pub stopping: Option<Stopping>,
}

/// Computes every sample and writes `samples.parquet`, `curves.parquet` (as Arrow files too, where the study wants them),
/// `atlas.parquet` (for an extension), `further_points.parquet` where worst cases are searched, `run.json`, and the report
/// made from these.
///
/// `backend` evaluates the contacts; what it fails to do the processor does.
/// Runs on the current rayon thread pool; `progress` is called before the first sample and after each.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Problem`] if the nominal model is no harmonic balance problem;
/// [`Error::Command`] if it has no resonance in the band; [`Error::Threads`] if the system gives no more threads; [`Error::Store`] or [`Error::Report`] if a result cannot be
/// written.
pub fn run(
    study: &Study,
    folder: &OutputFolder,
    backend: &BackendSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    run_after(study, folder, Solved::default(), backend, progress)
}

/// The same where the samples of `kept` are solved already.
///
/// # Errors
/// Those of [`run`], and [`Error::Command`] if sample 0 is not what it was.
pub(super) fn run_after(
    study: &Study,
    folder: &OutputFolder,
    kept: Solved,
    backend: &BackendSettings,
    progress: impl Fn(Progress) + Sync,
) -> Result<RunResult, Error> {
    let clock = Instant::now();
    let backend = OpenBackend::open(backend, &study.solver);
    let prepared = study.prepared()?;
    let ensemble = prepared.ensemble(backend.gpu());
    let mut record = first_record(&prepared, &ensemble)?;
    refuse_other_results(study, &ensemble, &kept)?;
    let meter = Meter::start(kept.outcomes.len() as u64, study.samples, progress);
    let solved = look_by_look(study, &ensemble, &backend, kept, &meter, &mut record)?;
    let Solved { outcomes, anchors } = &solved;
    let alone = study.output.one_at_a_time;
    record.one_at_a_time = alone.then(|| ensemble.one_at_a_time(anchors));
    let input_names: Vec<String> = record.inputs.iter().map(|i| i.name.clone()).collect();
    let [samples_name, curves_name] = TABLES;
    let path = |name: &str| folder.path().join(name);
    let provenance = &record.provenance;
    record.tables = vec![
        write_samples(&path(samples_name), provenance, &input_names, outcomes)?,
        write_curves(&path(curves_name), provenance, outcomes)?,
        write_anchors(&path(ATLAS_FILE), &kept_study(study, folder)?, anchors)?,
    ];
    let further = worst_cases(&ensemble, &record, &solved, &meter);
    write_further_points(folder, &input_names, &further, &mut record)?;
    write_arrow_tables(folder.path(), study.output.arrow)?;
    record.backend = backend.report();
    record.wall_time_s = clock.elapsed().as_secs_f64();
    record.write(folder.path())?;
    // From the files alone, so that `report` gives the same bytes.
    let (summary, _) = report::render(folder.path())?;
    Ok(RunResult {
        outcomes: solved.outcomes,
        summary,
        unfolded: study.unfolded(),
        stopping: record.stopping,
    })
}

/// Solves the samples of a study: all, or as many as its rule takes, judged at one look after the other. Then the record
/// says how many these are.
fn look_by_look(
    study: &Study,
    ensemble: &Ensemble,
    backend: &OpenBackend,
    kept: Solved,
    meter: &Meter<impl Fn(Progress) + Sync>,
    record: &mut RunRecord,
) -> Result<Solved, Error> {
    let more = |kept: Solved, samples: u64| {
        let solved = backend.extend(ensemble, kept, samples, || meter.one_more());
        solved.map_err(|error| Error::Threads(error.to_string()))
    };
    let Some(plan) = &study.stopping else {
        return more(kept, study.samples);
    };
    let n_kept = kept.outcomes.len() as u64;
    let mut solved = kept;
    for (&samples, look) in plan.looks.iter().zip(1..) {
        // an extension goes on where the rule was not met
        if samples < n_kept {
            continue;
        }
        solved = more(solved, samples)?;
        record.backend = backend.report();
        let stopping = report::at_look(plan, look, record, &solved.outcomes);
        let met = stopping.met;
        record.stopping = Some(stopping);
        record.design.description = study.design.first(samples).description();
        if met {
            break;
        }
    }
    Ok(solved)
}

/// The record of a study before its samples: no tables, and no part of the backend.
fn first_record(prepared: &PreparedStudy, ensemble: &Ensemble) -> Result<RunRecord, Error> {
    let study = prepared.study;
    let (linear, band) = (&prepared.linear, prepared.band());
    let nominal = Problem::new(linear, prepared.contacts.clone(), 1.0, study.solver.anchor)?;
    let design = &study.design;
    Ok(RunRecord {
        provenance: provenance(study, prepared.folded()),
        backend: BackendReport::default(),
        inputs: input_records(study),
        design: DesignRecord {
            kind: design.kind(),
            description: design.description(),
            independent: design.kind() == DesignKind::MonteCarlo,
            growth: design.growth(),
            outer_points: design.outer_points(),
            further_points: 0,
            mixed_inputs: design.mixed_inputs().to_vec(),
        },
        frequency_tolerance: FREQUENCY_TOLERANCE,
        levels: study.levels.clone(),
        curve_samples: study.output.curve_samples,
        bands: study.output.bands,
        level_unit: level_unit(study).to_owned(),
        stuck: linear_record(study, linear, &nominal.stuck_stiffness, band)?,
        free: linear_record(study, linear, &vec![0.0; linear.n_relative()], band)?,
        nominal: Some(ensemble.nominal()),
        one_at_a_time: None,
        components: component_records(&prepared.components),
        contact_grid: contact_grid(study),
        requirements: study.requirements.clone(),
        stopping: None,
        surrogate: study.surrogate,
        study_file: FileRecord::of(&study.file_name(), study.text.as_bytes()),
        tables: Vec::new(),
        wall_time_s: 0.0,
    })
}

/// Writes the samples of further points and notes them in the record; a file of other ones does not stay.
fn write_further_points(
    folder: &OutputFolder,
    input_names: &[String],
    further: &[SampleOutcome],
    record: &mut RunRecord,
) -> Result<(), Error> {
    let path = folder.path().join(FURTHER_POINTS);
    if further.is_empty() {
        remove_if_there(&path)?;
        return remove_if_there(&path.with_extension("arrow"));
    }
    let table = write_samples(&path, &record.provenance, input_names, further)?;
    record.tables.push(table);
    let points: BTreeSet<Option<u64>> = further.iter().map(|o| o.group.outer).collect();
    record.design.further_points = points.len() as u64;
    Ok(())
}

fn remove_if_there(path: &Path) -> Result<(), Error> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::file(path, source))
        }
        _ => Ok(()),
    }
}

/// Refuses kept samples that this program and this model would not give again: the first one is solved anew.
fn refuse_other_results(study: &Study, ensemble: &Ensemble, kept: &Solved) -> Result<(), Error> {
    let Some(first) = kept.outcomes.first() else {
        return Ok(());
    };
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

/// The study as an extension will need it. Its path is relative to the results wherever there is such a path, so that both
/// can move together.
fn kept_study(study: &Study, folder: &OutputFolder) -> Result<StoredStudy, Error> {
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

/// What the contact grid of the built-in rig changes.
fn contact_grid(study: &Study) -> Option<ContactGridRecord> {
    let ModelSettings::TwoBladeStrip {
        blades, interface, ..
    } = &study.model
    else {
        return None;
    };
    let found = blades.grid_error(interface)?;
    Some(ContactGridRecord {
        contact_nodes: found.contact_nodes,
        shift_hz: found.shift_hz,
        limit_hz: found.limit_hz(),
        relative: found.relative(),
    })
}

fn component_records(components: &[(&'static str, ComponentSummary)]) -> Vec<ComponentRecord> {
    let record = |(name, component): &(&str, ComponentSummary)| ComponentRecord {
        name: (*name).to_owned(),
        modes: component.n_modes,
        first_left_out_hz: Some(component.first_left_out).filter(|f| f.is_finite()),
    };
    components.iter().map(record).collect()
}

/// Names of the inputs with their distributions or intervals.
fn input_records(study: &Study) -> Vec<InputRecord> {
    let design = &study.design;
    let inputs = design.inputs().iter().enumerate();
    inputs
        .map(|(j, (input, distribution))| InputRecord {
            name: input.name().to_owned(),
            prior: design.assumption(j),
            distribution: design.drawn().contains(&j).then(|| distribution.clone()),
        })
        .collect()
}

/// Linear response per unit level over the band, and its resonance.
fn linear_record(
    study: &Study,
    model: &LinearModel,
    k: &[f64],
    band: Band,
) -> Result<LinearRecord, Error> {
    let resonance = linear_resonance(model, k, band)
        .map_err(|error| Error::Problem(error.into()))?
        .ok_or_else(|| Error::Command {
            path: study.path.clone(),
            message: format!(
                "frequency: the band {} to {} holds no natural frequency of the structure with {} contacts; `inspect` lists them",
                study.frequency.unit.of_rad_s(band.low),
                study.frequency.unit.of_rad_s(band.high),
                if k.iter().all(|k| *k == 0.0) { "open" } else { "stuck" },
            ),
        })?;
    let even =
        (0..LINEAR_POINTS).map(|i| band.low + band.width() * i as f64 / (LINEAR_POINTS - 1) as f64);
    let mut omega: Vec<f64> = even.chain([resonance.omega]).collect();
    omega.sort_by(f64::total_cmp);
    let curve = omega
        .into_iter()
        .map(|omega| CurvePoint {
            frequency_hz: rad_s_to_hz(omega),
            amplitude_m: linear_response(model, k, omega).norm(),
        })
        .collect();
    Ok(LinearRecord {
        frequency_hz: rad_s_to_hz(resonance.omega),
        curve,
    })
}

fn level_unit(study: &Study) -> &'static str {
    match study.model {
        ModelSettings::TwoBladeStrip { .. } => "N",
        ModelSettings::Matrices(_) => "units of the harmonic force",
    }
}

fn provenance(study: &Study, folded: bool) -> Provenance {
    let solver = &study.solver;
    Provenance {
        study: study.name.clone(),
        seed: study.design.seed(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: option_env!("MICROSLIP_COMMIT").map(str::to_owned),
        model: match study.model {
            ModelSettings::TwoBladeStrip { .. } => "two blades with a strip damper (built in)",
            ModelSettings::Matrices(_) => "matrices of the user",
        }
        .to_owned(),
        law: solver.aft.law,
        events: solver.aft.events,
        anchor: solver.anchor,
        harmonics: solver.harmonics.orders().to_vec(),
        time_points: solver.aft.n_time,
        folded,
        truncation_threshold: solver.alert.map(|alert| alert.threshold),
        highest_harmonic: solver.alert.map(|alert| alert.highest_harmonic),
    }
}
