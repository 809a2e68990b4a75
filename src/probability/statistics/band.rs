//! Pointwise and simultaneous bands of curves on a common grid.

use super::curve::CurveSet;
use super::observed::Sorted;
use super::order_statistic::{quantile, quantile_rank};
use super::proportion::{Share, share};

/// Quantiles of the curves at one abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct BandPoint {
    /// Abscissa.
    pub x: f64,
    /// One quantile of the present curves per probability asked for; absent where no curve reaches.
    pub quantiles: Option<Vec<f64>>,
    /// Number of curves that reach this abscissa; the others are missing here, not zero.
    pub present: usize,
}

/// Pointwise quantiles of many curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// One entry per grid point.
    pub points: Vec<BandPoint>,
    /// Share of whole curves between the first and the last quantile wherever they exist, failed samples unknown; absent
    /// without samples. Below the difference of the probabilities, because a pointwise band is no envelope of curves.
    pub whole_curves_inside: Option<Share>,
}

/// Quantiles of the curves at each grid point. Shape: `probabilities` ascending, at least one.
#[must_use]
pub fn pointwise_band(curves: &CurveSet, probabilities: &[f64], confidence: f64) -> Band {
    let points: Vec<BandPoint> = (0..curves.grid().len())
        .map(|i| band_point(curves, i, probabilities))
        .collect();
    let inside = |row: &Vec<f64>| {
        row.iter().zip(&points).all(|(v, point)| {
            let Some([low, .., high]) = point.quantiles.as_deref() else {
                return true;
            };
            !v.is_finite() || (*low..=*high).contains(v)
        })
    };
    let yes = curves.rows().iter().flatten().filter(|row| inside(row));
    let (yes, failed) = (yes.count(), curves.failed());
    Band {
        whole_curves_inside: share(yes, curves.total() - failed - yes, failed, confidence),
        points,
    }
}

fn band_point(curves: &CurveSet, i: usize, probabilities: &[f64]) -> BandPoint {
    let sorted = Sorted::finite(curves.column(i));
    let present = sorted.values().len();
    let quantiles = probabilities.iter().map(|&p| quantile(&sorted, p));
    let quantiles = quantiles.collect();
    BandPoint {
        x: curves.grid()[i],
        quantiles,
        present,
    }
}

/// What a curve that lacks grid points says about whether it lies inside a band.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MissingPoints {
    /// Nothing: it may have left the band where it is missing, so it counts as outside when the band is calibrated.
    Outside,
    /// It is judged where it exists, and so is the band: its coverage then holds for curves where they exist.
    NotJudged,
}

/// An envelope at one abscissa.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct EnvelopePoint {
    /// Abscissa.
    pub x: f64,
    /// Lower edge.
    pub lower: f64,
    /// Median (simultaneous band) or deepest curve (depth band).
    pub centre: f64,
    /// Upper edge.
    pub upper: f64,
}

/// A band for whole curves, with the coverage that a half of the samples which did not shape it shows.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Envelope {
    /// One entry per grid point; `None` where no shaping curve exists.
    pub points: Vec<Option<EnvelopePoint>>,
    /// Share of whole curves asked for.
    pub level: f64,
    /// Expected share of further whole curves inside, at least `level`: k/(m + 1) from m calibrating samples.
    pub expected_coverage: f64,
    /// Calibrating samples inside, outside and unknown (failed, or incomplete and not seen to leave).
    pub calibration: Share,
    /// Curves that shaped the band.
    pub shaped_by: usize,
    /// Failed samples, of both halves.
    pub failed: usize,
    /// Curves that lack a grid point, of both halves.
    pub incomplete: usize,
}

/// Why there is no envelope of whole curves.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum EnvelopeRefusal {
    /// Level or confidence outside (0, 1).
    #[error("level and confidence must lie between 0 and 1")]
    Probability,
    /// No curve to shape the band.
    #[error("no curve shapes the band")]
    NoCurve,
    /// The calibrating half is too small, or too much of it failed or left the band however wide.
    #[error("{inside} of {calibrating} calibrating samples can be enclosed, and {needed} must be")]
    NotEnclosed {
        /// Calibrating samples that a band of this shape can enclose.
        inside: usize,
        /// Calibrating samples, failed ones included.
        calibrating: usize,
        /// Calibrating samples that it must enclose.
        needed: usize,
    },
}

impl EnvelopeRefusal {
    /// Calibrating samples with which there is a band that holds the share `level`, if all further ones can be enclosed. What must be
    /// enclosed grows with them, so this is more than the present number needs. Absent where their number is not what is lacking: so many
    /// would do without those that cannot be enclosed, whose share is larger than the band may leave out.
    #[must_use]
    pub fn enough(&self, level: f64) -> Option<usize> {
        let Self::NotEnclosed {
            inside,
            calibrating,
            ..
        } = *self
        else {
            return None;
        };
        let outside = calibrating - inside;
        let holds = |m: usize, outside: usize| quantile_rank(m + 1, level) + outside <= m;
        let too_many = outside as f64 > (1.0 - level) * calibrating as f64;
        if holds(calibrating, 0) && too_many {
            return None;
        }
        (calibrating..).find(|&m| holds(m, outside))
    }
}

