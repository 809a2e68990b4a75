//! Depth of curves: which are typical, and the band that the deepest ones span.

use super::band::{Envelope, EnvelopePoint, EnvelopeRefusal, Family, MissingPoints, calibrated};
use super::curve::CurveSet;

/// Modified band depth of each curve: the mean share of the grid on which it lies between two others, over all pairs.
///
/// Shape: one entry per sample; `None` for failed samples, curves that lack a grid point, and fewer than two curves.
/// Source: López-Pintado & Romo, J. Amer. Statist. Assoc. 104 (2009) 718–734, bands of two curves, with the count by
/// ranks of Sun, Genton & Nychka, Stat 1 (2012) 68–74 (a curve belongs to the pairs that it forms itself).
#[must_use]
pub fn modified_band_depth(curves: &CurveSet) -> Vec<Option<f64>> {
    let complete: Vec<(usize, &[f64])> = complete_rows(curves);
    let n = complete.len();
    let mut depths = vec![None; curves.total()];
    if n < 2 || curves.grid().is_empty() {
        return depths;
    }
    let pairs = |k: usize| (k * k.saturating_sub(1) / 2) as f64;
    let mut held = vec![0.0; n];
    for i in 0..curves.grid().len() {
        let mut column: Vec<f64> = complete.iter().map(|(_, row)| row[i]).collect();
        column.sort_by(f64::total_cmp);
        for (held, (_, row)) in held.iter_mut().zip(&complete) {
            let below = column.partition_point(|v| *v < row[i]);
            let above = n - column.partition_point(|v| *v <= row[i]);
            *held += pairs(n) - pairs(below) - pairs(above);
        }
    }
    let scale = pairs(n) * curves.grid().len() as f64;
    for ((index, _), held) in complete.iter().zip(held) {
        depths[*index] = Some(held / scale);
    }
    depths
}

/// Index and values of the curves that lack no grid point.
fn complete_rows(curves: &CurveSet) -> Vec<(usize, &[f64])> {
    let rows = curves.rows().iter().enumerate();
    rows.filter_map(|(i, row)| Some((i, row.as_deref()?)))
        .filter(|(_, row)| row.iter().all(|v| v.is_finite()))
        .collect()
}

/// Envelopes of the 1, 2, 3, … deepest curves.
struct Deepest {
    grid: Vec<f64>,
    /// Per grid point, the lower and upper edge of the k deepest curves at entry k − 1.
    edges: Vec<Vec<(f64, f64)>>,
    shaped_by: usize,
}

impl Deepest {
    fn of(curves: &CurveSet) -> Self {
        let depths = modified_band_depth(curves);
        let mut deepest = complete_rows(curves);
        deepest.sort_by(|(i, _), (j, _)| {
            let depth = |k: usize| depths[k].unwrap_or(0.0);
            depth(*j).total_cmp(&depth(*i)).then(i.cmp(j))
        });
        let edges = |point: usize| {
            let values = deepest.iter().map(|(_, row)| row[point]);
            let grow = |edges: &mut (f64, f64), v: f64| {
                *edges = (edges.0.min(v), edges.1.max(v));
                Some(*edges)
            };
            values
                .scan((f64::INFINITY, f64::NEG_INFINITY), grow)
                .collect()
        };
        Self {
            grid: curves.grid().to_vec(),
            edges: (0..curves.grid().len()).map(edges).collect(),
            shaped_by: deepest.len(),
        }
    }
}

impl Family for Deepest {
    fn score(&self, point: usize, value: f64) -> Option<f64> {
        let edges = &self.edges[point];
        let k = edges.partition_point(|(low, high)| value < *low || value > *high);
        (k < edges.len()).then_some((k + 1) as f64)
    }

    fn band(&self, point: usize, count: f64) -> Option<EnvelopePoint> {
        let edges = &self.edges[point];
        let (lower, upper) = *edges.get((count as usize).checked_sub(1)?)?;
        Some(EnvelopePoint {
            x: self.grid[point],
            lower,
            centre: edges.first()?.0,
            upper,
        })
    }

    fn shaped_by(&self) -> usize {
        self.shaped_by
    }
}

/// Band spanned by the deepest of the even samples, of as many as hold the share `level` of the odd samples' whole curves.
///
/// Only complete curves shape it. It keeps the shape of real curves, but never exceeds their outermost values: with few
/// samples it is refused where [`super::band::simultaneous_band`] can still stretch.
///
/// # Errors
///
/// Why no such band exists.
pub fn depth_band(
    curves: &CurveSet,
    level: f64,
    confidence: f64,
    missing: MissingPoints,
) -> Result<Envelope, EnvelopeRefusal> {
    let (shaping, calibrating) = curves.halves();
    let family = Deepest::of(&shaping);
    calibrated(&family, curves, &calibrating, missing, level, confidence)
}
