//! Parameters of one test are found again, whatever the measurement adds.

use crate::synthetic::Bench;
use microslip::identify::found::result::TestEstimate;
use microslip::identify::{IdentifySettings, TestResult, TestStatus, identify_test};

pub(crate) fn result(bench: &Bench) -> TestResult {
    let found = identify_test(&bench.record(), &IdentifySettings::default());
    let resonance = found.cycles.and_then(|cycles| cycles.force_resonance);
    assert_eq!(resonance, None, "a bench without force cells: {bench:?}");
    found
}

pub(crate) fn estimate(bench: &Bench) -> TestEstimate {
    let found = result(bench);
    assert_eq!(
        found.status,
        TestStatus::Slips,
        "{bench:?}: {:?}",
        found.notes
    );
    found.estimate.unwrap()
}

/// Largest relative errors of the friction coefficient and of both stiffnesses.
fn recovers(bench: &Bench, [friction, stiffness]: [f64; 2]) {
    let found = estimate(bench);
    let error = found.friction.unwrap().coefficient.value / bench.friction - 1.0;
    assert!(
        error.abs() < friction,
        "friction coefficient off by {error:e}: {bench:?}"
    );
    for side in [0, 1] {
        let value = found.tangential.sides_n_per_um[side].unwrap().value;
        let error = 1e6 * value / bench.stiffness[side] - 1.0;
        assert!(
            error.abs() < stiffness,
            "stiffness {side} off by {error:e}: {bench:?}"
        );
    }
}

/// Seen to fail with the elastic travel left in the slip distance, and with the energy by rectangles.
#[test]
fn a_loop_without_faults_is_exact() {
    let bench = Bench::default();
    recovers(&bench, [1e-8, 1e-8]);
    let found = estimate(&bench);
    let friction = found.friction.unwrap();
    let difference = friction.energy_difference.unwrap();
    assert!(
        difference.abs() < 2e-3,
        "energy gives another coefficient: {difference}"
    );
    // 4 μ N (X - X*) with X* = μ N / k
    let limit = 0.6 * 100.0 / 50e6;
    let energy = 4.0 * 60.0 * (5e-6 - limit);
    assert!(
        (found.energy_j.value / energy - 1.0).abs() < 1e-3,
        "energy {}",
        found.energy_j.value
    );
    let onset = found.onset.unwrap();
    assert!(
        (onset.elastic_limit_m / limit - 1.0).abs() < 1e-6,
        "{onset:?}"
    );
    assert!((onset.first_slip_share - 1.0).abs() < 0.06, "{onset:?}");
    assert!(
        found.misfit.relative_rms < 1e-3 && !found.misfit.large,
        "{:?}",
        found.misfit
    );
}

/// Seen to fail with plateaus that reach back over the knee.
#[test]
fn friction_and_stiffness_over_their_whole_range() {
    for friction in [0.1, 0.3, 0.6, 1.2] {
        for scale in [0.1, 1.0, 10.0] {
            let stiffness = 50e6 * scale;
            let limit = friction * 100.0 / stiffness;
            for over in [1.3, 3.0, 10.0] {
                let bench = Bench {
                    friction,
                    stiffness: [stiffness; 2],
                    amplitude: over * limit,
                    noise: [0.002 * limit, 0.002 * friction * 100.0, 0.1],
                    ..Bench::default()
                };
                recovers(&bench, [0.01, 0.05]);
            }
        }
    }
}

/// Seen to fail with the mean force left out of the offset.
#[test]
fn noise_drift_and_offsets_leave_the_parameters() {
    let bench = Bench {
        noise: [0.05e-6, 0.5, 0.5],
        offset: [3e-6, 20.0],
        drift: [0.1e-6, 0.3],
        ..Bench::default()
    };
    recovers(&bench, [0.01, 0.05]);
    let friction = estimate(&bench).friction.unwrap();
    let offset = friction.tangential_offset_n - 20.0;
    // 0.3 N per cycle over 20 cycles: the offset is that of their middle
    assert!((offset - 3.2).abs() < 0.5, "offset {offset}");
}

/// Of a loop that is not even about its middle the mean force is no offset: the plateaus tell it. Seen to fail with the mean.
#[test]
fn plateaus_tell_the_offset_of_an_uneven_loop() {
    let bench = Bench {
        stiffness: [30e6, 60e6],
        offset: [0.0, 20.0],
        ..Bench::default()
    };
    let friction = estimate(&bench).friction.unwrap();
    let offset = friction.tangential_offset_n - 20.0;
    assert!(offset.abs() < 0.02, "offset {offset}");
    for (side, sign) in friction.sides.into_iter().zip([1.0, -1.0]) {
        assert!((side - 0.6 - sign * 0.2).abs() < 1e-3, "{side}");
    }
}

