//! A surrogate of the results over the inputs, corrected by samples that did not shape it (`statistics::cross_fit`).
//! Whatever it says is labelled "surrogate": no other number of a report comes from it.

use super::allowable::amplitude_limits_m;
use super::peaks::values;
use crate::ensemble::outcome::PeakRecord;
use crate::report::asked::surrogate::SurrogateSettings;
use crate::report::run::input::ReportInput;
use crate::report::run::record::{InputRecord, RunRecord};
use crate::sampling::Distribution;
use crate::sampling::stream::{SURROGATE, uniform};
use crate::statistics::{
    ChaosSettings, Exceedance, HoldOutSettings, Index, Observed, Polynomials, PredictionError,
    SurrogateExceedance, SurrogateSamples, cross_fit, exceedance,
};
use schemars::JsonSchema;
use serde::Serialize;

/// Samples that shape a surrogate at most: its cost grows with their number, its accuracy hardly beyond.
const MOST_FITTED: usize = 2000;
/// Largest share of failed samples: where they lie nothing shapes a surrogate and nothing checks it.
const MOST_FAILED: f64 = 0.05;
/// Points at which a surrogate is evaluated for a probability.
const POINTS: u64 = 100_000;

/// The surrogates at one excitation level.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelSurrogates {
    /// Of the resonance frequency (Hz).
    pub frequency: SurrogateResult,
    /// Of the amplitude (m).
    pub amplitude: SurrogateResult,
}

/// A surrogate, or why there is none.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SurrogateResult {
    /// A fitted one.
    Surrogate(Surrogate),
    /// Why there is none.
    Refused(String),
}

/// What a surrogate is worth and what it says.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Surrogate {
    /// Its errors at samples that did not shape it.
    pub held_out: PredictionError,
    /// Highest degree of its polynomials.
    pub degree: usize,
    /// Number of its terms.
    pub terms: usize,
    /// Samples that shaped it.
    pub fitted: usize,
    /// Samples without a solution, of all: where they lie it extrapolates.
    pub failed: usize,
    /// Sobol' indices, one per random input.
    pub indices: Vec<SurrogateIndex>,
    /// Probabilities of exceeding the limits that the study states; empty without, and for the frequency.
    pub exceedances: Vec<ExceedanceBoth>,
}

/// Shares of the variance by one input.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SurrogateIndex {
    /// Name of the input.
    pub input: String,
    /// By the input alone.
    pub first: Index,
    /// By the input and all its interactions.
    pub total: Index,
}

/// An exceedance probability of the surrogate beside that of the samples.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct ExceedanceBoth {
    /// By the surrogate; threshold in m.
    pub surrogate: SurrogateExceedance,
    /// By the samples.
    pub samples: Option<Exceedance>,
}

impl SurrogateResult {
    /// The surrogate, if there is one.
    #[must_use]
    pub fn surrogate(&self) -> Option<&Surrogate> {
        match self {
            Self::Surrogate(surrogate) => Some(surrogate),
            Self::Refused(_) => None,
        }
    }
}

/// Surrogates at level `i`; absent where the study wants none.
pub(in crate::report) fn surrogates(input: &ReportInput, i: usize) -> Option<LevelSurrogates> {
    let settings = input.record.surrogate?;
    let random = random_inputs(input.record);
    let shaped = |value: fn(&PeakRecord) -> f64, limits: &[f64]| {
        let results = values(input.outcomes, i, value);
        match surrogate(input, settings, &random, &results, limits) {
            Ok(surrogate) => SurrogateResult::Surrogate(surrogate),
            Err(reason) => SurrogateResult::Refused(reason),
        }
    };
    Some(LevelSurrogates {
        frequency: shaped(|p| p.frequency_hz, &[]),
        amplitude: shaped(|p| p.amplitude_m, &amplitude_limits_m(input.record, i)),
    })
}

/// A random input: its number among all and its distribution.
type Random<'a> = (usize, &'a InputRecord, &'a Distribution);

fn random_inputs(record: &RunRecord) -> Vec<Random<'_>> {
    let inputs = record.inputs.iter().enumerate();
    inputs
        .filter_map(|(j, input)| Some((j, input, input.distribution.as_ref()?)))
        .collect()
}

/// Fits, checks and reads one surrogate. Shape: `results[samples]`, NaN = failed.
fn surrogate(
    input: &ReportInput,
    settings: SurrogateSettings,
    random: &[Random],
    results: &[f64],
    limits: &[f64],
) -> Result<Surrogate, String> {
    let n = results.len();
    let failed = results.iter().filter(|v| !v.is_finite()).count();
    require_few(failed, n)?;
    let seed = input.record.provenance.seed;
    let of_law = |(_, _, law): &Random| Polynomials::of_law(law.is_gaussian());
    let basis: Vec<Polynomials> = random.iter().map(of_law).collect();
    let points: Vec<Vec<f64>> = input
        .outcomes
        .iter()
        .map(|o| coordinates(&basis, unit_point(random, &o.inputs)))
        .collect();
    let samples = SurrogateSamples {
        basis: &basis,
        inputs: &points,
        results,
    };
    let hold_out = HoldOutSettings {
        parts: (1.0 / settings.hold_out()).round() as usize,
        most_fitted: MOST_FITTED,
        seed,
    };
    let fit = cross_fit(&samples, &hold_out, &ChaosSettings::default());
    let fit = fit.map_err(|refusal| refusal.to_string())?;
    let names = random.iter().map(|(_, input, _)| input.name.clone());
    let observed = Observed::of(results.iter().copied());
    let confidence = input.record.confidence();
    Ok(Surrogate {
        held_out: fit.error(),
        degree: fit.whole.degree,
        terms: fit.whole.terms.len(),
        fitted: fit.whole.valid,
        failed,
        indices: (names.zip(fit.indices(confidence)))
            .map(|(input, index)| SurrogateIndex {
                input,
                first: index.first,
                total: index.total,
            })
            .collect(),
        exceedances: (limits.iter())
            .filter_map(|&limit| {
                let fresh = |i| coordinates(&basis, fresh_point(seed, i, random.len()));
                Some(ExceedanceBoth {
                    surrogate: fit.exceedance((0..POINTS).map(fresh), limit, confidence)?,
                    samples: exceedance(&observed, limit, confidence),
                })
            })
            .collect(),
    })
}

/// Refuses more failed samples of `n` than a surrogate can bear.
fn require_few(failed: usize, n: usize) -> Result<(), String> {
    match failed as f64 > MOST_FAILED * n as f64 {
        false => Ok(()),
        true => Err(format!(
            "{failed} of {n} samples have no solution: must be at most {:.0} %, because a surrogate only guesses there",
            100.0 * MOST_FAILED
        )),
    }
}

/// Coordinates of a point of the unit cube.
fn coordinates(basis: &[Polynomials], point: Vec<f64>) -> Vec<f64> {
    let pairs = basis.iter().zip(point);
    pairs.map(|(basis, u)| basis.coordinate(u)).collect()
}

/// Where the random inputs of a sample lie in the unit cube.
fn unit_point(random: &[Random], inputs: &[f64]) -> Vec<f64> {
    let place = |(j, _, distribution): &Random| distribution.cdf(inputs[*j]).clamp(0.0, 1.0);
    random.iter().map(place).collect()
}

/// Point `i` of a Monte Carlo sample that has no number in common with those of a study.
fn fresh_point(seed: u64, i: u64, inputs: usize) -> Vec<f64> {
    (SURROGATE..)
        .take(inputs)
        .map(|j| uniform(seed, i, j))
        .collect()
}
