//! Box law with located events: exact force and derivative of trigonometric signals.
//!
//! Between two events the traction is a trigonometric polynomial: k_t u − z in stick, z = k_t w the slider, and ± mu g in slip,
//! g the normal force. So its Fourier integrals between the events have a closed form, which replaces the sums over time
//! points of [`super::tangent`].
//!
//! **Derivatives.** The traction is continuous. So the motion of an event in time adds nothing to the derivative, with one
//! exception: the slider of a stick depends on the event at which the stick began. If it began where a bound of the slider
//! turned, the derivative by the phase is zero there. If it began where the contact closed, w = u(θ_c), and the phase of
//! closing changes by dθ_c = −dg/g'(θ_c).
//!
//! Transition rules: Petrov and Ewins, J. Turbomach. 125, 2003.

use super::play::{LaneScratch, LaneState, Play, Source, phase};
use crate::aft::batch::Want;
use crate::aft::forces::{AftForces, Periodicity, StateCounts, StateSummary, TangentBlock};
use crate::aft::lanes::masks::{
    add_masked_gram, add_masked_product, add_scaled, clear, subtract_product, sums_of_run,
};
use crate::aft::lanes::motions::Motion;
use crate::aft::lanes::workspace::Workspace;
use crate::aft::plan::AftPlan;
use crate::aft::settings::Laps;
use crate::aft::signals::breakpoints::{Intervals, first_sample_from};
use crate::aft::signals::polynomial::{basis_row, rate};
use crate::aft::vector::size;
use crate::contact::{ContactParameters, Real};
use pulp::Simd;
use std::f64::consts::TAU;

/// Scratch of the located evaluation.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct LocatedBox<T> {
    intervals: Intervals<T>,
    lane: LaneScratch<T>,
}

impl<T: Real> LocatedBox<T> {
    /// Finds the intervals between time points that contain events, for a group of states. Overwrites the displacement
    /// coefficients in `work`.
    #[inline(always)]
    pub(in crate::aft) fn mark<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        work: &mut Workspace<T>,
    ) {
        self.intervals.mark(simd, plan, work);
    }

    /// Forces, summary and, if wanted, derivatives of one state; to be called after `mark`.
    #[inline(always)]
    pub(in crate::aft) fn evaluate(
        &mut self,
        at: LaneState<T>,
        want: Want,
        out: &mut AftForces<T>,
    ) {
        let (plan, m) = (at.plan, at.plan.m);
        let p = at.work.parameters.of(at.lane);
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
            out.blocks
                .resize(offset + TangentBlock::COUNT * size, T::ZERO);
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
        let nn = tangents.then(|| &mut out.blocks[offset + TangentBlock::NN as usize * size..]);
        scratch.normal(plan, &p, nn);
        scratch.store(at, 2, &mut out.forces);
        let summary = scratch.summary(at, plays);
        let stuck = plays[0].stuck && plays[1].stuck && summary.counts.separated == 0;
        if tangents {
            out.add_tangent(offset, stuck);
        }
        out.summaries.push(summary);
    }
}

impl<T: Real> LaneScratch<T> {
    /// Writes the coefficients of the traction in direction `d` to `force`, and its derivatives if wanted.
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
            (TangentBlock::T1T1, TangentBlock::T1N)
        } else {
            (TangentBlock::T2T2, TangentBlock::T2N)
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

    /// Derivatives of k_t w by u and by v: two factors of the trigonometric functions at the event, which are written to `row`.
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

    /// Writes the coefficients of the normal force to `force`, and their derivatives if wanted.
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
    fn store(&self, at: LaneState<T>, c: usize, forces: &mut [T]) {
        let column = forces[at.state..].iter_mut().step_by(at.batch.n_states);
        let column = column.skip(c * at.plan.m);
        for (target, &force) in column.zip(&self.force) {
            *target = force;
        }
    }

    /// Counts the time points in each motion.
    #[inline(always)]
    fn summary(&self, at: LaneState<T>, plays: [Play<T>; 2]) -> StateSummary {
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
            counts: StateCounts::new(n, count(slip), count(separated)),
            laps: count(laps),
            periodicity,
        }
    }
}

/// ∫₀^θ cos kt dt and, up to a constant, ∫₀^θ sin kt dt for k = 0..=2H, over the distance of two time points.
/// Shape: `[2][2H + 1]`.
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
