//! Exact derivative of the box law in segment form, where events are decided or interpolated at the samples; for located events see
//! [`super::located`].
//!
//! Inside a stick segment that starts after the event r, T_i = T_r + k_t (u_i − u_r); so its derivative is k_t b_i plus
//! a constant row, and every segment adds one rank-1 product. Cost per state: O(segments · m²), and
//! Nt/64 words of bits to find the segments. Derived from the transition rules of Petrov and Ewins
//! (J. Turbomach. 125, 2003).

use crate::aft::forces::TangentBlock;
use crate::aft::lanes::masks::{
    MaskScratch, View, add_masked_gram, add_scaled, clear, set, subtract_product,
};
use crate::aft::lanes::motions::{Event, Motion, runs};
use crate::aft::lanes::workspace::LapPosition;
use crate::contact::Real;

/// Rows of the segment form.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct SegmentScratch<T> {
    masks: MaskScratch<T>,
    /// Spectra of the masks of stick and of signed slip. Shape: `[2][2H + 1]` each.
    stick: Vec<T>,
    slip: Vec<T>,
    /// Derivative of the slider position by u and of the traction at the event by n. Shape: `[m]` each.
    slider: Vec<T>,
    traction: Vec<T>,
}

/// Derivative blocks of the box law from the last lap in `view`; `before` are the last events of earlier laps.
///
/// Shape: `out` `[block][m][m]`, zero on entry.
#[inline(always)]
pub(in crate::aft) fn box_tangent<T: Real>(
    view: View<T>,
    before: [Option<Event>; 2],
    scratch: &mut SegmentScratch<T>,
    out: &mut [T],
) {
    let size = view.plan.m * view.plan.m;
    assert_eq!(out.len(), TangentBlock::COUNT * size, "one tangent");
    let (t1t1, rest) = out.split_at_mut(size);
    let (t2t2, rest) = rest[2 * size..].split_at_mut(size);
    let (t1n, rest) = rest.split_at_mut(size);
    let (t2n, nn) = rest.split_at_mut(size);
    let p = view.parameters();
    scratch.direction(view, 0, before[0], t1t1, t1n);
    scratch.direction(view, 1, before[1], t2t2, t2n);
    scratch.masks.contact_spectrum(view);
    scratch.masks.add_contact(view.plan, p.k_n, nn);
}

impl<T: Real> SegmentScratch<T> {
    /// Blocks dT_d/du_d and dT_d/dn of one direction.
    #[inline(always)]
    fn direction(
        &mut self,
        view: View<T>,
        d: usize,
        before: Option<Event>,
        tt: &mut [T],
        tn: &mut [T],
    ) {
        let n = view.plan.n_time();
        let p = view.parameters();
        let width = 2 * view.plan.n_mask_orders();
        clear(&mut self.stick, width);
        clear(&mut self.slip, width);
        let mut last = before;
        for run in runs(&view.work.words, n, view.lane, d) {
            let spectrum = self.masks.run(view.plan, run.start, run.end);
            match run.motion {
                Motion::Stick => {
                    add_scaled(&mut self.stick, T::ONE, spectrum);
                    self.segment(view, d, last, tt, tn);
                }
                Motion::SlipUp => add_scaled(&mut self.slip, T::ONE, spectrum),
                Motion::SlipDown => add_scaled(&mut self.slip, -T::ONE, spectrum),
                Motion::Separated => {}
            }
            last = run.event().or(last);
        }
        add_masked_gram(view.plan, &self.stick, p.k_t[d], tt);
        add_masked_gram(view.plan, &self.slip, p.mu * p.k_n, tn);
    }

    /// Constant row of the stick segment whose spectrum was asked for last, after the event `last`.
    #[inline(always)]
    fn segment(
        &mut self,
        view: View<T>,
        d: usize,
        last: Option<Event>,
        tt: &mut [T],
        tn: &mut [T],
    ) {
        let Some(event) = last else {
            return;
        };
        let (plan, p) = (view.plan, view.parameters());
        let here = plan.row(event.sample);
        set(&mut self.slider, p.k_t[d], here);
        match event.motion {
            Motion::SlipUp => set(&mut self.traction, p.mu * p.k_n, here),
            Motion::SlipDown => set(&mut self.traction, -(p.mu * p.k_n), here),
            Motion::Stick | Motion::Separated => {
                clear(&mut self.traction, plan.m);
                self.closing(view, d, event.sample);
            }
        }
        let sums = self.masks.sums_of_run(plan);
        subtract_product(tt, T::ONE, sums, &self.slider);
        for (row, &w) in tn.chunks_exact_mut(plan.m).zip(sums) {
            add_scaled(row, w, &self.traction);
        }
    }

    /// Slider set between the separated sample `before` and the next one: w = (1 − θ) u₋ + θ u.
    #[inline(always)]
    fn closing(&mut self, view: View<T>, d: usize, before: usize) {
        let n = view.plan.n_time();
        let sample = (before + 1) % n;
        let s = view.work.samples.as_slice();
        let instant = view.work.closing(sample, view.lane, LapPosition::Later);
        if instant == T::ZERO {
            return;
        }
        let k_t = view.parameters().k_t[d];
        let (row, row_before) = (view.plan.row(sample), view.plan.row(before));
        set(&mut self.slider, k_t * (T::ONE - instant), row_before);
        add_scaled(&mut self.slider, k_t * instant, row);
        let jump = k_t * (s[sample].u[d][view.lane] - s[before].u[d][view.lane]);
        let (_, factors) = view.closing_derivative(sample);
        add_scaled(&mut self.traction, -(jump * factors[0]), row_before);
        add_scaled(&mut self.traction, -(jump * factors[1]), row);
    }
}
