//! Solved samples that predict the peaks of others.
//!
//! The peaks of a sample vary smoothly with its inputs nearly everywhere. So a spline through the peaks of the nearest solved
//! samples gives a start from which a few Newton iterations converge. A prediction is only a start: every reported result
//! solves the balance equations of its own sample.

use super::inverses::{Inverses, StartOfSample};
use crate::harmonics::HarmonicSet;
use crate::hb::Solution;
use crate::hb::newton::Point;
use crate::hb::peak::maxima::Maxima;
use crate::hb::peak::predicted::PeakPrediction;
use faer::prelude::c64;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Solved samples by their place in the unit cube of the inputs.
#[derive(Debug, Clone, Default)]
pub struct Atlas {
    anchors: Vec<Anchor>,
    /// Of the first anchors; clones share them.
    inverses: Arc<Inverses>,
}

/// One solved sample.
#[derive(Debug, Clone)]
pub struct Anchor {
    /// Values of the inputs' distribution functions. Shape: `[inputs]`, 0 to 1.
    pub place: Vec<f64>,
    /// Peaks by level. Shape: `[levels]`.
    pub peaks: Vec<ModePeaks>,
}

/// The peaks of the modes that were found at one level.
#[derive(Debug, Clone, Default)]
pub struct ModePeaks(pub(super) Vec<(usize, AnchorPeak)>);

/// Sample, level and mode of a peak that is to be predicted.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// Values of the inputs' distribution functions. Shape: `[inputs]`, 0 to 1.
    pub inputs: &'a [f64],
    /// Number of the level.
    pub level: usize,
    /// Number of the mode.
    pub mode: usize,
}

/// A peak as a start for the peaks of other samples.
#[derive(Debug, Clone)]
pub struct AnchorPeak {
    pub(super) harmonics: HarmonicSet,
    pub(super) point: Point,
    pub(super) response: c64,
    pub(super) sharpness: Option<f64>,
}

/// A solved sample near a place, with its peak of the mode at the level of the place.
#[derive(Debug, Clone, Copy)]
pub struct NearAnchor<'a> {
    /// Distance from the place.
    pub distance: f64,
    /// Values of the inputs' distribution functions. Shape: `[inputs]`, 0 to 1.
    pub place: &'a [f64],
    /// The peak.
    pub peak: &'a AnchorPeak,
}

/// A predicted peak and its harmonics.
#[derive(Debug, Clone)]
pub struct AtlasPrediction {
    /// Harmonics of the nearest anchor.
    pub harmonics: HarmonicSet,
    /// Displacements, frequency and phase.
    pub peak: PeakPrediction,
    /// Amplitude (m).
    pub amplitude: f64,
}

/// Number of anchors of a spline, per unknown of its linear part.
const ANCHORS_PER_UNKNOWN: usize = 6;
/// Regularisation of the linear part, which keeps it finite if the anchors do not span all inputs.
const RIDGE: f64 = 1e-5;
/// Regularisation of the spline, which keeps it finite if anchors coincide.
const SMOOTHING: f64 = 1e-9;

impl Place<'_> {
    /// A key that is equal for equal places, bit by bit.
    pub(super) fn key(&self) -> StartOfSample {
        let bits = self.inputs.iter().map(|x| x.to_bits());
        (bits.collect(), self.level, self.mode)
    }
}

impl ModePeaks {
    /// `maxima` as starts for the peaks of other samples.
    #[must_use]
    pub fn new(maxima: &Maxima) -> Self {
        let of_mode = |(mode, solution)| (mode, AnchorPeak::new(solution));
        Self(maxima.by_mode().into_iter().map(of_mode).collect())
    }

    /// The peaks, in the order in which their modes were searched.
    pub fn iter(&self) -> impl Iterator<Item = &AnchorPeak> {
        self.0.iter().map(|(_, peak)| peak)
    }

    fn of_mode(&self, mode: usize) -> Option<&AnchorPeak> {
        let mut peaks = self.0.iter();
        peaks
            .find(|(other, _)| *other == mode)
            .map(|(_, peak)| peak)
    }
}

