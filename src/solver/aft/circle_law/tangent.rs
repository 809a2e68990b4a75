//! Exact derivative of the circle law where events are decided or interpolated at the samples; for located events see
//! [`super::sensitivity`].
//!
//! The slider carries the derivative B = k_t dw of its position by all displacement coefficients. A stick segment adds
//! k_t b_i − B (one masked sum and one rank-1 product). A slip sample returns the predicted derivative to the disc,
//! dT = (L/|T*|) p pᵀ dT* + mu k_n e b_i with e = T*/|T*| and p normal to e, and adds one rank-1 product.

use super::march::slip_monodromy;
use super::march::{Cycle, lane2};
use super::steady_cycle::{Hold, Origin, is_singular, solve_identity_minus};
use crate::aft::forces::TangentBlock;
use crate::aft::lanes::masks::{
    MaskScratch, RANK, View, add_masked_gram, add_products, add_scaled,
};
use crate::aft::lanes::workspace::LapPosition;
use crate::aft::vector::size;
use crate::contact::Real;
use crate::contact::law::{CircleStep, anchored_at_closing, circle_step};

/// Scratch of the derivative of the circle law.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct CircleScratch<T> {
    /// Slider (m) and its derivative times k_t. Shape: `[2]`, `[2][3m]`.
    slider: [T; 2],
    by: [Vec<T>; 2],
    /// Derivative of the end traction by the start traction.
    monodromy: [T; 4],
    /// Traction derivative of the present slip sample. Shape: `[2][3m]`.
    slip: [Vec<T>; 2],
    /// Weights and traction derivatives that wait to be added. Shape: `[rank][m]`, `[rank][2][3m]`.
    weights: Vec<T>,
    rows: Vec<T>,
    waiting: usize,
}

/// Where the derivative of one lap goes.
struct Target<'a, T> {
    masks: &'a mut MaskScratch<T>,
    out: &'a mut [T],
}

/// Derivative blocks of the circle law for the lane in `view`, marched as `cycle` says.
///
/// Shape: `out` `[block][m][m]`, zero on entry.
#[inline(always)]
pub(in crate::aft) fn circle_tangent<T: Real>(
    view: View<T>,
    cycle: &Cycle<T>,
    scratch: &mut CircleScratch<T>,
    masks: &mut MaskScratch<T>,
    out: &mut [T],
) {
    let size = view.plan.m * view.plan.m;
    let p = view.parameters();
    scratch.clear(view);
    let origin = cycle.origin[view.lane];
    scratch.slider = match origin {
        Origin::Anchor => p.anchor,
        Origin::Itself | Origin::Held(_) => lane2(&cycle.start, view.lane),
    };
    let laps = match origin {
        Origin::Anchor => cycle.laps[view.lane],
        Origin::Itself => 2,
        Origin::Held(hold) => {
            scratch.hold(view, &hold);
            1
        }
    };
    for lap in 1..=laps {
        if lap == 2 && origin == Origin::Itself {
            scratch.close_cycle();
            scratch.slider = lane2(&cycle.start, view.lane);
        }
        let target = (lap == laps).then_some(Target {
            masks: &mut *masks,
            out: &mut *out,
        });
        let position = match (origin, lap) {
            (Origin::Anchor, 1) => LapPosition::First,
            _ => LapPosition::Later,
        };
        scratch.lap(view, position, target);
    }
    masks.contact_spectrum(view);
    let nn = &mut out[TangentBlock::NN as usize * size..][..size];
    masks.add_contact(view.plan, p.k_n, nn);
}

impl<T: Real> CircleScratch<T> {
    #[inline(always)]
    fn clear(&mut self, view: View<T>) {
        let m = view.plan.m;
        for rows in self.by.iter_mut().chain(&mut self.slip) {
            rows.clear();
            rows.resize(3 * m, T::ZERO);
        }
        self.weights.resize(RANK * m, T::ZERO);
        self.rows.resize(RANK * 6 * m, T::ZERO);
        self.monodromy = [T::ONE, T::ZERO, T::ZERO, T::ONE];
        self.waiting = 0;
    }

