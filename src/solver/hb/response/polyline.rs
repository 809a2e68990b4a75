//! Solutions along the branch through a band, close enough together for a plot with straight lines between them.
//!
//! A sweep with steps of limited length stays on the branch. But if pairs begin to slip or to lift off, the curve bends
//! sharply between two of its solutions. So the tangents at both ends of a segment bound how far the curve may lie from the
//! straight line. If that is more than [`PLOT_ERROR`], a solution is added on the segment. The added solution also shows
//! whether the bound holds; if not, more solutions are added.

use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::continuation::ContinuationEnd;
use crate::hb::branch::sweep::{SweepSettings, follow};
use crate::hb::equations::balance::Balance;
use crate::hb::equations::effort::{Counted, Meter, WorkCount};
use crate::hb::newton::{Iterate, Point};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::ControlFlow;

/// Largest distance between the curve and the straight lines, over the largest amplitude; along the frequency axis over the
/// half-power half-width of the peak.
pub const PLOT_ERROR: f64 = 3e-3;
/// How often a step of the sweep is divided.
const MOST_DIVISIONS: usize = 10;
/// Shares of a segment at which a solution is tried that divides it.
const SHARES: [f64; 4] = [0.5, 0.35, 0.65, 0.2];

/// The solutions of one sweep through the band, in the order of the sweep.
#[derive(Debug)]
pub(super) struct Polyline<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    pub(super) points: Vec<Counted<BranchPoint<'p>>>,
    /// What is known of the segments between the points. Shape: `[points - 1]`.
    states: Vec<SegmentState>,
}

/// What is known of a segment between two solutions.
#[derive(Debug, Clone, Copy, Default)]
struct SegmentState {
    line: LineCheck,
    /// How often the step of the sweep was divided.
    divisions: usize,
}

/// Whether the tangents at its ends bound the distance of a segment from the straight line.
#[derive(Debug, Clone, Copy, Default)]
enum LineCheck {
    /// Yes, as far as known.
    #[default]
    Bounded,
    /// No: the solution that divided the step was farther away.
    Exceeded,
    /// Not known: no solution was found that divides the segment.
    Unsolved(Status),
}

/// How a sweep ended.
pub(super) struct SweepEnd {
    /// [`Status::Converged`] at the far end of the band, or where the opposite sweep was met.
    pub(super) status: Status,
    /// Whether the opposite sweep was met.
    pub(super) met: bool,
    /// Work after the last solution.
    pub(super) work: WorkCount,
}

