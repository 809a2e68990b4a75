//! Verification of `aft`: the batch evaluation and its exact derivative.

use microslip::aft::{
    AftBatch, AftForces, AftPlan, AftSettings, Block, Laps, Periodicity, Tangent, Want, evaluate,
};
use microslip::contact::{ContactParameters, FrictionLaw, Real, Recontact};
use microslip::harmonics::{HarmonicSet, phases};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Coefficients `[3][m]` and parameters of one state.
#[derive(Debug, Clone)]
pub struct State {
    pub q: Vec<f64>,
    pub p: ContactParameters<f64>,
}

pub const LAWS: [FrictionLaw; 2] = [FrictionLaw::Box, FrictionLaw::Circle];
pub const RECONTACTS: [Recontact; 2] = [Recontact::AtSample, Recontact::Interpolated];

pub fn settings(n_time: usize, law: FrictionLaw, recontact: Recontact, laps: Laps) -> AftSettings {
    AftSettings {
        n_time,
        law,
        recontact,
        laps,
    }
}

pub fn batch<T: Real>(states: &[State]) -> AftBatch<T> {
    let cast = T::from_f64;
    let width = states.first().map_or(0, |s| s.q.len());
    let displacement = (0..width)
        .flat_map(|j| states.iter().map(move |s| cast(s.q[j])))
        .collect();
    let parameters = states
        .iter()
        .map(|s| ContactParameters {
            k_n: cast(s.p.k_n),
            k_t: s.p.k_t.map(cast),
            mu: cast(s.p.mu),
            n_0: cast(s.p.n_0),
            anchor: s.p.anchor.map(cast),
        })
        .collect();
    AftBatch {
        n_states: states.len(),
        displacement,
        parameters,
    }
}

pub fn run<T: Real>(plan: &AftPlan<T>, states: &[State], want: Want) -> AftForces<T> {
    let mut out = AftForces::default();
    evaluate(plan, &batch(states), want, &mut out);
    out
}

/// Force coefficients `[3][m]` of one state.
pub fn forces<T: Real>(out: &AftForces<T>, state: usize) -> Vec<f64> {
    let column = out.forces.iter().skip(state).step_by(out.n_states);
    column.map(|&f| f.to_f64()).collect()
}

/// Dense tangent `[3m][3m]` of one state.
fn tangent<T: Real>(out: &AftForces<T>, state: usize, p: &ContactParameters<T>) -> Vec<f64> {
    let width = 3 * out.n_coefficients;
    let mut dense = vec![0.0; width * width];
    for j in 0..width {
        let mut x = vec![T::ZERO; width];
        let mut y = x.clone();
        x[j] = T::ONE;
        out.apply_tangent(state, p, &x, &mut y);
        for i in 0..width {
            dense[i * width + j] = y[i].to_f64();
        }
    }
    dense
}

/// Random states in nondimensional units: stick, slip, lift-off, mixed, constant normal load, absent directions.
pub fn random_states(rng: &mut ChaCha8Rng, set: &HarmonicSet, n: usize) -> Vec<State> {
    let m = set.n_coefficients();
    (0..n)
        .map(|_| {
            let amplitude = 10f64.powf(rng.random_range(-1.0..1.2));
            let lift = 10f64.powf(rng.random_range(-1.5..0.4));
            let mut q = vec![0.0; 3 * m];
            for c in 0..3 {
                for j in 0..m {
                    let order = set.orders()[j.div_ceil(2)] as f64;
                    let normal: f64 = StandardNormal.sample(rng);
                    let size = if c == 2 { lift } else { amplitude };
                    q[c * m + j] = size * normal / (1.0 + order * order);
                }
            }
            let mut unit = || -> f64 { StandardNormal.sample(rng) };
            let anchor: [f64; 2] = [0.5 * amplitude * unit(), 0.5 * amplitude * unit()];
            State {
                q,
                p: ContactParameters {
                    k_n: if rng.random_bool(0.1) {
                        0.0
                    } else {
                        rng.random_range(0.5..2.0)
                    },
                    k_t: [
                        if rng.random_bool(0.05) {
                            0.0
                        } else {
                            rng.random_range(0.5..2.0)
                        },
                        rng.random_range(0.5..2.0),
                    ],
                    mu: rng.random_range(0.2..0.8),
                    n_0: rng.random_range(0.3..2.0),
                    anchor,
                },
            }
        })
        .collect()
}

/// Relative error of the tangent of one state against central differences; `None` if an event lies within a step.
fn difference_error(plan: &AftPlan<f64>, state: &State) -> Option<f64> {
    let width = state.q.len();
    let base = run(plan, std::slice::from_ref(state), Want::ForcesAndTangents);
    let exact = tangent(&base, 0, &state.p);
    let scale = state.q.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let h = 1e-5 * scale;
    let mut steps = Vec::new();
    for j in 0..width {
        for sign in [1.0, -1.0] {
            let mut moved = state.clone();
            moved.q[j] += sign * h;
            steps.push(moved);
        }
    }
    let stepped = run(plan, &steps, Want::Forces);
    if stepped.summaries.iter().any(|s| {
        let b = &base.summaries[0];
        (s.stick, s.slip, s.separated) != (b.stick, b.slip, b.separated)
    }) {
        return None;
    }
    let norm = exact.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let mut worst: f64 = 0.0;
    for j in 0..width {
        let (up, down) = (forces(&stepped, 2 * j), forces(&stepped, 2 * j + 1));
        for i in 0..width {
            let difference = (up[i] - down[i]) / (2.0 * h);
            worst = worst.max((difference - exact[i * width + j]).abs());
        }
    }
    Some(worst / norm)
}

#[test]
fn quick_tangent() {
    let sets = [
        HarmonicSet::up_to(1),
        HarmonicSet::up_to(5),
        HarmonicSet::new(vec![0, 1, 3, 5]).unwrap(),
    ];
    for law in LAWS {
        for recontact in RECONTACTS {
            for laps in [
                Laps::Periodic,
                Laps::Fixed(1),
                Laps::Fixed(2),
                Laps::Fixed(3),
            ] {
                for set in &sets {
                    let mut rng = ChaCha8Rng::seed_from_u64(1);
                    let plan = AftPlan::new(set, settings(64, law, recontact, laps));
                    let states = random_states(&mut rng, set, 60);
                    let mut errors = Vec::new();
                    for s in &states {
                        if let Some(e) = difference_error(&plan, s) {
                            errors.push(e);
                        }
                    }
                    errors.sort_by(f64::total_cmp);
                    let out = run(&plan, &states, Want::ForcesAndTangents);
                    let np = out
                        .summaries
                        .iter()
                        .filter(|s| s.periodicity == Periodicity::NotPeriodic)
                        .count();
                    let da = out
                        .summaries
                        .iter()
                        .filter(|s| s.periodicity == Periodicity::DependsOnAnchor)
                        .count();
                    let stuck = out
                        .tangents
                        .iter()
                        .filter(|t| **t == Tangent::Stuck)
                        .count();
                    let laps_max = out.summaries.iter().map(|s| s.laps).max();
                    println!(
                        "{law:?} {recontact:?} {laps:?} {:?}: n {} median {:.1e} p90 {:.1e} max {:.1e}  notper {np} anchor {da} stuck {stuck} laps {laps_max:?}",
                        set.orders(),
                        errors.len(),
                        errors[errors.len() / 2],
                        errors[errors.len() * 9 / 10],
                        errors[errors.len() - 1]
                    );
                }
            }
        }
    }
    let _ = (phases(3), Block::NN);
}
