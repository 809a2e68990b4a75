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

use super::cubic_segment::{ComplexScales, CubicSegment};
use crate::harmonics::HarmonicSet;
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::branch_segment::CLOSE;
use crate::hb::branch::continuation::{StepSettings, continue_branch};
use crate::hb::branch::sweep::SweepDirection;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Iterate, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::structure::resonance::Band;
use std::ops::ControlFlow;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Amplitude |ŷ| of the response that defines resonance (m).
    pub amplitude: f64,
}

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
    /// Lowest and highest frequency (rad/s) between which there are several solutions: the sweeps jump at these ends. Absent where
    /// every frequency of the band has one.
    pub several: Option<[f64; 2]>,
}

/// Largest distance between the curve and the solutions, over the amplitude of the peak; along the frequency axis over the
/// half-power half-width of an oscillator with the phase rate of the peak.
pub const CURVE_ERROR: f64 = 3e-3;

/// First, shortest and largest relative change of the displacements per step. Shorter steps would resolve the kinks where
/// pairs begin to slip or lift off; the rounds of halving do that at less cost.
const STEPS: [f64; 3] = [0.4, 0.1, 2.0];
/// Most steps of the continuation per side.
const MOST_STEPS: usize = 60;
/// Rounds in which solutions are added between those of the continuation.
const MOST_ROUNDS: usize = 4;
/// Estimated error that the step control aims at, and estimated error above which solutions are added. Kinks make the
/// estimate too low, by a factor of two at most where it was checked.
const ESTIMATES: [f64; 2] = [0.1 * CURVE_ERROR, CURVE_ERROR / 3.0];
/// Where contacts are linear: first and longest step over the half-width of the peak, and longest step over the band.
const LINEAR_STEPS: [f64; 3] = [0.3, 4.0, 0.125];
/// Range of the length of such a step over that of the step before.
const LINEAR_GROWTH: [f64; 2] = [0.5, 2.0];
/// Deviation of a dynamic contact force from that of a contact that sticks or is open, over the largest one, below which it is linear.
const LINEAR_FORCE: f64 = 1e-6;
/// Residual over the largest dynamic displacement at the peak. That is enough for a plot; the peak itself is solved to the
/// study's tolerance.
const TOLERANCE: f64 = 1e-4;

