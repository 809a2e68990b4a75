//! Forced response around a peak: few solutions along the branch, many points between them.
//!
//! Between two solutions the dynamic stiffness 1/ŷ is a cubic Hermite polynomial in the frequency ω: the tangents are
//! known, and where the ŷ of one oscillator draws a circle, its 1/ŷ is a parabola in ω. Around folds both are cubics in
//! arclength. Solutions are added until the cubics are as exact as [`CURVE_ERROR`] says. The curve kept is what a sweep
//! away from the peak meets: where the branch folds back, the part behind the fold is left out.

use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::continuation::{StepSettings, walk};
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

/// Distance at most between the curve and the solutions, over the amplitude of the peak; along the frequency axis over
/// the half-power half-width of an oscillator with the phase rate of the peak.
pub const CURVE_ERROR: f64 = 3e-3;

/// First, shortest and largest relative change of the displacements per solution; shorter ones would resolve kinks
/// where pairs begin to slip or lift off, which the rounds of halving do at less cost.
const STEPS: [f64; 3] = [0.4, 0.1, 2.0];
/// Solutions per side before the walk gives up.
const MOST_STEPS: usize = 60;
/// Rounds in which solutions are added between those of the walk.
const MOST_ROUNDS: usize = 4;
/// Estimate of the error that the walk aims at, and above which solutions are added: kinks make it too low, by a factor
/// of two at most where it was checked.
const ESTIMATES: [f64; 2] = [0.1 * CURVE_ERROR, CURVE_ERROR / 3.0];
/// Slopes dω/dt at the ends of a leg over that of its chord, up to which ω is the parameter.
const STRAIGHT: std::ops::Range<f64> = 0.1..10.0;
/// Distance in the picture between two points of the curve.
const SPACING: f64 = 0.04;
/// Points per leg at most.
const MOST_POINTS: f64 = 24.0;
/// Residual over the largest dynamic displacement at the peak. The picture needs no more; the peak itself is solved to
/// the study's tolerance.
const TOLERANCE: f64 = 1e-4;

/// The forced response through `peak` inside `band`, ascending in frequency. Where the walk fails the curve ends.
#[must_use]
pub fn response_curve(
    balance: &Balance<'_>,
    peak: &Point,
    band: Band,
    newton: NewtonSettings,
) -> Vec<CurvePoint> {
    let newton = NewtonSettings {
        tolerance: newton
            .tolerance
            .max(TOLERANCE * peak.dynamic_share(balance).min(1.0)),
        ..newton
    };
    let side = |upwards: bool| {
        let mut march = March::outwards(balance, peak, upwards, (band, newton));
        march.refine();
        march.points(band)
    };
    let mut curve = side(false);
    curve.reverse();
    curve.pop();
    curve.extend(side(true));
    curve
}

/// The solutions of one side, in the order of the walk.
struct March<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    omega_scale: f64,
    picture: Picture,
    points: Vec<BranchPoint<'p>>,
    /// Lengths of the steps between the points. Shape: `[points - 1]`.
    lengths: Vec<f64>,
}

impl<'b, 'p> March<'b, 'p> {
    /// Walks from the peak until the band ends, the error of each leg governing the next step.
    fn outwards(
        balance: &'b Balance<'p>,
        peak: &Point,
        upwards: bool,
        (band, newton): (Band, NewtonSettings),
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
        let picture = Picture::of(&start, band);
        let start = if upwards { start } else { start.reversed() };
        let (mut points, mut lengths) = (Vec::new(), Vec::new());
        let mut before: Option<Leg> = None;
        let end = walk(balance, start, newton, steps, |from, to, length| {
            let mut longest = f64::INFINITY;
            if let Some(leg) = &before {
                let share = leg.error(&picture, length, to) / ESTIMATES[0];
                longest = f64::max(leg.length / share.sqrt().sqrt(), STEPS[1]);
            }
            before = Some(Leg::new(balance, &from, to, length));
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
            picture,
            points,
            lengths,
        }
    }

    fn leg(&self, i: usize) -> Leg {
        Leg::new(
            self.balance,
            &self.points[i],
            &self.points[i + 1],
            self.lengths[i],
        )
    }

    /// Error of leg i, as the solutions beyond its ends see it.
    fn error(&self, i: usize) -> f64 {
        let ahead = (self.lengths.get(i + 1)).map_or(0.0, |&length| {
            (self.leg(i)).error(&self.picture, length, &self.points[i + 2])
        });
        let behind = i.checked_sub(1).map_or(0.0, |j| {
            let leg = self.leg(i).reversed();
            leg.error(&self.picture, self.lengths[j], &self.points[j])
        });
        f64::max(ahead, behind)
    }

    /// Adds a solution in the middle of every leg that is not exact enough.
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

    /// Whether a solution could be added in the middle of leg i.
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

    /// Points from the peak outwards that a sweep meets.
    fn points(&self, band: Band) -> Vec<CurvePoint> {
        let peak = &self.points[0];
        let mut front = peak.iterate.point.omega;
        let mut points = vec![CurvePoint {
            omega: front,
            amplitude: peak.response.norm(),
        }];
        let sign = peak.tangent.omega.signum();
        for i in 0..self.lengths.len() {
            for (omega, response) in self.leg(i).points(&self.picture) {
                if sign * (omega - front) > 0.0 {
                    front = omega;
                    if band.contains(omega) {
                        let amplitude = response.norm();
                        points.push(CurvePoint { omega, amplitude });
                    }
                }
            }
        }
        points
    }
}

/// The scales in which the curve is looked at.
#[derive(Debug, Clone, Copy)]
struct Picture {
    width: f64,
    height: f64,
}

impl Picture {
    fn of(peak: &BranchPoint<'_>, band: Band) -> Self {
        let half_width = (peak.tangent.omega / peak.phase_rate()).abs();
        Self {
            width: half_width.min(band.width()),
            height: peak.response.norm(),
        }
    }

