//! Surrogates of frequency and amplitude at each measured level, and what they are worth.

use super::observation::ObservedQuantity;
use super::prior::Prior;
use crate::statistics::{
    Chaos, ChaosRefusal, ChaosSettings, HoldOutSettings, PredictionError, SurrogateSamples,
    cross_fit,
};

/// Points that were solved. Failed ones have no numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SolvedPoints {
    /// Values of all inputs of the study. Shape: points × inputs.
    pub inputs: Vec<Vec<f64>>,
    /// Frequency (Hz) and ln amplitude (m); NaN where a level has no solution. Shape: points × levels of the study.
    pub results: Vec<Vec<[f64; 2]>>,
    /// Number of the first points that are samples of the prior; the others are draws of a posterior.
    pub of_prior: usize,
}

/// Surrogate of one quantity at one level.
#[derive(Debug, Clone, PartialEq)]
pub struct Surrogate {
    /// Place of the level among those of the study.
    pub level: usize,
    /// The quantity.
    pub quantity: ObservedQuantity,
    /// Expansion over the coordinates of the prior.
    pub expansion: Chaos,
    /// Its error at samples that did not shape it.
    pub held_out: PredictionError,
    /// Standard deviation of its error that a likelihood takes: root mean square of the errors held out, over all points or over
    /// those where the posterior is, the larger one.
    pub deviation: f64,
}

/// Surrogates at the measured levels, by level and then by quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Surrogates {
    /// The surrogates.
    pub all: Vec<Surrogate>,
}

/// Parts in which points are held out.
const PARTS: usize = 5;
/// Points that shape a surrogate at most: its cost grows with their number, its accuracy hardly beyond.
const MOST_FITTED: usize = 2000;
/// Largest share of samples without a solution: where they lie nothing shapes a surrogate and nothing checks it.
const MOST_FAILED: f64 = 0.05;
/// Fewest draws of a posterior whose errors are judged on their own.
pub(super) const FEWEST_LOCAL: usize = 8;

impl Surrogates {
    /// Fits a surrogate to each quantity at each of `levels`.
    ///
    /// # Errors
    /// Why there is none: too few points, too many failed ones, or results that do not vary.
    pub fn fit(
        prior: &Prior,
        points: &SolvedPoints,
        levels: &[usize],
        seed: u64,
    ) -> Result<Self, String> {
        let coordinates: Vec<Vec<f64>> = (points.inputs.iter())
            .map(|values| prior.coordinates_of_values(values))
            .collect();
        let mut all = Vec::new();
        for level in levels {
            for (q, quantity) in ObservedQuantity::ALL.into_iter().enumerate() {
                let results: Vec<f64> = points.results.iter().map(|r| r[*level][q]).collect();
                let fitted = fit(prior, &coordinates, &results, points.of_prior, seed);
                let (expansion, held_out, deviation) = fitted.map_err(|reason| {
                    let name = match quantity {
                        ObservedQuantity::Frequency => "frequency",
                        ObservedQuantity::LogAmplitude => "amplitude",
                    };
                    format!("no surrogate of the {name} at level {level}, counted from 0: {reason}")
                })?;
                all.push(Surrogate {
                    level: *level,
                    quantity,
                    expansion,
                    held_out,
                    deviation,
                });
            }
        }
        Ok(Self { all })
    }

    /// Predictions at the coordinates `at`, in the order of [`Surrogates::all`].
    #[must_use]
    pub fn predict(&self, at: &[f64]) -> Vec<f64> {
        let expansions = self.all.iter().map(|surrogate| &surrogate.expansion);
        expansions.map(|expansion| expansion.predict(at)).collect()
    }
}

/// The surrogate of `results` over `coordinates`, its error held out, and its deviation. The first `of_prior` points are samples of
/// the prior. Shape of `coordinates`: points × inputs.
fn fit(
    prior: &Prior,
    coordinates: &[Vec<f64>],
    results: &[f64],
    of_prior: usize,
    seed: u64,
) -> Result<(Chaos, PredictionError, f64), String> {
    // of the prior alone: draws of a posterior without a solution are told by its check
    let samples = &results[..of_prior];
    let failed = samples.iter().filter(|r| !r.is_finite()).count();
    if failed as f64 > MOST_FAILED * samples.len() as f64 {
        return Err(format!(
            "{failed} of {} samples have no solution: must be at most {:.0} %, because a surrogate only guesses there; `microslip run` of the study \
             shows how they end",
            samples.len(),
            100.0 * MOST_FAILED
        ));
    }
    let samples = SurrogateSamples {
        basis: prior.polynomials(),
        inputs: coordinates,
        results,
    };
    let hold_out = HoldOutSettings {
        parts: PARTS,
        most_fitted: MOST_FITTED,
        seed,
    };
    let found = cross_fit(&samples, &hold_out, &ChaosSettings::default());
    let found = found.map_err(|refusal| match refusal {
        ChaosRefusal::TooFewLeft { .. } => format!("{refusal} (--samples)"),
        other => other.to_string(),
    })?;
    let held_out = found.error();
    let local = found.held_out_errors().filter(|(i, _)| *i >= of_prior);
    let local: Vec<f64> = local.map(|(_, error)| error).collect();
    let local = match local.len() < FEWEST_LOCAL {
        true => 0.0,
        false => root_mean_square(&local),
    };
    Ok((found.whole, held_out, held_out.rms.max(local)))
}

/// Root of the mean square; 0 of none.
#[must_use]
pub fn root_mean_square(values: &[f64]) -> f64 {
    let square: f64 = values.iter().map(|v| v * v).sum();
    (square / values.len().max(1) as f64).sqrt()
}
