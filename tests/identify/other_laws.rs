//! Loops of other equations than those of an elastic-Coulomb contact: a bad fit is told.

use crate::synthetic::{Bench, normal};
use microslip::identify::found::result::TestEstimate;
use microslip::identify::{IdentifySettings, TestResult, TestStatus, identify_test};

/// What a law of friction needs.
#[derive(Clone, Copy)]
pub(crate) struct Contact {
    /// Force of gross slip (N).
    pub(crate) limit: f64,
    /// Stiffness (N/m).
    pub(crate) stiffness: f64,
}

/// That of the tests of this file.
const CONTACT: Contact = Contact {
    limit: 60.0,
    stiffness: 50e6,
};

/// Friction coefficient 0.6, stiffness 50 N/um, normal force 100 N, amplitude over the elastic limit; noise of 1 % of the force.
fn result(over: f64, seed: u64, mut force: impl FnMut(f64, f64) -> f64) -> TestResult {
    let bench = Bench {
        amplitude: over * 60.0 / 50e6,
        per_cycle: 300.0,
        cycles: 10,
        seed,
        ..Bench::default()
    };
    let mut record = bench.record();
    let mut before = 0.0;
    for (i, displacement) in record.displacement.iter().enumerate() {
        record.tangential_force[i] = force(before, *displacement) + 0.6 * normal(seed, i as u64, 1);
        before = *displacement;
    }
    let found = identify_test(&record, &IdentifySettings::default());
    let resonance = found.cycles.and_then(|cycles| cycles.force_resonance);
    assert_eq!(resonance, None, "a law of friction is no resonance");
    found
}

fn estimate(result: &TestResult) -> &TestEstimate {
    result.estimate.as_ref().unwrap()
}

/// Parallel springs with sliders (Iwan), of these slip limits over their mean.
pub(crate) fn array(contact: Contact, limits: &[f64]) -> impl FnMut(f64, f64) -> f64 + use<> {
    let count = limits.len() as f64;
    let mean = limits.iter().sum::<f64>() / count;
    let limits: Vec<f64> = limits
        .iter()
        .map(|l| contact.limit / count * l / mean)
        .collect();
    let mut forces = vec![0.0_f64; limits.len()];
    move |before, now| {
        for (force, limit) in forces.iter_mut().zip(&limits) {
            *force = (*force + contact.stiffness / count * (now - before)).clamp(-limit, *limit);
        }
        forces.iter().sum()
    }
}

/// Bouc-Wen with β = γ = 1/2.
pub(crate) fn bouc_wen(contact: Contact, exponent: i32) -> impl FnMut(f64, f64) -> f64 {
    let mut force = 0.0_f64;
    move |before, now| {
        for _ in 0..20 {
            let step = (now - before) / 20.0;
            let resisted = 0.5 * (1.0 + (force * step).signum());
            force += contact.stiffness
                * step
                * (1.0 - resisted * (force / contact.limit).abs().powi(exponent));
        }
        force
    }
}

/// Seen to fail without the knee: a parabolic pressure made the stiffness 10 % too small.
#[test]
fn contacts_under_an_uneven_pressure_keep_their_stiffness() {
    let place = |i: i32| (f64::from(i) + 0.5) / 24.0;
    let profiles: [Vec<f64>; 4] = [
        (0..24).map(|i| 0.5 + place(i)).collect(),
        (0..24).map(|i| 0.2 + 1.6 * place(i)).collect(),
        (0..24).map(|i| 2.0 * place(i)).collect(),
        (0..24)
            .map(|i| 1.0 - (2.0 * place(i) - 1.0).powi(2))
            .collect(),
    ];
    for (number, limits) in profiles.iter().enumerate() {
        for over in [4.0, 12.0] {
            let found = result(over, 3, array(CONTACT, limits));
            let found = estimate(&found);
            let friction = found.friction.unwrap().coefficient.value / 0.6 - 1.0;
            let stiffness = found.tangential.stiffness_n_per_um.value / 50.0 - 1.0;
            assert!(
                friction.abs() < 0.01,
                "profile {number}, {over}: friction off by {friction}"
            );
            assert!(
                stiffness.abs() < 0.05,
                "profile {number}, {over}: stiffness off by {stiffness}"
            );
        }
    }
}

#[test]
fn the_misfit_tells_other_laws() {
    let one = result(2.0, 5, array(CONTACT, &[1.0]));
    let misfit = estimate(&one).misfit;
    assert!(
        misfit.relative_rms < 0.01 && !misfit.large,
        "elastic-Coulomb: {misfit:?}"
    );
    let bouc_wen = result(3.0, 5, bouc_wen(CONTACT, 1));
    let misfit = estimate(&bouc_wen).misfit;
    assert!(misfit.relative_rms > 0.02, "Bouc-Wen: {misfit:?}");
    // sliders that harden: no plateau, as a second spring carries the rest
    let mut slider = array(CONTACT, &[1.0]);
    let hard = result(4.0, 5, move |before, now| slider(before, now) + 12e6 * now);
    assert_eq!(
        hard.status,
        TestStatus::NoSlip,
        "a force that goes on rising is no plateau"
    );
    let misfit = estimate(&hard).misfit;
    assert!(misfit.large, "slider with a spring beside it: {misfit:?}");
    assert!(
        hard.notes
            .iter()
            .any(|note| note.contains("differs from an elastic-Coulomb one")),
        "{:?}",
        hard.notes
    );
}
