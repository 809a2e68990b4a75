//! Box law with located events: exact force and derivative of trigonometric signals.
//!
//! Between its events the traction is k_t u − z in stick and ± mu g in slip, a trigonometric polynomial, so the Fourier
//! integrals over the stretches between the events have a closed form: the spectra of the stretches, in place of the
//! sums over samples of [`super::tangent`]. The force is continuous, so that moving events add nothing to the
//! derivative, but for the slider of a stick: it stands where a bound turned (which costs nothing to first order) or
//! where the contact closed, w = u(θ_c) with dθ_c = −dg/g'. Transition rules: Petrov and Ewins (J. Turbomach. 125,
//! 2003).

use crate::aft::batch::{AftBatch, Want};
use crate::aft::forces::{AftForces, Block, Periodicity, StateSummary, Tangent};
use crate::aft::lanes::masks::{
    add_masked_gram, add_masked_product, add_scaled, clear, subtract_product, sums_of_run,
};
use crate::aft::lanes::motions::Motion;
use crate::aft::lanes::workspace::Workspace;
use crate::aft::plan::AftPlan;
use crate::aft::settings::Laps;
use crate::aft::signals::breakpoints::{
    Breakpoint, Intervals, Signals, basis_row, first_sample_from, rate,
};
use crate::aft::vector::size;
use crate::contact::law::normal_force;
use crate::contact::{ContactParameters, Real};
use pulp::Simd;
use std::f64::consts::TAU;

/// Scratch of the located evaluation.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Located<T> {
    intervals: Intervals<T>,
    lane: LaneScratch<T>,
}

/// Scratch of one state.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct LaneScratch<T> {
    pub signals: Signals<T>,
    pub points: Vec<Breakpoint<T>>,
    /// Stretches of one direction in the last lap.
    runs: Vec<Run<T>>,
    /// Phase from which a direction slips, per interval between breakpoints.
    slip_from: Vec<T>,
    /// Antiderivatives at the ends of a stretch, its spectrum and the spectra of masks. Shape: `[2][2H + 1]` each.
    start: Vec<T>,
    end: Vec<T>,
    run: Vec<T>,
    stick: Vec<T>,
    slip: Vec<T>,
    /// Fourier integrals of a stretch, basis row of an event, force coefficients. Shape: `[m]`.
    sums: Vec<T>,
    row: Vec<T>,
    pub force: Vec<T>,
}

/// Where and how the slider was set last.
#[derive(Debug, Clone, Copy)]
struct Source {
    point: usize,
    motion: Motion,
}

/// Stretch of one motion; it starts where the one before ends.
#[derive(Debug, Clone, Copy)]
struct Run<T> {
    end: T,
    motion: Motion,
    /// k_t times the slider position (N), of a stick.
    slider: T,
    source: Option<Source>,
}

/// How the play of one direction went.
#[derive(Debug, Clone, Copy)]
struct Play<T> {
    /// Whether nothing ever moved the slider.
    stuck: bool,
    /// Change of k_t w over the last lap (N).
    change: T,
    /// Whether the last lap forgets the slider's start.
    forgets: bool,
}

/// One state of a group.
#[derive(Clone, Copy)]
pub(in crate::aft) struct Place<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub batch: &'a AftBatch<T>,
    pub work: &'a Workspace<T>,
    pub lane: usize,
    pub state: usize,
}

