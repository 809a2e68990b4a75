//! The march around the period, for a handful of states at a time (vector lanes).

use super::batch::AftBatch;
use super::motions::{WORD, Word};
use super::plan::{AftPlan, POINTS};
use crate::contact::law::{
    anchored_at_closing, box_slider, box_step, circle_step, closing_instant, normal_force,
};
use crate::contact::{ContactParameters, Events, Real};
use pulp::Simd;
use std::ops::Range;

/// Traction that counts as rounding, in rounding errors of the largest |k_t u| + mu N of the period.
const TOLERANCE: f64 = 256.0;

/// States marched together.
pub(super) const LANES: usize = 8;

/// One number per state.
pub(super) type Lane<T> = [T; LANES];

/// One number per component and state, component by component.
pub(super) type Components<T> = [T; 3 * LANES];

/// Even or odd part of signals at a few points of the first half period, which stay in the first cache.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Points<T>([Components<T>; POINTS]);

impl<T: Real> Default for Points<T> {
    #[inline(always)]
    fn default() -> Self {
        Self([[T::ZERO; 3 * LANES]; POINTS])
    }
}

/// Everything known of one time point.
///
/// Aligned to the lines of the cache: a vector that crosses them takes two accesses.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub(super) struct Sample<T> {
    /// Tangential displacements (m).
    pub u: [Lane<T>; 2],
    /// Gap function n_0 + k_n v (N).
    pub gap: Lane<T>,
    /// Tractions (N).
    pub traction: [Lane<T>; 2],
}

impl<T: Real> Sample<T> {
    /// Normal force of one lane (N).
    #[inline(always)]
    pub(super) fn normal(&self, lane: usize) -> T {
        normal_force(self.gap[lane])
    }

    /// Displacements; the approach goes into `gap`.
    #[inline(always)]
    fn set_signals(&mut self, signals: Components<T>) {
        for l in 0..LANES {
            self.u[0][l] = signals[l];
            self.u[1][l] = signals[LANES + l];
            self.gap[l] = signals[2 * LANES + l];
        }
    }

    /// Tractions and normal force.
    #[inline(always)]
    fn forces(&self) -> Components<T> {
        let mut forces = [T::ZERO; 3 * LANES];
        for l in 0..LANES {
            forces[l] = self.traction[0][l];
            forces[LANES + l] = self.traction[1][l];
            forces[2 * LANES + l] = self.normal(l);
        }
        forces
    }
}

/// Contact parameters of the lanes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LaneParameters<T> {
    pub k_n: Lane<T>,
    pub n_0: Lane<T>,
    pub mu: Lane<T>,
    pub k_t: [Lane<T>; 2],
    /// 1/k_t, or 0 for an absent spring.
    pub flexibility: [Lane<T>; 2],
    pub anchor: [Lane<T>; 2],
}

impl<T: Real> LaneParameters<T> {
    /// Parameters of one lane.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize) -> ContactParameters<T> {
        ContactParameters {
            k_n: self.k_n[lane],
            k_t: [self.k_t[0][lane], self.k_t[1][lane]],
            mu: self.mu[lane],
            n_0: self.n_0[lane],
            anchor: [self.anchor[0][lane], self.anchor[1][lane]],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, p: &ContactParameters<T>) {
        self.k_n[lane] = p.k_n;
        self.n_0[lane] = p.n_0;
        self.mu[lane] = p.mu;
        for d in 0..2 {
            self.k_t[d][lane] = p.k_t[d];
            self.flexibility[d][lane] = if p.k_t[d] > T::ZERO {
                T::ONE / p.k_t[d]
            } else {
                T::ZERO
            };
            self.anchor[d][lane] = p.anchor[d];
        }
    }
}

/// What one lap counts, per state, as floating-point numbers (exact: at most 65536).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LapCount<T> {
    /// Samples that slip in at least one direction.
    pub slip: Lane<T>,
    /// 1 if a sample is at the upper or at the lower limit of a direction, else 0 (box law only).
    pub upper: [Lane<T>; 2],
    /// See `upper`.
    pub lower: [Lane<T>; 2],
    /// Square of the largest |T*| − L, by which a sample moves the slider (N², circle law only).
    pub way: Lane<T>,
}

