//! Solutions along the branch through a band, close enough together for a picture with straight lines between them.
//!
//! A walk with steps of limited length keeps to the branch; where pairs begin to slip or to lift off the curve bends sharply
//! between two of its solutions. So solutions are added where the tangents at both ends of a line leave room for more than
//! [`PICTURE_ERROR`] beside it. A solution that was added shows whether the tangents knew what lies between; if not, more are added.

use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::continuation::WalkEnd;
use crate::hb::branch::stretch::Stretch;
use crate::hb::branch::sweep::{Route, follow};
use crate::hb::equations::balance::Balance;
use crate::hb::equations::effort::{Meter, WorkCount};
use crate::hb::newton::{Iterate, Point};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::ControlFlow;

/// Distance at most between the curve and the straight lines, over the largest amplitude; along the frequency axis over
/// the half-power half-width of the peak.
pub const PICTURE_ERROR: f64 = 3e-3;
/// How often a step of the walk is divided.
const MOST_DIVISIONS: usize = 10;
/// Shares of a step where a solution is looked for that divides it.
const SHARES: [f64; 4] = [0.5, 0.35, 0.65, 0.2];

/// The solutions of one way through the band, in the order of the way.
#[derive(Debug)]
pub(in crate::hb) struct Stations<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    /// Solutions with the work of each.
    pub(in crate::hb) points: Vec<(BranchPoint<'p>, WorkCount)>,
    /// The steps between them. Shape: `[points - 1]`.
    steps: Vec<Step>,
}

/// A step between two solutions.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    line: Line,
    /// How often the step of the walk was divided.
    divisions: usize,
}

/// What is known of the straight line between two solutions.
#[derive(Debug, Clone, Copy, Default)]
enum Line {
    /// The tangents at its ends say how far the curve may leave it.
    #[default]
    Seen,
    /// They do not: the solution that divided the step was farther away.
    Off,
    /// No solution that divides it was found.
    Unsolved(Status),
}

/// How a way ended.
pub(in crate::hb) struct End {
    /// [`Status::Converged`] at the far end of the band, or where the other way was met.
    pub(in crate::hb) status: Status,
    /// Whether the other way was met.
    pub(in crate::hb) met: bool,
    /// Work after the last solution.
    pub(in crate::hb) count: WorkCount,
}