impl<'b, 'p> Polyline<'b, 'p> {
    /// Sweeps from `first` through the band, to its far end or to the solution `other` of the opposite sweep.
    pub(super) fn swept(
        balance: &'b Balance<'p>,
        first: Counted<Iterate<'p>>,
        sweep: SweepSettings,
        newton: NewtonSettings,
        other: Option<&Point>,
        progress: &impl Fn(f64),
    ) -> (Self, SweepEnd) {
        let sign = sweep.direction.sign();
        let [begin, far_end] = sweep.direction.ends(sweep.band);
        let mut polyline = Self {
            balance,
            newton,
            points: Vec::new(),
            states: Vec::new(),
        };
        let (mut met, mut done, mut work) = (false, 0.0f64, first.work);
        let meter = Meter::new(&balance.problem.effort);
        let mut clipped = None;
        let end = follow(balance, first.solution, sweep, newton, |from, to| {
            let work_of_step = meter.read();
            let segment = BranchSegment::new(&from, to);
            let reached = to.iterate.point.omega;
            done = done.max(sign * (reached - begin) / (sign * (far_end - begin)));
            progress(done.min(1.0));
            met = other.is_some_and(|other| segment.passes(other));
            if sign * (reached - far_end) > 0.0 {
                clipped = segment.clipped(balance, far_end, newton);
            }
            polyline.states.push(SegmentState::default());
            polyline.points.push(Counted {
                solution: from,
                work,
            });
            work = work_of_step;
            match met {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        let (ContinuationEnd { status, last }, work_after) = (end, meter.read());
        if met {
            // beyond the end of the opposite sweep the solutions are known from that sweep
            polyline.states.pop();
        } else {
            polyline.points.push(Counted {
                solution: clipped.unwrap_or(last),
                work,
            });
        }
        let end = SweepEnd {
            status,
            met,
            work: work_after,
        };
        (polyline, end)
    }

    /// The segments in their order, each with the status of the solution that was to be added, if that failed.
    pub(super) fn segments(&self) -> impl Iterator<Item = (BranchSegment<'_, 'p>, Option<Status>)> {
        (0..self.states.len()).map(|i| match self.states[i].line {
            LineCheck::Unsolved(status) => (self.segment(i), Some(status)),
            _ => (self.segment(i), None),
        })
    }

    fn segment(&self, i: usize) -> BranchSegment<'_, 'p> {
        let [from, to] = [i, i + 1].map(|i| &self.points[i].solution);
        BranchSegment::new(from, to)
    }

    /// Adds solutions where straight lines are not exact enough.
    pub(super) fn refine(&mut self) {
        let Some(scales) = PlotScales::of(&self.points) else {
            return;
        };
        let mut i = 0;
        while i < self.states.len() {
            // the first part of a divided segment comes next
            if !(self.is_coarse(i, &scales) && self.divide(i, &scales)) {
                i += 1;
            }
        }
    }

    /// Whether the straight line of segment i may miss the curve.
    fn is_coarse(&self, i: usize, scales: &PlotScales) -> bool {
        let SegmentState { line, divisions } = self.states[i];
        let misses = match line {
            LineCheck::Bounded => scales.bound(&self.segment(i)) > PLOT_ERROR,
            LineCheck::Exceeded => true,
            LineCheck::Unsolved(_) => false,
        };
        misses && divisions < MOST_DIVISIONS
    }

    /// Adds a solution on segment i and checks how far it lies from the straight line; false if none was found.
    fn divide(&mut self, i: usize, scales: &PlotScales) -> bool {
        let (balance, newton) = (self.balance, self.newton);
        let (segment, divisions) = (self.segment(i), self.states[i].divisions + 1);
        let meter = Meter::new(&balance.problem.effort);
        let mut failure = Status::StepTooSmall;
        let added = SHARES.iter().find_map(|share| {
            let found = segment.inside(balance, share * segment.length, newton);
            failure = found.as_ref().err().copied().unwrap_or(failure);
            found.ok()
        });
        let Some(point) = added else {
            self.states[i].line = LineCheck::Unsolved(failure);
            self.points[i + 1].work += meter.read();
            return false;
        };
        // if the curve is farther away than the tangents allow, they do not bound it on the halves either
        let missed = scales.distance(&segment, &point);
        let line = match missed > PLOT_ERROR.max(scales.bound(&segment)) {
            true => LineCheck::Exceeded,
            false => LineCheck::Bounded,
        };
        self.states
            .splice(i..=i, [SegmentState { line, divisions }; 2]);
        let work = meter.read();
        let solution = point;
        self.points.insert(i + 1, Counted { solution, work });
        true
    }
}

/// Scales of the frequency and the amplitude in the plot.
struct PlotScales {
    width: f64,
    height: f64,
}

impl PlotScales {
    fn of(points: &[Counted<BranchPoint<'_>>]) -> Option<Self> {
        let height = |i: usize| points[i].solution.response.norm();
        let top = (0..points.len()).max_by(|&i, &j| height(i).total_cmp(&height(j)))?;
        // friction flattens the peak: the phase changes slowly there, and an oscillator with this rate would be too wide
        let flank = height(top) * FRAC_1_SQRT_2;
        let omega = |i: usize| points[i].solution.iterate.point.omega;
        let is_above = |i: &usize| height(*i) > flank;
        let above =
            ((0..=top).rev().take_while(is_above)).chain((top..points.len()).take_while(is_above));
        let (low, high) = above.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), i| {
            (low.min(omega(i)), high.max(omega(i)))
        });
        let highest = &points[top].solution;
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

    /// Distance of a solution from the straight line between the ends of a segment.
    fn distance(&self, segment: &BranchSegment<'_, '_>, point: &BranchPoint<'_>) -> f64 {
        let [a, b, p] = [segment.from, segment.to, point].map(|p| self.place(p));
        let [chord, away] = [b, p].map(|to| [to[0] - a[0], to[1] - a[1]]);
        let across = chord[0] * away[1] - chord[1] * away[0];
        across.abs() / f64::hypot(chord[0], chord[1])
    }

    /// Bound of the distance between the curve and the straight line. A curve that bends to one side lies between the line and
    /// the point where the tangents at its ends meet. For a curve that bends to both sides the bound is that of two corners.
    fn bound(&self, segment: &BranchSegment<'_, '_>) -> f64 {
        let [a, b] = [segment.from, segment.to].map(|p| self.place(p));
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
            (slope(tangent(segment.from)), slope(tangent(segment.to)));
        if !(goes && comes) {
            return length;
        }
        match first * last < 0.0 {
            true => length * first.abs() * last.abs() / (first.abs() + last.abs()),
            false => length * 0.25 * first.abs().max(last.abs()),
        }
    }
}
