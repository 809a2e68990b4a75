//! Derivatives along a lap of the circle law with located events.
//!
//! A row holds the derivatives of one number: by the two components of the slider z = k_t w at the start of the lap and, if the
//! tangent is wanted, by all displacement coefficients. Three numbers describe the state of the contact: the slider in stick,
//! the angle of the traction in slip, and the phase of an event at and just after that event.

use crate::aft::forces::TangentBlock;
use crate::aft::lanes::masks::{MaskScratch, add_masked_gram, add_scaled, clear};
use crate::aft::plan::{AftPlan, CHUNK, Chunk};
use crate::contact::{ContactParameters, Real};
use pulp::{Simd, WithSimd};

/// Derivatives of one number: the first two of the first chunk by the start tractions, the others by the displacement
/// coefficients, component by component in whole chunks. What pads a chunk stays 0.
pub(in crate::aft) type Row<T> = Vec<Chunk<T>>;

/// Factors of the signals at one phase in a number that is a sum of them: of s = k_t u (N), s', s'', L = mu N, L' and L''; those of
/// s'' and L'' for events only.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct SignalWeights<T> {
    pub path: [T; 2],
    pub rate: [T; 2],
    pub bend: [T; 2],
    pub limit: T,
    pub limit_rate: T,
    pub limit_bend: T,
}

impl<T: Real> SignalWeights<T> {
    pub(in crate::aft) const NONE: Self = Self {
        path: [T::ZERO; 2],
        rate: [T::ZERO; 2],
        bend: [T::ZERO; 2],
        limit: T::ZERO,
        limit_rate: T::ZERO,
        limit_bend: T::ZERO,
    };
}

/// What all rows need.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) struct Base<'a, T> {
    pub plan: &'a AftPlan<T>,
    pub p: &'a ContactParameters<T>,
}

/// The basis row at a sample, by its number, or at an event.
#[derive(Debug, Clone, Copy)]
pub(in crate::aft) enum Basis<'a, T> {
    Sample(usize),
    Event(&'a [T]),
}

/// The rows of the present state.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Rows<T> {
    /// Whether the displacement coefficients have columns.
    pub full: bool,
    pub slider: [Row<T>; 2],
    pub angle: Row<T>,
    pub instant: Row<T>,
}

impl<T: Real> Rows<T> {
    /// Rows of a lap from a slider that depends on nothing but the start tractions.
    #[inline(always)]
    pub(in crate::aft) fn start(&mut self, plan: &AftPlan<T>, full: bool) {
        self.full = full;
        let width = if full { width(plan) } else { 1 };
        let [first, second] = &mut self.slider;
        for row in [first, second, &mut self.angle, &mut self.instant] {
            row.clear();
            row.resize(width, [T::ZERO; CHUNK]);
        }
        self.slider[0][0][0] = T::ONE;
        self.slider[1][0][1] = T::ONE;
    }

    /// Derivative of the sliders by the start tractions, row-major.
    #[inline(always)]
    pub(in crate::aft) fn monodromy(&self) -> [T; 4] {
        let [a, b] = &self.slider;
        [a[0][0], a[0][1], b[0][0], b[0][1]]
    }
}

/// Chunks of a row.
fn width<T: Real>(plan: &AftPlan<T>) -> usize {
    1 + 3 * plan.n_chunks()
}

/// Adds the row of a sum of the signals at a phase whose basis row is `at`.
#[inline(always)]
pub(in crate::aft) fn add_signals<T: Real>(
    base: Base<T>,
    row: &mut [Chunk<T>],
    at: Basis<T>,
    weights: SignalWeights<T>,
) {
    let k = base.p.k_t;
    let friction = base.p.mu * base.p.k_n;
    let factors = [
        [weights.path[0], weights.rate[0], weights.bend[0]].map(|w| k[0] * w),
        [weights.path[1], weights.rate[1], weights.bend[1]].map(|w| k[1] * w),
        [weights.limit, weights.limit_rate, weights.limit_bend].map(|w| friction * w),
    ];
    let components = row[1..].chunks_exact_mut(base.plan.n_chunks());
    for (row, factors) in components.zip(factors) {
        match at {
            _ if factors == [T::ZERO; 3] => {}
            Basis::Sample(i) => {
                let [value, rate, _] = factors;
                let (b, rates) = base.plan.wave(i);
                set_rows(row, [b, rates], |row, b, r| row + (value * b + rate * r));
            }
            Basis::Event(b) => add_signal(base.plan, row.as_flattened_mut(), b, factors),
        }
    }
}

