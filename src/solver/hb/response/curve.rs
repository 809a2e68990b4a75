//! Forced response around a peak: few solutions along the branch, many points between them.
//!
//! Between two solutions the dynamic stiffness 1/ŷ is a cubic Hermite polynomial in the frequency ω. The tangents are known,
//! and 1/ŷ is smooth: for one oscillator ŷ draws a circle, but 1/ŷ is a parabola in ω. Around folds 1/ŷ and ω are cubics in
//! arclength. Solutions are added until the cubics are as exact as [`CURVE_ERROR`] says. The curve consists of the points that
//! a sweep away from the peak meets: the part behind a fold is left out. What slow sweeps through the band meet is found on the
//! whole branch.
//!
//! Where every contact sticks or is open over the whole period, its dynamic force is linear in the displacements. Then the harmonics
//! above the first vanish, the branch has no folds, and its solutions are found at frequencies of choice on harmonics 0 and 1 alone.

pub use super::curve_side::{CURVE_ERROR, CurvePoint};
use super::curve_side::{CurveSide, is_linear};
use crate::aft::AftSettings;
use crate::harmonics::HarmonicSet;
use crate::hb::branch::sweep::SweepDirection;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::rest::stiffness_at_rest;
use crate::hb::newton::{Iterate, Point};
use crate::hb::settings::{HbSettings, NewtonSettings};
use crate::hb::structure::resonance::{Band, linear_resonances};

/// The forced response through a peak.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ResponseCurve {
    /// What a sweep away from the peak meets on either side. Ascending in frequency, one point per frequency.
    pub points: Vec<CurvePoint>,
    /// What slow sweeps through the whole band meet; absent where the branch could not be followed from one end of the band to
    /// the other.
    pub sweeps: Option<Sweeps>,
}

/// Slow sweeps through the band. Where the branch folds back, the response jumps from the fold to that later part of the branch
/// which goes on in the direction of the sweep.
///
/// Source: Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019, section 4 (turning points).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweeps {
    /// The largest amplitude of the sweep from low to high frequencies.
    pub upward: CurvePoint,
    /// The largest amplitude of the sweep from high to low frequencies.
    pub downward: CurvePoint,
    /// Lowest and highest frequency (rad/s) between which there are several solutions: the sweeps jump at these ends. The widest such range;
    /// absent where every frequency of the band has one solution.
    pub several: Option<[f64; 2]>,
}

/// Residual over the largest dynamic displacement at the peak. That is enough for a plot; the peak itself is solved to the
/// study's tolerance.
const TOLERANCE: f64 = 1e-4;

/// The forced response through `peak` inside `band`, with the Newton settings of `settings` and the stability that these ask for.
/// Where the continuation fails the curve ends.
#[must_use]
pub fn response_curve(
    balance: &Balance<'_>,
    peak: &Point,
    band: Band,
    settings: &HbSettings,
) -> ResponseCurve {
    let newton = NewtonSettings {
        tolerance: (settings.newton.tolerance)
            .max(TOLERANCE * peak.dynamic_share(balance).min(1.0)),
        ..settings.newton
    };
    let few = balance.on(HarmonicSet::up_to(1));
    let linear = linear_sides([balance, &few], peak, band, newton, settings.aft);
    let sides = linear.unwrap_or_else(|| {
        [SweepDirection::Downward, SweepDirection::Upward].map(|direction| {
            let mut side = CurveSide::outwards(balance, peak, direction, band, newton);
            side.refine();
            side
        })
    });
    let width = sides[0].scales.width;
    let [below, above] = sides.map(|side| side.branch(settings));
    let side = |side: &[CurvePoint], direction| {
        let mut points = met(side.iter().copied(), direction, band);
        // of a jump the fold
        points.dedup_by_key(|point| point.omega);
        points
    };
    let mut points = side(&below, SweepDirection::Downward);
    points.reverse();
    points.pop();
    points.extend(side(&above, SweepDirection::Upward));
    let branch: Vec<CurvePoint> = (below.into_iter().rev())
        .chain(above.into_iter().skip(1))
        .collect();
    ResponseCurve {
        points,
        sweeps: sweeps(&branch, band, CURVE_ERROR * width),
    }
}

/// Both sides of a peak of `balance` on harmonics 0 and 1, those of `few`; none where a contact force is not linear.
fn linear_sides<'b, 'p>(
    [balance, few]: [&'b Balance<'p>; 2],
    peak: &Point,
    band: Band,
    newton: NewtonSettings,
    aft: AftSettings,
) -> Option<[CurveSide<'b, 'p>; 2]> {
    if !is_linear(balance, &Iterate::new(balance, peak.clone())) {
        return None;
    }
    // other modes may make contacts slip, and are narrow
    let stiffness = stiffness_at_rest(balance.problem, aft, band.low);
    let resonances = linear_resonances(balance.problem.model, &stiffness, band, 0.0).ok()?;
    let peak = peak.padded(balance, few);
    let side = |direction| {
        let mut side = CurveSide::linear(few, &peak, direction, band, newton)?;
        for resonance in &resonances {
            side.add(resonance)?;
        }
        side.refine();
        let are_linear = side.points.iter().all(|p| is_linear(few, &p.iterate));
        are_linear.then_some(side)
    };
    Some([
        side(SweepDirection::Downward)?,
        side(SweepDirection::Upward)?,
    ])
}

