//! From a study and a measured response to the posterior of its inputs.

use std::path::Path;

use super::chains::Chains;
use super::check::{errors, round, spread};
use super::found::{Calibrated, Origin, Round};
use super::observation::Observations;
use super::posterior::Posterior;
use super::prior::Prior;
use super::settings::CalibrationSettings;
use super::summary::{Drawn, summary};
use super::surrogate::{SolvedPoints, Surrogates};
use crate::Error;
use crate::ensemble::outcome::LevelOutcome;
use crate::ensemble::program::Program;
use crate::ensemble::stop::Stop;
use crate::file::{FileError, FileRecord};
use crate::record::read_response;
use crate::study::{EvaluationError, Evaluator, Study};
use libm::log;

/// Solved samples that searches start from.
const ANCHORS: u64 = 64;
/// Rounds of fit, chains and check at most.
const MOST_ROUNDS: usize = 4;

/// What a calibration is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CalibrationStage {
    /// Samples of the study are solved.
    Samples(usize),
    /// Chains draw, in a round counted from 1.
    Chains(usize),
    /// Draws of the posterior are solved.
    Check(usize),
}

/// Calibrates the inputs of `study` with the response in the file `measured`.
///
/// # Errors
/// [`Error::Study`] on inputs without a prior distribution; [`Error::File`] on a response that cannot be taken;
/// [`Error::Unfit`] if no surrogate can be made or the chains cannot go on.
pub fn calibrate(
    study: Study,
    measured: &Path,
    settings: &CalibrationSettings,
    progress: impl Fn(CalibrationStage),
) -> Result<Calibrated, Error> {
    let path = study.path.clone();
    let refused = |message: String| Error::unfit(&path, message);
    (settings.validate()).map_err(|bad| refused(format!("--{bad}")))?;
    let prior = Prior::of(&study.design).map_err(|bad| study.bad_setting(&bad))?;
    let observations = observed(&study, measured)?;
    let samples = number_of_samples(&study, settings).map_err(refused)?;
    let origin = origin(&study, measured)?;
    progress(CalibrationStage::Samples(samples));
    let never = Stop::default();
    let stopped = |error: EvaluationError| refused(error.to_string());
    let anchors = ANCHORS.min(samples as u64);
    let evaluator = Evaluator::solved(study.into_prepared()?, anchors, &never, |_| {});
    let evaluator = evaluator.map_err(stopped)?;
    let solve = |points: &[Vec<f64>]| evaluator.evaluate(points, &never).map_err(stopped);
    let mut points = prior_points(&evaluator, samples, solve)?;
    let mut rounds: Vec<Round> = Vec::new();
    loop {
        let fitted = Surrogates::fit(&prior, &points, &observations.levels(), settings.seed);
        let surrogates = fitted.map_err(refused)?;
        let asked = settings.discrepancy;
        let posterior = Posterior::new(&prior, &surrogates, &observations, asked);
        progress(CalibrationStage::Chains(rounds.len() + 1));
        let chains = Chains::draw(&posterior, settings);
        let chains = chains.map_err(refused)?;
        progress(CalibrationStage::Check(settings.checked));
        let scores = spread(&chains, settings.checked, posterior.scores());
        let values = |z: &Vec<f64>| prior.with_fixed(&prior.values(z));
        let draws: Vec<Vec<f64>> = scores.iter().map(values).collect();
        let results: Vec<_> = solve(&draws)?.iter().map(|p| numbers(p)).collect();
        let errors = errors(&posterior, &surrogates, &scores, &results);
        let round = round(
            points.inputs.len(),
            draws.len(),
            &posterior,
            &surrogates,
            &errors,
        );
        // draws without a solution teach nothing: a further round would be this one again
        let last = round.is_enough() || round.solved() == 0;
        rounds.push(round);
        if last || rounds.len() == MOST_ROUNDS {
            let drawn = Drawn {
                posterior: &posterior,
                surrogates: &surrogates,
                chains: &chains,
                errors: &errors,
                settings,
            };
            return Ok(summary(origin, rounds, &drawn));
        }
        points.inputs.extend(draws);
        points.results.extend(results);
    }
}

/// The first samples of the prior, solved; those that searches start from are so already.
fn prior_points(
    evaluator: &Evaluator<'_>,
    samples: usize,
    solve: impl Fn(&[Vec<f64>]) -> Result<Vec<Vec<LevelOutcome>>, Error>,
) -> Result<SolvedPoints, Error> {
    let design = &evaluator.study().design;
    let inputs: Vec<Vec<f64>> = (0..samples as u64).map(|i| design.sample(i)).collect();
    let known = evaluator.sampled().iter();
    let mut results: Vec<_> = known.map(|sample| numbers(&sample.levels)).collect();
    let others = solve(&inputs[results.len()..])?;
    results.extend(others.iter().map(|levels| numbers(levels)));
    Ok(SolvedPoints {
        inputs,
        results,
        of_prior: samples,
    })
}

fn observed(study: &Study, measured: &Path) -> Result<Observations, FileError> {
    let observations = Observations::of(&read_response(measured)?, &study.levels);
    observations.map_err(|bad| FileError::content(measured, bad.line, bad.fault.to_string()))
}

fn origin(study: &Study, measured: &Path) -> Result<Origin, Error> {
    Ok(Origin {
        study: study.name.clone(),
        program: Program::this(),
        study_file: FileRecord::of(&study.file_name(), study.text.as_bytes()),
        files: study.file_records()?,
        measured_file: FileRecord::of_file(measured)?,
        levels: study.levels.clone(),
    })
}

fn number_of_samples(study: &Study, settings: &CalibrationSettings) -> Result<usize, String> {
    let samples = settings.samples.unwrap_or(study.samples);
    if samples == 0 || samples > study.samples {
        return Err(format!(
            "--samples = {samples}: must be from 1 to the number of samples of the study, {}",
            study.samples
        ));
    }
    usize::try_from(samples).map_err(|error| error.to_string())
}

/// Frequency (Hz) and ln amplitude (m) of each level; NaN without a solution.
fn numbers(levels: &[LevelOutcome]) -> Vec<[f64; 2]> {
    let of_level = |level: &LevelOutcome| {
        let solved = level.solved_peak();
        solved.map_or([f64::NAN; 2], |p| [p.frequency_hz, log(p.amplitude_m)])
    };
    levels.iter().map(of_level).collect()
}