/// Adds what a step of slip between two samples depends on: the change of s, s' at the end, half the sum of L.
#[inline(always)]
pub(in crate::aft) fn add_step<T: Real>(
    base: Base<T>,
    row: &mut [Chunk<T>],
    [here, next]: [usize; 2],
    path: [T; 2],
    rate: [T; 2],
    limit: T,
) {
    let n = base.plan.n_chunks();
    let ((before, _), (after, rates)) = (base.plan.wave(here), base.plan.wave(next));
    let mut components = row[1..].chunks_exact_mut(n);
    for (d, row) in components.by_ref().take(2).enumerate() {
        let (value, rate) = (base.p.k_t[d] * path[d], base.p.k_t[d] * rate[d]);
        set_rows(row, [before, after], |row, b, a| row + value * (a - b));
        add_row(row, rate, rates);
    }
    let value = base.p.mu * base.p.k_n * limit;
    for row in components {
        set_rows(row, [before, after], |row, b, a| row + value * (a + b));
    }
}

/// `row` += `value` b + `rate` b' + `bend` b''.
#[inline(always)]
pub(super) fn add_signal<T: Real>(
    plan: &AftPlan<T>,
    row: &mut [T],
    b: &[T],
    [value, rate, bend]: [T; 3],
) {
    row[0] += value;
    let pairs = row[1..].chunks_exact_mut(2).zip(b[1..].chunks_exact(2));
    for (&order, (row, b)) in plan.order_numbers.iter().zip(pairs) {
        let (value, rate) = (value - bend * order * order, rate * order);
        row[0] += value * b[0] - rate * b[1];
        row[1] += value * b[1] + rate * b[0];
    }
}

/// Every number of `row` becomes a function of itself and those of two rows.
#[inline(always)]
pub(in crate::aft) fn set_rows<T: Real>(
    row: &mut [Chunk<T>],
    [a, b]: [&[Chunk<T>]; 2],
    f: impl Fn(T, T, T) -> T,
) {
    for (row, (a, b)) in row.iter_mut().zip(a.iter().zip(b)) {
        let mut new = *row;
        for l in 0..CHUNK {
            new[l] = f(new[l], a[l], b[l]);
        }
        *row = new;
    }
}

/// `row` += `factor` `x`.
#[inline(always)]
pub(in crate::aft) fn add_row<T: Real>(row: &mut [Chunk<T>], factor: T, x: &[Chunk<T>]) {
    set_rows(row, [x, x], |row, x, _| row + factor * x);
}

/// `row` = `factor` `row`.
#[inline(always)]
pub(in crate::aft) fn scale<T: Real>(row: &mut [Chunk<T>], factor: T) {
    for value in row.as_flattened_mut() {
        *value = factor * *value;
    }
}

/// Derivatives of the jumps at a kink: of the first and of the second derivative of the tractions.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct KinkRows<T> {
    pub jump: [Row<T>; 2],
    pub bend: [Row<T>; 2],
}

/// Products that wait to be added together.
const RANK: usize = 32;

/// Chunks of both tractions, side by side.
type Pair<T> = [T; 2 * CHUNK];

/// Derivative blocks under construction.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Blocks<T> {
    masks: MaskScratch<T>,
    /// Spectrum of the samples that stick. Shape: `[2][2H + 1]`.
    stick: Vec<T>,
    /// Weight of the next product. Shape: `[m]`.
    weight: Vec<T>,
    /// Products that wait to be added. Shape: `[m][RANK]`, `[width][RANK]`.
    weights: Vec<T>,
    rows: Vec<Pair<T>>,
    waiting: usize,
    /// Sum of the waiting products of one chunk. Shape: `[m]`.
    product: Vec<Pair<T>>,
    /// Derivatives of the force coefficients. Shape: `[width][m]`.
    sums: Vec<Pair<T>>,
    /// Row under construction for each traction.
    pub traction: [Row<T>; 2],
    pub kink: KinkRows<T>,
}