/// Buffers of one group of lanes.
#[derive(Debug, Clone, Default)]
pub(super) struct Workspace<T> {
    /// Cosine coefficients (mean included) and sine coefficients. Shape: `[cosine]`, `[sine]`.
    cosines: Vec<Components<T>>,
    sines: Vec<Components<T>>,
    /// Shape: `[time]`.
    pub samples: Vec<Sample<T>>,
    pub parameters: LaneParameters<T>,
    /// Samples before which a contact of the lanes closes, if instants of closing are interpolated. Shape: `[word]`.
    closings: Vec<u64>,
    /// Motions of the samples. Shape: `[word]`.
    pub words: Vec<Word>,
    /// Samples out of contact.
    pub separated: Lane<T>,
    /// Largest traction that counts as rounding (N).
    pub tolerance: Lane<T>,
}

impl<T: Real> Workspace<T> {
    /// Reads the states from `first` on; lanes past the end repeat the last state.
    #[inline(always)]
    pub(super) fn load<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        batch: &AftBatch<T>,
        first: usize,
    ) {
        let (n, m) = (batch.n_states, plan.m);
        self.cosines.resize(m / 2 + 1, [T::ZERO; 3 * LANES]);
        self.sines.resize(m / 2, [T::ZERO; 3 * LANES]);
        for (c, rows) in batch.displacement.chunks_exact(m * n).enumerate() {
            for (j, values) in rows.chunks_exact(n).enumerate() {
                let target = if j % 2 == 1 || j == 0 {
                    &mut self.cosines[j.div_ceil(2)]
                } else {
                    &mut self.sines[j / 2 - 1]
                };
                let target = &mut target[c * LANES..][..LANES];
                if let Some(values) = values[first..].first_chunk::<LANES>() {
                    target.copy_from_slice(values);
                    continue;
                }
                for (l, target) in target.iter_mut().enumerate() {
                    *target = values[(first + l).min(n - 1)];
                }
            }
        }
        for l in 0..LANES {
            let state = (first + l).min(n - 1);
            self.parameters.set(l, &batch.parameters[state]);
        }
        self.samples.resize(plan.n_time(), Sample::default());
        self.words
            .resize(plan.n_time().div_ceil(WORD), Word::default());
        self.synthesize(simd, plan);
        self.close_gaps(plan.settings.events);
    }

    /// Displacements at all time points; the approach goes into `gap`.
    #[inline(always)]
    fn synthesize<S: Simd>(&mut self, simd: S, plan: &AftPlan<T>) {
        let (cosines, sines) = (&self.cosines, &self.sines);
        let samples = &mut self.samples;
        points(simd, plan, cosines, sines, |i, u| samples[i].set_signals(u));
    }

    /// Derivatives of the displacements by the phase at all time points, handed on as (point, values). The
    /// coefficients of the displacements are replaced.
    #[inline(always)]
    pub(super) fn synthesize_rates<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        emit: impl FnMut(usize, Components<T>),
    ) {
        self.cosines[0] = [T::ZERO; 3 * LANES];
        let pairs = self.cosines[1..].iter_mut().zip(&mut self.sines);
        for (&k, (cosine, sine)) in plan.orders[1..].iter().zip(pairs) {
            let k = T::from_f64(k as f64);
            for j in 0..3 * LANES {
                (cosine[j], sine[j]) = (k * sine[j], -(k * cosine[j]));
            }
        }
        points(simd, plan, &self.cosines, &self.sines, emit);
    }

    /// Gap functions, samples out of contact and samples that close.
    #[inline(always)]
    fn close_gaps(&mut self, events: Events) {
        let p = &self.parameters;
        let (mut first, mut second, mut normal) =
            ([T::ZERO; LANES], [T::ZERO; LANES], [T::ZERO; LANES]);
        let mut separated = [0; LANES];
        for (word, samples) in self.words.iter_mut().zip(self.samples.chunks_mut(WORD)) {
            let mut open = [0; LANES];
            for (i, s) in samples.iter_mut().enumerate() {
                let gap: Lane<T> = std::array::from_fn(|l| p.n_0[l] + p.k_n[l] * s.gap[l]);
                s.gap = gap;
                mark(&mut open, i, |l| gap[l] <= T::ZERO);
                for l in 0..LANES {
                    first[l] = first[l].or_larger(s.u[0][l].abs());
                    second[l] = second[l].or_larger(s.u[1][l].abs());
                    normal[l] = normal[l].or_larger(gap[l]);
                }
            }
            word.separated = open;
            for l in 0..LANES {
                separated[l] += open[l].count_ones();
            }
        }
        self.separated = separated.map(whole);
        for l in 0..LANES {
            let tangential = p.k_t[0][l] * first[l] + p.k_t[1][l] * second[l];
            let scale = tangential + p.mu[l] * normal[l];
            self.tolerance[l] = T::from_f64(TOLERANCE) * T::EPSILON * scale;
        }
        self.closings.clear();
        let last = (self.samples.len() - 1) % WORD;
        let mut before = self.words[self.words.len() - 1]
            .separated
            .map(|b| b >> last);
        for word in &self.words {
            let mut closings = 0;
            for (before, &open) in before.iter_mut().zip(&word.separated) {
                closings |= (open << 1 | *before & 1) & !open;
                *before = open >> (WORD - 1);
            }
            let interpolated = events == Events::Interpolated;
            self.closings.push(if interpolated { closings } else { 0 });
        }
    }

    /// Samples of a word before which a contact of the lanes closes; in the first lap none does before the first one.
    #[inline(always)]
    fn closings_of(&self, word: usize, first: bool) -> u64 {
        self.closings[word] & !u64::from(first && word == 0)
    }

    /// Whether a contact of the lanes closes just before the sample.
    #[inline(always)]
    fn closes(&self, sample: usize, first: bool) -> bool {
        self.closings_of(sample / WORD, first) >> (sample % WORD) & 1 == 1
    }

    /// Instant of closing since the sample before; 0 if the contact does not close, and for events at samples.
    #[inline(always)]
    pub(super) fn closing(&self, sample: usize, lane: usize, first: bool) -> T {
        if self.closes(sample, first) {
            closing_instant(
                self.before(sample).gap[lane],
                self.samples[sample].gap[lane],
            )
        } else {
            T::ZERO
        }
    }

    /// The sample before.
    #[inline(always)]
    fn before(&self, sample: usize) -> &Sample<T> {
        &self.samples[sample.checked_sub(1).unwrap_or(self.samples.len() - 1)]
    }

    /// One lap of the box law from the sliders `z` = k_t w (N), which end where the lap ends. Unless it is recorded, it
    /// leaves neither tractions nor motions, and of the counts `slip` tells only whether there is any.
    #[inline(always)]
    pub(super) fn box_lap<const RECORD: bool>(
        &mut self,
        z: &mut [Lane<T>; 2],
        first: bool,
    ) -> LapCount<T> {
        let mut slip = [0; LANES];
        let (mut upper, mut lower) = ([[0; LANES]; 2], [[0; LANES]; 2]);
        for w in 0..self.words.len() {
            // samples at the upper and at the lower limit
            let (mut above, mut below) = ([[0; LANES]; 2], [[0; LANES]; 2]);
            let mut closings = self.closings_of(w, first);
            // The sliders stay in registers over a stretch without closing.
            let mut start = w * WORD;
            let end = (start + WORD).min(self.samples.len());
            loop {
                let stop = (w * WORD + closings.trailing_zeros() as usize).min(end);
                self.box_stretch::<RECORD>(start..stop, z, &mut above, &mut below);
                if stop == end {
                    break;
                }
                self.anchor(stop, z);
                closings &= closings - 1;
                start = stop;
            }
            let word = &mut self.words[w];
            word.set_limits(above, below);
            for l in 0..LANES {
                slip[l] += word.slips(l);
                for d in 0..2 {
                    upper[d][l] |= above[d][l];
                    lower[d][l] |= below[d][l];
                }
            }
        }
        let some = |bits: [Lane<u64>; 2]| bits.map(|b| b.map(|b| flag(b != 0)));
        LapCount {
            slip: slip.map(whole),
            upper: some(upper),
            lower: some(lower),
            ..LapCount::default()
        }
    }

    /// The samples `stretch` of one word, between which no contact closes.
    #[allow(
        clippy::needless_range_loop,
        reason = "a plain loop over lanes becomes vector code"
    )]
    #[inline(always)]
    fn box_stretch<const RECORD: bool>(
        &mut self,
        stretch: Range<usize>,
        z: &mut [Lane<T>; 2],
        above: &mut [Lane<u64>; 2],
        below: &mut [Lane<u64>; 2],
    ) {
        let p = &self.parameters;
        let first = stretch.start % WORD;
        for (i, s) in self.samples[stretch].iter_mut().enumerate() {
            let limit: Lane<T> = std::array::from_fn(|l| p.mu[l] * s.normal(l));
            for d in 0..2 {
                let mut traction = [T::ZERO; LANES];
                for l in 0..LANES {
                    let path = p.k_t[d][l] * s.u[d][l];
                    (traction[l], z[d][l]) = if RECORD {
                        box_step(limit[l], path, z[d][l])
                    } else {
                        // not clipped, which the lap need not know
                        (path - z[d][l], box_slider(limit[l], path, z[d][l]))
                    };
                }
                if RECORD {
                    s.traction[d] = traction;
                    mark(&mut above[d], first + i, |l| traction[l] >= limit[l]);
                    mark(&mut below[d], first + i, |l| traction[l] <= -limit[l]);
                } else {
                    mark(&mut above[d], first + i, |l| traction[l].abs() >= limit[l]);
                }
            }
        }
    }

    /// Sliders `z` (N) of the contacts that close just before the sample.
    #[allow(
        clippy::needless_range_loop,
        reason = "a plain loop over lanes becomes vector code"
    )]
    #[inline(always)]
    fn anchor(&self, sample: usize, z: &mut [Lane<T>; 2]) {
        let (before, s) = (self.before(sample), &self.samples[sample]);
        for l in 0..LANES {
            let instant = closing_instant(before.gap[l], s.gap[l]);
            for d in 0..2 {
                let path = self.parameters.k_t[d][l] * s.u[d][l];
                z[d][l] = anchored_at_closing(z[d][l], path, instant);
            }
        }
    }

    /// Distance from the limit (N) within which a slider of the circle law touches it: a steady cycle is found to
    /// within the tolerance, so that its slider may stand off a limit that holds it by that much.
    #[inline(always)]
    pub(super) fn touch_margin(&self, lane: usize) -> T {
        self.tolerance[lane] + self.tolerance[lane]
    }

    /// One lap of the circle law from the sliders `w`, which end where the lap ends. `monodromy` (2 × 2, row-major) is
    /// multiplied by the derivative of the end traction by the start traction.
    #[inline(always)]
    pub(super) fn circle_lap(
        &mut self,
        w: &mut [Lane<T>; 2],
        monodromy: &mut [Lane<T>; 4],
        first: bool,
    ) -> LapCount<T> {
        let margin: Lane<T> = std::array::from_fn(|l| self.touch_margin(l));
        let p = &self.parameters;
        let mut count = LapCount::<T>::default();
        for i in 0..self.samples.len() {
            let closing: Option<Lane<T>> = self
                .closes(i, first)
                .then(|| std::array::from_fn(|l| self.closing(i, l, first)));
            let s = &mut self.samples[i];
            for l in 0..LANES {
                let u = [s.u[0][l], s.u[1][l]];
                let start = match closing {
                    Some(instant) => [
                        anchored_at_closing(w[0][l], u[0], instant[l]),
                        anchored_at_closing(w[1][l], u[1], instant[l]),
                    ],
                    None => [w[0][l], w[1][l]],
                };
                let k_t = [p.k_t[0][l], p.k_t[1][l]];
                let flexibility = [p.flexibility[0][l], p.flexibility[1][l]];
                let limit = p.mu[l] * s.normal(l);
                let step = circle_step(k_t, flexibility, (limit, margin[l]), u, start);
                [s.traction[0][l], s.traction[1][l]] = step.traction;
                [w[0][l], w[1][l]] = step.slider;
                let contact = s.gap[l] > T::ZERO;
                count.slip[l] += flag(step.slips & contact);
                let missing = T::ONE - step.ratio;
                let square = step.trial[0] * step.trial[0] + step.trial[1] * step.trial[1];
                count.way[l] = count.way[l].or_larger(missing * missing * square);
                // entry by entry: with a closure this loop is no vector code
                let factor = [
                    monodromy[0][l],
                    monodromy[1][l],
                    monodromy[2][l],
                    monodromy[3][l],
                ];
                let turned = slip_monodromy(step.trial, step.ratio, factor);
                for (entry, (&old, new)) in monodromy.iter_mut().zip(factor.iter().zip(turned)) {
                    let sliding = if step.touches { new } else { old };
                    entry[l] = if contact { sliding } else { T::ZERO };
                }
            }
        }
        count
    }

    /// Force coefficients, handed on as (component, coefficient, lanes); they replace those of the displacement.
    #[inline(always)]
    pub(super) fn analyse<S: Simd>(
        &mut self,
        simd: S,
        plan: &AftPlan<T>,
        mut emit: impl FnMut(usize, usize, &[T]),
    ) {
        let n = plan.n_time();
        let samples = self.samples.as_slice();
        let (mut even, mut odd) = (Points::default(), Points::default());
        for first in (0..=n / 2).step_by(POINTS) {
            let points = first..(first + POINTS).min(n / 2 + 1);
            let (even, odd) = (&mut even.0[..points.len()], &mut odd.0[..points.len()]);
            for (i, (even, odd)) in points.clone().zip(even.iter_mut().zip(&mut *odd)) {
                let after = samples[i].forces();
                let before = samples[if i == 0 { 0 } else { n - i }].forces();
                let (mut sum, mut difference) = (after, after);
                for j in 0..3 * LANES {
                    sum[j] += before[j];
                    difference[j] -= before[j];
                }
                (*even, *odd) = (sum, difference);
                // The point is its own mirror image.
                if i == 0 || 2 * i == n {
                    *even = after;
                }
            }
            for (weights, signal, out) in [
                (&plan.cosine_weights, even, &mut self.cosines),
                (&plan.sine_weights, odd, &mut self.sines),
            ] {
                let rows = out.len();
                let weights = &weights[first * rows..][..points.len() * rows];
                T::table_product(simd, weights, signal, out, first > 0);
            }
        }
        for c in 0..3 {
            for (k, values) in self.cosines.iter().enumerate() {
                emit(c, (2 * k).saturating_sub(1), &values[c * LANES..][..LANES]);
            }
            for (k, values) in self.sines.iter().enumerate() {
                emit(c, 2 * k + 2, &values[c * LANES..][..LANES]);
            }
        }
    }
}

