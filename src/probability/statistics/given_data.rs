//! Sensitivity from samples that exist already: no evaluation is added.

use super::bin::equal_count;
use super::bootstrap::Bootstrap;
use super::limit::Interval;
use super::moment::{MomentEstimate, moment_estimate};
use super::observed::Observed;
use super::sensitivity::{Index, SensitivityRefusal, mean_and_variance, varies};
use statrs::distribution::{ContinuousCDF, Normal};

/// First-order index of one input from given samples.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct GivenDataIndex {
    /// The index among the samples that did not fail.
    pub index: Index,
    /// Samples that did not fail.
    pub valid: usize,
    /// Failed samples. With any, the index describes the solved part of the input space only, and must be read so.
    pub failed: usize,
}

/// Samples that give an index. Shape: one input and one result per sample; a result that is not finite is a failed sample.
#[derive(Debug, Clone, Copy)]
pub struct GivenData<'a> {
    /// Values of one input, finite and independent of the other inputs.
    pub inputs: &'a [f64],
    /// The results.
    pub results: &'a [f64],
    /// Replicate of each sample of a quasi-random design, one number for all where it has only one sequence; absent for
    /// samples whose other inputs are random.
    pub replicates: Option<&'a [u64]>,
    /// Seed of the order of samples with the same input.
    pub seed: u64,
    /// Confidence of the interval, in (0, 1).
    pub confidence: f64,
}

/// Fewest samples of an index from given samples.
const FEWEST: usize = 160;
/// Fewest replicates of a quasi-random design.
const FEWEST_REPLICATES: usize = 2;
/// The interval is wider than the normal law has it by this many n-ths, for the few samples that the spread of their
/// squares is known from: measured, as the factor for replicates (`cargo bench --bench coverage`).
const SMALL_SAMPLE: f64 = 30.0;

/// First-order index Var(E[result | input]) / Var(result) by ranks, with its interval.
///
/// Samples in ascending order of the input: half the mean square difference of neighbours estimates E[Var(result |
/// input)], and 1 − Σ (y_{i+1} − y_i)² / (2 (n − 1) s²) the index. The last sample has no neighbour: the first one is none
/// (it would bias the index of a dominant input by −6/n). What the neighbours' inputs differ biases the index by a share
/// that falls with n²; neighbours of second order show it, and the upper limit holds it.
///
/// Samples of the same input stand in random order, so that the other inputs are not sorted within (a grid, a file).
/// Neighbours in one sequence of quasi-random points differ in the other inputs by rule: only those of different replicates
/// count, R replicates widen the interval by √(R/(R − 1)), and one sequence alone has no index.
///
/// The terms of the estimate depend on their neighbours alone. So their variance is γ₀ + 2 (γ₁ − γ₂) of
/// the autocovariances along the order, the trend along the input left out. The interval is the hull of the intervals of the index and of
/// ln(1 − index), at most 1. Sources: Chatterjee, J. Amer. Statist. Assoc. 116 (2021) 2009–2022; Gamboa, Gremaud, Klein &
/// Lagnoux, Bernoulli 28 (2022) 2345–2374.
///
/// # Errors
///
/// Fewer than 160 solved samples, a result or an input that does not vary, one sequence of quasi-random points, confidence
/// outside (0, 1).
pub fn first_order_index(data: &GivenData) -> Result<GivenDataIndex, SensitivityRefusal> {
    assert_eq!(
        data.inputs.len(),
        data.results.len(),
        "one result per sample"
    );
    if data.confidence <= 0.0 || data.confidence >= 1.0 {
        return Err(SensitivityRefusal::Bootstrap);
    }
    let ordered = in_order(data);
    let (found, needed) = (ordered.len(), FEWEST);
    if found < needed {
        return Err(SensitivityRefusal::TooFew { found, needed });
    }
    if !varies(ordered.iter().map(|s| s.result)) {
        return Err(SensitivityRefusal::Constant);
    }
    let solved = (data.inputs.iter().zip(data.results)).filter(|(_, result)| result.is_finite());
    if !varies(solved.map(|(input, _)| *input)) {
        return Err(SensitivityRefusal::FixedInput);
    }
    let replicates = data.replicates.map(|all| {
        let mut all = all.to_vec();
        all.sort_unstable();
        all.dedup();
        all.len()
    });
    if replicates.is_some_and(|n| n < FEWEST_REPLICATES) {
        return Err(SensitivityRefusal::OneSequence);
    }
    let neighbours = Neighbours::of(&ordered);
    let z = Normal::standard().inverse_cdf((1.0 + data.confidence) / 2.0);
    let small = 1.0 + SMALL_SAMPLE / found as f64;
    let shared = replicates.map_or(1.0, |n| (n as f64 / (n as f64 - 1.0)).sqrt());
    Ok(GivenDataIndex {
        index: neighbours.index(z * small * shared),
        valid: found,
        failed: data.results.len() - found,
    })
}