impl<T: Real> Blocks<T> {
    #[inline(always)]
    pub(in crate::aft) fn start(&mut self, plan: &AftPlan<T>) {
        let zero = [T::ZERO; 2 * CHUNK];
        clear(&mut self.stick, 2 * plan.n_mask_orders());
        self.weights.resize(RANK * plan.m, T::ZERO);
        self.rows.resize(RANK * width(plan), zero);
        self.product.resize(plan.m, zero);
        self.sums.clear();
        self.sums.resize(width(plan) * plan.m, zero);
        self.waiting = 0;
        let KinkRows { jump, bend } = &mut self.kink;
        for row in [&mut self.traction, jump, bend].into_iter().flatten() {
            row.clear();
            row.resize(width(plan), [T::ZERO; CHUNK]);
        }
    }

    /// Stick of the samples `range`: dT = k_t b − dz.
    #[inline(always)]
    pub(in crate::aft) fn stick<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        range: std::ops::Range<usize>,
        slider: &[Row<T>; 2],
    ) {
        let run = self.masks.run(plan, range.start, range.end);
        add_scaled(&mut self.stick, T::ONE, run);
        for (row, z) in self.traction.iter_mut().zip(slider) {
            set_rows(row, [z, z], |_, z, _| -z);
        }
        self.weight.clear();
        self.weight.extend_from_slice(self.masks.sums_of_run(plan));
        self.queue_traction(simd, plan);
    }

    /// Slip at sample i: dT = `turned` dφ + e dL.
    #[inline(always)]
    pub(in crate::aft) fn slip<S: Simd>(
        &mut self,
        simd: S,
        base: Base<T>,
        i: usize,
        angle: &Row<T>,
        turned: [T; 2],
        e: [T; 2],
    ) {
        let plan = base.plan;
        self.weight.clear();
        let weighted = plan.row(i).iter().zip(&plan.weight);
        self.weight.extend(weighted.map(|(&b, &w)| w * b));
        let friction = base.p.mu * base.p.k_n;
        let (b, _) = plan.wave(i);
        let normal = angle.len() - b.len();
        let targets = self.rows[self.waiting..].iter_mut().step_by(RANK);
        for (k, (target, angle)) in targets.zip(angle).enumerate() {
            let mut pair = [T::ZERO; 2 * CHUNK];
            for l in 0..CHUNK {
                pair[l] = turned[0] * angle[l];
                pair[CHUNK + l] = turned[1] * angle[l];
            }
            if k >= normal {
                let b = b[k - normal];
                for l in 0..CHUNK {
                    pair[l] += friction * e[0] * b[l];
                    pair[CHUNK + l] += friction * e[1] * b[l];
                }
            }
            *target = pair;
        }
        self.queue(simd, plan);
    }

    /// Adds (w ∘ b) ⊗ `traction`, with the derivative of b that has the factor 1.
    #[inline(always)]
    pub(in crate::aft) fn weigh<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        b: &[T],
        factors: [T; 3],
    ) {
        clear(&mut self.weight, plan.m);
        add_signal(plan, &mut self.weight, b, factors);
        for (weight, &w) in self.weight.iter_mut().zip(&plan.weight) {
            *weight = *weight * w;
        }
        self.queue_traction(simd, plan);
    }

    /// Puts the rows in `traction` next to the weights.
    #[inline(always)]
    fn queue_traction<S: Simd>(&mut self, simd: S, plan: &AftPlan<T>) {
        let [first, second] = &self.traction;
        let targets = self.rows[self.waiting..].iter_mut().step_by(RANK);
        for (target, (first, second)) in targets.zip(first.iter().zip(second)) {
            target[..CHUNK].copy_from_slice(first);
            target[CHUNK..].copy_from_slice(second);
        }
        self.queue(simd, plan);
    }

    /// Puts the weights next to the rows that were just written.
    #[inline(always)]
    fn queue<S: Simd>(&mut self, simd: S, plan: &AftPlan<T>) {
        let columns = self.weights[self.waiting..].iter_mut().step_by(RANK);
        for (target, &weight) in columns.zip(&self.weight) {
            *target = weight;
        }
        self.waiting += 1;
        if self.waiting == RANK {
            self.flush(simd, plan);
        }
    }

    /// Adds the waiting products to the sums.
    #[inline(always)]
    pub(in crate::aft) fn flush<S: Simd>(&mut self, simd: S, plan: &AftPlan<T>) {
        // Callers may be functions of their own, which are compiled for any processor.
        simd.vectorize(Flush { blocks: self, plan });
    }

    /// Adds what the start tractions contribute, whose derivatives by the displacement coefficients are `rows`.
    #[inline(always)]
    pub(in crate::aft) fn add_starts(&mut self, plan: &AftPlan<T>, [first, second]: &[Row<T>; 2]) {
        let (starts, sums) = self.sums.split_at_mut(plan.m);
        let rows = first[1..].iter().zip(&second[1..]);
        for (sums, (first, second)) in sums.chunks_exact_mut(plan.m).zip(rows) {
            for (sum, start) in sums.iter_mut().zip(&*starts) {
                let mut new = *sum;
                for l in 0..CHUNK {
                    new[l] += start[0] * first[l] + start[1] * second[l];
                    new[CHUNK + l] += start[CHUNK] * first[l] + start[CHUNK + 1] * second[l];
                }
                *sum = new;
            }
        }
    }

    /// Adds the sums and the samples that stick to the blocks.
    #[inline(always)]
    pub(in crate::aft) fn store(&self, base: Base<T>, out: &mut [T]) {
        let (m, n) = (base.plan.m, base.plan.n_chunks());
        let blocks = out
            .chunks_exact_mut(m * m)
            .zip(&TangentBlock::ALL[..TangentBlock::NN as usize]);
        for (out, block) in blocks {
            let (d, c) = (block.row_component(), block.column_component());
            let sums = &self.sums[(1 + c * n) * m..][..n * m];
            for (chunk, sums) in sums.chunks_exact(m).enumerate() {
                for (row, sum) in out.chunks_exact_mut(m).zip(sums) {
                    let columns = row[chunk * CHUNK..].iter_mut().take(CHUNK);
                    for (column, &sum) in columns.zip(&sum[d * CHUNK..]) {
                        *column += sum;
                    }
                }
            }
        }
        for (block, k) in [
            (TangentBlock::T1T1, base.p.k_t[0]),
            (TangentBlock::T2T2, base.p.k_t[1]),
        ] {
            let block = &mut out[block as usize * m * m..][..m * m];
            add_masked_gram(base.plan, &self.stick, k, block);
        }
    }
}

/// The arguments of [`Blocks::flush`].
struct Flush<'a, T> {
    blocks: &'a mut Blocks<T>,
    plan: &'a AftPlan<T>,
}

impl<T: Real> WithSimd for Flush<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { blocks, plan } = self;
        let waiting = std::mem::take(&mut blocks.waiting);
        for weights in blocks.weights.chunks_exact_mut(RANK) {
            weights[waiting..].fill(T::ZERO);
        }
        let rows = blocks.rows.chunks_exact_mut(RANK);
        for (rows, sums) in rows.zip(blocks.sums.chunks_exact_mut(plan.m)) {
            rows[waiting..].fill([T::ZERO; 2 * CHUNK]);
            T::table_product(simd, &blocks.weights, rows, &mut blocks.product, false);
            for (sum, product) in sums.iter_mut().zip(&blocks.product) {
                let mut new = *sum;
                for l in 0..2 * CHUNK {
                    new[l] += product[l];
                }
                *sum = new;
            }
        }
    }
}
