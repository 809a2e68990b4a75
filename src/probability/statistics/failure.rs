//! Where in the input space samples fail.

use super::bin::equal_count;
use super::proportion::{Proportion, proportion};
use statrs::distribution::{ContinuousCDF, Normal};

/// Failure rate of the samples between two values of an input.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct FailureBin {
    /// Smallest value of the input.
    pub lower: f64,
    /// Largest value of the input.
    pub upper: f64,
    /// Samples in the bin.
    pub samples: usize,
    /// Failed samples among them.
    pub failed: usize,
    /// Failure rate with its Clopper–Pearson interval.
    pub rate: Proportion,
}

/// How one input differs between failed and solved samples.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct FailurePattern {
    /// P(input of a failed sample > input of a solved one), ties half: ½ = no shift, 1 = all failures at large values.
    pub superiority: f64,
    /// Two-sided p-value of the shift (Mann–Whitney, normal approximation with ties).
    pub shift_p_value: f64,
    /// Largest distance between the two distribution functions; sees failures at both ends too.
    pub distance: f64,
    /// p-value of the distance (Kolmogorov–Smirnov, asymptotic).
    pub distance_p_value: f64,
    /// Failure rate over bins of equal count, ascending.
    pub bins: Vec<FailureBin>,
}

/// Failures over one input; `None` unless some samples failed and some did not, and confidence lies in (0, 1).
///
/// Shape: `inputs` and `failed` have one entry per sample. With many inputs one p-value in twenty is below 0.05 by chance.
/// Sources: Mann & Whitney, Ann. Math. Statist. 18 (1947) 50–60; Stephens, J. R. Statist. Soc. B 32 (1970) 115–122.
#[must_use]
pub fn failure_pattern(
    inputs: &[f64],
    failed: &[bool],
    bins: usize,
    confidence: f64,
) -> Option<FailurePattern> {
    assert_eq!(inputs.len(), failed.len(), "one flag per sample");
    let n_failed = failed.iter().filter(|&&f| f).count();
    if n_failed == 0 || n_failed == failed.len() {
        return None;
    }
    let bins = equal_count(inputs, bins).into_iter().map(|group| {
        let count = group.members.iter().filter(|&&i| failed[i]).count();
        Some(FailureBin {
            lower: group.lower,
            upper: group.upper,
            samples: group.members.len(),
            failed: count,
            rate: proportion(count, group.members.len(), confidence)?,
        })
    });
    let ranks = two_samples(inputs, failed);
    Some(FailurePattern {
        superiority: ranks.superiority,
        shift_p_value: ranks.shift_p_value,
        distance: ranks.distance,
        distance_p_value: kolmogorov_p_value(ranks.distance, n_failed, failed.len() - n_failed),
        bins: bins.collect::<Option<_>>()?,
    })
}

struct TwoSamples {
    superiority: f64,
    shift_p_value: f64,
    distance: f64,
}

/// Rank statistics of the flagged samples against the others; both exist.
fn two_samples(inputs: &[f64], flagged: &[bool]) -> TwoSamples {
    let n = inputs.len() as f64;
    let m = flagged.iter().filter(|&&f| f).count() as f64;
    let rest = n - m;
    // Equal values form one step: pairs within it count half, and it reduces the variance of the rank sum.
    let steps = tied_steps(inputs, flagged);
    let (mut wins, mut ties, mut distance) = (0.0, 0.0, 0.0_f64);
    let (mut seen, mut seen_rest) = (0.0, 0.0);
    for (in_step, rest_in_step) in steps {
        wins += in_step * (seen_rest + rest_in_step / 2.0);
        let size = in_step + rest_in_step;
        ties += size * (size * size - 1.0);
        seen += in_step;
        seen_rest += rest_in_step;
        distance = distance.max((seen / m - seen_rest / rest).abs());
    }
    let variance = m * rest / 12.0 * (n + 1.0 - ties / (n * (n - 1.0)));
    let z = if variance > 0.0 {
        (wins - m * rest / 2.0) / variance.sqrt()
    } else {
        0.0
    };
    TwoSamples {
        superiority: wins / (m * rest),
        shift_p_value: 2.0 * Normal::standard().cdf(-z.abs()),
        distance,
    }
}

/// Number of flagged and of other samples at each distinct value, ascending.
fn tied_steps(inputs: &[f64], flagged: &[bool]) -> Vec<(f64, f64)> {
    let mut order: Vec<usize> = (0..inputs.len()).collect();
    order.sort_by(|&i, &j| inputs[i].total_cmp(&inputs[j]));
    let count = |step: &[usize]| {
        let inside = step.iter().filter(|&&i| flagged[i]).count();
        (inside as f64, (step.len() - inside) as f64)
    };
    order
        .chunk_by(|&i, &j| inputs[i] == inputs[j])
        .map(count)
        .collect()
}

/// 2 Σ (−1)^(k−1) exp(−2 k² λ²) with Stephens' λ for finite samples.
fn kolmogorov_p_value(distance: f64, m: usize, n: usize) -> f64 {
    let size = ((m * n) as f64 / (m + n) as f64).sqrt();
    let lambda = (size + 0.12 + 0.11 / size) * distance;
    if lambda < 0.2 {
        return 1.0; // the series converges slowly there, to 1 within 1e-12
    }
    let term = |k: f64| (-2.0 * (k * lambda).powi(2)).exp();
    let series: f64 = (1..=100)
        .map(|k| match k % 2 {
            1 => term(f64::from(k)),
            _ => -term(f64::from(k)),
        })
        .sum();
    (2.0 * series).clamp(0.0, 1.0)
}
