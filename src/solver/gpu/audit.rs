//! What the processor does beside the device in the self-test, and which share of the peaks it searches again.

use crate::aft::{AftBatch, AftForces, AftPlan, AftScratch, Tangent, TangentBlock, Want, evaluate};

/// Forces and tangents of the states that the device did not decide.
pub(super) fn decide(
    plan: &AftPlan<f64>,
    batch: &AftBatch<f64>,
    states: &[usize],
    out: &mut AftForces<f64>,
) {
    if states.is_empty() {
        return;
    }
    let n = batch.n_states;
    let rows = batch.displacement.chunks_exact(n);
    let few = AftBatch {
        n_states: states.len(),
        displacement: rows
            .flat_map(|row| states.iter().map(|&i| row[i]))
            .collect(),
        parameters: states.iter().map(|&i| batch.parameters[i]).collect(),
    };
    let mut decided = AftForces::default();
    let scratch = &mut AftScratch::default();
    evaluate(plan, &few, Want::ForcesAndTangents, scratch, &mut decided);
    let rows = decided.forces.chunks_exact(states.len());
    for (row, values) in out.forces.chunks_exact_mut(n).zip(rows) {
        states.iter().zip(values).for_each(|(&i, &f)| row[i] = f);
    }
    let size = TangentBlock::COUNT * plan.n_coefficients() * plan.n_coefficients();
    for (k, &i) in states.iter().enumerate() {
        out.summaries[i] = decided.summaries[k];
        out.tangents[i] = match decided.tangents[k] {
            Tangent::Stuck => Tangent::Stuck,
            Tangent::Blocks(from) => {
                let offset = out.blocks.len();
                out.blocks
                    .extend_from_slice(&decided.blocks[from..][..size]);
                Tangent::Blocks(offset)
            }
        };
    }
}

/// Whether a share of all lists of numbers holds this one: by a hash of its numbers, so that neither time nor the order of samples
/// decides (FNV-1a over words, finished by a multiplication that spreads the last ones).
pub(super) fn chosen(numbers: &[f64], share: f64) -> bool {
    let mix = |hash: u64, x: &f64| (hash ^ x.to_bits()).wrapping_mul(0x0100_0000_01b3);
    let hash = numbers.iter().fold(0xcbf2_9ce4_8422_2325, mix);
    let spread = (hash ^ (hash >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((spread >> 11) as f64) < share * (1u64 << 53) as f64
}

/// Largest differences of forces, over the state's largest force that its motion could cause, and of derivatives, over
/// its largest stiffness.
pub(super) fn differences(
    batch: &AftBatch<f64>,
    found: &AftForces<f64>,
    exact: &AftForces<f64>,
) -> [f64; 2] {
    let (n, m) = (exact.n_states, exact.n_coefficients);
    let mut out = [0.0f64; 2];
    let worse = |most: f64, x: f64| if x <= most { most } else { x };
    for (i, p) in batch.parameters.iter().enumerate() {
        let k = [p.k_t[0], p.k_t[1], p.k_n];
        let column = |x: &[f64], row: usize| x[row * n + i];
        let rows = 0..3 * m;
        let scale = (rows.clone())
            .map(|row| (k[row / m] * column(&batch.displacement, row)).abs())
            .fold(p.n_0.abs(), f64::max);
        for row in rows {
            let difference = column(&found.forces, row) - column(&exact.forces, row);
            out[0] = worse(out[0], difference.abs() / scale.max(f64::MIN_POSITIVE));
        }
        let stiffness = k.into_iter().fold(f64::MIN_POSITIVE, f64::max);
        out[1] = worse(out[1], tangent_difference(i, found, exact, k) / stiffness);
    }
    out
}

/// Largest difference of the entries of the tangents of one state.
fn tangent_difference(
    i: usize,
    found: &AftForces<f64>,
    exact: &AftForces<f64>,
    k: [f64; 3],
) -> f64 {
    let m = exact.n_coefficients;
    let entry = |of: &AftForces<f64>, block: TangentBlock, a: usize, b: usize| match of.tangents[i]
    {
        Tangent::Blocks(offset) => of.block(offset, block)[a * m + b],
        Tangent::Stuck if a == b && block.row_component() == block.column_component() => {
            k[block.row_component()]
        }
        Tangent::Stuck => 0.0,
    };
    let mut most = 0.0f64;
    for block in TangentBlock::ALL {
        for (a, b) in (0..m).flat_map(|a| (0..m).map(move |b| (a, b))) {
            most = most.max((entry(found, block, a, b) - entry(exact, block, a, b)).abs());
        }
    }
    most
}
