//! Verification of `aft`: the batch evaluation and its exact derivative.

mod batch;
mod fine_march;
mod located;
mod located_circle;
mod plain_march;
mod steady;

use microslip::aft::{
    AftBatch, AftForces, AftPlan, AftScratch, AftSettings, Laps, Periodicity, StateSummary,
    Tangent, TangentBlock, Want, evaluate,
};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::harmonics::{HarmonicSet, phases};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Coefficients `[3][m]` and parameters of one state.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) q: Vec<f64>,
    pub(crate) p: ContactParameters<f64>,
}

pub(crate) const LAWS: [FrictionLaw; 2] = [FrictionLaw::Box, FrictionLaw::Circle];
pub(crate) const EVENTS: [Events; 2] = [Events::Sampled, Events::Interpolated];

pub(crate) fn settings(n_time: usize, law: FrictionLaw, events: Events, laps: Laps) -> AftSettings {
    AftSettings {
        n_time,
        law,
        events,
        laps,
    }
}

pub(crate) fn batch(states: &[State]) -> AftBatch<f64> {
    let width = states.first().map_or(0, |s| s.q.len());
    let displacement = (0..width)
        .flat_map(|j| states.iter().map(move |s| s.q[j]))
        .collect();
    let parameters = states.iter().map(|s| s.p).collect();
    AftBatch {
        n_states: states.len(),
        displacement,
        parameters,
    }
}

pub(crate) fn run(plan: &AftPlan<f64>, states: &[State], want: Want) -> AftForces<f64> {
    let mut out = AftForces::default();
    evaluate(
        plan,
        &batch(states),
        want,
        &mut AftScratch::default(),
        &mut out,
    );
    out
}

/// Force coefficients `[3][m]` of one state.
pub(crate) fn forces(out: &AftForces<f64>, state: usize) -> Vec<f64> {
    let column = out.forces.iter().skip(state).step_by(out.n_states);
    column.copied().collect()
}

/// Force coefficients of one state evaluated alone.
pub(crate) fn forces_of(set: &HarmonicSet, s: AftSettings, state: &State) -> Vec<f64> {
    let plan = AftPlan::<f64>::new(set, s);
    forces(&run(&plan, std::slice::from_ref(state), Want::Forces), 0)
}

/// Largest difference over the largest entry of `expected`.
pub(crate) fn relative_difference(found: &[f64], expected: &[f64]) -> f64 {
    let largest = expected
        .iter()
        .fold(f64::MIN_POSITIVE, |a, x| a.max(x.abs()));
    let pairs = found.iter().zip(expected);
    pairs.fold(0.0, |a: f64, (f, e)| a.max((f - e).abs())) / largest
}

