//! Exact derivative of the box law in segment form.
//!
//! Inside a stick segment that starts after the event r, T_i = T_r + k_t (u_i − u_r); so its derivative is k_t b_i plus
//! a constant row, and every segment adds one rank-1 product. The sums over masks Σ w b bᵀ need the spectrum of the
//! mask alone: products of sines and cosines are sums over p − q (Toeplitz) and p + q (Hankel). Cost per state:
//! O(segments · m²), and Nt/64 words of bits to find the segments. Derived from the transition rules of Petrov and Ewins
//! (J. Turbomach. 125, 2003).

use super::batch::Block;
use super::march::Workspace;
use super::motions::{Event, Motion, contacts, last_event, runs};
use super::plan::AftPlan;
use crate::contact::{ContactParameters, Real};

/// Scratch rows of the segment form.
#[derive(Debug, Clone, Default)]
pub(super) struct SegmentScratch<T> {
    /// Spectra of the masks of contact, stick and signed slip. Shape: `[2][2H + 1]` each.
    contact: Vec<T>,
    stick: Vec<T>,
    slip: Vec<T>,
    /// Spectrum of one run.
    run: Vec<T>,
    /// Σ w_i b_i over one segment. Shape: `[m]`.
    sums: Vec<T>,
    /// Derivative of the slider position by u and of the traction at the event by n. Shape: `[m]` each.
    slider: Vec<T>,
    traction: Vec<T>,
}

/// One lane of a marched workspace.
#[derive(Clone, Copy)]
pub(super) struct View<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub work: &'a Workspace<T>,
    pub lane: usize,
}

impl<T: Real> View<'_, T> {
    #[inline(always)]
    pub(super) fn parameters(&self) -> ContactParameters<T> {
        self.work.parameters.of(self.lane)
    }

    /// Last event of direction `d` in the lap that was marched last.
    #[inline(always)]
    pub(super) fn last_event(&self, d: usize) -> Option<Event> {
        last_event(&self.work.words, self.lane, d)
    }

    /// Derivative of the instant of closing at `sample` by the coefficients of n: factors of b at the sample before
    /// and at the sample.
    #[inline(always)]
    pub(super) fn closing_derivative(&self, sample: usize) -> (usize, [T; 2]) {
        let n = self.plan.n_time();
        let before = (sample + n - 1) % n;
        let (g0, g1) = (
            self.work.samples[before].gap[self.lane],
            self.work.samples[sample].gap[self.lane],
        );
        let factor = self.parameters().k_n / ((g0 - g1) * (g0 - g1));
        (before, [-(factor * g1), factor * g0])
    }
}

