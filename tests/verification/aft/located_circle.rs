//! Verification of located events of the circle law: forces of higher order in the time step and their exact derivative.

use super::*;

fn located(n_time: usize, laps: Laps) -> AftSettings {
    settings(n_time, FrictionLaw::Circle, Events::Located, laps)
}

fn plan(set: &HarmonicSet, n_time: usize, laps: Laps) -> AftPlan<f64> {
    AftPlan::new(set, located(n_time, laps))
}

/// States of [`random_states`] that slip or lift off.
fn moving_states(set: &HarmonicSet, seed: u64, n: usize) -> Vec<State> {
    let mut states = random_states(&mut ChaCha8Rng::seed_from_u64(seed), set, 3 * n);
    let out = run(&plan(set, 128, Laps::Periodic), &states, Want::Forces);
    let mut moving = out.summaries.iter().map(|s| s.slip + s.separated > 0);
    states.retain(|_| moving.next() == Some(true));
    states.truncate(n);
    assert_eq!(states.len(), n, "enough states move");
    states
}

fn errors(set: &HarmonicSet, states: &[State], s: AftSettings, exact: &AftForces<f64>) -> Vec<f64> {
    let out = run(&AftPlan::<f64>::new(set, s), states, Want::Forces);
    let error = |i| relative_difference(&forces(&out, i), &forces(exact, i));
    let mut errors: Vec<f64> = (0..states.len()).map(error).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

#[test]
fn convergence() {
    for h in [1, 3, 5] {
        let set = HarmonicSet::up_to(h);
        let states = moving_states(&set, 11, 200);
        let exact = run(&plan(&set, 8192, Laps::Periodic), &states, Want::Forces);
        let sampled = settings(8192, FrictionLaw::Circle, Events::Interpolated, Laps::Periodic);
        let e = errors(&set, &states, sampled, &exact);
        println!("H {h} interpolated 8192: {:.1e} {:.1e} {:.1e}", e[100], e[190], e[199]);
        for n in [64, 128, 256, 512, 1024, 2048] {
            let e = errors(&set, &states, located(n, Laps::Periodic), &exact);
            let sampled = settings(n, FrictionLaw::Circle, Events::Interpolated, Laps::Periodic);
            let c = errors(&set, &states, sampled, &exact);
            println!("H {h} n {n}: {:.1e} {:.1e} {:.1e}   interpolated {:.1e} {:.1e} {:.1e}", e[100], e[190], e[199], c[100], c[190], c[199]);
        }
    }
}

#[test]
fn tangents() {
    for set in sets() {
        for laps in [Laps::Periodic, Laps::Fixed(1), Laps::Fixed(3)] {
            let plan = plan(&set, 48, laps);
            let states = random_states(&mut ChaCha8Rng::seed_from_u64(3), &set, 240);
            for (i, state) in states.iter().enumerate() {
                let error = difference_error(&plan, state);
                if !(error < 1e-7) { println!("{laps:?} state {i}: {error:e}"); }
            }
        }
    }
}
