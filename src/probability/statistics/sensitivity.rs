//! What the estimators of sensitivity share: an index with its interval, the verdict on it, and why there is none.

use super::hull::hull;
use std::fmt;

/// Share of the variance up to which an index counts as 0: a thousandth of the standard deviation, for peaks solved to
/// a millionth and scattered by no less than a thousandth. An input without influence still moves the last digits of a
/// solution, always by a variance above 0, so that no interval of it holds 0.
const RESOLUTION: f64 = 1e-6;

/// Whether an index differs from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Influence {
    /// The interval lies above 0, by more than the solutions resolve (a millionth of the variance).
    Distinct,
    /// The interval does not: these samples do not show an influence.
    NotDistinguishable,
}

impl fmt::Display for Influence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Distinct => "distinct from 0",
            Self::NotDistinguishable => "not distinguishable from 0",
        })
    }
}

/// A sensitivity index: share of the variance of a result.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Index {
    /// Estimate; may lie slightly below 0.
    pub estimate: f64,
    /// Lower confidence limit.
    pub lower: f64,
    /// Upper confidence limit.
    pub upper: f64,
    /// Verdict from the interval.
    pub influence: Influence,
}

impl Index {
    pub(super) fn new(estimate: f64, lower: f64, upper: f64) -> Self {
        let influence = match lower > RESOLUTION {
            true => Influence::Distinct,
            false => Influence::NotDistinguishable,
        };
        Self {
            estimate,
            lower,
            upper,
            influence,
        }
    }
}

/// Why there is no sensitivity index. None is better than a wrong 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SensitivityRefusal {
    /// Failed evaluations; leaving their rows out would change the inputs' law.
    #[error(
        "{failed} of {total} evaluations failed; leaving them out would bias the indices: solve them again, or use an \
         estimate from the given samples"
    )]
    Failed {
        /// Evaluations that failed.
        failed: usize,
        /// Evaluations in all.
        total: usize,
    },
    /// The result does not vary, by more than rounding.
    #[error("the result does not vary")]
    Constant,
    /// The input has one value.
    #[error("the input does not vary")]
    FixedInput,
    /// Samples whose neighbours in one input are not random in the others.
    #[error(
        "not available for one sequence of quasi-random points: neighbours in one input are not random in the others; \
         use replicates, a pick-freeze design or independent samples"
    )]
    OneSequence,
    /// Rows that share the values of several inputs.
    #[error(
        "rows repeat the values of several inputs, as designs for other estimates and chains do, so that neighbours in one input \
         are not random in the others; use independent rows, or the analysis that belongs to the design"
    )]
    RepeatedRows,
    /// Rows whose neighbours in one input are regularly far apart in another.
    #[error(
        "neighbours in one input are regularly far apart in another, as in a sequence of quasi-random points; use independent \
         rows, or the analysis that belongs to the design"
    )]
    RegularRows,
    /// Too few samples.
    #[error("{} too few, {needed} are needed", match found {
        1 => "1 sample is".to_owned(),
        n => format!("{n} samples are"),
    })]
    TooFew {
        /// Samples there are.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
    /// Numbers of columns, rows or results that do not fit together.
    #[error("the table has {found} entries where a multiple of {multiple} is needed")]
    Shape {
        /// Entries found.
        found: usize,
        /// Number whose multiple is needed.
        multiple: usize,
    },
    /// A resampling interval needs replicates and a confidence in (0, 1).
    #[error("a resampling interval needs 20 replicates and a confidence between 0 and 1")]
    Bootstrap,
}

/// Largest spread, relative to the largest value, that counts as rounding: a solution is located to a billionth, and what
/// is computed in another order from the same numbers differs by some 1e-15.
const ROUNDING: f64 = 1e-12;

/// Whether finite values differ by more than rounding. What does not vary has no index, no correlation and no fit.
#[must_use]
pub fn varies(values: impl Iterator<Item = f64>) -> bool {
    let differ = |[low, high]: [f64; 2]| high - low > ROUNDING * high.abs().max(low.abs());
    hull(values).is_some_and(differ)
}

/// Refuses results that hold a failed one, or fewer than `needed`.
pub(super) fn all_solved(results: &[f64], needed: usize) -> Result<(), SensitivityRefusal> {
    let failed = results.iter().filter(|v| !v.is_finite()).count();
    if failed > 0 {
        let total = results.len();
        return Err(SensitivityRefusal::Failed { failed, total });
    }
    if results.len() < needed {
        let found = results.len();
        return Err(SensitivityRefusal::TooFew { found, needed });
    }
    Ok(())
}

/// Refuses settings that give no interval.
pub(super) fn usable(bootstrap: &super::Bootstrap) -> Result<(), SensitivityRefusal> {
    let inside = bootstrap.confidence > 0.0 && bootstrap.confidence < 1.0;
    match inside && bootstrap.replicates >= 20 {
        true => Ok(()),
        false => Err(SensitivityRefusal::Bootstrap),
    }
}

/// Mean and variance (about it, with n) of finite values.
pub(super) fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let variance = values.map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean, variance)
}
