//! Derivatives along a lap of the circle law with located events.
//!
//! A row holds the derivatives of one number by the two start tractions of the slider and, if the tangent is wanted, by
//! all displacement coefficients. Three numbers carry the state: the slider z = k_t w in stick, the angle of the
//! traction in slip, the phase of an event while it is near.

use super::batch::Block;
use super::plan::AftPlan;
use super::tangent::{RANK, SegmentScratch, add_masked_gram, add_products, add_scaled};
use crate::contact::{ContactParameters, Real};

/// Columns of a row that belong to the start tractions; those of the displacement coefficients follow, `[3][m]`.
pub(super) const STARTS: usize = 2;

/// A number as a sum of the signals at one phase: factors of s = k_t u (N), s', L = mu N and L'.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mix<T> {
    pub path: [T; 2],
    pub rate: [T; 2],
    pub limit: T,
    pub limit_rate: T,
}

impl<T: Real> Mix<T> {
    pub(super) const NONE: Self = Self {
        path: [T::ZERO; 2],
        rate: [T::ZERO; 2],
        limit: T::ZERO,
        limit_rate: T::ZERO,
    };
}

/// What rows depend on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Base<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub p: &'a ContactParameters<T>,
}

/// The rows of the present state.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows<T> {
    /// Whether the displacement coefficients have columns.
    pub full: bool,
    pub slider: [Vec<T>; 2],
    pub angle: Vec<T>,
    pub instant: Vec<T>,
}

impl<T: Real> Rows<T> {
    /// Rows of a lap from a slider that depends on nothing but the start tractions.
    #[inline(always)]
    pub(super) fn start(&mut self, plan: &AftPlan<T>, full: bool) {
        self.full = full;
        let width = if full { STARTS + 3 * plan.m } else { STARTS };
        let [first, second] = &mut self.slider;
        for row in [first, second, &mut self.angle, &mut self.instant] {
            row.clear();
            row.resize(width, T::ZERO);
        }
        self.slider[0][0] = T::ONE;
        self.slider[1][1] = T::ONE;
    }

    /// Derivative of the sliders by the start tractions, row-major.
    #[inline(always)]
    pub(super) fn monodromy(&self) -> [T; 4] {
        let [a, b] = &self.slider;
        [a[0], a[1], b[0], b[1]]
    }
}

/// Adds a mix of the signals where the basis row is `b`.
#[inline(always)]
pub(super) fn add_mix<T: Real>(base: Base<T>, row: &mut [T], b: &[T], mix: Mix<T>) {
    let m = base.plan.m;
    if row.len() == STARTS {
        return;
    }
    let [first, rest] = split(&mut row[STARTS..], m);
    let [second, normal] = split(rest, m);
    let k = base.p.k_t;
    let friction = base.p.mu * base.p.k_n;
    for (row, value, rate) in [
        (first, k[0] * mix.path[0], k[0] * mix.rate[0]),
        (second, k[1] * mix.path[1], k[1] * mix.rate[1]),
        (normal, friction * mix.limit, friction * mix.limit_rate),
    ] {
        add_signal(base.plan, row, b, value, rate);
    }
}

#[inline(always)]
fn split<T>(row: &mut [T], at: usize) -> [&mut [T]; 2] {
    let (a, b) = row.split_at_mut(at);
    [a, b]
}

/// `row` += `value` b + `rate` b'.
#[inline(always)]
fn add_signal<T: Real>(plan: &AftPlan<T>, row: &mut [T], b: &[T], value: T, rate: T) {
    row[0] += value;
    let pairs = row[1..].chunks_exact_mut(2).zip(b[1..].chunks_exact(2));
    for (&order, (row, b)) in plan.order_numbers.iter().zip(pairs) {
        let rate = rate * order;
        row[0] += value * b[0] - rate * b[1];
        row[1] += value * b[1] + rate * b[0];
    }
}

/// `row` = `factor` `row`.
#[inline(always)]
pub(super) fn scale<T: Real>(row: &mut [T], factor: T) {
    for value in row {
        *value = factor * *value;
    }
}

/// Derivative blocks under construction.
#[derive(Debug, Clone, Default)]
pub(super) struct Blocks<T> {
    pub segments: SegmentScratch<T>,
    /// Products that wait to be added. Shape: `[rank][m]`, `[rank][2][width]`.
    weights: Vec<T>,
    rows: Vec<T>,
    waiting: usize,
    /// Derivative of the force coefficients by the start tractions. Shape: `[2][m][2]`.
    starts: Vec<T>,
    /// Row under construction for each traction. Shape: `[2][width]`.
    pub traction: [Vec<T>; 2],
}

