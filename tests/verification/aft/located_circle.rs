//! Verification of located events of the circle law: order of the forces, and agreement with the box law where the laws
//! are the same. Their derivatives and symmetries are checked with those of the other laws.

use super::*;

fn located(n_time: usize) -> AftSettings {
    settings(n_time, FrictionLaw::Circle, Events::Located, Laps::Periodic)
}

/// Second order or better on random slipping and lifting states, with an error that plain events at samples have at
/// fifty times as many points; these converge to the same force, so that the truth does not rest on located events alone.
/// Seen to fail without the terms of the kinks.
#[test]
fn forces_converge_with_second_order() {
    for h in [1, 3, 5] {
        let set = HarmonicSet::up_to(h);
        let states = moving_states(&set, located(128), 11, 200);
        let exact = run(&AftPlan::new(&set, located(8192)), &states, Want::Forces);
        let error = |n| errors(&set, &states, located(n), &exact);
        let (coarse, fine) = (error(128), error(1024));
        assert!(coarse[100] < 1e-4, "H = {h}: median {:e}", coarse[100]);
        assert!(coarse[199] < 2e-3, "H = {h}: largest {:e}", coarse[199]);
        for rank in [100, 190] {
            let order = (coarse[rank] / fine[rank]).ln() / 8f64.ln();
            assert!(order > 1.9, "H = {h}: order {order} at rank {rank}");
        }
        let s = settings(
            8192,
            FrictionLaw::Circle,
            Events::Interpolated,
            Laps::Periodic,
        );
        let plain = errors(&set, &states, s, &exact);
        assert!(plain[199] < 1e-3, "H = {h}: plain {:e}", plain[199]);
    }
}

/// With one tangential direction both laws are the same, located events of the box law are exact, and the step of slip is, too: what
/// is left is the sum over the samples, of fourth order. Seen to fail without the jumps of the second derivative: third order,
/// a median of some 3e-6.
#[test]
fn in_one_direction_the_laws_agree() {
    let set = HarmonicSet::up_to(3);
    let mut states = moving_states(&set, located(128), 14, 200);
    for state in &mut states {
        state.p.k_t[0] = 0.0;
    }
    let s = settings(128, FrictionLaw::Box, Events::Located, Laps::Periodic);
    let exact = run(&AftPlan::<f64>::new(&set, s), &states, Want::Forces);
    let error = |n| errors(&set, &states, located(n), &exact);
    let (coarse, fine) = (error(128), error(1024));
    assert!(coarse[100] < 1e-6, "median {:e}", coarse[100]);
    let order = (coarse[100] / fine[100]).ln() / 8f64.ln();
    assert!(order > 3.7, "order {order}");
}

/// Where the friction limit is below the round-off of the spring's force, no friction is left: the travel of the slider is lost.
///
/// Seen to fail without the rule: forces that are no numbers from a ratio of 1e16 on (random model 2153: `non-finite`), and 58 N in place of 1e-14 N.
#[test]
fn friction_below_round_off_is_none() {
    let set = HarmonicSet::up_to(1);
    let mut q = vec![0.0; 9];
    (q[1], q[2], q[5]) = (-78.63765941245562, -15418.53646466893, -20831.142224866206);
    for (straight, law) in [true, false]
        .into_iter()
        .flat_map(|s| LAWS.map(|law| (s, law)))
    {
        for decade in 0..12 {
            let mut state = State {
                q: q.clone(),
                p: ContactParameters {
                    k_n: 0.0,
                    k_t: [1082.3, 202.7],
                    mu: 10f64.powi(-decade),
                    n_0: 1e-3,
                    anchor: [0.0; 2],
                },
            };
            if straight {
                state.p.k_t[1] = 0.0;
            }
            let s = settings(128, law, Events::Located, Laps::Periodic);
            let plan = AftPlan::<f64>::new(&set, s);
            let out = run(&plan, std::slice::from_ref(&state), Want::ForcesAndTangents);
            assert!(out.blocks.iter().all(|x| x.is_finite()), "{law:?} {decade}");
            let found = forces(&out, 0)[..6].to_vec();
            // k_t u is 1.7e10 N times as large as the limit with a coefficient of 1
            match decade < 5 {
                true => assert!(
                    found.iter().all(|f| f.is_finite()) && found[1] != 0.0,
                    "{found:?}"
                ),
                false => assert!(
                    found.iter().all(|f| f.abs() <= 2e-9),
                    "{law:?} {decade}: {found:?}"
                ),
            }
        }
    }
}

