//! Is it the same algorithm, and is it precise enough?

use crate::device;
use crate::states::{located, random};
use microslip::aft::gpu::{Device, Kernels, Precision, ScaledForces, ScaledStates, Shape};
use microslip::aft::{AftBatch, AftForces, Block, Tangent, Want, evaluate};
use microslip::contact::{ContactParameters, Real};
use microslip::harmonics::HarmonicSet;

/// Forces and tangents of one state, the former over the largest force of the state, the latter over the stiffness.
struct Answer {
    forces: Vec<f64>,
    /// Largest force that the motion could have caused.
    scale: f64,
    /// Seven blocks; those of the stuck contact where it sticks.
    tangent: Vec<f64>,
    /// Largest stiffness.
    stiffness: f64,
    stuck: bool,
}

fn on_device(
    device: &Device,
    set: &HarmonicSet,
    n_time: usize,
    precision: Precision,
    scaled: &ScaledStates,
) -> ScaledForces {
    let shape =
        Shape::of(&located::<f64>(set, n_time), precision).expect("the box law has a shader");
    let kernels = Kernels::new(device, shape).expect("the shader compiles");
    let buffers = kernels
        .buffers(device, scaled.n_states)
        .expect("memory suffices");
    let result = kernels
        .evaluate(device, &buffers, &[scaled], Want::ForcesAndTangents)
        .expect("it runs");
    result
        .parts
        .into_iter()
        .next()
        .flatten()
        .expect("no state overflows")
}

/// The scaled states as states of unit stiffness, for the law in any precision.
fn unit_states<T: Real>(scaled: &ScaledStates) -> AftBatch<T> {
    let n = scaled.n_states;
    let m = scaled.coefficients.len() / (3 * n) + 1;
    let cast = T::from_f64;
    let mut displacement = vec![T::ZERO; 3 * m * n];
    for c in 0..3 {
        let from = &scaled.coefficients[c * (m - 1) * n..][..(m - 1) * n];
        let to = &mut displacement[(c * m + 1) * n..][..(m - 1) * n];
        to.iter_mut().zip(from).for_each(|(t, f)| *t = cast(*f));
    }
    let parameters = (0..n)
        .map(|i| {
            let constant = |row: usize| cast(scaled.constants[row * n + i]);
            ContactParameters {
                k_n: T::ONE,
                k_t: [T::ONE; 2],
                mu: constant(0),
                n_0: constant(1),
                anchor: [constant(2), constant(3)],
            }
        })
        .collect();
    AftBatch {
        n_states: n,
        displacement,
        parameters,
    }
}

fn answers<T: Real>(out: &AftForces<T>, batch: &AftBatch<T>) -> Vec<Answer> {
    let m = out.n_coefficients;
    (0..out.n_states)
        .map(|i| {
            let forces: Vec<f64> = out.forces[i..]
                .iter()
                .step_by(out.n_states)
                .map(|f| f.to_f64())
                .collect();
            let p = &batch.parameters[i];
            let (stuck, tangent) = match out.tangents[i] {
                Tangent::Stuck => {
                    let mut blocks = vec![0.0; Block::COUNT * m * m];
                    for (block, k) in [
                        (Block::T1T1, p.k_t[0]),
                        (Block::T2T2, p.k_t[1]),
                        (Block::NN, p.k_n),
                    ] {
                        (0..m)
                            .for_each(|a| blocks[block as usize * m * m + a * m + a] = k.to_f64());
                    }
                    (true, blocks)
                }
                Tangent::Blocks(offset) => {
                    let blocks = &out.blocks[offset..][..Block::COUNT * m * m];
                    (false, blocks.iter().map(|x| x.to_f64()).collect())
                }
            };
            let k = [p.k_t[0].to_f64(), p.k_t[1].to_f64(), p.k_n.to_f64()];
            let q = batch.displacement[i..]
                .iter()
                .step_by(batch.n_states)
                .enumerate();
            let scale = q
                .map(|(j, q)| (k[j / m] * q.to_f64()).abs())
                .fold(p.n_0.to_f64().abs(), f64::max);
            Answer {
                forces,
                scale,
                tangent,
                stiffness: largest(&k),
                stuck,
            }
        })
        .collect()
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |a, x| a.max(x.abs()))
}

/// Largest differences of forces and tangents, each over the largest entry, per state, ascending.
fn differences(found: &[Answer], expected: &[Answer]) -> [Vec<f64>; 2] {
    let relative = |a: &[f64], b: &[f64], scale: f64| {
        let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        largest(&difference) / scale
    };
    let sorted = |f: &dyn Fn(&Answer, &Answer) -> f64| {
        let mut all: Vec<f64> = found.iter().zip(expected).map(|(a, b)| f(a, b)).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    [
        sorted(&|a, b| relative(&a.forces, &b.forces, b.scale)),
        sorted(&|a, b| relative(&a.tangent, &b.tangent, b.stiffness)),
    ]
}

fn report(name: &str, h: usize, [forces, tangents]: &[Vec<f64>; 2]) {
    let n = forces.len();
    let at = |x: &[f64]| {
        format!(
            "median {:.1e} p99 {:.1e} max {:.1e}",
            x[n / 2],
            x[n * 99 / 100],
            x[n - 1]
        )
    };
    eprintln!(
        "{name}, H = {h}: forces {}; tangents {}",
        at(forces),
        at(tangents)
    );
}

#[test]
fn shader_f32() {
    shader_against_the_same_law(Precision::F32);
}
#[test]
fn shader_f64() {
    shader_against_the_same_law(Precision::F64);
}

fn shader_against_the_same_law(precision: Precision) {
    {
        let Some(device) = device("shader_against_the_same_law", precision) else {
            return;
        };
        for (h, n_time) in [(1, 64), (3, 128), (5, 128), (7, 128)] {
            let set = HarmonicSet::up_to(h);
            let batch = random(&set, 512, 7);
            let scaled = ScaledStates::new(&batch).unwrap();
            let raw = on_device(&device, &set, n_time, precision, &scaled);
            let plan = located::<f64>(&set, n_time);
            let mut out = AftForces::default();
            scaled.unscale(&plan, &batch, &raw, &mut out);
            let found = answers(&out, &batch);
            let mut exact = AftForces::default();
            evaluate(&plan, &batch, Want::ForcesAndTangents, &mut exact);
            let expected = answers(&exact, &batch);
            report(precision.name(), h, &differences(&found, &expected));
            eprintln!(
                "stuck {} {}",
                found.iter().filter(|a| a.stuck).count(),
                expected.iter().filter(|a| a.stuck).count()
            );
            let unit = unit_states::<f32>(&scaled);
            let plan32 = located::<f32>(&set, n_time);
            let mut out32 = AftForces::default();
            evaluate(&plan32, &unit, Want::ForcesAndTangents, &mut out32);
            let unit64 = unit_states::<f64>(&scaled);
            let mut out64 = AftForces::default();
            scaled_total(&scaled, &raw, &unit64, &mut out64, &plan);
            report(
                "same law f32",
                h,
                &differences(&answers(&out64, &unit64), &answers(&out32, &unit)),
            );
        }
    }
}

/// Forces and tangents of the scaled states as unit states.
fn scaled_total(
    _scaled: &ScaledStates,
    raw: &ScaledForces,
    unit: &AftBatch<f64>,
    out: &mut AftForces<f64>,
    plan: &microslip::aft::AftPlan<f64>,
) {
    let mut again = ScaledStates::new(unit).unwrap();
    again.set_unit_scale();
    again.unscale(plan, unit, raw, out);
}
