//! Slopes that single points do not spoil.

use crate::identify::cycles::mean_loop::{median, robust_scale};

/// A line through points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct Line {
    /// Rise over run.
    pub(in crate::identify) slope: f64,
    /// Height at 0.
    pub(super) intercept: f64,
    /// Standard deviation of the points about it.
    pub(super) deviation: f64,
    /// Standard error of the slope by these; none of fewer than four points.
    pub(in crate::identify) standard_error: Option<f64>,
    /// Standard uncertainty of the slope because the points may lie on another curve; 0 where a line is all that is asked for.
    pub(in crate::identify) model_error: f64,
}

/// Points above which neighbours are averaged: the pairs grow with the square.
const MOST_POINTS: usize = 120;
/// Fewest points that show a deviation from their line.
const LEAST_FOR_ERROR: usize = 4;
/// Variance of the median of pairwise slopes over that of least squares, for normal noise.
/// Source: Sen, J. Am. Stat. Assoc. 63 (1968) 1379-1389 (efficiency 3/π).
const OVER_LEAST_SQUARES: f64 = 1.047;

/// Median of the slopes of all pairs of points that are at least half the points apart; none of fewer than two points.
///
/// The points are in the order of time: whatever the noise, the farther point of a pair is known, and the median is
/// that of the true slope with noise in both coordinates. Least squares gives too small a slope then.
/// Source: Theil 1950; Sen, J. Am. Stat. Assoc. 63 (1968) 1379-1389.
pub(super) fn pairwise_line(x: &[f64], y: &[f64]) -> Option<Line> {
    let n = x.len();
    let (x, y) = (thinned(x), thinned(y));
    let m = x.len();
    let pairs = (0..m).flat_map(|i| (i + m.div_ceil(2).max(1)..m).map(move |j| (i, j)));
    let slopes = pairs
        .filter(|(i, j)| x[*j] > x[*i])
        .map(|(i, j)| (y[j] - y[i]) / (x[j] - x[i]));
    let slope = median(&mut slopes.collect::<Vec<f64>>())?;
    let heights: Vec<f64> = x.iter().zip(&y).map(|(x, y)| y - slope * x).collect();
    let [intercept, deviation] = robust_scale(&heights)?;
    let mean = x.iter().sum::<f64>() / m as f64;
    let square: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
    let variance = OVER_LEAST_SQUARES * deviation.powi(2) / square;
    Some(Line {
        slope,
        intercept,
        deviation,
        standard_error: (n >= LEAST_FOR_ERROR).then(|| variance.sqrt()),
        model_error: 0.0,
    })
}

/// Line of the force over the displacement of a stick branch, from the displacement over the force: where little of the displacement is
/// elastic its noise may turn the line over, and the compliance passes through 0 where the slope does not. None without a rise or fall.
pub(super) fn branch_line(displacement: &[f64], force: &[f64]) -> Option<Line> {
    let compliance = pairwise_line(force, displacement)?;
    let slope = 1.0 / compliance.slope;
    slope.is_finite().then(|| Line {
        slope,
        intercept: -slope * compliance.intercept,
        deviation: slope.abs() * compliance.deviation,
        standard_error: compliance.standard_error.map(|error| slope * slope * error),
        model_error: 0.0,
    })
}

/// Means of neighbours, so many that few enough points are left.
fn thinned(values: &[f64]) -> Vec<f64> {
    let size = values.len().div_ceil(MOST_POINTS).max(1);
    values
        .chunks(size)
        .map(|part| part.iter().sum::<f64>() / part.len() as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::branch_line;

    /// Noise of the displacement is even in the compliance. A slope of force over displacement is half as steep here.
    #[test]
    fn noise_of_the_displacement_does_not_flatten_a_branch() {
        let noise = |k: u32| 3.0 * ((f64::from(k) * 0.618_033_988_75).fract() - 0.5);
        let force: Vec<f64> = (0..100).map(|k| f64::from(k) / 100.0).collect();
        let displacement: Vec<f64> = (0..100).map(|k| f64::from(k) / 100.0 + noise(k)).collect();
        let slope = branch_line(&displacement, &force).unwrap().slope;
        assert!((slope - 1.0).abs() < 0.1, "{slope}");
    }
}