/// Motions up to 1e10 times as large as what the contact sticks for, as small friction and a large level make them: where
/// the motion turns back, the slider rests for less than a thousandth of a step, and round-off of its travel is not far below
/// the limit. Random models met the first two. The sum over samples misses of so short a stick what grows as the root of
/// that ratio (3.5e-6 times it at 128 points). Seen to fail (no end within ten minutes) with the search for the start of slip from
/// the zero of a cubic, which ends in the round-off about the turning point: slip began and ended there for ever; and without the
/// jumps of the second derivative, which leave 70 times the error.
#[test]
fn a_slider_far_beyond_its_limit_turns_back() {
    let set = HarmonicSet::up_to(1);
    let state = |q: [f64; 3], k_t: f64, mu: f64, n_0: f64| State {
        q: q.into_iter().chain([0.0; 6]).collect(),
        p: ContactParameters {
            k_n: 0.0,
            k_t: [k_t, 0.0],
            mu,
            n_0,
            anchor: [0.0; 2],
        },
    };
    let mut states = vec![
        state(
            [-10972.146713368258, -247.60479369874784, 23827.40366837348],
            35.1759274228703,
            1.7381330519002882e-5,
            0.8998746314285547,
        ),
        state(
            [22.414418592214613, 148.0784799466934, 1.675388940494024],
            2962.8919480235736,
            0.003996281232252343,
            0.010307112026545506,
        ),
    ];
    states.extend((0..200).map(|i| {
        let (phase, size) = (0.1 + 0.03 * f64::from(i), 10f64.powi(i % 10));
        let q = [0.3 * size, size * phase.cos(), size * phase.sin()];
        state(q, 1.0, 1.0, 1.0)
    }));
    let s = settings(128, FrictionLaw::Box, Events::Located, Laps::Periodic);
    let exact = run(&AftPlan::<f64>::new(&set, s), &states, Want::Forces);
    let plan = AftPlan::<f64>::new(&set, located(128));
    let found = run(&plan, &states, Want::ForcesAndTangents);
    for (i, state) in states.iter().enumerate() {
        let limit = state.p.mu * state.p.n_0;
        let ratio = state.p.k_t[0] * state.q[1].hypot(state.q[2]) / limit;
        let pairs = forces(&found, i).into_iter().zip(forces(&exact, i));
        let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / limit;
        assert!(error < 1e-5 * ratio.sqrt(), "{state:?}: {error:e}");
    }
}

/// A motion `ratio` times as large as what a contact with the limit 1 N sticks for, on an ellipse of this width over its length.
fn ellipse(ratio: f64, width: f64, phase: f64) -> State {
    let [c, s] = [phase.cos(), phase.sin()].map(|part| ratio * part);
    let q = [0.3 * ratio, c, s, 0.0, -width * s, width * c, 0.0, 0.0, 0.0];
    State {
        q: q.to_vec(),
        p: ContactParameters {
            k_n: 0.0,
            k_t: [1.0; 2],
            mu: 1.0,
            n_0: 1.0,
            anchor: [0.0; 2],
        },
    }
}

/// Derivatives where intervals have nodes between their samples, against differences. Seen to fail without the derivatives of the
/// tractions at these nodes.
#[test]
fn tangents_on_narrow_ellipses_agree_with_differences() {
    let set = HarmonicSet::up_to(1);
    let plan = AftPlan::<f64>::new(&set, located(128));
    let mut largest = 0.0f64;
    for ratio in [1e2, 1e3, 1e4] {
        for width in [1e-3, 1e-2, 3e-2] {
            for i in 0..20 {
                let state = ellipse(ratio, width, 0.1 + 0.314 * f64::from(i));
                let error = difference_error(&plan, &state);
                largest = largest.max(error);
            }
        }
    }
    println!("largest {largest:.1e}");
    assert!(largest < 1e-7, "{largest:e}");
}

/// Narrow ellipses beyond the limit: at a tip the velocity turns around within a step, which nodes between the samples resolve. The
/// largest error over the limit, against 64 times as many points, is stated in the page of limits. Seen to fail without these nodes:
/// 4.0e-2, and 2.9e-4 times the root of the ratio.
#[test]
fn narrow_ellipses_err_by_as_much_as_is_stated() {
    let set = HarmonicSet::up_to(1);
    let plan = |points| AftPlan::<f64>::new(&set, located(points));
    let mut largest = [0.0f64; 2];
    for ratio in [1e1, 1e2, 1e3, 1e4, 1e5] {
        for width in [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0] {
            let phases = (0..20).map(|i| 0.1 + 0.314 * f64::from(i));
            let states: Vec<State> = phases.map(|phase| ellipse(ratio, width, phase)).collect();
            let [found, exact] = [128, 8192].map(|n| run(&plan(n), &states, Want::Forces));
            let error = |i| {
                let pairs = forces(&found, i).into_iter().zip(forces(&exact, i));
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let error = (0..states.len()).map(error).fold(0.0, f64::max);
            println!("{ratio:.0e} times the limit, width {width:.0e}: {error:.1e}");
            largest = [largest[0].max(error), largest[1].max(error / ratio.sqrt())];
        }
    }
    println!("largest {largest:?}");
    assert!(largest[0] < 4e-3 && largest[1] < 1.2e-4, "{largest:?}");
}
