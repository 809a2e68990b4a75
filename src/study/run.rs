//! All samples of a study: what `run` computes and writes.

use std::time::Instant;

use super::output::OutputFolder;
use super::read::{ModelSettings, Study, StudyModel};
use super::solve::Progress;
use crate::Error;
use crate::ensemble::Ensemble;
use crate::ensemble::backend::{BackendSettings, OpenBackend};
use crate::ensemble::outcome::{CurvePoint, SampleOutcome};
use crate::ensemble::store::{Provenance, write_curves, write_samples};
use crate::hb::peak::PeakSettings;
use crate::hb::resonance::{Band, linear_resonance, linear_response};
use crate::hb::{LinearModel, Problem};
use crate::report::{self, ReportInput, Summary};
use crate::units::rad_s_to_hz;
use std::sync::atomic::{AtomicU64, Ordering};

/// Relative change of frequency at which a peak counts as located; three times finer than the 1e-6 promised.
const FREQUENCY_TOLERANCE: f64 = 3e-7;
/// Points of the linear curves in the report.
const LINEAR_POINTS: usize = 600;

/// What a run gives, beside its files.
#[derive(Debug)]
pub struct RunResult {
    /// Outcomes in the order of the samples.
    pub outcomes: Vec<SampleOutcome>,
    /// Statistics as in `summary.json`.
    pub summary: Summary,
}

/// Computes every sample and writes `samples.parquet`, `curves.parquet`, `summary.json` and `report.html`.
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
    let clock = Instant::now();
    let backend = OpenBackend::open(backend, study.solver.newton.tolerance);
    let StudyModel {
        reduced, contacts, ..
    } = study.build_model()?;
    let folded = match study.mirror {
        true => LinearModel::folded(&reduced, &contacts)?,
        false => None,
    };
    let linear = match folded {
        Some(half) => half,
        None => LinearModel::new(&reduced)?,
    };
    let contacts: Vec<_> = linear.pairs.iter().map(|&pair| contacts[pair]).collect();
    let [low, high] = study.frequency.band;
    let band = Band { low, high };
    let nominal = Problem::new(&linear, contacts.clone(), 1.0, study.solver.anchor)?;
    let stuck = LinearCurve::new(study, &linear, &nominal.stuck_stiffness, band)?;
    let free = LinearCurve::new(study, &linear, &vec![0.0; linear.n_relative()], band)?;
    let ensemble = Ensemble {
        linear: &linear,
        contacts: &contacts,
        design: &study.design,
        levels: &study.levels,
        settings: &study.solver,
        peak: PeakSettings {
            band,
            frequency_tolerance: FREQUENCY_TOLERANCE,
        },
        curve_samples: study.output.curve_samples,
        backend: backend.backend(),
    };
    let (total, done) = (study.samples, AtomicU64::new(0));
    progress(Progress { done: 0, total });
    let one_more = || {
        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
        progress(Progress { done, total });
    };
    let outcomes = (backend.run(&ensemble, total, one_more))
        .map_err(|error| Error::Threads(error.to_string()))?;
    let nominal = ensemble.nominal();
    let input_names: Vec<String> = study
        .design
        .inputs()
        .iter()
        .map(|(input, _)| input.name().to_owned())
        .collect();
    let provenance = provenance(study, linear.n_contacts() < reduced.n_contacts());
    let samples_path = folder.path().join("samples.parquet");
    write_samples(&samples_path, &provenance, &input_names, &outcomes)?;
    write_curves(
        &folder.path().join("curves.parquet"),
        &provenance,
        &outcomes,
    )?;
    let input = ReportInput {
        provenance: &provenance,
        input_names: &input_names,
        levels: &study.levels,
        level_unit: level_unit(study),
        free_frequency_hz: free.frequency_hz,
        stuck_frequency_hz: stuck.frequency_hz,
        free_curve: &free.curve,
        stuck_curve: &stuck.curve,
        nominal: Some(&nominal),
        outcomes: &outcomes,
        wall_time_s: clock.elapsed().as_secs_f64(),
        backend: &backend.report(),
    };
    let summary = report::write(folder.path(), &input)?;
    Ok(RunResult { outcomes, summary })
}

/// Linear response per unit level over the band, and its resonance.
struct LinearCurve {
    frequency_hz: f64,
    curve: Vec<CurvePoint>,
}

impl LinearCurve {
    fn new(study: &Study, model: &LinearModel, k: &[f64], band: Band) -> Result<Self, Error> {
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
        let even = (0..LINEAR_POINTS)
            .map(|i| band.low + band.width() * i as f64 / (LINEAR_POINTS - 1) as f64);
        let mut omega: Vec<f64> = even.chain([resonance.omega]).collect();
        omega.sort_by(f64::total_cmp);
        let curve = omega
            .into_iter()
            .map(|omega| CurvePoint {
                frequency_hz: rad_s_to_hz(omega),
                amplitude_m: linear_response(model, k, omega).norm(),
            })
            .collect();
        Ok(Self {
            frequency_hz: rad_s_to_hz(resonance.omega),
            curve,
        })
    }
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
