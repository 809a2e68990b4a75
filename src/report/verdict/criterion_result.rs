//! What is said of a criterion: its judgement, in words and level by level.

use super::over_box::OverBox;
use crate::report::asked::requirement::Criterion;
use crate::statistics::{Counted, Interval, Judgement, Remedy};
use schemars::JsonSchema;
use serde::Serialize;

/// A criterion and its judgement.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CriterionResult {
    /// As the study file states it.
    pub criterion: Criterion,
    /// The worst of its levels: FAIL before UNDECIDED before PASS.
    pub judgement: Judgement,
    /// Whether the samples are no independent draws, so that the judgement is an indication and has no confidence.
    pub indication: bool,
    /// What was found, asked and, if undecided, what would decide.
    pub sentence: String,
    /// One entry per level that it holds for.
    pub levels: Vec<LevelResult>,
    /// The level, or outer point of one, that takes more than the level that decides, where the judgement is UNDECIDED; absent where
    /// none does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardest: Option<LevelResult>,
    /// The same with inputs of flat distributions taken as known to an interval only; absent without such inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_intervals: Option<IgnoranceResult>,
}

/// A criterion at one excitation level.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelResult {
    /// Excitation level (N on each blade for the built-in model, else a factor).
    pub level: f64,
    /// Number that is judged, from the samples with a trusted solution: the quantile that leaves out 1 − share, or the
    /// probability; where no input is random the result itself, or 0 or 1. In the unit of the limit. Absent without samples.
    pub estimate: Option<f64>,
    /// Where it lies: the side that passes holds with the confidence of the criterion, the side that fails with it at all
    /// levels and outer points together; whatever samples without a trusted solution would have given, and wherever the
    /// others lie within their numerical errors.
    pub interval: Interval,
    /// Judgement.
    pub judgement: Judgement,
    /// Samples by what they say about the limit.
    #[serde(flatten)]
    pub counted: Counted,
    /// Why samples are unknown.
    pub unknown_because: Unknown,
    /// What the numerical error of the samples does to the interval.
    pub numerical_error: NumericalWidth,
    /// Frequency of PASS if the truth were better than the limit; absent where no input is random.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<Power>,
    /// What would decide; absent where the judgement is PASS or FAIL.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<Remedy>,
    /// Engine order with the smallest margin in most of the samples at the estimate; absent for other quantities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine_order: Option<u32>,
    /// The outer point of the epistemic inputs that decides: the criterion must hold at each. Absent without such inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outer: Option<u64>,
    /// Where over the epistemic inputs the limit is kept and where not; absent without such inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_box: Option<OverBox>,
}

/// Samples that may keep a limit or break it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Unknown {
    /// Without a solution.
    pub failed: usize,
    /// With one that is not to be trusted: unstable, bouncing, or with a truncation error above the threshold.
    pub untrusted: usize,
    /// With the limit inside their numerical error.
    pub within_error: usize,
}

/// How far the numerical error of the samples moves the limits of an interval.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NumericalWidth {
    /// The lower limit, downwards, in the unit of the criterion; absent where the limit is open.
    pub lower: Option<f64>,
    /// The upper limit, upwards, likewise.
    pub upper: Option<f64>,
    /// Sources of error that nobody estimated and that are not in it.
    pub not_estimated: Vec<&'static str>,
}

/// How often a study of so many samples, all of them known, passes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Power {
    /// Share of the population that is taken to keep the limit: half of what may break it does.
    pub kept: f64,
    /// Probability of PASS.
    pub probability: f64,
    /// Samples with which it reaches 90 %; absent beyond a million.
    pub samples_for_90_percent: Option<usize>,
}

/// A judgement with inputs taken as known to an interval only.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct IgnoranceResult {
    /// The inputs with uniform and log-uniform distributions.
    pub inputs: Vec<String>,
    /// FAIL, or UNDECIDED: samples of a prior never show that a limit holds everywhere.
    pub judgement: Judgement,
    /// What it rests on, or what would decide.
    pub basis: String,
}

impl CriterionResult {
    /// The level that decides: of those with the judgement of all, the one with the worst estimate.
    #[must_use]
    pub fn deciding(&self) -> Option<&LevelResult> {
        let levels = self.levels.iter().filter(|l| l.judgement == self.judgement);
        levels.max_by(|a, b| a.cost(&self.criterion).total_cmp(&b.cost(&self.criterion)))
    }
}

impl LevelResult {
    /// The larger, the worse. Without an estimate nothing is known: that is the worst.
    pub(super) fn cost(&self, criterion: &Criterion) -> f64 {
        match self.estimate {
            None => f64::INFINITY,
            Some(v) if criterion.quantity.at_least() => -v,
            Some(v) => v,
        }
    }
}
