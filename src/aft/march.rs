//! The march around the period, for a handful of states at a time (vector lanes).

use super::batch::AftBatch;
use super::plan::AftPlan;
use crate::contact::law::{
    anchored_at_closing, box_step, circle_step, closing_instant, normal_force,
};
use crate::contact::{ContactParameters, Real, Recontact};

/// States marched together.
pub(super) const LANES: usize = 8;

/// One number per state.
pub(super) type Lane<T> = [T; LANES];

/// Everything known of one time point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sample<T> {
    /// Tangential displacements (m).
    pub u: [Lane<T>; 2],
    /// Gap function n_0 + k_n v (N).
    pub gap: Lane<T>,
    /// Normal force (N).
    pub normal: Lane<T>,
    /// Instant of closing since the point before (0 at other points, and for anchors at samples).
    pub closing: Lane<T>,
    /// Tractions (N).
    pub traction: [Lane<T>; 2],
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
    pub(super) fn of(&self, lane: usize) -> ContactParameters<T> {
        ContactParameters {
            k_n: self.k_n[lane],
            k_t: [self.k_t[0][lane], self.k_t[1][lane]],
            mu: self.mu[lane],
            n_0: self.n_0[lane],
            anchor: [self.anchor[0][lane], self.anchor[1][lane]],
        }
    }

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
    /// Samples at the upper and at the lower limit of each direction (box law only).
    pub upper: [Lane<T>; 2],
    /// See `upper`.
    pub lower: [Lane<T>; 2],
    /// Largest 1 − L/|T*|: how far the contact slips at most (circle law only).
    pub overshoot: Lane<T>,
}

/// Buffers of one group of lanes.
#[derive(Debug, Clone, Default)]
pub(super) struct Workspace<T> {
    /// Displacement coefficients. Shape: `[3][coefficient]`.
    coefficients: Vec<Lane<T>>,
    /// Shape: `[time]`.
    pub samples: Vec<Sample<T>>,
    pub parameters: LaneParameters<T>,
    /// Instant of closing from the last point to the first one of the next lap.
    pub closing_over_end: Lane<T>,
    /// Samples out of contact.
    pub separated: Lane<T>,
    /// Largest |k_t u| + mu N of the period: scale of rounding errors of the tractions (N).
    pub scale: Lane<T>,
    /// Sums and differences of a signal at ±θ. Shape: `[2][Nt/2 + 1]`.
    folded: Vec<Lane<T>>,
}

impl<T: Real> Workspace<T> {
    /// Reads the states from `first` on; lanes past the end repeat the last state.
    pub(super) fn load(&mut self, plan: &AftPlan<T>, batch: &AftBatch<T>, first: usize) {
        let n = batch.n_states;
        self.coefficients.clear();
        for row in batch.displacement.chunks_exact(n) {
            let lane = std::array::from_fn(|l| row[(first + l).min(n - 1)]);
            self.coefficients.push(lane);
        }
        for l in 0..LANES {
            let state = (first + l).min(n - 1);
            self.parameters.set(l, &batch.parameters[state]);
        }
        self.samples.resize(plan.n_time(), Sample::default());
        self.synthesize(plan);
        self.close_gaps(plan.settings.recontact);
    }

    /// Displacements at all time points; the approach goes into `gap`. Points ±θ share cosine and sine sums.
    fn synthesize(&mut self, plan: &AftPlan<T>) {
        let (n, m) = (plan.n_time(), plan.m);
        for i in 0..=n / 2 {
            let row = plan.row(i);
            let mirror = (n - i) % n;
            for (c, q) in self.coefficients.chunks_exact(m).enumerate() {
                let (even, odd) = cosine_and_sine_sums(row, q);
                let (plus, minus) = (
                    std::array::from_fn(|l| even[l] + odd[l]),
                    std::array::from_fn(|l| even[l] - odd[l]),
                );
                *component(&mut self.samples[mirror], c) = minus;
                *component(&mut self.samples[i], c) = plus;
            }
        }
    }

    /// Gap functions, normal forces and instants of closing.
    fn close_gaps(&mut self, recontact: Recontact) {
        let p = self.parameters;
        let gap = |v: &Lane<T>| std::array::from_fn(|l| p.n_0[l] + p.k_n[l] * v[l]);
        let mut before = [T::ONE; LANES];
        self.separated = [T::ZERO; LANES];
        self.scale = [T::ZERO; LANES];
        for s in &mut self.samples {
            s.gap = gap(&s.gap);
            for l in 0..LANES {
                s.normal[l] = normal_force(s.gap[l]);
                s.closing[l] = T::ZERO;
                self.separated[l] += flag(s.gap[l] <= T::ZERO);
                let size = (p.k_t[0][l] * s.u[0][l]).abs()
                    + (p.k_t[1][l] * s.u[1][l]).abs()
                    + p.mu[l] * s.normal[l];
                self.scale[l] = self.scale[l].or_larger(size);
            }
        }
        self.closing_over_end = [T::ZERO; LANES];
        if recontact == Recontact::Interpolated {
            for s in &mut self.samples {
                s.closing = instants(&before, &s.gap);
                before = s.gap;
            }
            self.closing_over_end = instants(&before, &self.samples[0].gap);
        }
    }

