//! Contact states in the units of the shaders, and forces back from them.
//!
//! A state goes down as forces over its own scale, a power of two: the stick signals k_t u of both directions without
//! their means, which only shift the anchors, and the gap function n_0 + k_n v. The static offsets are folded in here, in
//! double precision, so that small vibrations around large static loads lose nothing. Back come deviations from the
//! stuck contact, exactly zero for a pair that never moves but for its mean traction.

use crate::aft::AftBatch;
use crate::aft::AftPlan;
use crate::aft::{AftForces, Periodicity, StateCounts, StateSummary, Tangent, TangentBlock};

/// States in the units of the shaders.
#[derive(Debug, Clone)]
pub struct ScaledStates {
    /// Number of states.
    pub n_states: usize,
    /// Shape: `[3][harmonic][cos, sin][state]`.
    pub coefficients: Vec<f64>,
    /// Friction coefficient, mean of the gap function, anchors. Shape: `[4][state]`.
    pub constants: Vec<f64>,
    /// Force (N) that counts as 1. Shape: `[state]`.
    scale: Vec<f64>,
}

/// What the shaders say of the same states.
#[derive(Debug, Clone, Default)]
pub struct ScaledForces {
    /// Force less that of the stuck contact. Shape: `[3][coefficient][state]`.
    pub deviations: Vec<f64>,
    /// Place among the states that move; `None` = stuck. Shape: `[state]`.
    pub slots: Vec<Option<usize>>,
    /// Derivatives by the signals less those of the stuck contact; empty if not asked for.
    /// Shape: `[slot][block of blocks][m][m]`.
    pub tangents: Vec<f64>,
    /// States that the device did not decide, ascending; their numbers mean nothing.
    pub undecided: Vec<usize>,
    /// Number of states with a place.
    pub n_moving: usize,
    /// Which blocks the tangents have; the others are zero.
    pub blocks: &'static [TangentBlock],
}

impl ScaledStates {
    /// `None` if a number is not finite.
    #[must_use]
    pub fn new(batch: &AftBatch<f64>) -> Option<Self> {
        let n = batch.n_states;
        let m = batch.displacement.len() / (3 * n.max(1));
        let mut scaled = Self {
            n_states: n,
            coefficients: vec![0.0; 3 * (m - 1) * n],
            constants: vec![0.0; 4 * n],
            scale: vec![1.0; n],
        };
        for (i, p) in batch.parameters.iter().enumerate() {
            let k = [p.k_t[0], p.k_t[1], p.k_n];
            let q = |c: usize, j: usize| batch.displacement[(c * m + j) * n + i];
            let forces = |c: usize| (1..m).map(move |j| k[c] * q(c, j));
            let gap = p.n_0 + p.k_n * q(2, 0);
            let anchors = [0, 1].map(|d| p.k_t[d] * (p.anchor[d] - q(d, 0)));
            let largest = ((0..3).flat_map(forces))
                .chain([gap, anchors[0], anchors[1]])
                .fold(
                    0.0,
                    |most: f64, f| if f.abs() <= most { most } else { f.abs() },
                );
            if !largest.is_finite() || !p.mu.is_finite() {
                return None;
            }
            let scale = power_of_two(largest);
            for c in 0..3 {
                for (j, force) in forces(c).enumerate() {
                    scaled.coefficients[(c * (m - 1) + j) * n + i] = force / scale;
                }
            }
            for (row, value) in [p.mu, gap / scale, anchors[0] / scale, anchors[1] / scale]
                .into_iter()
                .enumerate()
            {
                scaled.constants[row * n + i] = value;
            }
            scaled.scale[i] = scale;
        }
        Some(scaled)
    }

    /// Total forces and tangents of `batch`, which these states were made from.
    ///
    /// The summaries are coarse: a state that moves counts as slipping all the time.
    pub fn unscale(
        &self,
        plan: &AftPlan<f64>,
        batch: &AftBatch<f64>,
        scaled: &ScaledForces,
        out: &mut AftForces<f64>,
    ) {
        out.reset(plan, batch);
        let (n, m) = (batch.n_states, plan.n_coefficients());
        for (row, deviations) in scaled.deviations.chunks_exact(n).enumerate() {
            let (c, j) = (row / m, row % m);
            for (i, deviation) in deviations.iter().enumerate() {
                let p = &batch.parameters[i];
                let q = batch.displacement[row * n + i];
                let stuck = match (c, j) {
                    (2, 0) => p.n_0 + p.k_n * q,
                    (2, _) => p.k_n * q,
                    (_, 0) => 0.0,
                    (d, _) => p.k_t[d] * q,
                };
                out.forces[row * n + i] = stuck + self.scale[i] * deviation;
            }
        }
        let all = StateCounts::new(plan.n_time(), 0, 0).stick;
        for slot in &scaled.slots {
            let slip = if slot.is_some() { all } else { 0 };
            out.summaries.push(StateSummary {
                counts: StateCounts::new(plan.n_time(), slip, 0),
                laps: 2,
                periodicity: Periodicity::DependsOnAnchor,
            });
        }
        if !scaled.tangents.is_empty() || scaled.slots.iter().all(Option::is_none) {
            self.unscale_tangents(batch, scaled, m, out);
        }
    }

    fn unscale_tangents(
        &self,
        batch: &AftBatch<f64>,
        scaled: &ScaledForces,
        m: usize,
        out: &mut AftForces<f64>,
    ) {
        let size = m * m;
        for (slot, p) in scaled.slots.iter().zip(&batch.parameters) {
            let Some(slot) = slot else {
                out.tangents.push(Tangent::Stuck);
                continue;
            };
            let offset = out.blocks.len();
            out.tangents.push(Tangent::Blocks(offset));
            out.blocks.resize(offset + TangentBlock::COUNT * size, 0.0);
            let blocks = &mut out.blocks[offset..];
            let values = scaled.tangents[slot * scaled.blocks.len() * size..].chunks_exact(size);
            for (&block, values) in scaled.blocks.iter().zip(values) {
                let k = [p.k_t[0], p.k_t[1], p.k_n][block.column_component()];
                let target = &mut blocks[block as usize * size..][..size];
                (target.iter_mut().zip(values)).for_each(|(t, v)| *t = k * v);
                if block.row_component() == block.column_component() {
                    (0..m).for_each(|a| target[a * m + a] += k);
                }
            }
        }
    }
}

/// The smallest power of two above `x` > 0; 1 for 0.
fn power_of_two(x: f64) -> f64 {
    match x {
        0.0 => 1.0,
        x => x.log2().floor().exp2() * 2.0,
    }
}
