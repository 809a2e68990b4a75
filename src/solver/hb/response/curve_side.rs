//! The solutions on one side of a peak, few enough that the cubics between them are exact enough, and the points of a curve through them.

use super::cubic_segment::{ComplexScales, CubicSegment};
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::branch_segment::CLOSE;
use crate::hb::branch::continuation::{StepSettings, continue_branch};
use crate::hb::branch::sweep::{SweepDirection, smallest_step};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Iterate, Point, solve};
use crate::hb::settings::{HbSettings, NewtonSettings};
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::{Band, LinearResonance};
use std::ops::ControlFlow;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Amplitude |ŷ| of the response that defines resonance (m).
    pub amplitude: f64,
    /// Whether it is unstable; absent where that was not assessed, and between solutions.
    pub unstable: Option<bool>,
}

/// Largest distance between the curve and the solutions, over the amplitude of the peak; along the frequency axis over the
/// half-power half-width of an oscillator with the phase rate of the peak.
pub const CURVE_ERROR: f64 = 3e-3;

/// First, shortest and largest relative change of the displacements per step. Shorter steps would resolve the kinks where
/// pairs begin to slip or lift off; the rounds of halving do that at less cost.
const STEPS: [f64; 3] = [0.4, 0.1, 2.0];
/// Most steps of the continuation per side. Gaps that close make many folds: of random models with lift-off a side took up to 78.
const MOST_STEPS: usize = 400;
/// Rounds in which solutions are added between those of the continuation.
const MOST_ROUNDS: usize = 4;
/// How often a segment is halved where contacts are linear and a solution takes little: a mode may be a hundred times as narrow as the steps.
const LINEAR_ROUNDS: usize = 10;
/// Estimated error that the step control aims at, and estimated error above which solutions are added. Kinks make the
/// estimate too low, by a factor of two at most where it was checked.
const ESTIMATES: [f64; 2] = [0.1 * CURVE_ERROR, CURVE_ERROR / 3.0];
/// Where contacts are linear: first step over the half-width of the peak, and longest step over the band.
const LINEAR_STEPS: [f64; 2] = [0.3, 0.125];
/// A longer segment, in half-widths of the peak, is compared with a solution in its middle.
const LONG: f64 = 8.0;
/// Where contacts are linear: range of the length of a step over that of the step before.
const LINEAR_GROWTH: [f64; 2] = [0.5, 2.0];
/// A resonance needs no solution of its own where a solution lies within the first distance, in half-widths of its mode: the amplitude there
/// is at most 0.5 % below the largest. A place one half-width beside the resonance needs none where a solution lies within the second
/// distance: the cubics then have the width of the resonance.
const NEXT_TO: [f64; 2] = [0.1, 0.5];

/// Deviation of a dynamic contact force from that of a contact that sticks or is open, over the largest one, below which it is linear.
const LINEAR_FORCE: f64 = 1e-6;

/// The solutions on one side of the peak, in the order of the continuation.
pub(super) struct CurveSide<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    omega_scale: f64,
    pub(super) scales: ComplexScales,
    pub(super) points: Vec<BranchPoint<'p>>,
    /// Lengths of the steps between the points. Shape: `[points - 1]`.
    lengths: Vec<f64>,
    /// Whether contacts are linear: then solutions are at frequencies of choice.
    linear: bool,
}