    /// One lap of the box law from the sliders `w`, which end where the lap ends.
    #[allow(
        clippy::needless_range_loop,
        reason = "a plain loop over lanes becomes vector code"
    )]
    pub(super) fn box_lap(&mut self, w: &mut [Lane<T>; 2]) -> LapCount<T> {
        let p = &self.parameters;
        let mut count = LapCount::<T>::default();
        for s in &mut self.samples {
            for l in 0..LANES {
                let limit = p.mu[l] * s.normal[l];
                let mut at_limit = [(false, false); 2];
                for d in 0..2 {
                    let u = s.u[d][l];
                    let start = anchored_at_closing(w[d][l], u, s.closing[l]);
                    let (traction, slider) =
                        box_step(p.k_t[d][l], p.flexibility[d][l], limit, u, start);
                    s.traction[d][l] = traction;
                    w[d][l] = slider;
                    at_limit[d] = (traction >= limit, traction <= -limit);
                    count.upper[d][l] += flag(at_limit[d].0);
                    count.lower[d][l] += flag(at_limit[d].1);
                }
                let slips = at_limit[0].0 | at_limit[0].1 | at_limit[1].0 | at_limit[1].1;
                count.slip[l] += flag(slips & (s.gap[l] > T::ZERO));
            }
        }
        count
    }

    /// One lap of the circle law from the sliders `w`, which end where the lap ends. If wanted, `monodromy`
    /// (2 × 2, row-major) is multiplied by the derivative of the end traction by the start traction.
    pub(super) fn circle_lap<const MONODROMY: bool>(
        &mut self,
        w: &mut [Lane<T>; 2],
        monodromy: &mut [Lane<T>; 4],
    ) -> LapCount<T> {
        let p = &self.parameters;
        let mut count = LapCount::<T>::default();
        for s in &mut self.samples {
            for l in 0..LANES {
                let u = [s.u[0][l], s.u[1][l]];
                let start = [
                    anchored_at_closing(w[0][l], u[0], s.closing[l]),
                    anchored_at_closing(w[1][l], u[1], s.closing[l]),
                ];
                let k_t = [p.k_t[0][l], p.k_t[1][l]];
                let flexibility = [p.flexibility[0][l], p.flexibility[1][l]];
                let limit = p.mu[l] * s.normal[l];
                let step = circle_step(k_t, flexibility, limit, u, start);
                [s.traction[0][l], s.traction[1][l]] = step.traction;
                [w[0][l], w[1][l]] = step.slider;
                let contact = s.gap[l] > T::ZERO;
                count.slip[l] += flag(step.slips & contact);
                count.overshoot[l] = count.overshoot[l].or_larger(T::ONE - step.ratio);
                if MONODROMY {
                    let factor = [
                        monodromy[0][l],
                        monodromy[1][l],
                        monodromy[2][l],
                        monodromy[3][l],
                    ];
                    let turned = slip_monodromy(step.trial, step.ratio, factor);
                    for (entry, (&old, new)) in monodromy.iter_mut().zip(factor.iter().zip(turned))
                    {
                        let sliding = if step.touches { new } else { old };
                        entry[l] = if contact { sliding } else { T::ZERO };
                    }
                }
            }
        }
        count
    }

    /// Force coefficients of component `c` (0, 1 = tractions, 2 = normal force), handed on as (coefficient, lanes).
    pub(super) fn analyse(
        &mut self,
        plan: &AftPlan<T>,
        c: usize,
        mut emit: impl FnMut(usize, Lane<T>),
    ) {
        let n = plan.n_time();
        let half = n / 2 + 1;
        self.folded.resize(2 * half, [T::ZERO; LANES]);
        let (sums, differences) = self.folded.split_at_mut(half);
        for (i, (sum, difference)) in sums.iter_mut().zip(differences.iter_mut()).enumerate() {
            let (a, b) = (
                force(&self.samples[i], c),
                force(&self.samples[(n - i) % n], c),
            );
            let alone = i == 0 || 2 * i == n;
            *sum = std::array::from_fn(|l| if alone { a[l] } else { a[l] + b[l] });
            *difference = std::array::from_fn(|l| if alone { T::ZERO } else { a[l] - b[l] });
        }
        for (j, weights) in plan.analysis.chunks_exact(half).enumerate() {
            let signal = if j % 2 == 1 || j == 0 {
                &*sums
            } else {
                &*differences
            };
            let mut total = [T::ZERO; LANES];
            for (&weight, value) in weights.iter().zip(signal) {
                for l in 0..LANES {
                    total[l] += weight * value[l];
                }
            }
            emit(j, total);
        }
    }
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

fn instants<T: Real>(before: &Lane<T>, gap: &Lane<T>) -> Lane<T> {
    std::array::from_fn(|l| closing_instant(before[l], gap[l]))
}

fn component<T>(sample: &mut Sample<T>, c: usize) -> &mut Lane<T> {
    match c {
        0 | 1 => &mut sample.u[c],
        _ => &mut sample.gap,
    }
}

fn force<T>(sample: &Sample<T>, c: usize) -> &Lane<T> {
    match c {
        0 | 1 => &sample.traction[c],
        _ => &sample.normal,
    }
}

/// Σ over the mean and the cosines, and Σ over the sines, of basis value times coefficient.
#[inline(always)]
fn cosine_and_sine_sums<T: Real>(row: &[T], q: &[Lane<T>]) -> (Lane<T>, Lane<T>) {
    let mut even = q[0];
    let mut odd = [T::ZERO; LANES];
    for (b, q) in row[1..].chunks_exact(2).zip(q[1..].chunks_exact(2)) {
        for l in 0..LANES {
            even[l] += b[0] * q[0][l];
            odd[l] += b[1] * q[1][l];
        }
    }
    (even, odd)
}
