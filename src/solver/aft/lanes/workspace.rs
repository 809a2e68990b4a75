//! Signals, motions and tractions of a group of lanes around the period.

use super::lane::{Components, LANES, Lane};
use super::motions::{WORD, Word};
use super::sample::{LaneParameters, Sample};
use crate::aft::batch::AftBatch;
use crate::aft::plan::{AftPlan, POINTS};
use crate::contact::law::closing_instant;
use crate::contact::{Events, Real};
use pulp::Simd;

/// Traction that counts as rounding, in rounding errors of the largest |k_t u| + mu N of the period.
const TOLERANCE: f64 = 256.0;

/// Largest friction limit of the period, in rounding errors of the largest |k_t u|, below which there is no friction: the travel of the slider
/// would be lost in the round-off of the displacement.
const LOST: f64 = 4.0;

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

/// Whether anything was marched before a lap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::aft) enum LapPosition {
    First,
    Later,
}

/// What one lap counts, per state, as floating-point numbers (exact: at most 65536).
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::aft) struct LapCount<T> {
    /// Samples that slip in at least one direction.
    pub slip: Lane<T>,
    /// 1 if a sample is at the upper or at the lower limit of a direction, else 0 (box law only).
    pub upper: [Lane<T>; 2],
    /// See `upper`.
    pub lower: [Lane<T>; 2],
    /// Square of the largest |T*| − L, by which a sample moves the slider (N², circle law only).
    pub largest_slip_squared: Lane<T>,
}

/// Buffers of one group of lanes.
#[derive(Debug, Clone, Default)]
pub(in crate::aft) struct Workspace<T> {
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
    pub(in crate::aft) fn load<S: Simd>(
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
    pub(in crate::aft) fn synthesize_rates<S: Simd>(
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
            let p = &mut self.parameters;
            let tangential = p.k_t[0][l] * first[l] + p.k_t[1][l] * second[l];
            let limit = p.mu[l] * normal[l];
            self.tolerance[l] = T::from_f64(TOLERANCE) * T::EPSILON * (tangential + limit);
            if limit > T::ZERO && limit < T::from_f64(LOST) * T::EPSILON * tangential {
                p.mu[l] = T::ZERO;
            }
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
    pub(in crate::aft) fn closings_of(&self, word: usize, lap: LapPosition) -> u64 {
        self.closings[word] & !u64::from(lap == LapPosition::First && word == 0)
    }

    /// Whether a contact of the lanes closes just before the sample.
    #[inline(always)]
    pub(in crate::aft) fn closes(&self, sample: usize, lap: LapPosition) -> bool {
        self.closings_of(sample / WORD, lap) >> (sample % WORD) & 1 == 1
    }

    /// Instant of closing since the sample before, as a share of the interval, 0 to 1; 0 if the contact does not close, and where events are
    /// not interpolated.
    #[inline(always)]
    pub(in crate::aft) fn closing(&self, sample: usize, lane: usize, lap: LapPosition) -> T {
        if self.closes(sample, lap) {
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
    pub(in crate::aft) fn before(&self, sample: usize) -> &Sample<T> {
        &self.samples[sample.checked_sub(1).unwrap_or(self.samples.len() - 1)]
    }

    /// Distance from the limit (N) within which a slider of the circle law touches it: a steady cycle is found to
    /// within the tolerance, so that its slider may stand off a limit that holds it by that much.
    #[inline(always)]
    pub(in crate::aft) fn touch_margin(&self, lane: usize) -> T {
        self.tolerance[lane] + self.tolerance[lane]
    }

    /// Force coefficients, handed on as (component, coefficient, lanes); they replace those of the displacement.
    #[inline(always)]
    pub(in crate::aft) fn analyse<S: Simd>(
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
pub(in crate::aft) fn mark(bits: &mut Lane<u64>, i: usize, holds: impl Fn(usize) -> bool) {
    let bit = 1 << i;
    for (l, bits) in bits.iter_mut().enumerate() {
        *bits |= if holds(l) { bit } else { 0 };
    }
}

/// A number of samples.
#[inline(always)]
pub(in crate::aft) fn whole<T: Real>(count: u32) -> T {
    T::from_f64(f64::from(count))
}

/// 1 if `holds`, else 0.
#[inline(always)]
pub(in crate::aft) fn flag<T: Real>(holds: bool) -> T {
    if holds { T::ONE } else { T::ZERO }
}