/// Random states in nondimensional units: stick, slip, lift-off, mixed, constant normal load, absent directions.
fn random_states(rng: &mut ChaCha8Rng, set: &HarmonicSet, n: usize) -> Vec<State> {
    let m = set.n_coefficients();
    (0..n)
        .map(|_| {
            let amplitude = 10f64.powf(rng.random_range(-1.0..1.2));
            let lift = 10f64.powf(rng.random_range(-1.5..0.9));
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

/// States of [`random_states`] that slip or lift off under the law and events of `s`.
fn moving_states(set: &HarmonicSet, s: AftSettings, seed: u64, n: usize) -> Vec<State> {
    let mut states = random_states(&mut ChaCha8Rng::seed_from_u64(seed), set, 3 * n);
    let out = run(&AftPlan::<f64>::new(set, s), &states, Want::Forces);
    let mut moving = out
        .summaries
        .iter()
        .map(|s| s.counts.slip + s.counts.separated > 0);
    states.retain(|_| moving.next() == Some(true));
    states.truncate(n);
    assert_eq!(states.len(), n, "enough states move");
    states
}

/// Sorted relative errors of the forces under `s` against `exact`.
fn errors(set: &HarmonicSet, states: &[State], s: AftSettings, exact: &AftForces<f64>) -> Vec<f64> {
    let out = run(&AftPlan::<f64>::new(set, s), states, Want::Forces);
    let error = |i| relative_difference(&forces(&out, i), &forces(exact, i));
    let mut errors: Vec<f64> = (0..states.len()).map(error).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// Force increment J x of one state. Shape: `[3][m]`.
fn apply_tangent(
    out: &AftForces<f64>,
    state: usize,
    p: &ContactParameters<f64>,
    x: &[f64],
) -> Vec<f64> {
    let m = out.n_coefficients;
    let Tangent::Blocks(offset) = out.tangents[state] else {
        let k = [p.k_t[0], p.k_t[1], p.k_n];
        return x.iter().enumerate().map(|(j, x)| k[j / m] * x).collect();
    };
    let mut product = vec![0.0; 3 * m];
    for block in TangentBlock::ALL {
        let x = &x[block.column_component() * m..][..m];
        let product = &mut product[block.row_component() * m..][..m];
        let rows = out.block(offset, block).chunks_exact(m);
        for (product, row) in product.iter_mut().zip(rows) {
            for (a, x) in row.iter().zip(x) {
                *product += a * x;
            }
        }
    }
    product
}

/// Dense tangent `[3m][3m]` of one state.
fn tangent(out: &AftForces<f64>, state: usize, p: &ContactParameters<f64>) -> Vec<f64> {
    let width = 3 * out.n_coefficients;
    let mut dense = vec![0.0; width * width];
    for j in 0..width {
        let mut x = vec![0.0; width];
        x[j] = 1.0;
        let y = apply_tangent(out, state, p, &x);
        for i in 0..width {
            dense[i * width + j] = y[i];
        }
    }
    dense
}

/// Largest error of the tangent over the block norms against central differences of fourth order of three steps; the
/// best step counts, since an event may lie within the larger ones.
fn difference_error(plan: &AftPlan<f64>, state: &State) -> f64 {
    let base = run(plan, std::slice::from_ref(state), Want::ForcesAndTangents);
    let exact = tangent(&base, 0, &state.p);
    let size = state.q.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let mut best = f64::INFINITY;
    for h in [3e-5, 3e-6, 3e-7] {
        best = step_error(plan, state, &exact, h * size).min(best);
        if best < 1e-8 {
            break;
        }
    }
    best
}

/// The same for one step `h`.
fn step_error(plan: &AftPlan<f64>, state: &State, exact: &[f64], h: f64) -> f64 {
    let width = state.q.len();
    let m = width / 3;
    let steps = [-2.0, -1.0, 1.0, 2.0];
    let stepped: Vec<State> = (0..4 * width)
        .map(|i| {
            let mut moved = state.clone();
            moved.q[i / 4] += steps[i % 4] * h;
            moved
        })
        .collect();
    let stepped = run(plan, &stepped, Want::Forces);
    let mut largest = exact.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    if largest == 0.0 {
        // Never in contact: the differences must vanish against the springs.
        largest = state.p.k_n.max(state.p.k_t[0]).max(state.p.k_t[1]);
    }
    let mut norms = [1e-2 * largest; 9];
    let mut errors = [0.0f64; 9];
    for j in 0..width {
        let f: [Vec<f64>; 4] = std::array::from_fn(|k| forces(&stepped, 4 * j + k));
        for i in 0..width {
            let block = i / m * 3 + j / m;
            let entry = exact[i * width + j];
            norms[block] = norms[block].max(entry.abs());
            let slope = (f[0][i] - 8.0 * f[1][i] + 8.0 * f[2][i] - f[3][i]) / (12.0 * h);
            let error = slope - entry;
            errors[block] = errors[block].max(error.abs());
        }
    }
    let relative = errors.iter().zip(norms).map(|(e, n)| e / n);
    relative.fold(0.0, f64::max)
}

fn sets() -> [HarmonicSet; 3] {
    [
        HarmonicSet::up_to(1),
        HarmonicSet::up_to(4),
        HarmonicSet::new(vec![0, 1, 3, 5]).unwrap_or_else(|e| panic!("{e}")),
    ]
}

/// The plans of every law, rule of events and lap rule; located events of the box law have their own tests.
fn plans(set: &HarmonicSet, laps: &[Laps]) -> Vec<AftPlan<f64>> {
    let rules = LAWS.into_iter().flat_map(|law| EVENTS.map(|e| (law, e)));
    let rules = rules.chain([(FrictionLaw::Circle, Events::Located)]);
    rules
        .flat_map(|(law, events)| laps.iter().map(move |&laps| (law, events, laps)))
        .map(|(law, events, laps)| AftPlan::new(set, settings(48, law, events, laps)))
        .collect()
}

/// The plans whose events are decided at the samples.
fn sampled_plans(set: &HarmonicSet, laps: &[Laps]) -> Vec<AftPlan<f64>> {
    let mut plans = plans(set, laps);
    plans.retain(|plan| plan.settings().events != Events::Located);
    plans
}

/// Seen to fail with: last event of lap 1 forgotten (`update_events` removed); sign of the closing derivative;
/// start of the steady circle cycle not closed (`close_cycle` removed).
#[test]
fn tangents_agree_with_central_differences() {
    let all_laps = [
        Laps::Periodic,
        Laps::Fixed(1),
        Laps::Fixed(2),
        Laps::Fixed(4),
    ];
    for set in sets() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let states = random_states(&mut rng, &set, 240);
        for plan in plans(&set, &all_laps) {
            for (i, state) in states.iter().enumerate() {
                let error = difference_error(&plan, state);
                assert!(error < 1e-7, "{:?}, state {i}: {error:e}", plan.settings());
            }
        }
    }
}

/// The random states reach every kind of motion, so that the checks above mean something.
#[test]
fn random_states_stick_slip_lift_and_mix() {
    let set = HarmonicSet::up_to(4);
    let states = random_states(&mut ChaCha8Rng::seed_from_u64(3), &set, 240);
    for plan in plans(&set, &[Laps::Periodic]) {
        let out = run(&plan, &states, Want::ForcesAndTangents);
        let count = |f: fn(&StateSummary) -> bool| out.summaries.iter().filter(|s| f(s)).count();
        assert!(
            out.tangents
                .iter()
                .filter(|&&t| t == Tangent::Stuck)
                .count()
                > 10,
            "stuck"
        );
        assert!(
            count(|s| s.counts.slip > 0 && s.counts.separated == 0) > 50,
            "slip"
        );
        assert!(
            count(|s| s.counts.stick > 0 && s.counts.slip > 0 && s.counts.separated > 0) > 20,
            "mixed"
        );
        assert!(
            count(|s| s.periodicity == Periodicity::Unique) > 100,
            "unique"
        );
        assert!(
            count(|s| s.periodicity == Periodicity::DependsOnAnchor) > 20,
            "anchored"
        );
        assert_eq!(
            count(|s| s.periodicity == Periodicity::NotPeriodic),
            0,
            "not periodic"
        );
        assert!(
            out.summaries.iter().all(|s| s.counts.total() == 48),
            "samples"
        );
    }
}

/// Homogeneity of degree 1 without preload and anchor: J U = F (Euler). Seen to fail with: one normal block dropped.
#[test]
fn without_preload_the_tangent_reproduces_the_force() {
    for set in sets() {
        let mut states = random_states(&mut ChaCha8Rng::seed_from_u64(5), &set, 200);
        for s in &mut states {
            (s.p.n_0, s.p.anchor) = (0.0, [0.0; 2]);
        }
        for plan in plans(&set, &[Laps::Periodic, Laps::Fixed(2)]) {
            let out = run(&plan, &states, Want::ForcesAndTangents);
            for (i, s) in states.iter().enumerate() {
                let product = apply_tangent(&out, i, &s.p, &s.q);
                let error = relative_difference(&product, &forces(&out, i));
                assert!(error < 1e-12, "{:?} state {i}: {error:e}", plan.settings());
            }
        }
    }
}

/// F(s k, s n_0) = s F(k, n_0). Seen to fail with: k_n left out of the scaling.
#[test]
fn forces_scale_with_stiffness() {
    let set = HarmonicSet::up_to(4);
    let states = random_states(&mut ChaCha8Rng::seed_from_u64(6), &set, 200);
    let scaled: Vec<State> = states
        .iter()
        .cloned()
        .map(|mut s| {
            (s.p.k_n, s.p.n_0) = (3.7 * s.p.k_n, 3.7 * s.p.n_0);
            s.p.k_t = s.p.k_t.map(|k| 3.7 * k);
            s
        })
        .collect();
    for plan in plans(&set, &[Laps::Periodic, Laps::Fixed(3)]) {
        let (one, other) = (
            run(&plan, &states, Want::Forces),
            run(&plan, &scaled, Want::Forces),
        );
        for i in 0..states.len() {
            let expected: Vec<f64> = forces(&one, i).iter().map(|f| 3.7 * f).collect();
            let error = relative_difference(&forces(&other, i), &expected);
            assert!(error < 1e-12, "{:?} state {i}: {error:e}", plan.settings());
        }
    }
}

/// The period map of the box law is a projection. Seen to fail with: the circle law in place of the box law.
#[test]
fn the_third_lap_of_the_box_law_repeats_the_second() {
    let set = HarmonicSet::up_to(4);
    let states = random_states(&mut ChaCha8Rng::seed_from_u64(7), &set, 500);
    for events in EVENTS {
        let lap = |n| {
            let s = settings(64, FrictionLaw::Box, events, Laps::Fixed(n));
            run(&AftPlan::<f64>::new(&set, s), &states, Want::Forces)
        };
        let (second, third) = (lap(2), lap(3));
        for i in 0..states.len() {
            let error = relative_difference(&forces(&third, i), &forces(&second, i));
            assert!(error < 1e-13, "state {i}: {error:e}");
            assert_ne!(
                second.summaries[i].periodicity,
                Periodicity::NotPeriodic,
                "state {i}"
            );
        }
    }
}

/// Shifts the time of every component by `turn` radians: θ → θ + turn.
fn shifted(q: &[f64], set: &HarmonicSet, turn: f64) -> Vec<f64> {
    let mut out = q.to_vec();
    for row in out.chunks_exact_mut(set.n_coefficients()) {
        for (pair, &k) in row[1..].chunks_exact_mut(2).zip(&set.orders()[1..]) {
            let (sin, cos) = (k as f64 * turn).sin_cos();
            let (c, s) = (pair[0], pair[1]);
            (pair[0], pair[1]) = (c * cos + s * sin, s * cos - c * sin);
        }
    }
    out
}

fn shifted_states(states: &[State], set: &HarmonicSet, turn: f64) -> Vec<State> {
    let shift = |s: &State| State {
        q: shifted(&s.q, set, turn),
        p: s.p,
    };
    states.iter().map(shift).collect()
}

/// Seen to fail with: closing over the end of the period left out.
#[test]
fn a_shift_in_time_shifts_the_unique_steady_force() {
    for set in sets() {
        let states = random_states(&mut ChaCha8Rng::seed_from_u64(8), &set, 200);
        for plan in plans(&set, &[Laps::Periodic]) {
            let turn = std::f64::consts::TAU * 11.0 / 48.0;
            let moved = shifted_states(&states, &set, turn);
            let (one, other) = (
                run(&plan, &states, Want::Forces),
                run(&plan, &moved, Want::Forces),
            );
            for (i, summary) in one.summaries.iter().enumerate() {
                if summary.periodicity == Periodicity::Unique {
                    let expected = shifted(&forces(&one, i), &set, turn);
                    let error = relative_difference(&forces(&other, i), &expected);
                    assert!(error < 1e-11, "{:?} state {i}: {error:e}", plan.settings());
                }
            }
        }
    }
}
