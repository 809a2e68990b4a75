//! A small part of the contact slips long before the rest, or two halves with different limits: the start of the branch tells the stiffness.

use crate::other_laws::{Contact, array};
use crate::synthetic::{Bench, normal};
use microslip::identify::found::result::TestEstimate;
use microslip::identify::{IdentifySettings, TestResult, identify_test};

/// Friction coefficient 0.5, stiffness 50 N/um, 15 cycles at 10 Hz; `noise` of displacement (m) and force (N).
fn found(limits: &[f64], noise: [f64; 2], seed: u64) -> TestResult {
    let bench = Bench {
        friction: 0.5,
        amplitude: 8e-6,
        frequency: 10.0,
        per_cycle: 400.0,
        cycles: 15,
        ..Bench::default()
    };
    let mut record = bench.record();
    let contact = Contact {
        limit: 50.0,
        stiffness: 50e6,
    };
    let (mut force, mut before) = (array(contact, limits), 0.0);
    for i in 0..record.time.len() {
        let motion = record.displacement[i];
        record.displacement[i] += noise[0] * normal(seed, i as u64, 0);
        record.tangential_force[i] = force(before, motion) + noise[1] * normal(seed, i as u64, 1);
        before = motion;
    }
    identify_test(&record, &IdentifySettings::default())
}

fn estimate(result: &TestResult) -> &TestEstimate {
    result.estimate.as_ref().unwrap()
}

/// A hundred parts, of which `weak` have the limit `limit` times that of the others.
fn weak(weak: usize, limit: f64) -> Vec<f64> {
    (0..100)
        .map(|i| if i < weak { limit } else { 1.0 })
        .collect()
}

/// The interval holds the stiffness, and a note says why it is wide where it is.
fn holds(name: &str, limits: &[f64], noise: [f64; 2]) {
    let found = found(limits, noise, 1);
    let known = estimate(&found).tangential.stiffness_n_per_um;
    println!("{name} {noise:?}: {known:?}");
    assert!(
        (known.lower..=known.upper).contains(&50.0),
        "{name}, {noise:?}: {known:?}"
    );
    let told = found.notes.iter().any(|note| {
        note.contains("parts of the contact slip") || note.contains("the slope at the start")
    });
    assert!(told, "{name}, {noise:?}: {:?}", found.notes);
}

/// The window of a branch begins at a tenth of the swing: what slips before it left a line that is straight, with an interval of 0.1 to 1 %
/// about a stiffness that is 4 to 15 % too small.
///
/// Seen to fail with the program before.
#[test]
fn a_part_that_slips_early_is_in_the_interval() {
    for noise in [[1e-9, 0.01], [1e-8, 0.1]] {
        holds("10 % at 0.18", &weak(10, 0.18), noise);
        holds("5 % at 0.1", &weak(5, 0.1), noise);
        holds("15 % at 0.13", &weak(15, 0.13), noise);
        holds("10 % at 0.05", &weak(10, 0.05), noise);
        let edge: Vec<f64> = (0..100_u32)
            .map(|i| (f64::from(i) / 20.0 + 0.025).min(1.0))
            .collect();
        holds("edge of 20 %", &edge, noise);
    }
}

/// A contact without weak part keeps its narrow interval: noise bends a start or a window, and makes it wide, in about one of ten tests.
#[test]
fn a_straight_branch_keeps_its_interval() {
    let mut narrow = 0;
    for seed in 0..12 {
        let found = found(&[1.0], [1e-8, 0.1], seed);
        let known = estimate(&found).tangential.stiffness_n_per_um;
        let half = 0.5 * (known.upper - known.lower) / known.value;
        narrow += usize::from(half < 0.006);
        assert!((known.value / 50.0 - 1.0).abs() < 0.004, "{known:?}");
    }
    assert!(narrow >= 10, "{narrow} of 12");
}

/// Half of the contact at a third of the limit of the other: no spread of the family has this branch. Equal records gave 50.0 ± 0.2 or, where noise
/// let the short window look bent, 55.7 with an interval from 53.4 on.
///
/// Seen to fail with the program before.
#[test]
fn two_limits_give_one_answer() {
    for seed in 1..=24 {
        let found = found(&[0.5, 1.5], [3e-8, 0.3], seed);
        let estimate = estimate(&found);
        let known = estimate.tangential.stiffness_n_per_um;
        assert!(
            (known.value / 50.0 - 1.0).abs() < 0.02,
            "{seed}: {known:?}, {:?}",
            estimate.misfit
        );
    }
}