impl<'b, 'p> Stations<'b, 'p> {
    /// Walks from `start` along `route` to its far end, or to the solution `other` of another way.
    pub(in crate::hb) fn walked(
        balance: &'b Balance<'p>,
        start: (Iterate<'p>, WorkCount),
        route: Route,
        newton: NewtonSettings,
        (other, progress): (Option<&Point>, &impl Fn(f64)),
    ) -> (Self, End) {
        let sign = route.direction.sign();
        let [begin, far_end] = route.direction.ends(route.band);
        let mut stations = Self {
            balance,
            newton,
            points: Vec::new(),
            steps: Vec::new(),
        };
        let (mut met, mut done, mut spent) = (false, 0.0f64, start.1);
        let meter = Meter::new(&balance.problem.effort);
        let mut clipped = None;
        let end = follow(balance, start.0, route, newton, |from, to| {
            let work = meter.read();
            let stretch = Stretch::new(balance, &from, to);
            let reached = to.iterate.point.omega;
            done = done.max(sign * (reached - begin) / (sign * (far_end - begin)));
            progress(done.min(1.0));
            met = other.is_some_and(|other| stretch.passes(balance, other));
            if sign * (reached - far_end) > 0.0 {
                clipped = stretch.clipped(balance, far_end, newton);
            }
            stations.steps.push(Step::default());
            stations.points.push((from, spent));
            spent = work;
            match met {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        let (WalkEnd { status, last }, count) = (end, meter.read());
        if met {
            // what lies beyond the other way's end is known from that way
            stations.steps.pop();
        } else {
            stations.points.push((clipped.unwrap_or(last), spent));
        }
        (stations, End { status, met, count })
    }

    /// The steps, in their order, each with the status of what was to be added and could not be solved for.
    pub(in crate::hb) fn stretches(
        &self,
    ) -> impl Iterator<Item = (Stretch<'_, 'p>, Option<Status>)> {
        (0..self.steps.len()).map(|i| match self.steps[i].line {
            Line::Unsolved(status) => (self.stretch(i), Some(status)),
            _ => (self.stretch(i), None),
        })
    }

    fn stretch(&self, i: usize) -> Stretch<'_, 'p> {
        let [from, to] = [i, i + 1].map(|i| &self.points[i].0);
        Stretch::new(self.balance, from, to)
    }

    /// Adds solutions where straight lines are not exact enough.
    pub(in crate::hb) fn refine(&mut self) {
        let Some(picture) = Picture::of(&self.points) else {
            return;
        };
        let mut i = 0;
        while i < self.steps.len() {
            // the first part of a divided step comes next
            if !(self.is_coarse(i, &picture) && self.divide(i, &picture)) {
                i += 1;
            }
        }
    }

    /// Whether the straight line over step i may miss the curve.
    fn is_coarse(&self, i: usize, picture: &Picture) -> bool {
        let Step { line, divisions } = self.steps[i];
        let misses = match line {
            Line::Seen => picture.room(&self.stretch(i)) > PICTURE_ERROR,
            Line::Off => true,
            Line::Unsolved(_) => false,
        };
        misses && divisions < MOST_DIVISIONS
    }

    /// Adds a solution on step i and sees how far it lies from the straight line; whether there was one.
    fn divide(&mut self, i: usize, picture: &Picture) -> bool {
        let (balance, newton) = (self.balance, self.newton);
        let (stretch, divisions) = (self.stretch(i), self.steps[i].divisions + 1);
        let meter = Meter::new(&balance.problem.effort);
        let mut failure = Status::StepTooSmall;
        let added = SHARES.iter().find_map(|share| {
            let found = stretch.inside(balance, share * stretch.length, newton);
            failure = found.as_ref().err().copied().unwrap_or(failure);
            found.ok()
        });
        let Some(point) = added else {
            self.steps[i].line = Line::Unsolved(failure);
            self.points[i + 1].1 += meter.read();
            return false;
        };
        // tangents that leave less room than the curve takes know nothing of what lies between
        let missed = picture.distance(&stretch, &point);
        let line = match missed > PICTURE_ERROR.max(picture.room(&stretch)) {
            true => Line::Off,
            false => Line::Seen,
        };
        self.steps.splice(i..=i, [Step { line, divisions }; 2]);
        self.points.insert(i + 1, (point, meter.read()));
        true
    }
}

/// The scales in which the curve is looked at.
struct Picture {
    width: f64,
    height: f64,
}

impl Picture {
    fn of(points: &[(BranchPoint<'_>, WorkCount)]) -> Option<Self> {
        let height = |i: usize| points[i].0.response.norm();
        let top = (0..points.len()).max_by(|&i, &j| height(i).total_cmp(&height(j)))?;
        // friction cuts tops off: the phase turns slowly there, and an oscillator with its rate would be too wide
        let flank = height(top) * FRAC_1_SQRT_2;
        let omega = |i: usize| points[i].0.iterate.point.omega;
        let is_above = |i: &usize| height(*i) > flank;
        let above =
            ((0..=top).rev().take_while(is_above)).chain((top..points.len()).take_while(is_above));
        let (low, high) = above.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), i| {
            (low.min(omega(i)), high.max(omega(i)))
        });
        let highest = &points[top].0;
        let of_oscillator = (highest.tangent.omega / highest.phase_rate()).abs();
        let half = 0.5 * (high - low);
        Some(Self {
            width: match half > 0.0 {
                true => half.min(of_oscillator),
                false => of_oscillator,
            },
            height: height(top),
        })
    }

    fn place(&self, p: &BranchPoint<'_>) -> [f64; 2] {
        [
            p.iterate.point.omega / self.width,
            p.response.norm() / self.height,
        ]
    }

    /// Distance of a solution from the straight line between the ends of a step.
    fn distance(&self, stretch: &Stretch<'_, '_>, point: &BranchPoint<'_>) -> f64 {
        let [a, b, p] = [stretch.from, stretch.to, point].map(|p| self.place(p));
        let [chord, away] = [b, p].map(|to| [to[0] - a[0], to[1] - a[1]]);
        let across = chord[0] * away[1] - chord[1] * away[0];
        across.abs() / f64::hypot(chord[0], chord[1])
    }

    /// Distance from the straight line to where the tangents at its ends meet: a curve that bends one way stays within. For
    /// one that bends both ways, what two corners would leave.
    fn room(&self, stretch: &Stretch<'_, '_>) -> f64 {
        let [a, b] = [stretch.from, stretch.to].map(|p| self.place(p));
        let tangent = |p: &BranchPoint<'_>| {
            let rise = p.response.norm() * p.growth();
            [p.tangent.omega / self.width, rise / self.height]
        };
        let chord = [b[0] - a[0], b[1] - a[1]];
        let length = f64::hypot(chord[0], chord[1]);
        let slope = |d: [f64; 2]| {
            let along = d[0] * chord[0] + d[1] * chord[1];
            let across = d[1] * chord[0] - d[0] * chord[1];
            (across / along, along > 0.0)
        };
        let ((first, goes), (last, comes)) =
            (slope(tangent(stretch.from)), slope(tangent(stretch.to)));
        if !(goes && comes) {
            return length;
        }
        match first * last < 0.0 {
            true => length * first.abs() * last.abs() / (first.abs() + last.abs()),
            false => length * 0.25 * first.abs().max(last.abs()),
        }
    }
}