/// Values at all points, handed on as (point, values), from the coefficients. Cosine and sine sums are shared by the
/// points ±θ.
#[inline(always)]
fn points<S: Simd, T: Real>(
    simd: S,
    plan: &AftPlan<T>,
    cosines: &[Components<T>],
    sines: &[Components<T>],
    mut emit: impl FnMut(usize, Components<T>),
) {
    let n = plan.n_time();
    let (mut even, mut odd) = (Points::default(), Points::default());
    for first in (0..=n / 2).step_by(POINTS) {
        let rows = first..(first + POINTS).min(n / 2 + 1);
        let (even, odd) = (&mut even.0[..rows.len()], &mut odd.0[..rows.len()]);
        let of_cosines = &plan.cosines[first * cosines.len()..][..rows.len() * cosines.len()];
        let of_sines = &plan.sines[first * sines.len()..][..rows.len() * sines.len()];
        T::table_product(simd, of_cosines, cosines, even, false);
        T::table_product(simd, of_sines, sines, odd, false);
        for (i, (even, odd)) in rows.zip(even.iter().zip(&*odd)) {
            let (mut before, mut after) = (*even, *even);
            for j in 0..3 * LANES {
                before[j] -= odd[j];
                after[j] += odd[j];
            }
            emit(if i == 0 { 0 } else { n - i }, before);
            emit(i, after);
        }
    }
}