    /// Frequency, real and imaginary part of the response.
    fn place(&self, omega: f64, response: c64) -> [f64; 3] {
        [
            omega / self.width,
            response.re / self.height,
            response.im / self.height,
        ]
    }

    /// Distance of a place from the tangent at `point`: a difference along the curve is none.
    fn distance(&self, (omega, response): (f64, c64), point: &BranchPoint<'_>) -> f64 {
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
struct Leg {
    omega: [f64; 2],
    omega_rate: [f64; 2],
    stiffness: [c64; 2],
    stiffness_rate: [c64; 2],
    /// Arclength as the start and as the end measures it.
    length: f64,
    stretch: f64,
    /// Whether the parameter is the frequency, not the arclength.
    by_frequency: bool,
}

impl Leg {
    fn new(
        balance: &Balance<'_>,
        from: &BranchPoint<'_>,
        to: &BranchPoint<'_>,
        length: f64,
    ) -> Self {
        // tangents are of unit length where they stand; both ends must speak of the same arclength
        let stretch = from.length_at(balance, to, length);
        let rate = |p: &BranchPoint<'_>, length: f64| {
            -p.response_rate / (p.response * p.response) * length
        };
        Self {
            omega: [from.iterate.point.omega, to.iterate.point.omega],
            omega_rate: [from.tangent.omega * length, to.tangent.omega * stretch],
            stiffness: [from.response.inv(), to.response.inv()],
            stiffness_rate: [rate(from, length), rate(to, stretch)],
            length,
            stretch,
            by_frequency: false,
        }
        .straightened()
    }

    /// The same leg with the frequency as its parameter, unless it folds or nearly does.
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

    /// The same leg walked backwards.
    fn reversed(self) -> Self {
        let swap = |[a, b]: [f64; 2]| [b, a];
        let [a, b] = self.stiffness_rate;
        Self {
            omega: swap(self.omega),
            omega_rate: swap(self.omega_rate).map(|r| -r),
            stiffness: [self.stiffness[1], self.stiffness[0]],
            stiffness_rate: [-b, -a],
            length: self.stretch,
            stretch: self.length,
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

    /// Largest error of the cubics on the leg, from how far they miss the solution `next` at the distance `length`
    /// beyond its end: the errors there and in the middle are those of t²(1 − t)², (t²(1 − t)² : 1/16).
    fn error(&self, picture: &Picture, length: f64, next: &BranchPoint<'_>) -> f64 {
        let t = match self.by_frequency {
            true => (next.iterate.point.omega - self.omega[0]) / (self.omega[1] - self.omega[0]),
            false => 1.0 + length / self.stretch,
        };
        let missed = picture.distance(self.at(t), next);
        missed / (16.0 * (t * (t - 1.0)).powi(2))
    }

    /// Frequencies and responses at even parameters in (0, 1], close together in the picture.
    fn points(&self, picture: &Picture) -> impl Iterator<Item = (f64, c64)> {
        let [a, b] = [0, 1].map(|i| picture.place(self.omega[i], self.stiffness[i].inv()));
        let chord: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let n = (dot(chord, chord).sqrt() / SPACING).ceil();
        let n = n.clamp(2.0, MOST_POINTS);
        (1..=n as usize).map(move |i| self.at(i as f64 / n))
    }
}
