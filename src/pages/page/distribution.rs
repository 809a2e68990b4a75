//! Distribution functions as a panel shows them: steps, and their confidence interval.

use super::thinning::thinned;
use crate::statistics::{Sorted, empirical_cdf, share};

/// Values at which the confidence interval of a distribution function is drawn.
const INTERVALS: usize = 100;

/// Interval of the distribution function, with this confidence, at some of the known values of so many samples.
pub fn confidence_band(sorted: &Sorted, total: usize, confidence: f64) -> Vec<(f64, f64, f64)> {
    let n = sorted.values().len();
    let failed = total - n;
    let stride = n.div_ceil(INTERVALS).max(1);
    let ranks = (0..n).step_by(stride).chain(n.checked_sub(1));
    let at = |i: usize| {
        let value = *sorted.values().get(i)?;
        let below = sorted.values().partition_point(|v| *v <= value);
        let share = share(below, n - below, failed, confidence)?;
        Some((value, share.lower, share.upper))
    };
    ranks.filter_map(at).collect()
}

/// Corners of the empirical distribution function, at most as many as a panel can show. Thinned from the last corner back, so
/// that the steps still end at 1.
pub fn cumulative_steps(values: &Sorted) -> Vec<(f64, f64)> {
    let from_the_end = empirical_cdf(values).into_iter().rev().collect();
    thinned(from_the_end).into_iter().rev().collect()
}
