//! Circle law with located events: forces, tangents and summaries of a group of states.
//!
//! [`super::steady_cycle`] searches the periodic motion of the slider (the steady cycle). If derivatives are wanted, one more
//! lap along this cycle computes them; so the forces have the same bits with and without derivatives. The normal force is a
//! trigonometric polynomial between opening and closing and is integrated in closed form, as under the box law.

use super::between::Between;
use super::cells::Cells;
use super::course::Course;
use super::lap::{Lap, LapMarch};
use super::node::Node;
use super::sensitivity::{Base, Basis, Blocks, Rows, SignalWeights, add_signals};
use super::slip::SlipStep;
use super::steady_cycle::{
    Hold, LapEnd, Next, Origin, Search, classify, is_singular, solve_identity_minus,
};
use crate::aft::batch::Want;
use crate::aft::box_law::play::{LaneScratch, LaneState};
use crate::aft::forces::{AftForces, Periodicity, StateCounts, StateSummary, TangentBlock};
use crate::aft::lanes::lane::{LANES, Lane};
use crate::aft::lanes::workspace::Workspace;
use crate::aft::plan::{AftPlan, CHUNK};
use crate::aft::settings::Laps;
use crate::aft::signals::breakpoints::Intervals;
use crate::contact::{ContactParameters, Real};
use pulp::Simd;
use std::f64::consts::TAU;

/// Scratch of the evaluation.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct LocatedCircle<T> {
    intervals: Intervals<T>,
    /// Matrix of the slip from each time point to the next one ([`super::slip`]), row-major. Shape: `[time]`.
    maps: Vec<[Lane<T>; 4]>,
    lane: LaneScratch<T>,
    /// Signals of the present state at the time points. Shape: `[time + 1]`.
    nodes: Vec<Node<T>>,
    cells: Cells<T>,
    between: Between<T>,
    lap: Lap<T>,
    blocks: Blocks<T>,
    /// Corrections of the traction coefficients for kinks, and the coefficients of the normal force (N). Shape: `[lane][3][m]`.
    forces: Vec<T>,
}

/// Search for the steady cycle of one state, lap by lap.
#[derive(Debug, Clone, Copy)]
struct Cycle<T> {
    want: Want,
    stage: LapPurpose<T>,
    /// Slider k_t w (N) at the start of the next lap.
    next: [T; 2],
    laps: u32,
    periodicity: Periodicity,
    origin: Origin<T, T>,
    stuck: bool,
    /// Whether the last Newton step was so small that the next lap is expected to be the last one, which computes derivatives.
    near: bool,
}

/// Purpose of a lap.
#[derive(Debug, Clone, Copy)]
enum LapPurpose<T> {
    First,
    /// A lap of a given number of laps; its number.
    Fixed(u32),
    Search(Search<T, T>),
    /// A lap that computes derivatives; its number.
    Tangent(u32),
    Done,
}

