//! A surrogate of the results over the inputs, checked against samples that did not shape it. Whatever it says is
//! labelled "surrogate": no other number of a report comes from it.

use super::ReportInput;
use super::assessment::values;
use super::epistemic::amplitude_limits_m;
use super::record::{InputRecord, RunRecord};
use super::summary::CONFIDENCE;
use crate::ensemble::outcome::PeakRecord;
use crate::sampling::Distribution;
use crate::sampling::stream::{SURROGATE, uniform};
use crate::setting::BadSetting;
use crate::statistics::{
    Bootstrap, Chaos, ChaosSettings, Exceedance, Observed, SurrogateExceedance, exceedance,
    fit_chaos,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of a surrogate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SurrogateKind {
    /// Sparse polynomial chaos (`statistics::chaos`).
    PolynomialChaos,
}

/// `[surrogate]` of a study file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurrogateSettings {
    /// Kind of the surrogate.
    pub kind: SurrogateKind,
    /// Share of the samples that check it and do not shape it; 0.2 if absent.
    #[schemars(range(min = 0.05, max = 0.5))]
    hold_out: Option<f64>,
}

impl SurrogateSettings {
    /// Share of the samples that check it.
    #[must_use]
    pub fn hold_out(&self) -> f64 {
        self.hold_out.unwrap_or(0.2)
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[surrogate]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        let share = self.hold_out();
        let rule = "must be from 0.05 to 0.5";
        BadSetting::unless((0.05..=0.5).contains(&share), "hold_out", share, rule)
    }
}

/// Samples that shape a surrogate at most: its cost grows with their number, its accuracy hardly beyond.
const MOST_FITTED: usize = 2000;
/// Largest share of failed samples: where they lie nothing shapes a surrogate and nothing checks it.
const MOST_FAILED: f64 = 0.05;
/// Points at which a surrogate is evaluated for a probability.
const POINTS: u64 = 100_000;

/// The surrogates at one excitation level.
#[derive(Debug, Clone, Serialize)]
pub struct LevelSurrogates {
    /// Of the resonance frequency (Hz).
    pub frequency: SurrogateResult,
    /// Of the amplitude (m).
    pub amplitude: SurrogateResult,
}

/// A surrogate, or why there is none.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SurrogateResult {
    /// A fitted one.
    Surrogate(Surrogate),
    /// Why there is none.
    Refused(String),
}

/// What a surrogate is worth and what it says.
#[derive(Debug, Clone, Serialize)]
pub struct Surrogate {
    /// Share of the variance that it predicts, by leave-one-out cross-validation; 1 = exact, 0 = no better than the mean.
    pub q2: f64,
    /// Root mean square of the leave-one-out error, in the unit of the result.
    pub cross_validation_error: f64,
    /// Highest degree of its polynomials.
    pub degree: usize,
    /// Number of its terms.
    pub terms: usize,
    /// Samples that shaped it.
    pub fitted: usize,
    /// Samples without a solution, of all: where they lie it extrapolates.
    pub failed: usize,
    /// Its errors at samples that did not shape it.
    pub hold_out: HoldOut,
    /// Sobol' indices of its own, one per random input.
    pub indices: Vec<SurrogateIndex>,
    /// Probabilities of exceeding the limits that the study states; empty without, and for the frequency.
    pub exceedances: Vec<ExceedanceBoth>,
}

/// Solver against surrogate at samples that did not shape it.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct HoldOut {
    /// Solved samples.
    pub samples: usize,
    /// Root mean square difference, in the unit of the result.
    pub rms_error: f64,
    /// Largest difference, in the unit of the result.
    pub largest_error: f64,
}

/// Shares of a surrogate's variance by one input.
#[derive(Debug, Clone, Serialize)]
pub struct SurrogateIndex {
    /// Name of the input.
    pub input: String,
    /// By the input alone.
    pub first: f64,
    /// By the input and all its interactions.
    pub total: f64,
}

/// An exceedance probability of the surrogate beside that of the samples.
#[derive(Debug, Clone, Copy, Serialize)]
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
pub(super) fn surrogates(input: &ReportInput, i: usize) -> Option<LevelSurrogates> {
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
    if failed as f64 > MOST_FAILED * n as f64 {
        return Err(format!(
            "{failed} of {n} samples have no solution: must be at most {:.0} %, because a surrogate only guesses there",
            100.0 * MOST_FAILED
        ));
    }
    let seed = input.record.provenance.seed;
    let points: Vec<Vec<f64>> = input
        .outcomes
        .iter()
        .map(|o| unit_point(random, &o.inputs))
        .collect();
    let held = (settings.hold_out() * n as f64).ceil() as usize;
    let fitted = (n - held).min(MOST_FITTED);
    // drawn, not every k-th: a grid would lose whole planes
    let draw = Bootstrap {
        seed,
        replicates: 1,
        confidence: CONFIDENCE,
    };
    let mut shapes = vec![false; n];
    (draw.subsample(0, n, fitted))
        .into_iter()
        .for_each(|k| shapes[k] = true);
    let part = |chosen: bool| -> (Vec<Vec<f64>>, Vec<f64>) {
        let members = (0..n).filter(|&k| shapes[k] == chosen);
        members.map(|k| (points[k].clone(), results[k])).unzip()
    };
    let (shaping, shaping_results) = part(true);
    let chaos = fit_chaos(&shaping, &shaping_results, &ChaosSettings::default());
    let chaos = chaos.map_err(|refusal| refusal.to_string())?;
    let (checking, checking_results) = part(false);
    let names = random.iter().map(|(_, input, _)| input.name.clone());
    let observed = Observed::of(results.iter().copied());
    Ok(Surrogate {
        q2: chaos.q2,
        cross_validation_error: chaos.error,
        degree: chaos.degree,
        terms: chaos.terms.len(),
        fitted: chaos.valid,
        failed,
        hold_out: HoldOut::of(&chaos, &checking, &checking_results)
            .ok_or("no sample that was held out has a solution")?,
        indices: (names.zip(chaos.indices()))
            .map(|(input, index)| SurrogateIndex {
                input,
                first: index.first,
                total: index.total,
            })
            .collect(),
        exceedances: (limits.iter())
            .filter_map(|&limit| {
                let points = (0..POINTS).map(|i| fresh_point(seed, i, random.len()));
                Some(ExceedanceBoth {
                    surrogate: chaos.exceedance(points, limit, CONFIDENCE)?,
                    samples: exceedance(&observed, limit, CONFIDENCE),
                })
            })
            .collect(),
    })
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

impl HoldOut {
    /// `None` where no result is solved.
    fn of(chaos: &Chaos, points: &[Vec<f64>], results: &[f64]) -> Option<Self> {
        let solved = points.iter().zip(results).filter(|(_, y)| y.is_finite());
        let errors: Vec<f64> = solved.map(|(u, y)| (chaos.predict(u) - y).abs()).collect();
        let n = errors.len();
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        (n > 0).then(|| Self {
            samples: n,
            rms_error: (squares / n as f64).sqrt(),
            largest_error: errors.into_iter().fold(0.0, f64::max),
        })
    }
}
