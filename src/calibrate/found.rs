//! What a calibration has found: `calibration.json`.

use super::observation::{Observation, ObservedQuantity};
use super::settings::CalibrationSettings;
use crate::ensemble::program::Program;
use crate::file::FileRecord;
use crate::sampling::Distribution;
use crate::statistics::{Mixing, PredictionError};
use schemars::JsonSchema;
use serde::Serialize;

/// A calibration with its draws.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// Summary.
    pub summary: Calibration,
    /// Values of the random inputs. Shape: chains × draws × inputs, in the order of the summary's.
    pub draws: Vec<Vec<Vec<f64>>>,
}

/// Where a calibration comes from.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Origin {
    /// Name of the study.
    pub study: String,
    /// The program that calibrated.
    pub program: Program,
    /// The study file.
    pub study_file: FileRecord,
    /// The files that the study names.
    pub files: Vec<FileRecord>,
    /// The measured response.
    pub measured_file: FileRecord,
    /// Excitation levels of the study, of which observations give the places.
    pub levels: Vec<f64>,
}

/// A calibration: what went in, what is known now, and what checks it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Calibration {
    /// Where it comes from.
    #[serde(flatten)]
    pub origin: Origin,
    /// What was asked for.
    pub settings: CalibrationSettings,
    /// Rounds of fit, chains and check by the solver.
    pub rounds: Vec<Round>,
    /// The random inputs.
    pub inputs: Vec<CalibratedInput>,
    /// Correlation of the ranks of the inputs under the posterior (Spearman). Shape: square.
    pub rank_correlation: Vec<Vec<f64>>,
    /// Standard deviations of the model, where a discrepancy was asked for.
    pub deviations: Vec<FoundDeviation>,
    /// What was measured beside what is predicted.
    pub observations: Vec<Checked>,
    /// Posterior predictive p-value of all observations together; small = the model misfits.
    pub misfit_probability: f64,
    /// Share of the proposed moves of the chains that were taken.
    pub acceptance: f64,
    /// What to look at before the result is used.
    pub warnings: Vec<String>,
}

/// A round of fit, chains and check.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Round {
    /// Solved points that shaped the surrogates.
    pub points: usize,
    /// Draws of the posterior that were solved.
    pub checked: usize,
    /// Those of them without a solution at a measured level.
    pub failed: usize,
    /// Largest ratio, over levels and quantities, of the error at the solved draws (root mean square) to the one that entered the
    /// likelihood, or to a tenth of the measurement's standard deviation where that is larger; absent if no draw has a solution.
    pub worst_ratio: Option<f64>,
}

/// An input before and after.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CalibratedInput {
    /// Name.
    pub name: String,
    /// Its distribution in words.
    pub distribution: String,
    /// The same as it is.
    #[serde(skip)]
    pub law: Distribution,
    /// Quantiles before.
    pub prior: Quantiles,
    /// Quantiles after.
    pub posterior: Quantiles,
    /// Share of the posterior beyond the 2 % and the 98 % quantile of the prior; 0.04 where nothing was learnt.
    pub beyond_prior: f64,
    /// How well the chains agree; absent where they do not move.
    pub mixing: Option<Mixing>,
}

/// Quantiles of a number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Quantiles {
    /// 2.5 %.
    pub q025: f64,
    /// 25 %.
    pub q25: f64,
    /// 50 %.
    pub q50: f64,
    /// 75 %.
    pub q75: f64,
    /// 97.5 %.
    pub q975: f64,
}

/// Probabilities of [`Quantiles`].
pub const PROBABILITIES: [f64; 5] = [0.025, 0.25, 0.5, 0.75, 0.975];

impl Quantiles {
    /// Quantiles by their function.
    #[must_use]
    pub fn by(quantile: impl Fn(f64) -> f64) -> Self {
        let [q025, q25, q50, q75, q975] = PROBABILITIES.map(quantile);
        Self {
            q025,
            q25,
            q50,
            q75,
            q975,
        }
    }

    /// Quantiles of draws, none of which is NaN: linear between order statistics. All NaN of no draws.
    #[must_use]
    pub fn of(mut draws: Vec<f64>) -> Self {
        draws.sort_by(f64::total_cmp);
        Self::by(|p| {
            let place = p * draws.len().saturating_sub(1) as f64;
            let (below, share) = (place.floor() as usize, place.fract());
            let at = |i: usize| draws.get(i).or(draws.last()).copied().unwrap_or(f64::NAN);
            at(below) + share * (at(below + 1) - at(below))
        })
    }
}

/// A standard deviation of the model that was unknown.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FoundDeviation {
    /// The quantity; of a frequency in Hz, of an amplitude relative.
    pub quantity: ObservedQuantity,
    /// Its quantiles.
    pub posterior: Quantiles,
    /// How well the chains agree.
    pub mixing: Option<Mixing>,
}

/// A measured mean beside what the model predicts of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Checked {
    /// The measured mean.
    pub measured: Observation,
    /// The surrogate's error at samples that did not shape it.
    pub held_out: PredictionError,
    /// Standard deviation of its error that entered the likelihood.
    pub surrogate_deviation: f64,
    /// Its error at the draws of the posterior that were solved last (root mean square); absent if none has a solution.
    pub error_at_posterior: Option<f64>,
    /// Quantiles of the model's prediction before: of the inputs alone, without measurement error.
    pub prior: Quantiles,
    /// The same after.
    pub posterior: Quantiles,
    /// Probability of a mean below the measured one before; 0 or 1 where the prior does not reach it.
    pub below_by_prior: f64,
    /// The same after: near 0 or 1 where the calibrated model misses it.
    pub below_by_posterior: f64,
}
