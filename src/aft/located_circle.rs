//! Circle law with located events: forces, tangents and summaries of a group of states.
//!
//! Newton's method on the two start tractions of the slider finds the steady cycle, as in [`super::circle`]; where it is
//! not unique, plain laps from the anchor decide. The normal force is exact, as in [`super::located`].

use super::batch::{AftForces, Block, Periodicity, StateSummary, Tangent, Want};
use super::breakpoints::Intervals;
use super::circle::{
    MAX_LAPS, NEWTON_LAPS, Search, classify, is_singular, size, solve_identity_minus,
};
use super::course::{Course, Node};
use super::lap::{Lap, Walk};
use super::located::{LaneScratch, Place};
use super::march::{LANES, Lane, Workspace};
use super::plan::AftPlan;
use super::sensitivity::{Base, Blocks, Rows};
use super::settings::Laps;
use super::slip::SlipStep;
use crate::contact::{ContactParameters, Real};
use pulp::Simd;
use std::f64::consts::TAU;

/// Scratch of the evaluation.
#[derive(Debug, Clone, Default)]
pub(super) struct LocatedCircle<T> {
    intervals: Intervals<T>,
    /// Slip from each sample to the next one, row-major. Shape: `[time]`.
    maps: Vec<[Lane<T>; 4]>,
    lane: LaneScratch<T>,
    /// Samples of the present state. Shape: `[time + 1]`.
    nodes: Vec<Node<T>>,
    lap: Lap<T>,
    blocks: Blocks<T>,
    /// Kinks of the tractions, normal force coefficients. Shape: `[lane][3][m]`.
    forces: Vec<T>,
}

/// Search for the steady cycle of one state, lap by lap.
#[derive(Debug, Clone, Copy)]
struct Cycle<T> {
    stage: Stage<T>,
    /// Slider k_t w (N) at the start of the next lap.
    next: [T; 2],
    /// The same of the last lap of the cycle.
    start: [T; 2],
    laps: u32,
    periodicity: Periodicity,
    /// Whether the derivative is that of plain laps from the anchor, not that of the steady cycle.
    from_anchor: bool,
    stuck: bool,
    /// Whether the last Newton step was so small that the next lap should be the last one, which fills the tangent.
    near: bool,
}

/// What a lap is for; numbers count the laps of a stage from 1.
#[derive(Debug, Clone, Copy)]
enum Stage<T> {
    First,
    /// As many laps as the settings ask for.
    Fixed(u32),
    Newton(Search<T>),
    /// Plain laps from the anchor.
    Plain(u32),
    /// Newton's method from where they creep.
    Held(u32),
    /// The cycle once more.
    Repeat,
    /// Derivatives.
    Tangent(u32),
    Done,
}

impl<T: Real> LocatedCircle<T> {
    /// Finds the openings and closings of a group; the displacement coefficients in `work` are lost.
    #[inline(always)]
    pub(super) fn mark<S: Simd>(&mut self, simd: S, plan: &AftPlan<T>, work: &mut Workspace<T>) {
        self.intervals.mark(simd, plan, work);
        let n = plan.n_time();
        self.maps.resize(n, [[T::ZERO; LANES]; 4]);
        let p = &work.parameters;
        let length = T::from_f64(TAU / n as f64);
        for (i, map) in self.maps.iter_mut().enumerate() {
            let next = if i + 1 == n { 0 } else { i + 1 };
            let (a, b) = (&work.samples[i], &work.samples[next]);
            let rates = &self.intervals.rates[next];
            for l in 0..LANES {
                let limit = p.mu[l] * (a.normal(l) + b.normal(l));
                let path = |d: usize| p.k_t[d][l] * b.u[d][l] - p.k_t[d][l] * a.u[d][l];
                let rate = |d: usize| p.k_t[d][l] * rates[d * LANES + l];
                let step = SlipStep {
                    path: [path(0), path(1)],
                    rate: [rate(0), rate(1)],
                    limit: T::from_f64(0.5) * limit,
                    length,
                };
                for (k, entry) in step.map().into_iter().enumerate() {
                    map[k][l] = entry;
                }
            }
        }
        self.forces.clear();
        self.forces.resize(LANES * 3 * plan.m, T::ZERO);
    }