impl<'a, T> Place<'a, T> {
    /// The state of a lane of the group that starts at `first`.
    pub(in crate::aft) fn new(
        plan: &'a AftPlan<T>,
        batch: &'a AftBatch<T>,
        work: &'a Workspace<T>,
        (first, lane): (usize, usize),
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

impl<T: Real> Located<T> {
    /// Finds the intervals of a group that hold events; the displacement coefficients in `work` are lost.
    #[inline(always)]
    pub(in crate::aft) fn mark<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        work: &mut Workspace<T>,
    ) {
        self.intervals.mark(simd, plan, work);
    }

    /// Forces, summary, and tangent if wanted, of one state after `mark`.
    #[inline(always)]
    pub(in crate::aft) fn evaluate(&mut self, at: Place<T>, want: Want, out: &mut AftForces<T>) {
        let (plan, m) = (at.plan, at.plan.m);
        let p = at.batch.parameters[at.state];
        let scratch = &mut self.lane;
        let q =
            |c: usize, j: usize| at.batch.displacement[(c * m + j) * at.batch.n_states + at.state];
        scratch.signals.set(plan, q, &p);
        let (signals, points) = (&mut scratch.signals, &mut scratch.points);
        self.intervals
            .breakpoints(plan, at.work, at.lane, signals, points);
        scratch.slip_from.clear();
        scratch.slip_from.resize(points.len(), phase(2.0 * TAU));
        let offset = out.blocks.len();
        let size = m * m;
        let tangents = want == Want::ForcesAndTangents;
        if tangents {
            out.blocks.resize(offset + Block::COUNT * size, T::ZERO);
        }
        let mut plays = [Play {
            stuck: true,
            change: T::ZERO,
            forgets: true,
        }; 2];
        for (d, play) in plays.iter_mut().enumerate() {
            clear(&mut scratch.force, m);
            if p.k_t[d] > T::ZERO {
                *play = scratch.play(at, &self.intervals, &p, d);
                let blocks = tangents.then(|| &mut out.blocks[offset..]);
                scratch.traction(plan, &p, d, blocks);
            }
            scratch.store(at, d, &mut out.forces);
        }
        let nn = tangents.then(|| &mut out.blocks[offset + Block::NN as usize * size..]);
        scratch.normal(plan, &p, nn);
        scratch.store(at, 2, &mut out.forces);
        let summary = scratch.summary(at, plays);
        let stuck = plays[0].stuck && plays[1].stuck && summary.separated == 0;
        if tangents && stuck {
            out.blocks.truncate(offset);
        }
        if tangents {
            out.tangents.push(if stuck {
                Tangent::Stuck
            } else {
                Tangent::Blocks(offset)
            });
        }
        out.summaries.push(summary);
    }
}

impl<T: Real> LaneScratch<T> {
    /// Plays the slider of direction `d` from its anchor; `runs` are then the stretches of the last lap.
    #[inline(always)]
    fn play(
        &mut self,
        at: Place<T>,
        intervals: &Intervals<T>,
        p: &ContactParameters<T>,
        d: usize,
    ) -> Play<T> {
        let laps = match at.plan.settings.laps {
            Laps::Fixed(n) => n,
            Laps::Periodic => 2,
        };
        let n = self.points.len();
        let bounds = |point: &Breakpoint<T>| {
            let (stick, limit) = (p.k_t[d] * point.u[d], p.mu * normal_force(point.gap));
            [stick - limit, stick + limit]
        };
        let first = &self.points[0];
        let (mut slider, mut motion) = pushed(p.k_t[d] * p.anchor[d], bounds(first), first.open);
        let mut source = None;
        let mut stuck = true;
        let mut point = 0;
        let mut start = slider;
        let mut reached = [false; 2];
        for lap in 1..=laps {
            start = slider;
            reached = [false; 2];
            self.runs.clear();
            for k in 0..n {
                if motion != Motion::Stick {
                    (source, stuck) = (Some(Source { point, motion }), false);
                }
                let next = if k + 1 == n { 0 } else { k + 1 };
                let (a, b) = (self.points[k], self.points[next]);
                let (ends, levels) = (self.ends(k), [bounds(&a), bounds(&b)]);
                let before = slider;
                (slider, motion) = pushed(before, levels[1], a.open);
                point = next;
                let stick = Run {
                    end: ends[1],
                    motion: Motion::Stick,
                    slider: before,
                    source,
                };
                let side = match motion {
                    Motion::SlipUp => 0,
                    Motion::SlipDown => 1,
                    Motion::Stick => {
                        self.append(stick);
                        continue;
                    }
                    Motion::Separated => {
                        reached = [true; 2];
                        self.append(Run { motion, ..stick });
                        continue;
                    }
                };
                reached[side] = true;
                if lap == laps {
                    let mut from = ends[0];
                    if levels[0][side] != before {
                        let bracket = [(ends[0], levels[0][side]), (ends[1], levels[1][side])];
                        from = self
                            .signals
                            .reaches(at.plan, (d, side), before, bracket, |i| {
                                intervals.bound_at(at.work, (i, at.lane), (d, side))
                            });
                        self.append(Run { end: from, ..stick });
                    }
                    if from < self.slip_from[k] {
                        self.slip_from[k] = from;
                    }
                    self.append(Run { motion, ..stick });
                }
            }
            if stuck && motion == Motion::Stick {
                break;
            }
        }
        Play {
            stuck: stuck && motion == Motion::Stick,
            change: slider - start,
            forgets: reached[0] && reached[1],
        }
    }