/// Sets bit `i` of the lanes of which something holds.
#[inline(always)]
fn mark(bits: &mut Lane<u64>, i: usize, holds: impl Fn(usize) -> bool) {
    let bit = 1 << i;
    for (l, bits) in bits.iter_mut().enumerate() {
        *bits |= if holds(l) { bit } else { 0 };
    }
}

/// A number of samples.
#[inline(always)]
fn whole<T: Real>(count: u32) -> T {
    T::from_f64(f64::from(count))
}

/// 1 if `holds`, else 0.
#[inline(always)]
pub(super) fn flag<T: Real>(holds: bool) -> T {
    if holds { T::ONE } else { T::ZERO }
}

/// Derivative of a slip step, a p pᵀ, times the 2 × 2 matrix `factor`; p is normal to the trial traction.
#[inline(always)]
pub(super) fn slip_monodromy<T: Real>(trial: [T; 2], ratio: T, factor: [T; 4]) -> [T; 4] {
    let scale = ratio / (trial[0] * trial[0] + trial[1] * trial[1]);
    let normal = [-trial[1], trial[0]];
    let row = [
        scale * (normal[0] * factor[0] + normal[1] * factor[2]),
        scale * (normal[0] * factor[1] + normal[1] * factor[3]),
    ];
    [
        normal[0] * row[0],
        normal[0] * row[1],
        normal[1] * row[0],
        normal[1] * row[1],
    ]
}