/// Derivative blocks of the box law from the last lap in `view`; `before` are the last events of earlier laps.
///
/// Shape: `out` `[block][m][m]`, zero on entry.
#[inline(always)]
pub(super) fn box_tangent<T: Real>(
    view: View<T>,
    before: [Option<Event>; 2],
    scratch: &mut SegmentScratch<T>,
    out: &mut [T],
) {
    let size = view.plan.m * view.plan.m;
    assert_eq!(out.len(), Block::COUNT * size, "one tangent");
    let (t1t1, rest) = out.split_at_mut(size);
    let (t2t2, rest) = rest[2 * size..].split_at_mut(size);
    let (t1n, rest) = rest.split_at_mut(size);
    let (t2n, nn) = rest.split_at_mut(size);
    let p = view.parameters();
    scratch.direction(view, 0, before[0], t1t1, t1n);
    scratch.direction(view, 1, before[1], t2t2, t2n);
    scratch.contact_spectrum(view);
    scratch.add_contact(view.plan, p.k_n, nn);
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
            self.spectrum_of_run(view.plan, run.start, run.end);
            match run.motion {
                Motion::Stick => {
                    add_scaled(&mut self.stick, T::ONE, &self.run);
                    self.segment(view, d, last, tt, tn);
                }
                Motion::SlipUp => add_scaled(&mut self.slip, T::ONE, &self.run),
                Motion::SlipDown => add_scaled(&mut self.slip, -T::ONE, &self.run),
                Motion::Separated => {}
            }
            last = run.event().or(last);
        }
        add_masked_gram(view.plan, &self.stick, p.k_t[d], tt);
        add_masked_gram(view.plan, &self.slip, p.mu * p.k_n, tn);
    }

    /// Constant row of the stick segment whose spectrum is in `run`, after the event `last`.
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
        sums_of_run(plan, &self.run, &mut self.sums);
        subtract_product(tt, T::ONE, &self.sums, &self.slider);
        for (row, &w) in tn.chunks_exact_mut(plan.m).zip(&self.sums) {
            add_scaled(row, w, &self.traction);
        }
    }

    /// Slider set between the separated sample `before` and the next one: w = (1 − θ) u₋ + θ u.
    #[inline(always)]
    fn closing(&mut self, view: View<T>, d: usize, before: usize) {
        let n = view.plan.n_time();
        let sample = (before + 1) % n;
        let s = view.work.samples.as_slice();
        let instant = view.work.closing(sample, view.lane, false);
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

    /// Spectrum of the samples in contact, into `contact`.
    #[inline(always)]
    pub(super) fn contact_spectrum(&mut self, view: View<T>) {
        clear(&mut self.contact, 2 * view.plan.n_mask_orders());
        for (start, end) in contacts(&view.work.words, view.plan.n_time(), view.lane) {
            self.spectrum_of_run(view.plan, start, end);
            add_scaled(&mut self.contact, T::ONE, &self.run);
        }
    }

    /// Adds dN/dn, after `contact_spectrum`.
    #[inline(always)]
    pub(super) fn add_contact(&self, plan: &AftPlan<T>, k_n: T, nn: &mut [T]) {
        add_masked_gram(plan, &self.contact, k_n, nn);
    }

    /// Spectrum of the samples `start..end`.
    #[inline(always)]
    pub(super) fn run(&mut self, plan: &AftPlan<T>, start: usize, end: usize) -> &[T] {
        self.spectrum_of_run(plan, start, end);
        &self.run
    }

    /// Σ w_i b_i over the run whose spectrum was asked for last. Shape: `[m]`.
    #[inline(always)]
    pub(super) fn sums_of_run(&mut self, plan: &AftPlan<T>) -> &[T] {
        sums_of_run(plan, &self.run, &mut self.sums);
        &self.sums
    }

    /// Spectrum of the samples `start..end`, into `run`.
    #[inline(always)]
    fn spectrum_of_run(&mut self, plan: &AftPlan<T>, start: usize, end: usize) {
        let (a, b) = (plan.prefix_row(start), plan.prefix_row(end));
        self.run.clear();
        self.run.extend(b.iter().zip(a).map(|(&b, &a)| b - a));
    }
}

/// Σ w_i b_i over a run with the given spectrum.
#[inline(always)]
pub(super) fn sums_of_run<T: Real>(plan: &AftPlan<T>, run: &[T], sums: &mut Vec<T>) {
    let (cos, sin) = run.split_at(plan.n_mask_orders());
    sums.clear();
    sums.push(plan.weight[0] * cos[0]);
    for &k in &plan.orders[1..] {
        sums.push(plan.weight[1] * cos[k]);
        sums.push(plan.weight[1] * sin[k]);
    }
}

/// Adds `factor` Σ_i mask_i w_a,i b_b,i to the m × m block, from the spectrum of the mask.
#[inline(always)]
pub(super) fn add_masked_gram<T: Real>(
    plan: &AftPlan<T>,
    spectrum: &[T],
    factor: T,
    block: &mut [T],
) {
    let (m, orders) = (plan.m, &plan.orders);
    let (cos, sin) = spectrum.split_at(plan.n_mask_orders());
    let mean = factor * plan.weight[0];
    let double = factor * plan.weight[1];
    let half = T::from_f64(0.5) * double;
    block[0] += mean * cos[0];
    for (j, &q) in orders.iter().enumerate().skip(1) {
        block[2 * j - 1] += mean * cos[q];
        block[2 * j] += mean * sin[q];
        block[(2 * j - 1) * m] += double * cos[q];
        block[2 * j * m] += double * sin[q];
    }
    for (i, rows) in block[m..].chunks_exact_mut(2 * m).enumerate() {
        let p = orders[i + 1];
        let (cosine, sine) = rows.split_at_mut(m);
        let pairs = cosine[1..]
            .chunks_exact_mut(2)
            .zip(sine[1..].chunks_exact_mut(2));
        for (&q, (c, s)) in orders[1..].iter().zip(pairs) {
            let (c_minus, c_plus) = (cos[p.abs_diff(q)], cos[p + q]);
            let (s_plus, s_minus) = (sin[p + q], sin[p.abs_diff(q)]);
            let s_minus = if p < q { -s_minus } else { s_minus };
            c[0] += half * (c_minus + c_plus);
            c[1] += half * (s_plus - s_minus);
            s[0] += half * (s_plus + s_minus);
            s[1] += half * (c_minus - c_plus);
        }
    }
}