    /// Phases at the ends of the interval after breakpoint k.
    #[inline(always)]
    fn ends(&self, k: usize) -> [T; 2] {
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

    /// Traction coefficients of direction `d` from its runs into `force`, and its blocks if wanted.
    #[inline(always)]
    fn traction(
        &mut self,
        plan: &AftPlan<T>,
        p: &ContactParameters<T>,
        d: usize,
        mut blocks: Option<&mut [T]>,
    ) {
        let width = 2 * plan.n_mask_orders();
        let size = plan.m * plan.m;
        let (tt, tn) = if d == 0 {
            (Block::T1T1, Block::T1N)
        } else {
            (Block::T2T2, Block::T2N)
        };
        clear(&mut self.stick, width);
        clear(&mut self.slip, width);
        antiderivative(plan, T::ZERO, &mut self.start);
        for i in 0..self.runs.len() {
            let run = self.runs[i];
            antiderivative(plan, run.end, &mut self.end);
            self.run.clear();
            self.run
                .extend(self.end.iter().zip(&self.start).map(|(&b, &a)| b - a));
            std::mem::swap(&mut self.start, &mut self.end);
            match run.motion {
                Motion::Separated => {}
                Motion::SlipUp => add_scaled(&mut self.slip, T::ONE, &self.run),
                Motion::SlipDown => add_scaled(&mut self.slip, -T::ONE, &self.run),
                Motion::Stick => {
                    add_scaled(&mut self.stick, T::ONE, &self.run);
                    sums_of_run(plan, &self.run, &mut self.sums);
                    add_scaled(&mut self.force, -run.slider, &self.sums);
                    if let (Some(blocks), Some(source)) = (&mut blocks, run.source) {
                        let [stick, friction] = self.source_factors(plan, p, d, source);
                        subtract_product(
                            &mut blocks[tt as usize * size..][..size],
                            stick,
                            &self.sums,
                            &self.row,
                        );
                        subtract_product(
                            &mut blocks[tn as usize * size..][..size],
                            friction,
                            &self.sums,
                            &self.row,
                        );
                    }
                }
            }
        }
        let signals = &self.signals;
        add_masked_product(plan, &self.stick, p.k_t[d], &signals.u[d], &mut self.force);
        add_masked_product(plan, &self.slip, p.mu, &signals.gap, &mut self.force);
        if let Some(blocks) = blocks {
            let tt = &mut blocks[tt as usize * size..][..size];
            add_masked_gram(plan, &self.stick, p.k_t[d], tt);
            let tn = &mut blocks[tn as usize * size..][..size];
            add_masked_gram(plan, &self.slip, p.mu * p.k_n, tn);
        }
    }

    /// Derivative of k_t w by u and by v: factors of the basis row of the event, which is left in `row`.
    #[inline(always)]
    fn source_factors(
        &mut self,
        plan: &AftPlan<T>,
        p: &ContactParameters<T>,
        d: usize,
        source: Source,
    ) -> [T; 2] {
        self.row.resize(plan.m, T::ONE);
        basis_row(plan, self.points[source.point].theta, &mut self.row);
        let rate = |q: &[T]| rate(plan, &self.row, q);
        let friction = match source.motion {
            Motion::SlipUp => -(p.mu * p.k_n),
            Motion::SlipDown => p.mu * p.k_n,
            Motion::Stick => T::ZERO,
            Motion::Separated => {
                let closing = rate(&self.signals.gap);
                if closing > T::ZERO {
                    -(p.k_t[d] * p.k_n * rate(&self.signals.u[d]) / closing)
                } else {
                    T::ZERO
                }
            }
        };
        [p.k_t[d], friction]
    }

    /// Normal force coefficients into `force`, and their block if wanted.
    #[inline(always)]
    pub(in crate::aft) fn normal(
        &mut self,
        plan: &AftPlan<T>,
        p: &ContactParameters<T>,
        nn: Option<&mut [T]>,
    ) {
        clear(&mut self.force, plan.m);
        clear(&mut self.stick, 2 * plan.n_mask_orders());
        for k in 0..self.points.len() {
            let was_open = k == 0 || self.points[k - 1].open;
            if self.points[k].open != was_open {
                let factor = if was_open { -T::ONE } else { T::ONE };
                antiderivative(plan, self.points[k].theta, &mut self.end);
                add_scaled(&mut self.stick, factor, &self.end);
            }
        }
        if self.points.last().is_some_and(|last| !last.open) {
            antiderivative(plan, phase(TAU), &mut self.end);
            add_scaled(&mut self.stick, T::ONE, &self.end);
        }
        add_masked_product(
            plan,
            &self.stick,
            T::ONE,
            &self.signals.gap,
            &mut self.force,
        );
        if let Some(nn) = nn {
            add_masked_gram(plan, &self.stick, p.k_n, nn);
        }
    }

    #[inline(always)]
    fn store(&self, at: Place<T>, c: usize, forces: &mut [T]) {
        let column = forces[at.state..].iter_mut().step_by(at.batch.n_states);
        let column = column.skip(c * at.plan.m);
        for (target, &force) in column.zip(&self.force) {
            *target = force;
        }
    }

    /// Counts the samples in each motion.
    #[inline(always)]
    fn summary(&self, at: Place<T>, plays: [Play<T>; 2]) -> StateSummary {
        let n = at.plan.n_time();
        let before = |theta: T| first_sample_from(theta.to_f64(), n as f64);
        let (mut slip, mut separated) = (0, 0);
        for (k, &from) in self.slip_from.iter().enumerate() {
            let [start, end] = self.ends(k).map(before);
            if self.points[k].open {
                separated += end - start;
            } else {
                slip += end - before(from).clamp(start, end);
            }
        }
        let stuck = plays[0].stuck && plays[1].stuck;
        let laps = match at.plan.settings.laps {
            _ if stuck => 1,
            Laps::Fixed(n) => n,
            Laps::Periodic => 2,
        };
        let change = size(plays.map(|play| play.change));
        let periodicity = if change > at.work.tolerance[at.lane] {
            Periodicity::NotPeriodic
        } else if plays.iter().all(|play| play.forgets) {
            Periodicity::Unique
        } else {
            Periodicity::DependsOnAnchor
        };
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        StateSummary {
            stick: count(n - slip - separated),
            slip: count(slip),
            separated: count(separated),
            laps: count(laps),
            periodicity,
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

fn phase<T: Real>(theta: f64) -> T {
    T::from_f64(theta)
}

/// ∫₀^θ cos kt dt and sin kt dt (but for a constant) for k = 0..=2H, in samples. Shape: `[2][2H + 1]`.
#[inline(always)]
fn antiderivative<T: Real>(plan: &AftPlan<T>, theta: T, out: &mut Vec<T>) {
    let n = plan.n_mask_orders();
    clear(out, 2 * n);
    let (sines, cosines) = out.split_at_mut(n);
    let (sin, cos) = theta.sine_cosine();
    sines[0] = plan.per_order[0] * theta;
    let (mut c, mut s) = (T::ONE, T::ZERO);
    for k in 1..n {
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
        (sines[k], cosines[k]) = (plan.per_order[k] * s, -(plan.per_order[k] * c));
    }
}
