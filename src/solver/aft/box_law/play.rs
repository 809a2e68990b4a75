//! The slider of one direction of the box law, from breakpoint to breakpoint, and the stretches of its motion.
//!
//! The slider is a play: it rests until one of its bounds k_t u ∓ mu N reaches it, and then that bound pushes it.

use crate::aft::batch::AftBatch;
use crate::aft::lanes::motions::Motion;
use crate::aft::lanes::workspace::Workspace;
use crate::aft::plan::AftPlan;
use crate::aft::settings::Laps;
use crate::aft::signals::breakpoints::{Breakpoint, Intervals, Signals};
use crate::contact::law::normal_force;
use crate::contact::{ContactParameters, Real};
use std::f64::consts::TAU;

/// Scratch of one state.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct LaneScratch<T> {
    pub signals: Signals<T>,
    pub points: Vec<Breakpoint<T>>,
    /// Stretches of one direction in the last lap.
    pub(super) runs: Vec<Run<T>>,
    /// Phase from which a direction slips, per interval between breakpoints.
    pub(super) slip_from: Vec<T>,
    /// Antiderivatives at the ends of a stretch, its spectrum and the spectra of masks. Shape: `[2][2H + 1]` each.
    pub(super) start: Vec<T>,
    pub(super) end: Vec<T>,
    pub(super) run: Vec<T>,
    pub(super) stick: Vec<T>,
    pub(super) slip: Vec<T>,
    /// Fourier integrals of a stretch, basis row of an event, force coefficients. Shape: `[m]`.
    pub(super) sums: Vec<T>,
    pub(super) row: Vec<T>,
    pub force: Vec<T>,
}

/// Where and how the slider was set last.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    pub(super) point: usize,
    pub(super) motion: Motion,
}

/// Stretch of one motion; it starts where the one before ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run<T> {
    pub(super) end: T,
    pub(super) motion: Motion,
    /// k_t times the slider position (N), of a stick.
    pub(super) slider: T,
    pub(super) source: Option<Source>,
}

/// The slider of one direction between two breakpoints.
#[derive(Debug, Clone, Copy)]
struct Slider<T> {
    /// k_t w (N).
    place: T,
    motion: Motion,
    source: Option<Source>,
    /// Whether nothing has moved it yet.
    stuck: bool,
    /// The breakpoint at which it is.
    point: usize,
    /// Bounds that it has met in this lap.
    reached: [bool; 2],
}

/// A bound pushes the slider between two breakpoints.
#[derive(Debug, Clone, Copy)]
struct Push<T> {
    /// The lower (0) or the upper bound (1).
    side: usize,
    motion: Motion,
    /// The bound at both breakpoints (N).
    levels: [T; 2],
    /// The stick before it.
    stick: Run<T>,
}

/// How the play of one direction went.
#[derive(Debug, Clone, Copy)]
pub(super) struct Play<T> {
    /// Whether nothing ever moved the slider.
    pub(super) stuck: bool,
    /// Change of k_t w over the last lap (N).
    pub(super) change: T,
    /// Whether the last lap forgets the slider's start.
    pub(super) forgets: bool,
}

/// One state of a group.
#[derive(Clone, Copy)]
pub(in crate::aft) struct LaneState<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub batch: &'a AftBatch<T>,
    pub work: &'a Workspace<T>,
    pub lane: usize,
    pub state: usize,
}

impl<'a, T> LaneState<'a, T> {
    /// The state of a lane of the group that starts at `first`.
    pub(in crate::aft) fn new(
        plan: &'a AftPlan<T>,
        batch: &'a AftBatch<T>,
        work: &'a Workspace<T>,
        first: usize,
        lane: usize,
    ) -> Self {
        Self {
            plan,
            batch,
            work,
            lane,
            state: first + lane,
        }
    }
}

/// Lower and upper bound of k_t w in direction `d` at a breakpoint (N).
#[inline(always)]
fn bounds<T: Real>(p: &ContactParameters<T>, d: usize, point: &Breakpoint<T>) -> [T; 2] {
    let (stick, limit) = (p.k_t[d] * point.u[d], p.mu * normal_force(point.gap));
    [stick - limit, stick + limit]
}

