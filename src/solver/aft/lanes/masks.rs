//! Sums over the samples of one motion, from the spectrum of their mask.
//!
//! Σ w b bᵀ over a mask needs the spectrum of the mask alone: products of sines and cosines are sums over p − q (Toeplitz) and
//! p + q (Hankel).

use super::motions::{Event, contacts, last_event};
use super::workspace::Workspace;
use crate::aft::forces::TangentBlock;
use crate::aft::plan::AftPlan;
use crate::contact::{ContactParameters, Real};

/// Spectra and sums over runs of one motion.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct MaskScratch<T> {
    /// Spectrum of the mask of contact. Shape: `[2][2H + 1]`.
    contact: Vec<T>,
    /// Spectrum of one run.
    run: Vec<T>,
    /// Σ w_i b_i over one run. Shape: `[m]`.
    sums: Vec<T>,
}

/// One lane of a workspace.
#[derive(Clone, Copy)]
pub(in crate::aft) struct View<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub work: &'a Workspace<T>,
    pub lane: usize,
}

impl<T: Real> View<'_, T> {
    #[inline(always)]
    pub(in crate::aft) fn parameters(&self) -> ContactParameters<T> {
        self.work.parameters.of(self.lane)
    }

    /// Last event of direction `d` in the lap that was marched last.
    #[inline(always)]
    pub(in crate::aft) fn last_event(&self, d: usize) -> Option<Event> {
        last_event(&self.work.words, self.lane, d)
    }

    /// Derivative of the instant of closing at `sample` by the coefficients of n: factors of b at the sample before
    /// and at the sample.
    #[inline(always)]
    pub(in crate::aft) fn closing_derivative(&self, sample: usize) -> (usize, [T; 2]) {
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

impl<T: Real> MaskScratch<T> {
    /// Spectrum of the samples in contact, into `contact`.
    #[inline(always)]
    pub(in crate::aft) fn contact_spectrum(&mut self, view: View<T>) {
        clear(&mut self.contact, 2 * view.plan.n_mask_orders());
        for (start, end) in contacts(&view.work.words, view.plan.n_time(), view.lane) {
            self.spectrum_of_run(view.plan, start, end);
            add_scaled(&mut self.contact, T::ONE, &self.run);
        }
    }

    /// Adds dN/dn, after `contact_spectrum`.
    #[inline(always)]
    pub(in crate::aft) fn add_contact(&self, plan: &AftPlan<T>, k_n: T, nn: &mut [T]) {
        add_masked_gram(plan, &self.contact, k_n, nn);
    }

    /// Spectrum of the samples `start..end`.
    #[inline(always)]
    pub(in crate::aft) fn run(&mut self, plan: &AftPlan<T>, start: usize, end: usize) -> &[T] {
        self.spectrum_of_run(plan, start, end);
        &self.run
    }

    /// Σ w_i b_i over the run whose spectrum was asked for last. Shape: `[m]`.
    #[inline(always)]
    pub(in crate::aft) fn sums_of_run(&mut self, plan: &AftPlan<T>) -> &[T] {
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
pub(in crate::aft) fn sums_of_run<T: Real>(plan: &AftPlan<T>, run: &[T], sums: &mut Vec<T>) {
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
pub(in crate::aft) fn add_masked_gram<T: Real>(
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
pub(in crate::aft) fn add_masked_product<T: Real>(
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
pub(in crate::aft) fn subtract_product<T: Real>(
    block: &mut [T],
    factor: T,
    column: &[T],
    row: &[T],
) {
    for (target, &w) in block.chunks_exact_mut(row.len()).zip(column) {
        add_scaled(target, -(factor * w), row);
    }
}

/// Rank-1 products that [`add_products`] adds together.
pub(in crate::aft) const RANK: usize = 4;

/// Adds rank-1 products to all blocks but that of the normal force.
///
/// Shape: `weights` `[RANK][m]`; `row(r, d, c)` is the row of product r for the component d of the traction, by the `[m]`
/// coefficients of component c.
#[inline(always)]
pub(in crate::aft) fn add_products<'r, T: Real>(
    m: usize,
    weights: &[T],
    row: impl Fn(usize, usize, usize) -> &'r [T],
    out: &mut [T],
) {
    for block in &TangentBlock::ALL[..TangentBlock::NN as usize] {
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
pub(in crate::aft) fn add_scaled<T: Real>(y: &mut [T], a: T, x: &[T]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `y` = a `x`.
#[inline(always)]
pub(in crate::aft) fn set<T: Real>(y: &mut Vec<T>, a: T, x: &[T]) {
    y.clear();
    y.extend(x.iter().map(|&x| a * x));
}

/// `y` = 0, of length `n`.
#[inline(always)]
pub(in crate::aft) fn clear<T: Real>(y: &mut Vec<T>, n: usize) {
    y.clear();
    y.resize(n, T::ZERO);
}