impl<T: Real> LocatedCircle<T> {
    /// Finds where the contacts of a group of states open and close. Overwrites the displacement coefficients in `work`.
    #[inline(always)]
    pub(in crate::aft) fn mark<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        work: &mut Workspace<T>,
    ) {
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

    /// Summary and, if wanted, derivatives of one state; to be called after `mark`. [`Self::put_tractions`] gives its tractions.
    #[inline(always)]
    pub(in crate::aft) fn evaluate<S: Simd>(
        &mut self,
        simd: S,
        at: LaneState<T>,
        want: Want,
        out: &mut AftForces<T>,
    ) {
        let (plan, m) = (at.plan, at.plan.m);
        let p = at.work.parameters.of(at.lane);
        let coefficient =
            |c: usize, j: usize| at.batch.displacement[(c * m + j) * at.batch.n_states + at.state];
        let lane = &mut self.lane;
        lane.signals.set(plan, coefficient, &p);
        let (signals, points) = (&mut lane.signals, &mut lane.points);
        self.intervals
            .breakpoints(plan, at.work, at.lane, signals, points);
        let rates = &self.intervals.rates;
        self.nodes.clear();
        self.nodes
            .extend((0..=plan.n_time()).map(|i| Node::sampled(at.work, rates, &p, at.lane, i)));
        let course = Course {
            plan,
            work: at.work,
            nodes: &self.nodes,
            between: None,
            maps: &self.maps,
            lane: at.lane,
            p: &p,
            signals,
            points,
        };
        let course = course.with(self.cells.find(course, &mut self.between));
        let tangents = want == Want::ForcesAndTangents;
        let offset = out.blocks.len();
        if tangents {
            out.blocks
                .resize(offset + TangentBlock::COUNT * m * m, T::ZERO);
        }
        let (lap, blocks) = (&mut self.lap, &mut self.blocks);
        let cycle = Cycle::found(simd, course, lap, blocks, want);
        if tangents && !cycle.stuck {
            if cycle.origin == Origin::Itself {
                close_cycle(plan, &mut self.lap.rows, &mut self.blocks);
            }
            self.blocks
                .store(Base { plan, p: &p }, &mut out.blocks[offset..]);
        }
        let forces = &mut self.forces[at.lane * 3 * m..][..3 * m];
        forces.fill(T::ZERO);
        self.lap.complete(course, &mut forces[..2 * m]);
        out.summaries.push(cycle.summary(at, self.lap.slip));
        if tangents {
            out.add_tangent(offset, cycle.stuck);
        }
        let blocks = (tangents && !cycle.stuck)
            .then(|| &mut out.blocks[offset + TangentBlock::NN as usize * m * m..]);
        self.lane.normal(plan, &p, blocks);
        forces[2 * m..].copy_from_slice(&self.lane.force);
    }

    /// Tractions of the state that was evaluated last.
    #[inline(always)]
    pub(in crate::aft) fn put_tractions(&self, work: &mut Workspace<T>, lane: usize) {
        for (sample, t) in work.samples.iter_mut().zip(&self.lap.tractions) {
            (sample.traction[0][lane], sample.traction[1][lane]) = (t[0], t[1]);
        }
    }

    /// Adds to the sums over the time points the corrections for the kinks of the tractions, and sets the normal force.
    #[inline(always)]
    pub(in crate::aft) fn complete(&self, lane: usize, state: usize, out: &mut AftForces<T>) {
        let (n, m) = (out.n_states, out.n_coefficients);
        let column = out.forces[state..].iter_mut().step_by(n);
        let forces = &self.forces[lane * 3 * m..][..3 * m];
        for (j, (target, &force)) in column.zip(forces).enumerate() {
            *target = if j < 2 * m { *target + force } else { force };
        }
    }
}

/// Derivatives of a slider at rest that two instants of the period hold: at both the excess |s − z| − L is 0, and so is its
/// slope in time.
fn hold_slider<T: Real>(course: Course<T>, hold: &Hold<T, T>, rows: &mut Rows<T>) {
    let base = Base {
        plan: course.plan,
        p: course.p,
    };
    for slider in &mut rows.slider {
        slider.fill([T::ZERO; CHUNK]);
    }
    let mut row = Vec::new();
    for (k, (&theta, e)) in hold.instants.iter().zip(hold.directions).enumerate() {
        let excess = [0, 1].map(|j| if j == k { T::ONE } else { T::ZERO });
        let moved = hold.moved(excess).unwrap_or_default();
        course.event_node(theta, &mut row);
        for (slider, moved) in rows.slider.iter_mut().zip(moved) {
            let weights = SignalWeights {
                path: e.map(|e| moved * e),
                limit: -moved,
                ..SignalWeights::NONE
            };
            add_signals(base, slider, Basis::Event(&row), weights);
        }
    }
}