    /// Summary, and tangent if wanted, of one state after `mark`; its tractions go to [`Self::put_tractions`].
    #[inline(always)]
    pub(super) fn evaluate<S: Simd>(
        &mut self,
        simd: S,
        at: Place<T>,
        want: Want,
        out: &mut AftForces<T>,
    ) {
        let (plan, m) = (at.plan, at.plan.m);
        let p = at.batch.parameters[at.state];
        let coefficient =
            |c: usize, j: usize| at.batch.displacement[(c * m + j) * at.batch.n_states + at.state];
        let lane = &mut self.lane;
        lane.signals.set(plan, coefficient, &p);
        let (signals, points) = (&mut lane.signals, &mut lane.points);
        self.intervals
            .breakpoints(plan, at.work, at.lane, signals, points);
        let group = (at.work, self.intervals.rates.as_slice());
        self.nodes.clear();
        self.nodes
            .extend((0..=plan.n_time()).map(|i| Node::sampled(group, &p, at.lane, i)));
        let course = Course {
            plan,
            work: at.work,
            nodes: &self.nodes,
            maps: &self.maps,
            lane: at.lane,
            p: &p,
            signals,
            points,
        };
        let tangents = want == Want::ForcesAndTangents;
        let offset = out.blocks.len();
        if tangents {
            out.blocks.resize(offset + Block::COUNT * m * m, T::ZERO);
        }
        let mut cycle = Cycle::new(&p);
        while !matches!(cycle.stage, Stage::Done) {
            if cycle.starts_rows() {
                let full = cycle.carries_rows();
                self.lap.rows.start(plan, full);
                if full {
                    self.blocks.start(plan);
                }
            }
            let walk = Walk {
                simd,
                course,
                lap: &mut self.lap,
                target: cycle.is_last().then_some(&mut self.blocks),
            };
            let end = walk.go(cycle.next);
            cycle.advance(course, &mut self.lap, end, tangents);
        }
        if tangents && !cycle.stuck {
            if !cycle.from_anchor {
                close_cycle(plan, &mut self.lap.rows, &mut self.blocks);
            }
            self.blocks
                .store(Base { plan, p: &p }, &mut out.blocks[offset..]);
        }
        let forces = &mut self.forces[at.lane * 3 * m..][..3 * m];
        forces.fill(T::ZERO);
        self.lap.add_kinks(plan, &mut forces[..2 * m]);
        out.summaries.push(cycle.summary(at, self.lap.slip));
        if tangents && cycle.stuck {
            out.blocks.truncate(offset);
        }
        if tangents {
            out.tangents.push(if cycle.stuck {
                Tangent::Stuck
            } else {
                Tangent::Blocks(offset)
            });
        }
        let blocks = (tangents && !cycle.stuck)
            .then(|| &mut out.blocks[offset + Block::NN as usize * m * m..]);
        self.lane.normal(plan, &p, blocks);
        forces[2 * m..].copy_from_slice(&self.lane.force);
    }

    /// Tractions of the state that was evaluated last.
    #[inline(always)]
    pub(super) fn put_tractions(&self, work: &mut Workspace<T>, lane: usize) {
        for (sample, t) in work.samples.iter_mut().zip(&self.lap.tractions) {
            (sample.traction[0][lane], sample.traction[1][lane]) = (t[0], t[1]);
        }
    }

    /// Completes the forces from the sums over the samples: the kinks of the tractions, and the exact normal force.
    #[inline(always)]
    pub(super) fn complete(&self, lane: usize, state: usize, out: &mut AftForces<T>) {
        let (n, m) = (out.n_states, out.n_coefficients);
        let column = out.forces[state..].iter_mut().step_by(n);
        let forces = &self.forces[lane * 3 * m..][..3 * m];
        for (j, (target, &force)) in column.zip(forces).enumerate() {
            *target = if j < 2 * m { *target + force } else { force };
        }
    }
}

/// Adds what the periodic slider contributes to the blocks: its start derivative is (I − M)⁻¹ times its end derivative
/// for a fixed start.
fn close_cycle<T: Real>(plan: &AftPlan<T>, rows: &mut Rows<T>, blocks: &mut Blocks<T>) {
    let m = rows.monodromy();
    let [first, second] = &mut rows.slider;
    let pairs = first
        .as_flattened_mut()
        .iter_mut()
        .zip(second.as_flattened_mut());
    for (a, b) in pairs {
        [*a, *b] = solve_identity_minus(m, [*a, *b]);
    }
    blocks.add_starts(plan, &rows.slider);
}

impl<T: Real> Cycle<T> {
    fn new(p: &ContactParameters<T>) -> Self {
        let start = anchor(p);
        Self {
            stage: Stage::First,
            next: start,
            start,
            laps: 1,
            periodicity: Periodicity::DependsOnAnchor,
            from_anchor: true,
            stuck: false,
            near: false,
        }
    }

    /// Whether the rows of the next lap start anew.
    fn starts_rows(&self) -> bool {
        !matches!(self.stage, Stage::Tangent(number) if number > 1)
    }

    /// Whether the next lap carries the derivatives by the displacement coefficients.
    fn carries_rows(&self) -> bool {
        self.near || matches!(self.stage, Stage::Tangent(_))
    }

    /// Whether the next lap fills the tangent.
    fn is_last(&self) -> bool {
        let laps = if self.from_anchor { self.laps } else { 1 };
        self.near || matches!(self.stage, Stage::Tangent(number) if number == laps)
    }