/// A nested family of bands: the score of a curve is the smallest member that holds it.
pub(super) trait Family {
    /// Smallest member that holds the value at a grid point; `None` = none does.
    fn score(&self, point: usize, value: f64) -> Option<f64>;
    /// Band of the member at a grid point; `None` where nothing shapes it.
    fn band(&self, point: usize, member: f64) -> Option<EnvelopePoint>;
    /// Number of curves that shaped the family.
    fn shaped_by(&self) -> usize;
}

/// Smallest member of `family` that holds ⌈(m + 1) level⌉ of the m calibrating samples, failed ones never.
///
/// The samples are exchangeable and the family does not depend on the calibrating ones, so a further curve lies inside
/// with probability k/(m + 1) or more, for any law of the curves. This is split conformal prediction (Vovk, Gammerman & Shafer,
/// Algorithmic Learning in a Random World, 2005; Diquigiovanni, Fontana & Vantini, J. Multivar. Anal. 189 (2022) 104879).
pub(super) fn calibrated(
    family: &impl Family,
    curves: &CurveSet,
    calibrating: &CurveSet,
    missing: MissingPoints,
    level: f64,
    confidence: f64,
) -> Result<Envelope, EnvelopeRefusal> {
    let inside = |p: f64| p > 0.0 && p < 1.0;
    if !inside(level) || !inside(confidence) {
        return Err(EnvelopeRefusal::Probability);
    }
    if family.shaped_by() == 0 {
        return Err(EnvelopeRefusal::NoCurve);
    }
    let seen: Vec<_> = calibrating
        .rows()
        .iter()
        .map(|row| Some(whole_curve(family, row.as_ref()?)))
        .collect();
    let counts = |c: &WholeCurve| c.complete || missing == MissingPoints::NotJudged;
    let scores = seen.iter().flatten().filter(|c| counts(c));
    let scores = Sorted::finite(scores.filter_map(|c| c.score));
    let m = calibrating.total();
    let needed = quantile_rank(m + 1, level);
    let member = scores
        .order_statistic(needed)
        .ok_or(EnvelopeRefusal::NotEnclosed {
            inside: scores.values().len(),
            calibrating: m,
            needed,
        })?;
    let yes = scores.values().partition_point(|&s| s <= member);
    let leaves = |c: &&WholeCurve| c.score.is_none_or(|s| s > member);
    let no = seen.iter().flatten().filter(leaves).count();
    Ok(Envelope {
        points: (0..curves.grid().len())
            .map(|i| family.band(i, member))
            .collect(),
        level,
        expected_coverage: needed as f64 / (m + 1) as f64,
        calibration: share(yes, no, m - yes - no, confidence)
            .ok_or(EnvelopeRefusal::Probability)?,
        shaped_by: family.shaped_by(),
        failed: curves.failed(),
        incomplete: curves.incomplete(),
    })
}

struct WholeCurve {
    /// Smallest member that holds the curve wherever it exists; `None` = none does.
    score: Option<f64>,
    complete: bool,
}

fn whole_curve(family: &impl Family, row: &[f64]) -> WholeCurve {
    let present = row.iter().enumerate().filter(|(_, v)| v.is_finite());
    let mut scores = present.map(|(i, &v)| family.score(i, v));
    WholeCurve {
        score: scores.try_fold(0.0, |worst: f64, score| Some(worst.max(score?))),
        complete: row.iter().all(|v| v.is_finite()),
    }
}

/// Median ± λ times the distances to the outer pointwise quantiles, one λ for the whole curve.
struct Scaled {
    points: Vec<Option<EnvelopePoint>>,
    shaped_by: usize,
}

impl Family for Scaled {
    fn score(&self, point: usize, value: f64) -> Option<f64> {
        let at = self.points[point]?;
        let (distance, unit) = match value >= at.centre {
            true => (value - at.centre, at.upper - at.centre),
            false => (at.centre - value, at.centre - at.lower),
        };
        match unit > 0.0 {
            true => Some(distance / unit),
            false => (distance == 0.0).then_some(0.0),
        }
    }

    fn band(&self, point: usize, factor: f64) -> Option<EnvelopePoint> {
        let at = self.points[point]?;
        Some(EnvelopePoint {
            lower: at.centre - factor * (at.centre - at.lower),
            upper: at.centre + factor * (at.upper - at.centre),
            ..at
        })
    }

    fn shaped_by(&self) -> usize {
        self.shaped_by
    }
}