impl Anchor {
    /// Its peak of the mode at the level of the place, if it has one.
    fn near(&self, at: &Place<'_>) -> Option<NearAnchor<'_>> {
        Some(NearAnchor {
            distance: distance(at.inputs, &self.place),
            place: &self.place,
            peak: self.peaks[at.level].of_mode(at.mode)?,
        })
    }
}

impl AnchorPeak {
    /// `solution` as a start for the peaks of other samples.
    #[must_use]
    pub fn new(solution: &Solution) -> Self {
        Self {
            harmonics: solution.harmonics.clone(),
            point: solution.point(),
            response: solution.first_harmonic(0),
            sharpness: solution.sharpness,
        }
    }

    /// This peak as the prediction of one close by.
    #[must_use]
    pub fn as_prediction(&self) -> AtlasPrediction {
        AtlasPrediction {
            harmonics: self.harmonics.clone(),
            peak: PeakPrediction::new(self.point.clone(), self.response, self.sharpness),
            amplitude: self.response.norm(),
        }
    }
}

/// A peak on the straight line between the inputs of an anchor and those of a sample.
#[derive(Debug, Clone)]
pub struct PathPeak {
    /// Share of the distance from the anchor: 0 at the anchor, 1 at the sample.
    pub share: f64,
    /// The peak there.
    pub peak: AnchorPeak,
}

impl PathPeak {
    /// The peak at `share`, on the straight line through this one and the one `before`; this one without any before.
    #[must_use]
    pub fn extrapolated(&self, before: Option<&Self>, share: f64) -> AtlasPrediction {
        let Some(before) = before else {
            return self.peak.as_prediction();
        };
        let weight = (share - self.share) / (self.share - before.share);
        combined(&[(1.0 + weight, &self.peak), (-weight, &before.peak)])
    }
}

impl AtlasPrediction {
    /// The same peak at another excitation level: the level of a sample may depend on its inputs.
    #[must_use]
    pub fn at_level(mut self, level: f64) -> Self {
        self.peak.point.level = level;
        self
    }
}

/// Σ weight · peak, on the harmonics of the first.
fn combined(parts: &[(f64, &AnchorPeak)]) -> AtlasPrediction {
    let (_, first) = parts[0];
    let harmonics = first.harmonics.clone();
    let n_relative = first.point.r.len() / harmonics.n_coefficients();
    let mut r = vec![0.0; first.point.r.len()];
    let (mut omega, mut response) = (0.0, c64::new(0.0, 0.0));
    let mut sharpness = Some(0.0);
    for (weight, peak) in parts {
        let theirs = (peak.harmonics).convert(&peak.point.r, n_relative, &harmonics);
        r.iter_mut()
            .zip(&theirs)
            .for_each(|(r, x)| *r += weight * x);
        omega += weight * peak.point.omega;
        response += peak.response * *weight;
        sharpness = (sharpness.zip(peak.sharpness)).map(|(sum, s)| sum + weight * s);
    }
    let point = Point {
        r,
        omega,
        level: first.point.level,
    };
    AtlasPrediction {
        harmonics,
        peak: PeakPrediction::new(point, response, sharpness),
        amplitude: response.norm(),
    }
}

impl FromIterator<Anchor> for Atlas {
    /// Of anchors at the same distance the first one comes first.
    fn from_iter<I: IntoIterator<Item = Anchor>>(anchors: I) -> Self {
        Self {
            anchors: anchors.into_iter().collect(),
            inverses: Arc::default(),
        }
    }
}

impl Atlas {
    /// Adds solved samples. Of anchors at the same distance the one added first comes first.
    pub fn extend(&mut self, anchors: impl IntoIterator<Item = Anchor>) {
        self.anchors.extend(anchors);
    }

    /// Number of anchors.
    pub(super) fn len(&self) -> usize {
        self.anchors.len()
    }

    /// Inverse Jacobians at the peaks of the first anchors.
    pub(super) fn inverses(&self) -> &Inverses {
        &self.inverses
    }