impl<'b, 'p> CurveSide<'b, 'p> {
    /// Follows the branch from the peak to the end of the band. The error of each segment decides the length of the next step.
    pub(super) fn outwards(
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
            smallest: smallest_step(balance.events()),
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
    pub(super) fn linear(
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
        let longest = LINEAR_STEPS[1] * band.width();
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

    /// Adds the solutions at a resonance of the structure at rest and at its half-widths, if this side passes them and has none next to them:
    /// solutions far from a narrow resonance do not tell of it.
    ///
    /// Returns `None` if one is not found.
    pub(super) fn add(&mut self, resonance: &LinearResonance) -> Option<()> {
        let [at_top, beside] = NEXT_TO;
        for (half_widths, next_to) in [(-1.0, beside), (0.0, at_top), (1.0, beside)] {
            let omega = resonance.omega + half_widths * resonance.half_bandwidth;
            let away = |i: usize| self.points[i].iterate.point.omega - omega;
            let passes = |i: &usize| away(*i) * away(i + 1) <= 0.0;
            let Some(i) = (0..self.lengths.len()).find(passes) else {
                continue;
            };
            let apart = f64::min(away(i).abs(), away(i + 1).abs());
            if apart <= next_to * resonance.half_bandwidth {
                continue;
            }
            let found = self.at(i, omega)?;
            self.points.insert(i + 1, found);
            self.lengths.push(1.0);
        }
        Some(())
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
    pub(super) fn refine(&mut self) {
        if self.linear {
            return self.refine_linear();
        }
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

    /// The same where contacts are linear. The error of a long segment is that in its middle, too: 1/ŷ may have a pole there.
    fn refine_linear(&mut self) {
        let mut rounds = vec![0; self.lengths.len()];
        let mut i = 0;
        while i < self.lengths.len() {
            let [a, b] = [i, i + 1].map(|i| self.points[i].iterate.point.omega);
            let coarse = self.error(i) > ESTIMATES[1];
            let asked = coarse || (b - a).abs() > LONG * self.scales.width;
            let middle = match asked && rounds[i] < LINEAR_ROUNDS {
                true => self.at(i, 0.5 * (a + b)),
                false => None,
            };
            let missed = |middle: &BranchPoint<'p>| {
                coarse || self.segment(i).error(&self.scales, 1.0, middle) > ESTIMATES[1]
            };
            match middle.filter(missed) {
                None => i += 1,
                Some(middle) => {
                    self.points.insert(i + 1, middle);
                    self.lengths.push(1.0);
                    rounds[i] += 1;
                    rounds.insert(i, rounds[i]);
                }
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

    /// The points of the branch from the peak on, in the order of the continuation, with the stability that `settings` ask for.
    pub(super) fn branch(&self, settings: &HbSettings) -> Vec<CurvePoint> {
        let unstable = |point: &BranchPoint<'p>| {
            let solution = Solution::new(self.balance, &point.iterate, Status::Converged);
            let judged = solution.with_stability(self.balance.problem, settings);
            Some(!judged.stability?.is_stable())
        };
        let peak = &self.points[0];
        let mut points = vec![CurvePoint {
            omega: peak.iterate.point.omega,
            amplitude: peak.response.norm(),
            unstable: unstable(peak),
        }];
        for i in 0..self.lengths.len() {
            let segment = self.segment(i);
            let of_segment = segment.points(&self.scales);
            points.extend(of_segment.map(|(omega, response)| CurvePoint {
                omega,
                amplitude: response.norm(),
                unstable: None,
            }));
            if let Some(solved) = points.last_mut() {
                solved.unstable = unstable(&self.points[i + 1]);
            }
        }
        points
    }
}

/// Whether every contact sticks or is open over the whole period, so that its dynamic force is linear in the displacements. Its mean
/// force may still depend on the amplitude: a contact that has slipped on the way may stick afterwards.
pub(super) fn is_linear(balance: &Balance<'_>, iterate: &Iterate<'_>) -> bool {
    let force = &iterate.contact.force;
    let deviation = balance.deviation(&iterate.point.r, force);
    let n = balance.layout.n_relative();
    let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let allowed = LINEAR_FORCE * largest(&force[n..]);
    let of_row =
        |x: &[f64], row: usize| (x[n..].iter().skip(row).step_by(n)).all(|x| x.abs() <= allowed);
    iterate.contact.steady && (0..n).all(|row| of_row(&deviation, row) || of_row(force, row))
}