impl<T: Real> LaneScratch<T> {
    /// Plays the slider of direction `d` from its anchor; `runs` are then the stretches of the last lap.
    #[inline(always)]
    pub(super) fn play(
        &mut self,
        at: LaneState<T>,
        intervals: &Intervals<T>,
        p: &ContactParameters<T>,
        d: usize,
    ) -> Play<T> {
        let laps = match at.plan.settings.laps {
            Laps::Fixed(n) => n,
            Laps::Periodic => 2,
        };
        let n = self.points.len();
        let first = &self.points[0];
        let anchor = p.k_t[d] * p.anchor[d];
        let (place, motion) = pushed(anchor, bounds(p, d, first), first.open);
        let mut slider = Slider {
            place,
            motion,
            source: None,
            stuck: true,
            point: 0,
            reached: [false; 2],
        };
        let mut start = place;
        for lap in 1..=laps {
            start = slider.place;
            slider.reached = [false; 2];
            self.runs.clear();
            for k in 0..n {
                let slip = self.pass(p, d, k, &mut slider);
                if let (Some(slip), true) = (slip, lap == laps) {
                    self.slip_runs(at, intervals, d, k, slip);
                }
            }
            if slider.stuck && slider.motion == Motion::Stick {
                break;
            }
        }
        Play {
            stuck: slider.stuck && slider.motion == Motion::Stick,
            change: slider.place - start,
            forgets: slider.reached[0] && slider.reached[1],
        }
    }

    /// The slider of direction `d` from breakpoint k to the next one. A run of stick or of the open contact is appended; a bound
    /// that pushes the slider is returned.
    #[inline(always)]
    fn pass(
        &mut self,
        p: &ContactParameters<T>,
        d: usize,
        k: usize,
        slider: &mut Slider<T>,
    ) -> Option<Push<T>> {
        if slider.motion != Motion::Stick {
            let (point, motion) = (slider.point, slider.motion);
            (slider.source, slider.stuck) = (Some(Source { point, motion }), false);
        }
        let n = self.points.len();
        let next = if k + 1 == n { 0 } else { k + 1 };
        let (a, b) = (self.points[k], self.points[next]);
        let (ends, levels) = (self.ends(k), [bounds(p, d, &a), bounds(p, d, &b)]);
        let before = slider.place;
        (slider.place, slider.motion) = pushed(before, levels[1], a.open);
        slider.point = next;
        let motion = slider.motion;
        let stick = Run {
            end: ends[1],
            motion: Motion::Stick,
            slider: before,
            source: slider.source,
        };
        let side = match motion {
            Motion::SlipUp => 0,
            Motion::SlipDown => 1,
            Motion::Stick => {
                self.append(stick);
                return None;
            }
            Motion::Separated => {
                slider.reached = [true; 2];
                self.append(Run { motion, ..stick });
                return None;
            }
        };
        slider.reached[side] = true;
        let levels = levels.map(|level| level[side]);
        Some(Push {
            side,
            motion,
            levels,
            stick,
        })
    }

    /// Appends the runs of an interval in which a bound pushes the slider: stick up to the phase at which the bound reaches it,
    /// then slip.
    #[inline(always)]
    fn slip_runs(
        &mut self,
        at: LaneState<T>,
        intervals: &Intervals<T>,
        d: usize,
        k: usize,
        push: Push<T>,
    ) {
        let Push {
            side,
            motion,
            levels,
            stick,
        } = push;
        let ends = self.ends(k);
        let mut from = ends[0];
        if levels[0] != stick.slider {
            let bracket = [(ends[0], levels[0]), (ends[1], levels[1])];
            let signals = &mut self.signals;
            from = signals.reaches(at.plan, d, side, stick.slider, bracket, |i| {
                intervals.bound_at(at.work, i, at.lane, d, side)
            });
            self.append(Run { end: from, ..stick });
        }
        if from < self.slip_from[k] {
            self.slip_from[k] = from;
        }
        self.append(Run { motion, ..stick });
    }

    /// Phases at the ends of the interval after breakpoint k.
    #[inline(always)]
    pub(super) fn ends(&self, k: usize) -> [T; 2] {
        let end = self.points.get(k + 1).map_or(phase(TAU), |b| b.theta);
        [self.points[k].theta, end]
    }

    /// Lengthens the last run, or adds a new one.
    #[inline(always)]
    fn append(&mut self, run: Run<T>) {
        match self.runs.last_mut() {
            Some(last) if last.motion == run.motion => last.end = run.end,
            _ => self.runs.push(run),
        }
    }
}

/// The slider after a monotone stretch that ends with these bounds, and what it did there.
#[inline(always)]
fn pushed<T: Real>(slider: T, [lower, upper]: [T; 2], open: bool) -> (T, Motion) {
    if open {
        (T::from_f64(0.5) * (lower + upper), Motion::Separated)
    } else if lower > slider {
        (lower, Motion::SlipUp)
    } else if upper < slider {
        (upper, Motion::SlipDown)
    } else {
        (slider, Motion::Stick)
    }
}

pub(super) fn phase<T: Real>(theta: f64) -> T {
    T::from_f64(theta)
}
