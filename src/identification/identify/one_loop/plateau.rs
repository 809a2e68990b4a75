//! The plateau before a reversal: whether the whole contact slips, and where.

use super::half::Half;
use crate::identify::cycles::mean_loop::{MeanLoop, median};

/// Parts of the displacement of a half, at its end, in which a plateau is sought, longest first.
const TAILS: [f64; 10] = [0.9, 0.8, 0.65, 0.5, 0.35, 0.25, 0.17, 0.12, 0.08, 0.05];
/// Part of a flat tail, at its end, that is the plateau: the rest may be the knee.
const KEPT: f64 = 0.6;
/// Slope over the stick slope up to which a tail is flat.
const FLAT: f64 = 0.03;
/// Standard errors of the slope that are added before it is compared: what noise hides is no plateau.
pub(super) const SURE: f64 = 2.0;
/// T/N at the end of a half over that of its plateau, from which on the contact still slips.
const END_SLIPS: f64 = 0.98;
/// Fewest samples of a plateau.
const LEAST_SAMPLES: usize = 5;

/// First and last place of the plateau of a half whose stick branch has this slope (N/m); none where the contact does not slip as a
/// whole. The loop is one without an offset of T.
pub(super) fn plateau(
    half: &Half,
    cycle: &MeanLoop,
    stick_slope: f64,
    least_normal: f64,
) -> Option<[usize; 2]> {
    let x = half.displacement(cycle);
    let normal = cycle.normal.iter().sum::<f64>() / cycle.samples() as f64;
    let y: Vec<Option<f64>> = half
        .ratio(cycle, least_normal)
        .iter()
        .map(|r| r.map(|r| r * normal))
        .collect();
    let (last, whole) = (half.last(cycle), x[x.len() - 1]);
    let begin = |part: f64| x.partition_point(|x| *x < (1.0 - part) * whole);
    let flat = TAILS.into_iter().find(|part| {
        let first = begin(*part);
        first < last && is_flat(&x[first..=last], &y[first..=last], FLAT * stick_slope)
    })?;
    let first = begin(KEPT * flat);
    (last + 1 - first >= LEAST_SAMPLES).then_some([first, last])
}

/// T/N in the direction of the motion at the end of a half, as `end` says, or as its plateau says where the contact sticks for a moment
/// at the end.
pub(super) fn level(
    half: &Half,
    cycle: &MeanLoop,
    [first, last]: [usize; 2],
    least_normal: f64,
    end: f64,
) -> f64 {
    let ratio = half.ratio(cycle, least_normal);
    let mut slipping: Vec<f64> = ratio[first..=last].iter().copied().flatten().collect();
    match median(&mut slipping) {
        Some(usual) if end < END_SLIPS * usual => usual,
        _ => end,
    }
}

/// Whether the slope is surely not above `limit`.
fn is_flat(x: &[f64], y: &[Option<f64>], limit: f64) -> bool {
    let points: Vec<[f64; 2]> = x
        .iter()
        .zip(y)
        .filter_map(|(x, y)| y.map(|y| [*x, y]))
        .collect();
    let n = points.len() as f64;
    if points.len() < LEAST_SAMPLES || points.len() < y.len() / 2 {
        return false;
    }
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
    let centre = [mean(0), mean(1)];
    let sum = |a: usize, b: usize| -> f64 {
        points
            .iter()
            .map(|p| (p[a] - centre[a]) * (p[b] - centre[b]))
            .sum()
    };
    let (square, product) = (sum(0, 0), sum(0, 1));
    let slope = product / square;
    let rest = (sum(1, 1) - slope * product).max(0.0);
    let error = (rest / (n - 2.0) / square).sqrt();
    slope + SURE * error <= limit
}