    /// Start derivative of the periodic slider from the end derivative of a lap with a fixed start: (I − M)⁻¹ B.
    #[inline(always)]
    fn close_cycle(&mut self) {
        if is_singular(self.monodromy) {
            // no steady cycle was found
            return;
        }
        let [first, second] = &mut self.by;
        for (a, b) in first.iter_mut().zip(second) {
            [*a, *b] = solve_identity_minus(self.monodromy, [*a, *b]);
        }
    }

    /// Derivative of a slider that two samples hold: the excess |s − k_t w| − L of both stays 0.
    #[inline(always)]
    fn hold(&mut self, view: View<T>, hold: &Hold<usize, T>) {
        let (m, p) = (view.plan.m, view.parameters());
        for (k, (&i, e)) in hold.instants.iter().zip(hold.directions).enumerate() {
            let excess = [0, 1].map(|j| if j == k { T::ONE } else { T::ZERO });
            let row = view.plan.row(i);
            let moved = hold.moved(excess).unwrap_or_default();
            for (by, moved) in self.by.iter_mut().zip(moved) {
                for c in 0..2 {
                    add_scaled(&mut by[c * m..][..m], moved * e[c] * p.k_t[c], row);
                }
                add_scaled(&mut by[2 * m..], -(moved * p.mu * p.k_n), row);
            }
        }
    }

    /// One lap of slider and derivative; with a target, the traction derivatives are analysed into its blocks.
    #[inline(always)]
    fn lap(&mut self, view: View<T>, position: LapPosition, mut target: Option<Target<T>>) {
        let p = view.parameters();
        let flexibility = lane2(&view.work.parameters.flexibility, view.lane);
        let margin = view.work.touch_margin(view.lane);
        let mut stick_start = None;
        for (i, s) in view.work.samples.iter().enumerate() {
            let u = [s.u[0][view.lane], s.u[1][view.lane]];
            self.close_gap(view, i, view.work.closing(i, view.lane, position), u);
            let limit = p.mu * s.normal(view.lane);
            let step = circle_step(p.k_t, flexibility, limit, margin, u, self.slider);
            let contact = s.gap[view.lane] > T::ZERO;
            if contact && !step.touches {
                stick_start = stick_start.or(Some(i));
                continue;
            }
            if let (Some(start), Some(target)) = (stick_start.take(), &mut target) {
                self.stick_segment(view, start, i, target);
            }
            self.slider = step.slider;
            if !contact {
                self.follow(view, i);
                continue;
            }
            self.slip(view, i, &step);
            if let Some(target) = &mut target {
                self.queue_slip(view, i, target.out);
            }
        }
        if let Some(mut target) = target {
            if let Some(start) = stick_start {
                self.stick_segment(view, start, view.plan.n_time(), &mut target);
            }
            self.flush(view.plan.m, target.out);
        }
    }

    /// Slider anchored at the instant of closing before sample i.
    #[inline(always)]
    fn close_gap(&mut self, view: View<T>, i: usize, instant: T, u: [T; 2]) {
        if instant == T::ZERO {
            return;
        }
        let (m, p, row) = (view.plan.m, view.parameters(), view.plan.row(i));
        let (before, factors) = view.closing_derivative(i);
        let row_before = view.plan.row(before);
        for (d, by) in self.by.iter_mut().enumerate() {
            let jump = p.k_t[d] * (u[d] - self.slider[d]);
            for value in by.iter_mut() {
                *value = (T::ONE - instant) * *value;
            }
            add_scaled(&mut by[d * m..][..m], p.k_t[d] * instant, row);
            add_scaled(&mut by[2 * m..], jump * factors[0], row_before);
            add_scaled(&mut by[2 * m..], jump * factors[1], row);
            self.slider[d] = anchored_at_closing(self.slider[d], u[d], instant);
        }
    }