/// Band that holds the share `level` of whole curves: the pointwise quantiles of the even samples, stretched about the
/// median by the one factor with which it holds that share of the odd samples.
///
/// # Errors
///
/// Why no such band exists; too many failed samples are one reason.
pub fn simultaneous_band(
    curves: &CurveSet,
    level: f64,
    confidence: f64,
    missing: MissingPoints,
) -> Result<Envelope, EnvelopeRefusal> {
    let (shaping, calibrating) = curves.halves();
    let tail = (1.0 - level) / 2.0;
    let point = |i: usize| {
        let sorted = Sorted::finite(shaping.column(i));
        Some(EnvelopePoint {
            x: shaping.grid()[i],
            lower: quantile(&sorted, tail)?,
            centre: quantile(&sorted, 0.5)?,
            upper: quantile(&sorted, 1.0 - tail)?,
        })
    };
    let family = Scaled {
        points: (0..shaping.grid().len()).map(point).collect(),
        shaped_by: shaping.total() - shaping.failed(),
    };
    calibrated(&family, curves, &calibrating, missing, level, confidence)
}

#[cfg(test)]
mod tests {
    use super::super::curve::Curve;
    use super::*;
    use std::f64::consts::TAU;

    /// 101 constant curves 0..100, half of them only on the left: quantiles and counts by hand.
    /// Seen to fail when missing curves counted as zero.
    #[test]
    fn missing_curves_are_counted_not_zero() {
        let curves: Vec<Option<Curve>> = (0..=100)
            .map(|i| {
                let end = if i % 2 == 0 { 2.0 } else { 1.0 };
                Curve::through([(0.0, f64::from(i)), (end, f64::from(i))])
            })
            .collect();
        let set = CurveSet::of(&curves, &[0.5, 1.5, 3.0]);
        let band = pointwise_band(&set, &[0.05, 0.5, 0.95], 0.95);
        assert_eq!(band.points[0].quantiles, Some(vec![5.0, 50.0, 95.0]));
        assert_eq!(band.points[1].quantiles, Some(vec![4.0, 50.0, 96.0]));
        assert_eq!(band.points[2].quantiles, None);
        let present: Vec<usize> = band.points.iter().map(|p| p.present).collect();
        assert_eq!(present, [101, 51, 0]);
        let empty = pointwise_band(&CurveSet::of(&[], &[1.0]), &[0.5], 0.95);
        assert_eq!(
            (empty.points[0].present, empty.whole_curves_inside),
            (0, None)
        );
    }

    /// The number that a refusal names is the smallest that suffices: with one calibrating curve less there is no band.
    #[test]
    fn a_refusal_names_the_number_that_suffices() {
        let band = |n: u32| {
            let curve = |i| Curve::through([(0.0, f64::from(i)), (1.0, f64::from(i))]);
            let curves: Vec<Option<Curve>> = (0..n).map(curve).collect();
            let set = CurveSet::of(&curves, &[0.0, 1.0]);
            simultaneous_band(&set, 0.95, 0.95, MissingPoints::Outside)
        };
        let enough = |n: u32| band(n).unwrap_err().enough(0.95);
        assert_eq!([20, 36].map(enough), [Some(19), Some(19)]);
        assert!(band(38).is_ok());
        assert_eq!(EnvelopeRefusal::NoCurve.enough(0.95), None);
        let refused = |inside, calibrating| EnvelopeRefusal::NotEnclosed {
            inside,
            calibrating,
            needed: quantile_rank(calibrating + 1, 0.95),
        };
        // one that cannot be enclosed takes 20 more; of 400 those 100 are no matter of the number
        assert_eq!(refused(29, 30).enough(0.95), Some(39));
        assert_eq!(refused(300, 400).enough(0.95), None);
    }

    /// Y(t) = Z₁ cos t + Z₂ sin t with standard normal Z: the pointwise 95 % band is ±1.96 and holds the share
    /// P(Z₁² + Z₂² ≤ 1.96²) = 1 − exp(−1.96²/2) = 0.8535 of whole curves.
    /// Seen to fail when one point inside was enough.
    #[test]
    fn a_pointwise_band_is_no_envelope() {
        let n = 100;
        // Radii and angles on a grid of equal probability: the law of the radius is Rayleigh.
        let curves: Vec<Option<Curve>> = (0..n * n)
            .map(|i| {
                let share = ((i / n) as f64 + 0.5) / n as f64;
                let radius = (-2.0 * (1.0 - share).ln()).sqrt();
                let angle = TAU * ((i % n) as f64 + 0.5) / n as f64;
                Curve::through((0..=60).map(|j| {
                    let t = TAU * f64::from(j) / 60.0;
                    (t, radius * (t - angle).cos())
                }))
            })
            .collect();
        let grid: Vec<f64> = (0..=60).map(|j| TAU * f64::from(j) / 60.0).collect();
        let band = pointwise_band(&CurveSet::of(&curves, &grid), &[0.025, 0.975], 0.95);
        let inside = band.whole_curves_inside.unwrap().known.unwrap().estimate;
        assert!((inside - 0.8535).abs() < 0.01, "{inside}");
    }
}