    /// Of the `first` anchors that were added, the nearest whose peak of this mode at this level has these `harmonics`, and its
    /// number.
    pub(super) fn nearest_of_first(
        &self,
        first: usize,
        at: &Place<'_>,
        harmonics: &HarmonicSet,
    ) -> Option<(usize, NearAnchor<'_>)> {
        let anchors = self.anchors.iter().take(first).enumerate();
        let near = anchors
            .filter_map(|(i, anchor)| Some((i, anchor.near(at)?)))
            .filter(|(_, anchor)| anchor.peak.harmonics == *harmonics);
        near.min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance))
    }

    /// How much a sample at a place may cost beside others: the squares of the highest harmonics of the peaks of its nearest anchor.
    pub(super) fn expected_work(&self, place: &[f64]) -> usize {
        let near = self.nearest_anchor(place).into_iter();
        let peaks = near.flat_map(|anchor| anchor.peaks.iter().flat_map(ModePeaks::iter));
        peaks.map(|peak| peak.harmonics.highest().pow(2)).sum()
    }

    fn nearest_anchor(&self, place: &[f64]) -> Option<&Anchor> {
        let to = |anchor: &Anchor| distance(place, &anchor.place);
        (self.anchors.iter()).min_by(|a, b| to(a).total_cmp(&to(b)))
    }

    /// Modes at level number `level` of the nearest anchors, one more than there are inputs, ascending.
    pub(super) fn modes_near(&self, place: &[f64], level: usize) -> BTreeSet<usize> {
        let to = |anchor: &&Anchor| distance(place, &anchor.place);
        let mut near: Vec<&Anchor> = self.anchors.iter().collect();
        near.sort_by(|a, b| to(a).total_cmp(&to(b)));
        let near = near.into_iter().take(place.len() + 1);
        let modes = near.flat_map(|anchor| anchor.peaks[level].0.iter());
        modes.map(|(mode, _)| *mode).collect()
    }

    /// The predicted peak at `at`; `None` if no anchor has a peak of this mode at this level.
    #[must_use]
    pub fn predict(&self, at: &Place<'_>) -> Option<AtlasPrediction> {
        let mut near = self.by_distance(at);
        near.truncate(ANCHORS_PER_UNKNOWN * (at.inputs.len() + 1));
        let places: Vec<&[f64]> = near.iter().map(|anchor| anchor.place).collect();
        let weights = spline_weights(at.inputs, &places);
        let peaks = near.iter().map(|anchor| anchor.peak);
        let parts: Vec<(f64, &AnchorPeak)> = weights.into_iter().zip(peaks).collect();
        (!parts.is_empty()).then(|| combined(&parts))
    }

    /// The nearest anchor with a peak of this mode at this level.
    #[must_use]
    pub fn nearest(&self, at: &Place<'_>) -> Option<NearAnchor<'_>> {
        self.by_distance(at).into_iter().next()
    }

    /// Anchors with a peak of this mode at this level, the nearest first.
    fn by_distance(&self, at: &Place<'_>) -> Vec<NearAnchor<'_>> {
        let anchors = self.anchors.iter();
        let mut near: Vec<_> = anchors.filter_map(|anchor| anchor.near(at)).collect();
        near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        near
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// Weights w with Σ w_i v_i = value at `place` of the spline through v at `places` (nearest first). The spline is a sum of cubes
/// of the distances and a linear function: the smoothest function through the values, in any number of inputs.
/// Source: Duchon 1977, in Constructive Theory of Functions of Several Variables, 85–100.
fn spline_weights(place: &[f64], places: &[&[f64]]) -> Vec<f64> {
    let n = places.len();
    let nearest = || (0..n).map(|i| f64::from(u8::from(i == 0))).collect();
    let reach = places.last().map_or(0.0, |last| distance(place, last));
    // a place that has been solved already is predicted by its own peak
    if reach == 0.0 || distance(place, places[0]) <= 1e-9 * reach {
        return nearest();
    }
    let cube = |a: &[f64], b: &[f64]| (distance(a, b) / reach).powi(3);
    let linear = |i: usize, j: usize| match j {
        0 => 1.0,
        j => (places[i][j - 1] - place[j - 1]) / reach,
    };
    let size = n + place.len() + 1;
    let matrix = DMatrix::from_fn(size, size, |i, j| match (i < n, j < n) {
        (true, true) if i == j => SMOOTHING,
        (true, true) => cube(places[i], places[j]),
        (true, false) => linear(i, j - n),
        (false, true) => linear(j, i - n),
        (false, false) if i == j && i > n => -RIDGE,
        (false, false) => 0.0,
    });
    let right = DVector::from_fn(size, |i, _| match i < n {
        true => cube(places[i], place),
        false => f64::from(u8::from(i == n)),
    });
    let solution = matrix.lu().solve(&right);
    solution.map_or_else(nearest, |w| w.iter().take(n).copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peaks that vary linearly with the inputs. Shape: `[side * side]` anchors on a grid, one level.
    fn atlas(side: usize, peak: impl Fn(f64, f64) -> [f64; 3]) -> Atlas {
        let at = |i: usize| (i as f64 + 0.5) / side as f64;
        let anchor = |(i, j): (usize, usize)| {
            let (x, y) = (at(i), at(j));
            let [r, omega, response] = peak(x, y);
            Anchor {
                place: vec![x, y],
                peaks: vec![ModePeaks(vec![(
                    3,
                    AnchorPeak {
                        harmonics: HarmonicSet::up_to(1),
                        point: Point {
                            r: vec![r; 9],
                            omega,
                            level: 2.0,
                        },
                        response: c64::new(0.0, -response),
                        sharpness: None,
                    },
                )])],
            }
        };
        let grid = (0..side * side).map(|k| (k / side, k % side));
        grid.map(anchor).collect()
    }

    /// Level 0 of mode 3.
    fn at(inputs: &[f64]) -> Place<'_> {
        Place {
            inputs,
            level: 0,
            mode: 3,
        }
    }

    /// Seen to fail with a ridge of 0.1.
    #[test]
    fn linear_peaks_are_predicted() {
        let peak = |x: f64, y: f64| [1.0 + x - 2.0 * y, 100.0 + 3.0 * x, 5.0 + y];
        let atlas = atlas(6, peak);
        for [x, y] in [[0.41, 0.33], [0.72, 0.55], [0.02, 0.97]] {
            let found = atlas.predict(&at(&[x, y])).unwrap();
            let [r, omega, response] = peak(x, y);
            assert!(
                (found.peak.point.r[4] - r).abs() < 2e-3,
                "{x} {y} {found:?}"
            );
            assert!((found.peak.point.omega - omega).abs() < 3e-3);
            assert!((found.amplitude - response).abs() < 2e-3);
            assert!((found.peak.phasor - c64::new(0.0, -1.0)).norm() < 1e-12);
        }
    }

    /// A place that has been solved predicts itself, a mode or a level without solutions nothing. Seen to fail without the look
    /// at the distance.
    #[test]
    fn solved_places_predict_themselves() {
        let peak = |x: f64, y: f64| [x * y, 100.0 + x * x, 1.0];
        let mut atlas = atlas(3, peak);
        let place = at(&[0.5, 0.5]);
        let found = atlas.predict(&place).unwrap();
        assert_eq!(found.peak.point.omega, 100.25);
        let other = Place { mode: 2, ..place };
        assert!(atlas.predict(&other).is_none());
        let anchors = atlas.anchors.iter_mut();
        anchors.for_each(|a| a.peaks[0] = ModePeaks::default());
        assert!(atlas.predict(&place).is_none());
    }

    /// Inputs that do not vary, or anchors on a line or at one place, leave the spline what it is elsewhere: exact for what
    /// varies linearly. Seen to fail without ridge and without smoothing.
    #[test]
    fn degenerate_places_keep_linear_peaks() {
        let mut on_a_line: Vec<Vec<f64>> = (1..8).map(|i| vec![0.1 * f64::from(i), 0.5]).collect();
        for place in [[0.05, 0.5], [0.05, 0.7]] {
            let places: Vec<&[f64]> = on_a_line.iter().map(Vec::as_slice).collect();
            let weights = spline_weights(&place, &places);
            let found: f64 = weights.iter().zip(&places).map(|(w, p)| w * p[0]).sum();
            assert!((found - 0.05).abs() < 1e-3, "{place:?}: {weights:?}");
            on_a_line.insert(0, vec![0.1, 0.5]);
        }
        let at_once: Vec<&[f64]> = vec![&[0.5, 0.5]; 4];
        let sum: f64 = spline_weights(&[0.4, 0.5], &at_once).iter().sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
}