impl<T: Real> Blocks<T> {
    #[inline(always)]
    pub(super) fn start(&mut self, plan: &AftPlan<T>) {
        let width = STARTS + 3 * plan.m;
        self.weights.resize(RANK * plan.m, T::ZERO);
        self.rows.resize(RANK * 2 * width, T::ZERO);
        self.starts.clear();
        self.starts.resize(2 * plan.m * STARTS, T::ZERO);
        self.waiting = 0;
        self.clear_traction(plan);
    }

    /// Both rows of `traction` zero.
    #[inline(always)]
    pub(super) fn clear_traction(&mut self, plan: &AftPlan<T>) {
        for row in &mut self.traction {
            row.clear();
            row.resize(STARTS + 3 * plan.m, T::ZERO);
        }
    }

    /// Stick of the samples `range`: dT = k_t b − dz.
    #[inline(always)]
    pub(super) fn stick(
        &mut self,
        base: Base<T>,
        range: std::ops::Range<usize>,
        slider: &[Vec<T>; 2],
        out: &mut [T],
    ) {
        let (plan, size) = (base.plan, base.plan.m * base.plan.m);
        let run = self.segments.run(plan, range.start, range.end);
        for (block, k) in [(Block::T1T1, base.p.k_t[0]), (Block::T2T2, base.p.k_t[1])] {
            add_masked_gram(plan, run, k, &mut out[block as usize * size..][..size]);
        }
        for (row, z) in self.traction.iter_mut().zip(slider) {
            for (row, &z) in row.iter_mut().zip(z) {
                *row = -z;
            }
        }
        let at = self.waiting * plan.m;
        let sums = self.segments.sums_of_run(plan);
        self.weights[at..][..plan.m].copy_from_slice(sums);
        self.queue(plan, out);
    }

    /// Adds (w ∘ (`value` b + `rate` b')) ⊗ `traction`.
    #[inline(always)]
    pub(super) fn weigh(
        &mut self,
        plan: &AftPlan<T>,
        b: &[T],
        [value, rate]: [T; 2],
        out: &mut [T],
    ) {
        let weights = &mut self.weights[self.waiting * plan.m..][..plan.m];
        weights.fill(T::ZERO);
        add_signal(plan, weights, b, value, rate);
        for (weight, &w) in weights.iter_mut().zip(&plan.weight) {
            *weight = *weight * w;
        }
        self.queue(plan, out);
    }

    /// Puts the rows in `traction` next to the weights that were just written.
    #[inline(always)]
    fn queue(&mut self, plan: &AftPlan<T>, out: &mut [T]) {
        let width = STARTS + 3 * plan.m;
        let rows = &mut self.rows[self.waiting * 2 * width..][..2 * width];
        for (target, row) in rows.chunks_exact_mut(width).zip(&self.traction) {
            target.copy_from_slice(row);
        }
        self.waiting += 1;
        if self.waiting == RANK {
            self.flush(plan, out);
        }
    }

    /// Adds the waiting products to the blocks.
    #[inline(always)]
    pub(super) fn flush(&mut self, plan: &AftPlan<T>, out: &mut [T]) {
        let (m, width) = (plan.m, STARTS + 3 * plan.m);
        self.weights[self.waiting * m..].fill(T::ZERO);
        self.rows[self.waiting * 2 * width..].fill(T::ZERO);
        let row =
            |r: usize, d: usize, c: usize| &self.rows[(2 * r + d) * width + STARTS + c * m..][..m];
        add_products(m, &self.weights, row, out);
        for (d, starts) in self.starts.chunks_exact_mut(STARTS * m).enumerate() {
            for (a, starts) in starts.chunks_exact_mut(STARTS).enumerate() {
                for r in 0..RANK {
                    let row = &self.rows[(2 * r + d) * width..][..STARTS];
                    add_scaled(starts, self.weights[r * m + a], row);
                }
            }
        }
        self.waiting = 0;
    }

    /// Adds what the start tractions contribute, whose derivatives by the displacement coefficients are `rows`.
    #[inline(always)]
    pub(super) fn add_starts(&self, plan: &AftPlan<T>, rows: &[Vec<T>; 2], out: &mut [T]) {
        let m = plan.m;
        for block in &Block::ALL[..Block::NN as usize] {
            let (d, c) = (block.row_component(), block.column_component());
            let starts = self.starts[d * STARTS * m..].chunks_exact(STARTS);
            let target = &mut out[*block as usize * m * m..][..m * m];
            for (target, starts) in target.chunks_exact_mut(m).zip(starts) {
                for (row, &start) in rows.iter().zip(starts) {
                    add_scaled(target, start, &row[STARTS + c * m..][..m]);
                }
            }
        }
    }
}