/// Seen to fail with one line for both, and with the interval of a stiffness that neither side has.
#[test]
fn both_reversals_are_told_apart() {
    let bench = Bench {
        stiffness: [30e6, 60e6],
        ..Bench::default()
    };
    recovers(&bench, [1e-6, 1e-6]);
    let found = result(&bench);
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("after the reversal")),
        "{:?}",
        found.notes
    );
    let known = found.estimate.unwrap().tangential.stiffness_n_per_um;
    assert!(known.lower <= 30.0 && known.upper >= 60.0, "{known:?}");
}

/// Seen to fail with the mean normal force in T/N, and in the friction coefficient.
#[test]
fn a_normal_force_that_swings_is_followed_sample_by_sample() {
    let bench = Bench {
        normal_swing: 0.3,
        amplitude: 10e-6,
        ..Bench::default()
    };
    recovers(&bench, [1e-3, 1e-3]);
}

#[test]
fn samples_that_do_not_divide_the_period() {
    let bench = Bench {
        per_cycle: 217.3,
        noise: [0.0, 0.2, 0.2],
        ..Bench::default()
    };
    recovers(&bench, [0.01, 0.03]);
}

/// Seen to fail with no run-in.
#[test]
fn run_in_is_left_out() {
    let bench = Bench {
        run_in: 0.3,
        cycles: 40,
        noise: [0.0, 0.3, 0.3],
        ..Bench::default()
    };
    let found = result(&bench);
    let cycles = found.cycles.unwrap();
    assert!(
        (5..=20).contains(&cycles.run_in),
        "{} cycles",
        cycles.run_in
    );
    recovers(&bench, [0.01, 0.05]);
    let steady: Vec<bool> = found.loops.iter().map(|l| l.steady).collect();
    assert_eq!(
        steady.iter().filter(|s| **s).count(),
        cycles.steady,
        "cycles marked as steady"
    );
}

/// Seen to fail with two cycles left out always.
#[test]
fn a_steady_record_has_no_run_in() {
    let none = (0..20).filter(|seed| {
        let bench = Bench {
            seed: *seed,
            per_cycle: 100.0,
            noise: [0.0, 0.5, 0.5],
            ..Bench::default()
        };
        result(&bench).cycles.unwrap().run_in == 0
    });
    assert!(none.count() >= 18, "cycles of steady records are left out");
}

/// Seen to fail with the stiffness as measured.
#[test]
fn stiffness_in_series_is_taken_out() {
    let bench = Bench {
        series: Some(80e6),
        amplitude: 8e-6,
        ..Bench::default()
    };
    let settings = IdentifySettings {
        series_stiffness_n_per_um: Some(80.0),
        ..IdentifySettings::default()
    };
    let found = identify_test(&bench.record(), &settings);
    let tangential = found.estimate.unwrap().tangential;
    let measured = 1.0 / (1.0 / 50.0 + 1.0 / 80.0);
    assert!(
        (tangential.measured_n_per_um / measured - 1.0).abs() < 1e-3,
        "{tangential:?}"
    );
    assert!(
        (tangential.stiffness_n_per_um.value / 50.0 - 1.0).abs() < 3e-3,
        "{tangential:?}"
    );
    let settings = IdentifySettings {
        series_stiffness_n_per_um: Some(20.0),
        ..settings
    };
    let refused = identify_test(&bench.record(), &settings).status;
    assert!(
        matches!(&refused, TestStatus::Unusable(why) if why.contains("series stiffness")),
        "{refused:?}"
    );
}

/// Seen to fail with tails that rise taken for plateaus, and with a bound above the swing.
#[test]
fn a_loop_that_never_slips_gives_a_bound() {
    let bench = Bench {
        amplitude: 1e-6,
        noise: [0.0, 0.2, 0.2],
        ..Bench::default()
    };
    let found = result(&bench);
    assert_eq!(
        found.status,
        TestStatus::NoSlip,
        "50 N below the limit of 60 N"
    );
    let estimate = found.estimate.unwrap();
    let bound = estimate.friction_at_least.unwrap();
    assert!((0.49..=0.501).contains(&bound), "bound {bound}");
    assert!(estimate.friction.is_none(), "a coefficient without slip");
    let stiffness = estimate.tangential.stiffness_n_per_um.value;
    assert!((stiffness / 50.0 - 1.0).abs() < 0.02, "{stiffness}");
    assert!(
        found.notes.iter().any(|note| note.contains("at least 0.")),
        "{:?}",
        found.notes
    );
}

