//! Cycles at the start in which the loop still changes.

use super::mean_loop::{MeanLoop, inner_range};

/// Fewest cycles that are left.
const LEAST_CYCLES: usize = 5;
/// The rule must make the variance of the mean this many times smaller; by chance it does so in one record of fifty.
const GAIN: f64 = 0.2;

/// Cycles to leave out, at most half of them: those after which the mean of the others has the smallest standard error, for the
/// energy of the loop or its mean |T/N|, whichever needs more.
///
/// Source: White, Simulation 69 (1997) 323–334 (marginal standard error rule).
pub(super) fn run_in(loops: &[MeanLoop]) -> usize {
    if loops.len() < LEAST_CYCLES {
        return 0;
    }
    let clipped: Vec<MeanLoop> = loops.iter().map(clipped).collect();
    let energy = clipped.iter().map(MeanLoop::energy).collect();
    let force = clipped.iter().map(|cycle| {
        let absolute: f64 = cycle.tangential.iter().map(|t| t.abs()).sum();
        absolute / cycle.normal.iter().sum::<f64>()
    });
    let measures: [Vec<f64>; 2] = [energy, force.collect()];
    measures
        .iter()
        .map(|values| truncated(values))
        .max()
        .unwrap_or(0)
}

/// The loop without the greatest and least forces, which may be spikes.
fn clipped(cycle: &MeanLoop) -> MeanLoop {
    let [low, high] = inner_range(&cycle.tangential);
    let mut clipped = cycle.clone();
    clipped
        .tangential
        .iter_mut()
        .for_each(|t| *t = t.clamp(low, high));
    clipped
}

/// First value of the steady part of a series.
fn truncated(values: &[f64]) -> usize {
    let error = |first: usize| {
        let rest = &values[first..];
        let n = rest.len() as f64;
        let mean = rest.iter().sum::<f64>() / n;
        rest.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * n)
    };
    let candidates = 0..=(values.len() / 2).min(values.len() - LEAST_CYCLES);
    let best = candidates.min_by(|a, b| error(*a).total_cmp(&error(*b)));
    best.filter(|first| error(*first) < GAIN * error(0))
        .unwrap_or(0)
}