    /// Separated: the slider is where the surface is.
    #[inline(always)]
    fn follow(&mut self, view: View<T>, i: usize) {
        let (m, p) = (view.plan.m, view.parameters());
        for d in 0..2 {
            self.by[d].fill(T::ZERO);
            add_scaled(&mut self.by[d][d * m..][..m], p.k_t[d], view.plan.row(i));
            self.slider[d] = view.work.samples[i].u[d][view.lane];
        }
        self.monodromy = [T::ZERO; 4];
    }

    /// Traction derivative of a slip sample into `slip`, and the slider derivative after it.
    #[inline(always)]
    fn slip(&mut self, view: View<T>, i: usize, step: &CircleStep<T>) {
        let (m, p, row) = (view.plan.m, view.parameters(), view.plan.row(i));
        let length = size(step.trial);
        let e = [step.trial[0] / length, step.trial[1] / length];
        let [first, second] = &mut self.slip;
        for (((s0, s1), b0), b1) in first
            .iter_mut()
            .zip(second)
            .zip(&self.by[0])
            .zip(&self.by[1])
        {
            // p pᵀ (−B); the direct part k_t b_i of dT* is added below.
            let along = step.ratio * (e[1] * *b0 - e[0] * *b1);
            (*s0, *s1) = (-(e[1] * along), e[0] * along);
        }
        let normal = [-e[1], e[0]];
        for d in 0..2 {
            for c in 0..2 {
                let factor = step.ratio * normal[d] * normal[c] * p.k_t[c];
                add_scaled(&mut self.slip[d][c * m..][..m], factor, row);
            }
            add_scaled(&mut self.slip[d][2 * m..], p.mu * p.k_n * e[d], row);
            for (b, &t) in self.by[d].iter_mut().zip(&self.slip[d]) {
                *b = -t;
            }
            add_scaled(&mut self.by[d][d * m..][..m], p.k_t[d], row);
        }
        self.monodromy = slip_monodromy(step.trial, step.ratio, self.monodromy);
    }

    /// Analysis of the stick segment `start..end`: k_t b_i − B.
    #[inline(always)]
    fn stick_segment(&mut self, view: View<T>, start: usize, end: usize, target: &mut Target<T>) {
        let (plan, k_t) = (view.plan, view.parameters().k_t);
        let (m, size) = (plan.m, plan.m * plan.m);
        let run = target.masks.run(plan, start, end);
        for (block, k) in [(TangentBlock::T1T1, k_t[0]), (TangentBlock::T2T2, k_t[1])] {
            let block = &mut target.out[block as usize * size..][..size];
            add_masked_gram(plan, run, k, block);
        }
        let at = self.waiting;
        let weights = &mut self.weights[at * m..][..m];
        weights.copy_from_slice(target.masks.sums_of_run(plan));
        for d in 0..2 {
            let row = &mut self.rows[(2 * at + d) * 3 * m..][..3 * m];
            for (value, &b) in row.iter_mut().zip(&self.by[d]) {
                *value = -b;
            }
        }
        self.advance(m, target.out);
    }

    #[inline(always)]
    fn queue_slip(&mut self, view: View<T>, i: usize, out: &mut [T]) {
        let (m, at) = (view.plan.m, self.waiting);
        let weights = self.weights[at * m..][..m].iter_mut();
        for ((value, &b), &w) in weights.zip(view.plan.row(i)).zip(&view.plan.weight) {
            *value = w * b;
        }
        for d in 0..2 {
            self.rows[(2 * at + d) * 3 * m..][..3 * m].copy_from_slice(&self.slip[d]);
        }
        self.advance(m, out);
    }

    #[inline(always)]
    fn advance(&mut self, m: usize, out: &mut [T]) {
        self.waiting += 1;
        if self.waiting == RANK {
            self.flush(m, out);
        }
    }

    /// Adds the waiting products to the blocks.
    #[inline(always)]
    fn flush(&mut self, m: usize, out: &mut [T]) {
        self.weights[self.waiting * m..].fill(T::ZERO);
        let row = |r: usize, d: usize, c: usize| &self.rows[(2 * r + d) * 3 * m + c * m..][..m];
        add_products(m, &self.weights, row, out);
        self.waiting = 0;
    }
}