/// Adds to the derivatives what the start of the periodic slider contributes. With M = ∂z(T)/∂z(0) the derivative of the start
/// is (I − M)⁻¹ times the derivative of the end for a fixed start.
fn close_cycle<T: Real>(plan: &AftPlan<T>, rows: &mut Rows<T>, blocks: &mut Blocks<T>) {
    let m = rows.monodromy();
    if is_singular(m) {
        // no steady cycle was found
        return;
    }
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
    /// Makes laps until the cycle is found, and the laps that compute derivatives if they are wanted.
    #[inline(always)]
    fn found<S: Simd>(
        simd: S,
        course: Course<T>,
        lap: &mut Lap<T>,
        blocks: &mut Blocks<T>,
        want: Want,
    ) -> Self {
        let mut cycle = Self::new(course.p, want);
        while !matches!(cycle.stage, LapPurpose::Done) {
            if cycle.starts_rows() {
                let full = cycle.carries_rows();
                lap.rows.start(course.plan, full);
                if full {
                    blocks.start(course.plan);
                    if let (Origin::Held(hold), false) = (cycle.origin, cycle.near) {
                        hold_slider(course, &hold, &mut lap.rows);
                    }
                }
            }
            let march = LapMarch {
                simd,
                course,
                lap: &mut *lap,
                target: cycle.is_last().then_some(&mut *blocks),
            };
            let end = march.go(cycle.next);
            cycle.advance(course, lap, end);
        }
        cycle
    }

    fn new(p: &ContactParameters<T>, want: Want) -> Self {
        Self {
            want,
            stage: LapPurpose::First,
            next: anchor(p),
            laps: 1,
            periodicity: Periodicity::DependsOnAnchor,
            origin: Origin::Anchor,
            stuck: false,
            near: false,
        }
    }

    /// Whether the derivatives start at zero in the next lap.
    fn starts_rows(&self) -> bool {
        !matches!(self.stage, LapPurpose::Tangent(number) if number > 1)
    }

    /// Whether the next lap computes derivatives by the displacement coefficients.
    fn carries_rows(&self) -> bool {
        self.near || matches!(self.stage, LapPurpose::Tangent(_))
    }

    /// Whether the next lap writes the derivatives of the forces.
    fn is_last(&self) -> bool {
        let laps = match self.origin {
            Origin::Anchor => self.laps,
            Origin::Itself | Origin::Held(_) => 1,
        };
        self.near || matches!(self.stage, LapPurpose::Tangent(number) if number == laps)
    }

    /// Decides, from the slider at the end of a lap, on the next lap.
    #[inline(never)]
    fn advance(&mut self, course: Course<T>, lap: &Lap<T>, end: [T; 2]) {
        let took = LapEnd {
            start: self.next,
            end,
            monodromy: lap.rows.monodromy(),
            longest_slip: lap.longest_slip,
            tolerance: course.work.tolerance[course.lane],
        };
        match self.stage {
            LapPurpose::First => {
                self.stuck = !lap.moved;
                self.next = end;
                self.stage = match course.plan.settings.laps {
                    _ if self.stuck => LapPurpose::Done,
                    Laps::Fixed(1) => self.fixed(course.p, took, 1),
                    Laps::Fixed(_) => LapPurpose::Fixed(2),
                    Laps::Periodic => LapPurpose::Search(Search::new(end)),
                };
            }
            LapPurpose::Fixed(number) => match course.plan.settings.laps {
                Laps::Fixed(n) if number as usize >= n => {
                    self.stage = self.fixed(course.p, took, number);
                }
                _ => (self.stage, self.next) = (LapPurpose::Fixed(number + 1), end),
            },
            LapPurpose::Search(search) => self.search(search, course, took),
            LapPurpose::Tangent(_) if self.is_last() => self.stage = LapPurpose::Done,
            LapPurpose::Tangent(number) => {
                (self.stage, self.next) = (LapPurpose::Tangent(number + 1), end);
            }
            LapPurpose::Done => {}
        }
    }

    /// After the last lap of a given number of laps.
    fn fixed(&mut self, p: &ContactParameters<T>, took: LapEnd<T>, laps: u32) -> LapPurpose<T> {
        self.laps = laps;
        self.periodicity = classify(took.is_periodic(), took.monodromy);
        self.finish(p, took.start)
    }

    /// What follows once the cycle from `start` is found.
    fn finish(&mut self, p: &ContactParameters<T>, start: [T; 2]) -> LapPurpose<T> {
        if self.want == Want::Forces {
            return LapPurpose::Done;
        }
        self.next = match self.origin {
            Origin::Anchor => anchor(p),
            Origin::Itself | Origin::Held(_) => start,
        };
        LapPurpose::Tangent(1)
    }

    /// A lap of the search.
    fn search(&mut self, mut search: Search<T, T>, course: Course<T>, took: LapEnd<T>) {
        let filled = std::mem::take(&mut self.near);
        let next = search.take(took, |slider| course.held(slider));
        self.laps = search.laps;
        self.stage = LapPurpose::Search(search);
        match next {
            Next::Plain => self.next = took.end,
            Next::From(slider) => {
                self.next = slider;
                let small = |step: T| step * T::EPSILON.sqrt() <= took.tolerance;
                self.near = self.want == Want::ForcesAndTangents && search.step.is_some_and(small);
            }
            Next::Nothing => {
                (self.origin, self.periodicity) = (search.origin, search.periodicity);
                let done = filled && self.origin == Origin::Itself;
                self.stage = if done {
                    LapPurpose::Done
                } else {
                    self.finish(course.p, took.start)
                };
            }
        }
    }

    #[inline(always)]
    fn summary(&self, at: LaneState<T>, slip: u32) -> StateSummary {
        let separated = at.work.separated[at.lane].to_f64() as u32;
        StateSummary {
            counts: StateCounts::new(at.plan.n_time(), slip, separated),
            laps: self.laps,
            periodicity: self.periodicity,
        }
    }
}

/// The anchored slider k_t w (N).
fn anchor<T: Real>(p: &ContactParameters<T>) -> [T; 2] {
    [p.k_t[0] * p.anchor[0], p.k_t[1] * p.anchor[1]]
}
