//! Standard errors of a test from the scatter of its batches, and errors of the measuring chain.

use super::mean_loop::MeanLoop;
use crate::identify::settings::IdentifySettings;

/// Standard error of a mean, and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct RandomError {
    /// Standard error.
    pub(in crate::identify) standard_error: f64,
    /// Degrees of freedom.
    pub(in crate::identify) freedom: f64,
}

/// Means of some cycles each, which tell the scatter of the mean loop.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) struct Batches<'a> {
    /// Mean loops.
    pub(super) loops: &'a [MeanLoop],
    /// Cycles of each.
    pub(super) cycles: &'a [usize],
    /// Whether a resonance of the force cell was taken out of them: corners are then rounded, and the start of a branch may still vibrate.
    pub(in crate::identify) rounded: bool,
}

impl Batches<'_> {
    /// Error of a number of the mean loop; none of fewer than two batches.
    pub(in crate::identify) fn error(
        &self,
        number: impl Fn(&MeanLoop) -> Option<f64>,
    ) -> Option<RandomError> {
        let each: Vec<Option<f64>> = self.loops.iter().map(number).collect();
        of_batches(&each, self.cycles)
    }
}

/// From values of batches of so many `cycles`; none of fewer than two.
///
/// The variance of a value is that of one cycle over its cycles: twelve batches of twenty cycles have one or two each, and taken
/// as equal ones they would make the variance of the mean a ninth too large.
pub(in crate::identify) fn of_batches(
    values: &[Option<f64>],
    cycles: &[usize],
) -> Option<RandomError> {
    let both = values.iter().zip(cycles);
    let known: Vec<(f64, f64)> = both
        .filter_map(|(value, cycles)| Some(((*value)?, *cycles as f64)))
        .collect();
    let n = known.len() as f64;
    if known.len() < 2 {
        return None;
    }
    let all: f64 = known.iter().map(|(_, cycles)| cycles).sum();
    let mean = known.iter().map(|(v, cycles)| v * cycles).sum::<f64>() / all;
    let square: f64 = (known.iter())
        .map(|(v, cycles)| cycles * (v - mean).powi(2))
        .sum();
    Some(RandomError {
        standard_error: (square / (n - 1.0) / all).sqrt(),
        freedom: n - 1.0,
    })
}

/// From values without each part in turn (jackknife); none of fewer than two.
pub(in crate::identify) fn of_parts(values: &[Option<f64>]) -> Option<RandomError> {
    let found = of_batches(values, &vec![1; values.len()])?;
    Some(RandomError {
        // (n − 1)/n Σ (v − mean)²: the standard error of the mean, times n − 1
        standard_error: found.standard_error * found.freedom,
        ..found
    })
}

/// Correlation of two values over the batches that have both; 0 of fewer than four.
pub(in crate::identify) fn correlation(a: &[Option<f64>], b: &[Option<f64>]) -> f64 {
    let pairs: Vec<(f64, f64)> = a.iter().zip(b).filter_map(|(a, b)| a.zip(*b)).collect();
    let n = pairs.len() as f64;
    if pairs.len() < LEAST_FOR_CORRELATION {
        return 0.0;
    }
    let (x, y) = pairs
        .iter()
        .fold((0.0, 0.0), |(x, y), (a, b)| (x + a / n, y + b / n));
    let sum = |product: fn(f64, f64) -> f64| -> f64 {
        pairs.iter().map(|(a, b)| product(a - x, b - y)).sum()
    };
    let (xx, yy, xy) = (sum(|a, _| a * a), sum(|_, b| b * b), sum(|a, b| a * b));
    match xx > 0.0 && yy > 0.0 {
        true => xy / (xx * yy).sqrt(),
        false => 0.0,
    }
}

/// Fewest batches that tell a correlation.
const LEAST_FOR_CORRELATION: usize = 4;

/// Stated errors of the measuring chain, as standard uncertainties of logarithms: the gains of T, N and displacement are
/// independent, and the same in all tests.
#[derive(Debug, Clone, Copy)]
pub(in crate::identify) struct ChainError {
    /// Of the gain of a force.
    force: f64,
    /// Of the gain of a displacement.
    displacement: f64,
}

impl ChainError {
    /// As stated.
    pub(in crate::identify) fn of(settings: &IdentifySettings) -> Self {
        Self {
            force: settings.force_error_percent / 100.0,
            displacement: settings.displacement_error_percent / 100.0,
        }
    }

    /// Of ln μ, ln k_t as measured, ln k_n and ln energy: T/N, T/u, N/v, T u.
    pub(in crate::identify) fn of_ratio(&self) -> f64 {
        self.force.hypot(self.force)
    }

    /// Of ln k_t as measured, ln k_n and ln energy: T/u, N/v, T u.
    pub(in crate::identify) fn of_slope(&self) -> f64 {
        self.force.hypot(self.displacement)
    }

    /// Covariance of ln μ, ln k_t and ln k_n, where that of k_t is `amplified` by the rig's stiffness. T is in μ and k_t, N in μ
    /// and k_n, the displacement in k_t and k_n.
    pub(in crate::identify) fn covariance(&self, amplified: f64) -> [[f64; 3]; 3] {
        let [t, u] = [self.force.powi(2), self.displacement.powi(2)];
        let a = amplified;
        [
            [2.0 * t, a * t, -t],
            [a * t, a * a * (t + u), a * u],
            [-t, a * u, t + u],
        ]
    }
}