/// A solved sample.
struct Solved {
    result: f64,
    /// Its replicate, or a number of its own.
    group: u64,
}

/// Solved samples in the order of the input, those of the same input in random order.
fn in_order(data: &GivenData) -> Vec<Solved> {
    let solved = |i: usize| Solved {
        result: data.results[i],
        group: data.replicates.map_or(i as u64, |all| all[i]),
    };
    let places = ascending(data.inputs, data.seed).into_iter();
    let places = places.filter(|&i| data.results[i].is_finite());
    places.map(solved).collect()
}

/// Places of `values` in ascending order, those of the same value in random order.
pub(super) fn ascending(values: &[f64], seed: u64) -> Vec<usize> {
    let draw = Bootstrap {
        seed,
        replicates: 1,
        confidence: 0.95,
    };
    let random = draw.permutation(0, values.len());
    let mut places: Vec<usize> = (0..values.len()).collect();
    // random numbers are distinct, so that there is one order
    places.sort_unstable_by(|&a, &b| {
        let by_value = values[a].total_cmp(&values[b]);
        by_value.then(random[a].cmp(&random[b]))
    });
    places
}

/// What the differences of neighbours say.
struct Neighbours {
    /// E[Var(result | input)] over Var(result).
    rest: f64,
    /// Standard error of that.
    error: f64,
    /// How much less it may be: what neighbours of second order differ more.
    bias: f64,
}

impl Neighbours {
    fn of(ordered: &[Solved]) -> Self {
        let y = || ordered.iter().map(|s| s.result);
        let (mean, variance) = mean_and_variance(y());
        let variance = variance * ordered.len() as f64 / (ordered.len() as f64 - 1.0);
        let half_square = |lag: usize| {
            let pairs = ordered.iter().zip(&ordered[lag..]);
            let different = pairs.filter(|(a, b)| a.group != b.group);
            average(different.map(|(a, b)| (a.result - b.result).powi(2) / 2.0))
        };
        let (first, second) = (half_square(1), half_square(2));
        let rest = first / variance;
        let square = |s: &Solved| (s.result - mean).powi(2);
        let term = |pair: &[Solved]| match pair[0].group == pair[1].group {
            true => None,
            false => {
                let half = (pair[0].result - pair[1].result).powi(2) / 2.0;
                let share = rest * (square(&pair[0]) + square(&pair[1])) / 2.0;
                Some((half - share) / variance)
            }
        };
        // computed again for each lag: kept, they would take as much memory as the results
        let terms = |first: usize| ordered[first..].windows(2).map(term);
        let covariance = |lag: usize| {
            let pairs = terms(0).zip(terms(lag));
            average(pairs.filter_map(|(a, b)| Some(a? * b?)))
        };
        let own = covariance(0);
        let spread = (own + 2.0 * (covariance(1) - covariance(2))).max(0.5 * own);
        let count = terms(0).flatten().count() as f64;
        Self {
            rest,
            error: (spread / count).sqrt(),
            bias: ((second - first) / variance).max(0.0),
        }
    }

    /// The index with the hull of both intervals, `z` standard errors to each side.
    fn index(&self, z: f64) -> Index {
        let Self { rest, error, bias } = *self;
        let estimate = 1.0 - rest;
        let half = z * error;
        let factor = match rest > 0.0 {
            true => (half / rest).exp(),
            false => 1.0,
        };
        let lower = (estimate - half).min(1.0 - rest * factor);
        let upper = (estimate + half).max(1.0 - rest / factor + bias.min(rest));
        Index::new(estimate, lower, upper.min(1.0))
    }
}

/// Mean of some numbers; 0 without any.
fn average(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0));
    match n > 0.0 {
        true => sum / n,
        false => 0.0,
    }
}

/// Mean of a result where an input lies between two values.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ConditionalMean {
    /// Smallest value of the input.
    pub lower: f64,
    /// Largest value of the input.
    pub upper: f64,
    /// Samples, failed ones included.
    pub samples: usize,
    /// Failed samples among them.
    pub failed: usize,
    /// Moments of the result with intervals; absent where fewer than two samples are solved.
    pub moments: Option<MomentEstimate>,
}

/// Means of a result over bins of equal count along an input, ascending.
///
/// Shape: one input and one result per sample; a result that is not finite is a failed sample, and could have had any
/// value in `possible`.
#[must_use]
pub fn conditional_means(
    inputs: &[f64],
    results: &[f64],
    bins: usize,
    possible: Interval,
    confidence: f64,
) -> Vec<ConditionalMean> {
    assert_eq!(inputs.len(), results.len(), "one result per sample");
    let mean = |group: super::bin::Group| {
        let observed = Observed::of(group.members.iter().map(|&i| results[i]));
        ConditionalMean {
            lower: group.lower,
            upper: group.upper,
            samples: observed.total(),
            failed: observed.failed(),
            moments: moment_estimate(&observed, possible, confidence),
        }
    };
    equal_count(inputs, bins).into_iter().map(mean).collect()
}