/// The forced response through `peak` inside `band`. Where the continuation fails the curve ends.
#[must_use]
pub fn response_curve(
    balance: &Balance<'_>,
    peak: &Point,
    band: Band,
    newton: NewtonSettings,
) -> ResponseCurve {
    let newton = NewtonSettings {
        tolerance: newton
            .tolerance
            .max(TOLERANCE * peak.dynamic_share(balance).min(1.0)),
        ..newton
    };
    let linear = linear_sides(balance, peak, band, newton);
    let [(below, width), (above, _)] = linear.unwrap_or_else(|| {
        [SweepDirection::Downward, SweepDirection::Upward].map(|direction| {
            let mut side = CurveSide::outwards(balance, peak, direction, band, newton);
            side.refine();
            (side.branch(), side.scales.width)
        })
    });
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

/// Both sides of a peak on harmonics 0 and 1 with the half-width (rad/s); none where a contact force is not linear.
fn linear_sides(
    balance: &Balance<'_>,
    peak: &Point,
    band: Band,
    newton: NewtonSettings,
) -> Option<[(Vec<CurvePoint>, f64); 2]> {
    if !is_linear(balance, &Iterate::new(balance, peak.clone())) {
        return None;
    }
    let few = balance.on(HarmonicSet::up_to(1));
    let peak = peak.padded(balance, &few);
    let side = |direction| {
        let mut side = CurveSide::linear(&few, &peak, direction, band, newton)?;
        side.refine();
        let all = side.points.iter().all(|p| is_linear(&few, &p.iterate));
        all.then(|| (side.branch(), side.scales.width))
    };
    Some([
        side(SweepDirection::Downward)?,
        side(SweepDirection::Upward)?,
    ])
}

/// Whether every contact sticks or is open over the whole period, so that its dynamic force is linear in the displacements. Its mean
/// force may still depend on the amplitude: a contact that has slipped on the way may stick afterwards.
fn is_linear(balance: &Balance<'_>, iterate: &Iterate<'_>) -> bool {
    let force = &iterate.contact.force;
    let deviation = balance.deviation(&iterate.point.r, force);
    let n = balance.layout.n_relative();
    let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let allowed = LINEAR_FORCE * largest(&force[n..]);
    let of_row =
        |x: &[f64], row: usize| (x[n..].iter().skip(row).step_by(n)).all(|x| x.abs() <= allowed);
    iterate.contact.steady && (0..n).all(|row| of_row(&deviation, row) || of_row(force, row))
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
    let mut several: Option<[f64; 2]> = None;
    for omega in branch.iter().map(|point| point.omega) {
        front = front.max(omega);
        let [back, ahead] = [omega.max(band.low), front.min(band.high)];
        if ahead - back > resolution {
            let [low, high] = several.unwrap_or([back, ahead]);
            several = Some([low.min(back), high.max(ahead)]);
        }
    }
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

/// The solutions on one side of the peak, in the order of the continuation.
struct CurveSide<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    omega_scale: f64,
    scales: ComplexScales,
    points: Vec<BranchPoint<'p>>,
    /// Lengths of the steps between the points. Shape: `[points - 1]`.
    lengths: Vec<f64>,
    /// Whether contacts are linear: then solutions are at frequencies of choice.
    linear: bool,
}

impl<'b, 'p> CurveSide<'b, 'p> {
    /// Follows the branch from the peak to the end of the band. The error of each segment decides the length of the next step.
    fn outwards(
        balance: &'b Balance<'p>,
        peak: &Point,
        direction: SweepDirection,
        band: Band,
        newton: NewtonSettings,
    ) -> Self {
        let steps = StepSettings {
            first: STEPS[0],
            largest: STEPS[2],
            max_steps: MOST_STEPS,
            closeness: CLOSE,
            ..StepSettings::for_band(band.width())
        };
        let omega_scale = steps.omega_scale;
        let iterate = Iterate::new(balance, peak.clone());
        let start = BranchPoint::new(balance, iterate, omega_scale);
        let scales = ComplexScales::of(&start, band);
        let start = start.towards(direction.sign());
        let (mut points, mut lengths) = (Vec::new(), Vec::new());
        let mut before: Option<CubicSegment> = None;
        let end = continue_branch(balance, start, newton, steps, |from, to, length| {
            let mut longest = f64::INFINITY;
            if let Some(segment) = &before {
                let share = segment.error(&scales, length, to) / ESTIMATES[0];
                longest = f64::max(segment.length / share.sqrt().sqrt(), STEPS[1]);
            }
            before = Some(CubicSegment::new(&from, to, length));
            points.push(from);
            lengths.push(length);
            match band.contains(to.iterate.point.omega) {
                true => ControlFlow::Continue(longest),
                false => ControlFlow::Break(()),
            }
        });
        points.push(end.last);
        Self {
            balance,
            newton,
            omega_scale,
            scales,
            points,
            lengths,
            linear: false,
        }
    }

    /// The same by solutions at frequencies of choice, where contacts are linear; none where they are not.
    fn linear(
        balance: &'b Balance<'p>,
        peak: &Point,
        direction: SweepDirection,
        band: Band,
        newton: NewtonSettings,
    ) -> Option<Self> {
        let omega_scale = StepSettings::for_band(band.width()).omega_scale;
        let sign = direction.sign();
        let iterate = Iterate::new(balance, peak.clone());
        let start = BranchPoint::new(balance, iterate, omega_scale).towards(sign);
        let scales = ComplexScales::of(&start, band);
        let mut side = Self {
            balance,
            newton,
            omega_scale,
            scales,
            points: vec![start],
            lengths: Vec::new(),
            linear: true,
        };
        let longest = f64::min(
            LINEAR_STEPS[1] * scales.width,
            LINEAR_STEPS[2] * band.width(),
        );
        let mut step = f64::min(LINEAR_STEPS[0] * scales.width, longest);
        for i in 0..MOST_STEPS {
            let omega = side.points[i].iterate.point.omega;
            if !band.contains(omega) {
                return Some(side);
            }
            let next = side.at(i, omega + sign * step)?;
            let mut growth = LINEAR_GROWTH[1];
            if let Some(before) = i.checked_sub(1) {
                let share = side.segment(before).error(&scales, 1.0, &next) / ESTIMATES[0];
                growth = share.sqrt().sqrt().recip();
            }
            step = (step * growth.clamp(LINEAR_GROWTH[0], LINEAR_GROWTH[1])).min(longest);
            side.points.push(next);
            side.lengths.push(1.0);
        }
        None
    }

    /// The solution at `omega` (rad/s) next to solution i, where contacts are linear.
    fn at(&self, i: usize, omega: f64) -> Option<BranchPoint<'p>> {
        let from = &self.points[i];
        let point = Point {
            omega,
            ..from.iterate.point.clone()
        };
        let solved = solve(self.balance, point, Condition::FixedFrequency, self.newton).ok()?;
        let found = BranchPoint::new(self.balance, solved, self.omega_scale);
        Some(found.towards(from.tangent.omega))
    }

    fn segment(&self, i: usize) -> CubicSegment {
        if self.linear {
            return CubicSegment::over_frequency(&self.points[i], &self.points[i + 1]);
        }
        CubicSegment::new(&self.points[i], &self.points[i + 1], self.lengths[i])
    }

    /// Error of segment i, measured at the solutions beyond its ends.
    fn error(&self, i: usize) -> f64 {
        let ahead = (self.lengths.get(i + 1)).map_or(0.0, |&length| {
            (self.segment(i)).error(&self.scales, length, &self.points[i + 2])
        });
        let behind = i.checked_sub(1).map_or(0.0, |j| {
            let segment = self.segment(i).reversed();
            segment.error(&self.scales, self.lengths[j], &self.points[j])
        });
        f64::max(ahead, behind)
    }

    /// Adds a solution in the middle of every segment that is not exact enough.
    fn refine(&mut self) {
        for _ in 0..MOST_ROUNDS {
            let coarse: Vec<usize> = (0..self.lengths.len())
                .filter(|&i| self.error(i) > ESTIMATES[1])
                .collect();
            let added = coarse.iter().rev().filter(|&&i| self.halve(i)).count();
            if added == 0 {
                return;
            }
        }
    }

    /// Whether a solution could be added in the middle of segment i.
    fn halve(&mut self, i: usize) -> bool {
        if self.linear {
            let [a, b] = [i, i + 1].map(|i| self.points[i].iterate.point.omega);
            let middle = self.at(i, 0.5 * (a + b));
            let is_found = middle.is_some();
            self.points.splice(i + 1..i + 1, middle);
            self.lengths.resize(self.points.len() - 1, 1.0);
            return is_found;
        }
        let (from, half) = (&self.points[i], 0.5 * self.lengths[i]);
        let solved = from.step(self.balance, half, self.newton);
        let Ok(iterate) = solved else {
            return false;
        };
        let middle = BranchPoint::new(self.balance, iterate, self.omega_scale);
        let middle = middle.following(&from.tangent);
        // past a corner the branch is longer than the step over it
        let [rest, _] = middle.distances(&self.points[i + 1].iterate.point);
        if rest <= 0.0 {
            return false;
        }
        self.lengths.splice(i..=i, [half, rest]);
        self.points.insert(i + 1, middle);
        true
    }

    /// The points of the branch from the peak on, in the order of the continuation.
    fn branch(&self) -> Vec<CurvePoint> {
        let peak = &self.points[0];
        let mut points = vec![CurvePoint {
            omega: peak.iterate.point.omega,
            amplitude: peak.response.norm(),
        }];
        for i in 0..self.lengths.len() {
            let segment = self.segment(i);
            let of_segment = segment.points(&self.scales);
            points.extend(of_segment.map(|(omega, response)| CurvePoint {
                omega,
                amplitude: response.norm(),
            }));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::{CurvePoint, Sweeps, sweeps};
    use crate::hb::structure::resonance::Band;

    /// Points (frequency, amplitude) in the order of a branch.
    fn branch(points: &[[f64; 2]]) -> Vec<CurvePoint> {
        let point = |&[omega, amplitude]: &[f64; 2]| CurvePoint { omega, amplitude };
        points.iter().map(point).collect()
    }

    const BAND: Band = Band {
        low: 1.0,
        high: 9.0,
    };

    /// A curve that leans to low frequencies: upwards the response jumps at 6 past the top at 4, downwards it meets the top and jumps at 3.
    /// Seen to fail with both sweeps in the direction of the branch, with the ends of the range exchanged, and without the point on which a
    /// jump lands.
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
        let at = |omega, amplitude| CurvePoint { omega, amplitude };
        let expected = Sweeps {
            upward: at(6.0, 4.8),
            downward: at(4.0, 8.0),
            several: Some([3.0, 6.0]),
        };
        assert_eq!(found, expected);
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
