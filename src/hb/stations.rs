//! Solutions along the branch through a band, close enough together for a picture with straight lines between them.
//!
//! A walk with steps of limited length keeps to the branch; where pairs begin to slip or to lift off the curve bends sharply
//! between two of its solutions. So solutions are added where the tangents at both ends of a line leave room for more than
//! `PICTURE_ERROR` beside it.

use super::balance::Balance;
use super::continuation::{BranchPoint, WalkEnd};
use super::newton::{Iterate, Point, WorkCount};
use super::settings::NewtonSettings;
use super::status::Status;
use super::sweep::{Route, Stretch, follow};
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::ControlFlow;

/// Distance aimed at between the curve and the straight lines (corners where pairs begin to slip may miss it), over the largest amplitude; along the frequency axis over
/// the half-power half-width of the peak.
const PICTURE_ERROR: f64 = 3e-3;
/// Rounds in which solutions are added between those of the walk.
const MOST_ROUNDS: usize = 10;

/// The solutions of one way through the band, in the order of the way.
#[derive(Debug)]
pub(super) struct Stations<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    /// Solutions with the work of each.
    pub(super) points: Vec<(BranchPoint<'p>, WorkCount)>,
    /// Lengths of the steps between them. Shape: `[points - 1]`.
    lengths: Vec<f64>,
}

/// How a way ended.
pub(super) struct End {
    /// [`Status::Converged`] at the far end of the band, or where the other way was met.
    pub(super) status: Status,
    /// Whether the other way was met.
    pub(super) met: bool,
    /// Work after the last solution.
    pub(super) count: WorkCount,
}

impl<'b, 'p> Stations<'b, 'p> {
    /// Walks from `start` along `route` to its far end, or to the solution `other` of another way.
    pub(super) fn walked(
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
            lengths: Vec::new(),
        };
        let (mut met, mut done, mut spent) = (false, 0.0f64, start.1);
        let mut clipped = None;
        let end = follow(balance, start.0, route, newton, |taken, work| {
            let reached = taken.to.iterate.point.omega;
            done = done.max(sign * (reached - begin) / (sign * (far_end - begin)));
            progress(done.min(1.0));
            met = other.is_some_and(|other| taken.stretch().passes(balance, other));
            if sign * (reached - far_end) > 0.0 {
                let stretch = taken.stretch();
                clipped = stretch.clipped(balance, far_end, newton, &mut spent);
            }
            stations.lengths.push(taken.length);
            stations.points.push((taken.from, spent));
            spent = work;
            match met {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        let WalkEnd {
            status,
            mut last,
            count,
        } = end;
        if let (Some((point, length)), Some(before)) = (clipped, stations.lengths.last_mut()) {
            (last, *before) = (point, length);
        }
        if met {
            // what lies beyond the other way's end is known from that way
            stations.lengths.pop();
        } else {
            stations.points.push((last, spent));
        }
        (stations, End { status, met, count })
    }

    /// The steps, in their order.
    pub(super) fn stretches(&self) -> impl Iterator<Item = Stretch<'_, 'p>> {
        (self.points.windows(2).zip(&self.lengths)).map(|(ends, &length)| Stretch {
            from: &ends[0].0,
            to: &ends[1].0,
            length,
        })
    }

    /// Adds solutions where straight lines are not exact enough.
    pub(super) fn refine(&mut self) {
        let Some(picture) = Picture::of(&self.points) else {
            return;
        };
        for _ in 0..MOST_ROUNDS {
            let bent: Vec<usize> = (self.stretches().enumerate())
                .filter(|(_, stretch)| picture.room(stretch) > PICTURE_ERROR)
                .map(|(i, _)| i)
                .collect();
            let added = bent.iter().rev().filter(|&&i| self.halve(i)).count();
            if added == 0 {
                return;
            }
        }
    }

    /// Whether a solution could be added in the middle of step i.
    fn halve(&mut self, i: usize) -> bool {
        let (from, half) = (&self.points[i].0, 0.5 * self.lengths[i]);
        let mut count = WorkCount::default();
        let Some(middle) = from.beside(self.balance, half, self.newton, &mut count) else {
            return false;
        };
        let rest = half / from.scale_of(self.balance, &middle);
        self.lengths.splice(i..=i, [half, rest]);
        self.points.insert(i + 1, (middle, count));
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

    /// Distance from the straight line to where the tangents at its ends meet: a curve that bends one way stays within. For
    /// one that bends both ways, what two corners would leave.
    fn room(&self, stretch: &Stretch<'_, '_>) -> f64 {
        let [a, b] = [stretch.from, stretch.to].map(|p| {
            [
                p.iterate.point.omega / self.width,
                p.response.norm() / self.height,
            ]
        });
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