/// `out` += `factor` Σ_i mask_i w_i b_i (b_i · q), from the spectrum of the mask. Shape: `q`, `out` `[m]`.
#[inline(always)]
pub(super) fn add_masked_product<T: Real>(
    plan: &AftPlan<T>,
    spectrum: &[T],
    factor: T,
    q: &[T],
    out: &mut [T],
) {
    let orders = &plan.orders;
    let (cos, sin) = spectrum.split_at(plan.n_mask_orders());
    let (mean, double) = (factor * plan.weight[0], factor * plan.weight[1]);
    let half = T::from_f64(0.5) * double;
    let pairs = || orders[1..].iter().zip(q[1..].chunks_exact(2));
    let mut sum = cos[0] * q[0];
    for (&k, q) in pairs() {
        sum += cos[k] * q[0] + sin[k] * q[1];
    }
    out[0] += mean * sum;
    for (&p, out) in orders[1..].iter().zip(out[1..].chunks_exact_mut(2)) {
        out[0] += double * (cos[p] * q[0]);
        out[1] += double * (sin[p] * q[0]);
        let (mut c, mut s) = (T::ZERO, T::ZERO);
        for (&k, q) in pairs() {
            let (c_minus, c_plus) = (cos[p.abs_diff(k)], cos[p + k]);
            let (s_plus, s_minus) = (sin[p + k], sin[p.abs_diff(k)]);
            let s_minus = if p < k { -s_minus } else { s_minus };
            c += (c_minus + c_plus) * q[0] + (s_plus - s_minus) * q[1];
            s += (s_plus + s_minus) * q[0] + (c_minus - c_plus) * q[1];
        }
        out[0] += half * c;
        out[1] += half * s;
    }
}

/// `block` −= `factor` `column` `row`ᵀ.
#[inline(always)]
pub(super) fn subtract_product<T: Real>(block: &mut [T], factor: T, column: &[T], row: &[T]) {
    for (target, &w) in block.chunks_exact_mut(row.len()).zip(column) {
        add_scaled(target, -(factor * w), row);
    }
}

/// Rank-1 products that [`add_products`] adds together.
pub(super) const RANK: usize = 4;

/// Adds rank-1 products to all blocks but that of the normal force.
///
/// Shape: `weights` `[RANK][m]`; `row(r, d, c)` is the row of product r for the component d of the traction, by the `[m]`
/// coefficients of component c.
#[inline(always)]
pub(super) fn add_products<'r, T: Real>(
    m: usize,
    weights: &[T],
    row: impl Fn(usize, usize, usize) -> &'r [T],
    out: &mut [T],
) {
    for block in &Block::ALL[..Block::NN as usize] {
        let (d, c) = (block.row_component(), block.column_component());
        let rows: [&[T]; RANK] = std::array::from_fn(|r| row(r, d, c));
        let target = &mut out[*block as usize * m * m..][..m * m];
        for (a, target) in target.chunks_exact_mut(m).enumerate() {
            let w: [T; RANK] = [0, 1, 2, 3].map(|r: usize| weights[r * m + a]);
            let pairs = rows[0].iter().zip(rows[1]).zip(rows[2].iter().zip(rows[3]));
            for (value, ((&a, &b), (&c, &d))) in target.iter_mut().zip(pairs) {
                *value += (w[0] * a + w[1] * b) + (w[2] * c + w[3] * d);
            }
        }
    }
}

/// `y` += a `x`.
#[inline(always)]
pub(super) fn add_scaled<T: Real>(y: &mut [T], a: T, x: &[T]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

#[inline(always)]
fn set<T: Real>(y: &mut Vec<T>, a: T, x: &[T]) {
    y.clear();
    y.extend(x.iter().map(|&x| a * x));
}

#[inline(always)]
pub(super) fn clear<T: Real>(y: &mut Vec<T>, n: usize) {
    y.clear();
    y.resize(n, T::ZERO);
}