/// The points of `branch`, in the band, that a sweep along the branch, in this direction, meets. A jump adds the point on which it lands, at
/// the frequency of the fold.
fn met(
    branch: impl Iterator<Item = CurvePoint>,
    direction: SweepDirection,
    band: Band,
) -> Vec<CurvePoint> {
    let ahead = |point: &CurvePoint| direction.sign() * point.omega;
    let mut points: Vec<CurvePoint> = Vec::new();
    let mut before: Option<CurvePoint> = None;
    for point in branch {
        let fold = points.last().copied();
        if fold.is_none_or(|fold| ahead(&point) > ahead(&fold)) {
            let jump = fold
                .zip(before)
                .filter(|(fold, before)| ahead(before) < ahead(fold));
            points.extend(jump.map(|(fold, before)| landing(fold.omega, before, point)));
            points.push(point);
        }
        before = Some(point);
    }
    points.retain(|point| band.contains(point.omega));
    points
}

/// The point at `omega` between two points of a branch.
fn landing(omega: f64, from: CurvePoint, to: CurvePoint) -> CurvePoint {
    let share = (omega - from.omega) / (to.omega - from.omega);
    CurvePoint {
        omega,
        amplitude: from.amplitude + share * (to.amplitude - from.amplitude),
        unstable: None,
    }
}

/// What slow sweeps meet on a branch from below the band to above it. Parts that go back by less than `resolution` (rad/s) within the band
/// are no folds.
fn sweeps(branch: &[CurvePoint], band: Band, resolution: f64) -> Option<Sweeps> {
    let [first, last] = [branch.first()?.omega, branch.last()?.omega];
    if first > band.low || last < band.high {
        return None;
    }
    let highest = |points: Vec<CurvePoint>| {
        points
            .into_iter()
            .max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
    };
    let mut front = first;
    let mut several: Vec<[f64; 2]> = Vec::new();
    for omega in branch.iter().map(|point| point.omega) {
        front = front.max(omega);
        let [back, ahead] = [omega.max(band.low), front.min(band.high)];
        if ahead - back <= resolution {
            continue;
        }
        match several.last_mut().filter(|[_, end]| back <= *end) {
            Some([low, high]) => [*low, *high] = [low.min(back), high.max(ahead)],
            None => several.push([back, ahead]),
        }
    }
    let width = |[low, high]: &[f64; 2]| high - low;
    let several = (several.into_iter()).max_by(|a, b| width(a).total_cmp(&width(b)));
    Some(Sweeps {
        upward: highest(met(branch.iter().copied(), SweepDirection::Upward, band))?,
        downward: highest(met(
            branch.iter().rev().copied(),
            SweepDirection::Downward,
            band,
        ))?,
        several,
    })
}

#[cfg(test)]
mod tests {
    use super::{CurvePoint, Sweeps, sweeps};
    use crate::hb::structure::resonance::Band;

    /// Points (frequency, amplitude) in the order of a branch.
    fn branch(points: &[[f64; 2]]) -> Vec<CurvePoint> {
        let point = |&[omega, amplitude]: &[f64; 2]| CurvePoint {
            omega,
            amplitude,
            unstable: None,
        };
        points.iter().map(point).collect()
    }

    const BAND: Band = Band {
        low: 1.0,
        high: 9.0,
    };

    /// A curve that leans to low frequencies: upwards the response jumps at 6 past the top at 4, downwards it meets the top and jumps at 3.
    /// Seen to fail with both sweeps in the direction of the branch, with the ends of the range exchanged, without the point on which a
    /// jump lands, and with one range from the first fold to the last one.
    #[test]
    fn sweeps_jump_at_folds() {
        let leaning = branch(&[
            [0.5, 1.0],
            [5.0, 2.0],
            [6.0, 3.0],
            [4.0, 5.0],
            [3.0, 7.0],
            [4.0, 8.0],
            [6.5, 4.0],
            [9.5, 1.0],
        ]);
        let found = sweeps(&leaning, BAND, 0.1).expect("a branch through the band");
        let at = |omega, amplitude| CurvePoint {
            omega,
            amplitude,
            unstable: None,
        };
        let expected = Sweeps {
            upward: at(6.0, 4.8),
            downward: at(4.0, 8.0),
            several: Some([3.0, 6.0]),
        };
        assert_eq!(found, expected);
        // of two ranges the wider one, without what lies between them
        let twice = branch(&[
            [0.5, 1.0],
            [2.0, 2.0],
            [1.5, 3.0],
            [6.0, 4.0],
            [4.0, 7.0],
            [9.5, 1.0],
        ]);
        let found = sweeps(&twice, BAND, 0.1).expect("a branch through the band");
        assert_eq!(found.several, Some([4.0, 6.0]));
        // a step back that the curve does not resolve is no fold, and the top is met from both sides
        let upright = branch(&[[0.5, 1.0], [4.0, 7.0], [3.95, 8.0], [4.0, 7.0], [9.5, 1.0]]);
        let found = sweeps(&upright, BAND, 0.1).expect("a branch through the band");
        assert_eq!(found.several, None);
    }

    /// A branch that ends in the band tells nothing of a sweep through it. Seen to fail without this rule.
    #[test]
    fn a_branch_that_ends_in_the_band_has_no_sweeps() {
        let whole = [[0.5, 1.0], [4.0, 7.0], [9.5, 1.0]];
        assert!(sweeps(&branch(&whole), BAND, 0.1).is_some(), "whole");
        assert_eq!(sweeps(&branch(&whole[1..]), BAND, 0.1), None);
        assert_eq!(sweeps(&branch(&whole[..2]), BAND, 0.1), None);
    }
}
