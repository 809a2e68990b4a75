//! Sensitivity from samples that exist already, of any design: no evaluation is added.

use super::bin::equal_count;
use super::bootstrap::Bootstrap;
use super::limit::Interval;
use super::moment::{MomentEstimate, moment_estimate};
use super::observed::Observed;
use super::sensitivity::{Index, SensitivityRefusal, all_solved, mean_and_variance, usable};
use statrs::distribution::{ContinuousCDF, Normal};

/// First-order index of one input from given samples.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct GivenDataIndex {
    /// The index among the samples that did not fail.
    pub index: Index,
    /// Samples that did not fail.
    pub valid: usize,
    /// Failed samples. With any, the index describes the solved part of the input space only, and must be read so.
    pub failed: usize,
}

/// A subsample holds one in this many samples.
const SHARE: usize = 10;
/// Fewest samples of an index from given samples, so that a subsample holds 16.
const FEWEST: usize = 16 * SHARE;

/// First-order index Var(E[result | input]) / Var(result) by ranks, with a subsampling interval.
///
/// Samples in ascending order of the input: the product of neighbouring results estimates E[E[result | input]²]. Bias and
/// noise both fall with n, without any bin width. Neither the bootstrap nor the jackknife is consistent for products of
/// neighbours; the spread s of random tenths of the samples is: with m of n samples, estimate ∓ z s √(m/(n − m)).
///
/// Shape: one input and one result per sample; a result that is not finite is a failed sample. Inputs must be finite and
/// independent of each other. With the indicator of failure as result: which input the failures depend on.
/// Sources: Gamboa, Gremaud, Klein & Lagnoux, Bernoulli 28 (2022) 2345–2374; Politis & Romano, Ann. Statist. 22 (1994)
/// 2031–2050 (subsampling); Lin & Han, Biometrika 111 (2024) 1063–1070 (failure of the bootstrap).
///
/// # Errors
///
/// Fewer than 160 solved samples, a result that does not vary, settings that give no interval.
pub fn first_order_index(
    inputs: &[f64],
    results: &[f64],
    bootstrap: &Bootstrap,
) -> Result<GivenDataIndex, SensitivityRefusal> {
    assert_eq!(inputs.len(), results.len(), "one result per sample");
    usable(bootstrap)?;
    let pairs = inputs.iter().zip(results);
    let mut pairs: Vec<(f64, f64)> = pairs.map(|(&x, &y)| (x, y)).collect();
    pairs.retain(|(_, y)| y.is_finite());
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ordered: Vec<f64> = pairs.iter().map(|p| p.1).collect();
    all_solved(&ordered, FEWEST)?;
    let (mean, variance) = mean_and_variance(ordered.iter().copied());
    if variance <= (1e-14 * mean).powi(2) {
        return Err(SensitivityRefusal::Constant);
    }
    let estimate = neighbour_index(&ordered);
    let (n, m) = (ordered.len(), ordered.len() / SHARE);
    let replicate = |r: u32| {
        let part = bootstrap.subsample(r, n, m);
        let part: Vec<f64> = part.into_iter().map(|i| ordered[i]).collect();
        neighbour_index(&part)
    };
    let replicates: Vec<f64> = (0..bootstrap.replicates).map(replicate).collect();
    // A subsample without variation has no index: the result is constant but for few samples.
    all_solved(&replicates, 0).map_err(|_| SensitivityRefusal::Constant)?;
    let (_, spread) = mean_and_variance(replicates.iter().copied());
    let z = Normal::standard().inverse_cdf((1.0 + bootstrap.confidence) / 2.0);
    let half = z * (spread * m as f64 / (n - m) as f64).sqrt();
    Ok(GivenDataIndex {
        index: Index::new(estimate, (estimate - half, estimate + half)),
        valid: ordered.len(),
        failed: results.len() - ordered.len(),
    })
}

/// Mean product of neighbours about the mean over the variance; the last one's neighbour is the first.
fn neighbour_index(ordered: &[f64]) -> f64 {
    let (mean, variance) = mean_and_variance(ordered.iter().copied());
    let next = ordered.iter().cycle().skip(1);
    let products = ordered.iter().zip(next);
    let product: f64 = products.map(|(a, b)| (a - mean) * (b - mean)).sum();
    product / ordered.len() as f64 / variance
}

/// Mean of a result where an input lies between two values.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
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