    /// Takes the end of a lap and decides on the next one.
    #[inline(never)]
    fn advance(&mut self, course: Course<T>, lap: &mut Lap<T>, end: [T; 2], tangents: bool) {
        let change = [end[0] - self.next[0], end[1] - self.next[1]];
        let m = lap.rows.monodromy();
        let tolerance = course.work.tolerance[course.lane];
        let periodic = size(change) <= tolerance;
        match self.stage {
            Stage::First => {
                self.stuck = !lap.moved;
                self.stage = match course.plan.settings.laps {
                    _ if self.stuck => Stage::Done,
                    Laps::Fixed(1) => self.fixed(course.p, 1, periodic, m, tangents),
                    Laps::Fixed(_) => Stage::Fixed(2),
                    Laps::Periodic => Stage::Newton(Search::default()),
                };
                if !matches!(self.stage, Stage::Tangent(_)) {
                    self.next = end;
                }
            }
            Stage::Fixed(number) => match course.plan.settings.laps {
                Laps::Fixed(n) if number as usize >= n => {
                    self.stage = self.fixed(course.p, number, periodic, m, tangents);
                }
                _ => (self.stage, self.next) = (Stage::Fixed(number + 1), end),
            },
            Stage::Newton(search) => self.newton(search, course, lap, change, tangents),
            Stage::Plain(number) if number > 1 && periodic => {
                (self.start, self.laps, self.from_anchor) = (self.next, number, true);
                self.periodicity = Periodicity::DependsOnAnchor;
                self.stage = self.finish(course.p, tangents);
            }
            Stage::Plain(number) if number < MAX_LAPS => {
                (self.stage, self.next) = (Stage::Plain(number + 1), end);
            }
            Stage::Plain(_) => (self.stage, self.next) = (Stage::Held(1), end),
            Stage::Held(number) => {
                let lost = is_singular(m) || number > NEWTON_LAPS;
                let step = solve_identity_minus(m, change);
                if !lost && size(step) <= tolerance {
                    (self.start, self.from_anchor) = (self.next, false);
                    self.periodicity = Periodicity::DependsOnAnchor;
                    self.stage = self.finish(course.p, tangents);
                } else if lost {
                    (self.stage, self.next) = (Stage::Repeat, self.start);
                } else {
                    self.next = [self.next[0] + step[0], self.next[1] + step[1]];
                    self.stage = Stage::Held(number + 1);
                }
            }
            Stage::Repeat => self.stage = self.finish(course.p, tangents),
            Stage::Tangent(_) if self.is_last() => self.stage = Stage::Done,
            Stage::Tangent(number) => {
                (self.stage, self.next) = (Stage::Tangent(number + 1), end);
            }
            Stage::Done => {}
        }
    }

    /// After the last lap of a given number of laps.
    fn fixed(
        &mut self,
        p: &ContactParameters<T>,
        laps: u32,
        periodic: bool,
        m: [T; 4],
        tangents: bool,
    ) -> Stage<T> {
        (self.start, self.laps) = (self.next, laps);
        self.periodicity = classify(periodic, m);
        self.finish(p, tangents)
    }

    /// The stage after the cycle was found.
    fn finish(&mut self, p: &ContactParameters<T>, tangents: bool) -> Stage<T> {
        self.next = if self.from_anchor {
            anchor(p)
        } else {
            self.start
        };
        if tangents {
            Stage::Tangent(1)
        } else {
            Stage::Done
        }
    }

    /// A lap of Newton's method, which changed the slider by `change`.
    fn newton(
        &mut self,
        mut search: Search<T>,
        course: Course<T>,
        lap: &Lap<T>,
        change: [T; 2],
        tangents: bool,
    ) {
        let m = lap.rows.monodromy();
        let tolerance = course.work.tolerance[course.lane];
        self.laps += 1;
        if !search.settled(change, m, tolerance) && self.laps < MAX_LAPS {
            let step = search.step(change, m, self.laps);
            self.next = [self.next[0] + step[0], self.next[1] + step[1]];
            self.stage = Stage::Newton(search);
            self.near = tangents && size(step) * T::EPSILON.sqrt() <= tolerance;
            return;
        }
        self.start = self.next;
        self.periodicity = classify(size(change) <= tolerance, m);
        self.from_anchor = is_singular(m);
        let near = std::mem::take(&mut self.near);
        let rests = lap.way * T::EPSILON.sqrt() <= tolerance;
        if search.newton && rests {
            (self.stage, self.next) = (Stage::Plain(1), anchor(course.p));
        } else if near && !self.from_anchor {
            self.stage = Stage::Done;
        } else {
            self.stage = self.finish(course.p, tangents);
        }
    }

    #[inline(always)]
    fn summary(&self, at: Place<T>, slip: u32) -> StateSummary {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number between 0 and Nt"
        )]
        let separated = at.work.separated[at.lane].to_f64() as u32;
        let total = u32::try_from(at.plan.n_time()).unwrap_or(u32::MAX);
        StateSummary {
            stick: total - slip - separated,
            slip,
            separated,
            laps: self.laps,
            periodicity: self.periodicity,
        }
    }
}

/// The anchored slider k_t w (N).
fn anchor<T: Real>(p: &ContactParameters<T>) -> [T; 2] {
    [p.k_t[0] * p.anchor[0], p.k_t[1] * p.anchor[1]]
}
