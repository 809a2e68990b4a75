//! Forced response around a peak: few solutions along the branch, many points between them.
//!
//! Between two solutions the dynamic stiffness 1/ŷ is a cubic Hermite polynomial in the frequency ω. The tangents are known,
//! and 1/ŷ is smooth: for one oscillator ŷ draws a circle, but 1/ŷ is a parabola in ω. Around folds 1/ŷ and ω are cubics in
//! arclength. Solutions are added until the cubics are as exact as [`CURVE_ERROR`] says. The curve consists of the points that
//! a sweep away from the peak meets: the part behind a fold is left out. What slow sweeps through the band meet is found on the
//! whole branch.

use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::continuation::{StepSettings, continue_branch};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Iterate, Point};
use crate::hb::settings::NewtonSettings;
use crate::hb::structure::resonance::Band;
use faer::prelude::c64;
use std::ops::ControlFlow;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Amplitude |ŷ| of response 0 (m).
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
/// If the slopes dω/dt at the ends of a segment, over that of its chord, are in this range, the parameter is ω.
const STRAIGHT: std::ops::Range<f64> = 0.1..10.0;
/// Scaled distance between two points of the curve.
const SPACING: f64 = 0.04;
/// Points per segment at most.
const MOST_POINTS: f64 = 24.0;
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
    let side = |upwards: bool| {
        let mut side = CurveSide::outwards(balance, peak, upwards, band, newton);
        side.refine();
        (side.branch(), side.scales.width)
    };
    let [(below, width), (above, _)] = [false, true].map(side);
    let mut points = met(below.iter().copied(), false, band);
    points.reverse();
    points.pop();
    points.extend(met(above.iter().copied(), true, band));
    let branch: Vec<CurvePoint> = (below.into_iter().rev())
        .chain(above.into_iter().skip(1))
        .collect();
    ResponseCurve {
        points,
        sweeps: sweeps(&branch, band, CURVE_ERROR * width),
    }
}

/// The points of `branch`, in the band, that a sweep in the direction of the branch meets: `upwards` to higher frequencies.
fn met(branch: impl Iterator<Item = CurvePoint>, upwards: bool, band: Band) -> Vec<CurvePoint> {
    let sign = if upwards { 1.0 } else { -1.0 };
    let mut front = f64::NEG_INFINITY;
    let ahead = branch.filter(|point| {
        let ahead = sign * point.omega > front;
        front = front.max(sign * point.omega);
        ahead
    });
    ahead.filter(|point| band.contains(point.omega)).collect()
}

