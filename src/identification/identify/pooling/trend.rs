//! Dependence of a parameter on load or frequency.

use crate::identify::found::uncertain::factor;

/// Fewest tests of a trend.
const LEAST_TESTS: usize = 4;
/// Least ratio of the greatest to the least load or frequency.
const LEAST_RANGE: f64 = 1.2;

/// Slope of y over ln x by least squares, and its interval; none of too few tests or of too small a range.
pub(super) fn exponent(points: &[(f64, f64)], confidence: f64) -> Option<(f64, [f64; 2])> {
    let usable: Vec<(f64, f64)> = points.iter().copied().filter(|(x, _)| *x > 0.0).collect();
    let ends = |(low, high): (f64, f64), (x, _): &(f64, f64)| (low.min(*x), high.max(*x));
    let (low, high) = usable.iter().fold((f64::INFINITY, 0.0), ends);
    if usable.len() < LEAST_TESTS || high < LEAST_RANGE * low {
        return None;
    }
    let n = usable.len() as f64;
    let x: Vec<f64> = usable.iter().map(|(x, _)| libm::log(*x)).collect();
    let centre = x.iter().sum::<f64>() / n;
    let mean = usable.iter().map(|(_, y)| y).sum::<f64>() / n;
    let square: f64 = x.iter().map(|x| (x - centre).powi(2)).sum();
    let product: f64 = x
        .iter()
        .zip(&usable)
        .map(|(x, (_, y))| (x - centre) * (y - mean))
        .sum();
    let slope = product / square;
    let rest = x
        .iter()
        .zip(&usable)
        .map(|(x, (_, y))| (y - mean - slope * (x - centre)).powi(2));
    let error = (rest.sum::<f64>() / (n - 2.0) / square).sqrt();
    let half = factor(n - 2.0, confidence) * error;
    Some((slope, [slope - half, slope + half]))
}