/// Seen to fail with half of the way in alone.
#[test]
fn normal_stiffness_where_the_approach_is_measured() {
    let bench = Bench {
        normal_swing: 0.2,
        amplitude: 10e-6,
        noise: [0.0, 0.0, 0.2],
        ..Bench::default()
    };
    let mut record = bench.record();
    let clean = Bench {
        noise: [0.0; 3],
        ..bench
    }
    .record();
    record.approach = Some(clean.normal_force.iter().map(|n| n / 300e6).collect());
    let found = identify_test(&record, &IdentifySettings::default())
        .estimate
        .unwrap();
    let normal = found.normal_stiffness_n_per_um.unwrap();
    assert!((normal.value / 300.0 - 1.0).abs() < 0.01, "{normal:?}");
}

/// Seen to fail with spikes left in.
#[test]
fn spikes_are_replaced() {
    let mut record = Bench {
        noise: [0.0, 0.2, 0.2],
        ..Bench::default()
    }
    .record();
    for place in [1000, 2222, 3333] {
        record.tangential_force[place] += 500.0;
    }
    let found = identify_test(&record, &IdentifySettings::default());
    assert!(found.cycles.unwrap().spikes >= 3, "{:?}", found.cycles);
    let friction = found.estimate.unwrap().friction.unwrap().coefficient.value;
    assert!((friction / 0.6 - 1.0).abs() < 0.005, "{friction}");
}

/// A sensor that gives steps of 0.08 um with noise of a quarter of a step, and a small motion. Seen to fail with the scatter of each
/// phase alone as the measure of spikes.
#[test]
fn steps_of_a_sensor_are_no_spikes() {
    let bench = Bench {
        amplitude: 1.8e-6,
        noise: [0.02e-6, 0.3, 0.3],
        cycles: 60,
        per_cycle: 300.0,
        ..Bench::default()
    };
    let mut record = bench.record();
    let step = 0.08e-6;
    for value in &mut record.displacement {
        *value = (*value / step).round() * step;
    }
    let found = identify_test(&record, &IdentifySettings::default());
    assert!(found.cycles.unwrap().spikes < 10, "{:?}", found.cycles);
    let stiffness = found.estimate.unwrap().tangential.stiffness_n_per_um;
    assert!((stiffness.value / 50.0 - 1.0).abs() < 0.05, "{stiffness:?}");
}

/// A drift of T inside each cycle would tilt both plateaus and stand in the misfit.
#[test]
fn a_drift_of_the_force_is_taken_out_of_each_cycle() {
    let misfit = |per_cycle: f64| {
        let bench = Bench {
            drift: [0.0, per_cycle],
            ..Bench::default()
        };
        estimate(&bench).misfit.relative_rms
    };
    let (drifts, steady) = (misfit(6.0), misfit(0.0));
    assert!(drifts < steady + 2e-3, "{drifts} beside {steady}");
}

/// Forty cycles of 64.5 samples: a grid by samples instead of phases would be off by a third of a cycle at the end.
#[test]
fn the_grid_goes_with_the_phase() {
    let bench = Bench {
        per_cycle: 64.5,
        cycles: 40,
        ..Bench::default()
    };
    let found = estimate(&bench);
    assert!(found.misfit.relative_rms < 0.03, "{:?}", found.misfit);
    let friction = found.friction.unwrap().coefficient.value;
    assert!((friction / 0.6 - 1.0).abs() < 2e-3, "{friction}");
}

/// Cycles of the run-in do not count. Seen to fail with all cycles.
#[test]
fn the_scatter_is_that_of_the_steady_cycles() {
    let found = result(&Bench {
        run_in: 0.3,
        cycles: 40,
        noise: [0.0, 0.5, 0.0],
        ..Bench::default()
    });
    let steady = found.loops.iter().filter(|one| one.steady);
    let values: Vec<f64> = steady
        .map(|one| one.friction_coefficient.unwrap().value)
        .collect();
    assert!(
        values.len() < found.loops.len() && values.len() > 10,
        "{}",
        values.len()
    );
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let expected = (square / (n - 1.0)).sqrt() / mean;
    let scatter = found.estimate.unwrap().loop_scatter.unwrap();
    let share = scatter.friction_coefficient.unwrap();
    assert!((share / expected - 1.0).abs() < 1e-12, "{share} {expected}");
    assert!(scatter.energy.unwrap() > 0.0 && scatter.tangential_stiffness.unwrap() > 0.0);
}