/// What slow sweeps meet on a branch from below the band to above it. Parts that go back by less than `resolution` (rad/s) are no
/// folds.
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
        if front - omega > resolution {
            let [low, high] = several.unwrap_or([omega, front]);
            several = Some([low.min(omega), high.max(front)]);
        }
    }
    Some(Sweeps {
        upward: highest(met(branch.iter().copied(), true, band))?,
        downward: highest(met(branch.iter().rev().copied(), false, band))?,
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
}

impl<'b, 'p> CurveSide<'b, 'p> {
    /// Follows the branch from the peak to the end of the band. The error of each segment decides the length of the next step.
    fn outwards(
        balance: &'b Balance<'p>,
        peak: &Point,
        upwards: bool,
        band: Band,
        newton: NewtonSettings,
    ) -> Self {
        let steps = StepSettings {
            first: STEPS[0],
            largest: STEPS[2],
            max_steps: MOST_STEPS,
            ..StepSettings::for_band(band.width())
        };
        let omega_scale = steps.omega_scale;
        let iterate = Iterate::new(balance, peak.clone());
        let start = BranchPoint::new(balance, iterate, omega_scale, None, None);
        let scales = ComplexScales::of(&start, band);
        let start = if upwards { start } else { start.reversed() };
        let (mut points, mut lengths) = (Vec::new(), Vec::new());
        let mut before: Option<CubicSegment> = None;
        let end = continue_branch(balance, start, newton, steps, |from, to, length| {
            let mut longest = f64::INFINITY;
            if let Some(segment) = &before {
                let share = segment.error(&scales, length, to) / ESTIMATES[0];
                longest = f64::max(segment.length / share.sqrt().sqrt(), STEPS[1]);
            }
            before = Some(CubicSegment::new(balance, &from, to, length));
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
        }
    }

    fn segment(&self, i: usize) -> CubicSegment {
        CubicSegment::new(
            self.balance,
            &self.points[i],
            &self.points[i + 1],
            self.lengths[i],
        )
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
        let (from, half) = (&self.points[i], 0.5 * self.lengths[i]);
        let solved = from.step(self.balance, half, self.newton);
        let Ok(iterate) = solved else {
            return false;
        };
        let tangent = Some(&from.tangent);
        let middle = BranchPoint::new(self.balance, iterate, self.omega_scale, None, tangent);
        // past a corner the branch is longer than the step over it
        let [rest, _] = middle.distances(self.balance, &self.points[i + 1].iterate.point);
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

/// Scales of the frequency and of the complex response.
#[derive(Debug, Clone, Copy)]
struct ComplexScales {
    width: f64,
    height: f64,
}

impl ComplexScales {
    fn of(peak: &BranchPoint<'_>, band: Band) -> Self {
        let half_width = (peak.tangent.omega / peak.phase_rate()).abs();
        Self {
            width: half_width.min(band.width()),
            height: peak.response.norm(),
        }
    }

    /// Scaled frequency, real and imaginary part of the response.
    fn place(&self, omega: f64, response: c64) -> [f64; 3] {
        [
            omega / self.width,
            response.re / self.height,
            response.im / self.height,
        ]
    }

    /// Distance of a place from the tangent at `point`: differences along the curve do not count.
    fn distance(&self, omega: f64, response: c64, point: &BranchPoint<'_>) -> f64 {
        let omega = omega - point.iterate.point.omega;
        let away = self.place(omega, response - point.response);
        let along = self.place(point.tangent.omega, point.response_rate);
        let share = dot(away, along) / dot(along, along);
        let normal: [f64; 3] = std::array::from_fn(|i| away[i] - share * along[i]);
        dot(normal, normal).sqrt()
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The cubics between two solutions, over a parameter that runs from 0 to 1.
#[derive(Debug, Clone, Copy)]
struct CubicSegment {
    omega: [f64; 2],
    omega_rate: [f64; 2],
    stiffness: [c64; 2],
    stiffness_rate: [c64; 2],
    /// Arclength in the metric of the start, and in that of the end.
    length: f64,
    length_at_end: f64,
    /// Whether the parameter is the frequency, not the arclength.
    by_frequency: bool,
}

impl CubicSegment {
    fn new(
        balance: &Balance<'_>,
        from: &BranchPoint<'_>,
        to: &BranchPoint<'_>,
        length: f64,
    ) -> Self {
        // each tangent has unit length in the metric of its own point; both rates must be per the same arclength
        let length_at_end = from.length_at(balance, to, length);
        let rate = |p: &BranchPoint<'_>, length: f64| {
            -p.response_rate / (p.response * p.response) * length
        };
        Self {
            omega: [from.iterate.point.omega, to.iterate.point.omega],
            omega_rate: [
                from.tangent.omega * length,
                to.tangent.omega * length_at_end,
            ],
            stiffness: [from.response.inv(), to.response.inv()],
            stiffness_rate: [rate(from, length), rate(to, length_at_end)],
            length,
            length_at_end,
            by_frequency: false,
        }
        .straightened()
    }

    /// The same segment with the frequency as its parameter, unless it has or nearly has a fold.
    fn straightened(mut self) -> Self {
        let chord = self.omega[1] - self.omega[0];
        if self
            .omega_rate
            .iter()
            .all(|rate| STRAIGHT.contains(&(rate / chord)))
        {
            for i in 0..2 {
                self.stiffness_rate[i] *= chord / self.omega_rate[i];
                self.omega_rate[i] = chord;
            }
            self.by_frequency = true;
        }
        self
    }

    /// The same segment in the opposite direction.
    fn reversed(self) -> Self {
        let swap = |[a, b]: [f64; 2]| [b, a];
        let [a, b] = self.stiffness_rate;
        Self {
            omega: swap(self.omega),
            omega_rate: swap(self.omega_rate).map(|r| -r),
            stiffness: [self.stiffness[1], self.stiffness[0]],
            stiffness_rate: [-b, -a],
            length: self.length_at_end,
            length_at_end: self.length,
            by_frequency: self.by_frequency,
        }
    }

    /// Frequency and response at the parameter `t`, in or beyond [0, 1].
    fn at(&self, t: f64) -> (f64, c64) {
        let u = 1.0 - t;
        let value = [u * u * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t)];
        let slope = [t * u * u, -t * t * u];
        let omega = (0..2).map(|i| self.omega[i] * value[i] + self.omega_rate[i] * slope[i]);
        let stiffness = (0..2)
            .map(|i| self.stiffness[i] * value[i] + self.stiffness_rate[i] * slope[i])
            .sum::<c64>();
        (omega.sum(), stiffness.inv())
    }

    /// Largest error of the cubics on the segment, from their distance to the solution `next`, which lies `length` beyond its
    /// end. The error is taken to vary as t²(1 − t)², which is 1/16 in the middle.
    fn error(&self, scales: &ComplexScales, length: f64, next: &BranchPoint<'_>) -> f64 {
        let t = match self.by_frequency {
            true => (next.iterate.point.omega - self.omega[0]) / (self.omega[1] - self.omega[0]),
            false => 1.0 + length / self.length_at_end,
        };
        let (omega, response) = self.at(t);
        let missed = scales.distance(omega, response, next);
        missed / (16.0 * (t * (t - 1.0)).powi(2))
    }

    /// Frequencies and responses at even parameters in (0, 1], close together after scaling.
    fn points(&self, scales: &ComplexScales) -> impl Iterator<Item = (f64, c64)> {
        let [a, b] = [0, 1].map(|i| scales.place(self.omega[i], self.stiffness[i].inv()));
        let chord: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let n = (dot(chord, chord).sqrt() / SPACING).ceil();
        let n = n.clamp(2.0, MOST_POINTS);
        (1..=n as usize).map(move |i| self.at(i as f64 / n))
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

    /// A curve that leans to low frequencies: upwards the response jumps from 6 past the top at 4, downwards it meets the top and jumps at 3.
    /// Seen to fail with both sweeps in the direction of the branch, and with the ends of the range exchanged.
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
            upward: at(6.5, 4.0),
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
