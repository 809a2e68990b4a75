//! Loops of the published round robin of friction rigs, by its numbers: 600 samples per cycle at 100 Hz, normal forces of 17 to 253 N,
//! amplitudes of 1 to 24.5 um, a friction coefficient of 0.67, tangential stiffnesses of 50 and 170 N/um, some of them with no slip.
//!
//! The recorded loops are public without a licence, so that they are not here. These loops have the published parameters, by equations that
//! the identification does not know: an elastic-Coulomb contact, Iwan's array with an even spread of slip limits, and Bouc and Wen's.
//! Source of the figures: round robin of Imperial College London and Politecnico di Torino, 34 conditions, as the repository
//! sunfanyi/Machine-Learning-for-Friction-Hysteresis-Loops (2022) tells them.

use crate::other_laws::{Contact, array, bouc_wen};
use crate::synthetic::{Bench, normal};
use microslip::identify::{IdentifySettings, TestResult, TestStatus, identify_test};

const FRICTION: f64 = 0.67;
const NORMAL_N: [f64; 4] = [17.0, 87.0, 150.0, 253.0];
const AMPLITUDES_UM: [f64; 4] = [1.0, 4.0, 14.0, 24.5];
const STIFFNESS_N_PER_UM: [f64; 2] = [50.0, 170.0];

/// A loop with noise of 2 nm and of half a percent of the normal force.
fn result(contact: Contact, amplitude: f64, mut law: impl FnMut(f64, f64) -> f64) -> TestResult {
    let load = contact.limit / FRICTION;
    let bench = Bench {
        amplitude,
        per_cycle: 600.0,
        normal_force: load,
        cycles: 10,
        ..Bench::default()
    };
    let mut record = bench.record();
    let (mut before, clean) = (0.0, record.displacement.clone());
    for (i, displacement) in clean.into_iter().enumerate() {
        let noise = |k: u32| normal(7, i as u64, k);
        record.tangential_force[i] = law(before, displacement) + 5e-3 * load * noise(1);
        record.displacement[i] += 2e-9 * noise(0);
        before = displacement;
    }
    identify_test(&record, &IdentifySettings::default())
}

/// Largest sizes of the errors of friction coefficient and stiffness and largest misfit over all conditions of one law; and how many slip.
fn worst(
    name: &str,
    law: impl Fn(Contact) -> Box<dyn FnMut(f64, f64) -> f64>,
) -> ([f64; 3], usize) {
    let (mut worst, mut slips) = ([0.0_f64; 3], 0);
    for stiffness in STIFFNESS_N_PER_UM {
        for load in NORMAL_N {
            for amplitude in AMPLITUDES_UM {
                let contact = Contact {
                    limit: FRICTION * load,
                    stiffness: 1e6 * stiffness,
                };
                let found = result(contact, 1e-6 * amplitude, law(contact));
                let case = format!("{name}: {stiffness} N/um, {load} N, {amplitude} um");
                let estimate = found.estimate.as_ref();
                let Some(estimate) = estimate else {
                    panic!("{case}: {:?}", found.status);
                };
                let error = estimate.tangential.stiffness_n_per_um.value / stiffness - 1.0;
                let Some(friction) = estimate.friction else {
                    assert_eq!(found.status, TestStatus::NoSlip, "{case}");
                    let bound = estimate.friction_at_least.unwrap_or(0.0);
                    assert!(bound < 1.01 * FRICTION, "{case}: at least {bound}");
                    continue;
                };
                slips += 1;
                let friction = friction.coefficient.value / FRICTION - 1.0;
                let misfit = estimate.misfit.relative_rms;
                for (worst, found) in worst.iter_mut().zip([friction, error, misfit]) {
                    *worst = worst.max(found.abs());
                }
            }
        }
    }
    let [friction, stiffness, misfit] = worst.map(|w| 100.0 * w);
    println!(
        "{name}: {slips} of 32 slip; largest errors: mu {friction:.2} %, k_t {stiffness:.1} %, misfit {misfit:.1} %"
    );
    (worst, slips)
}

/// Seen to fail with a tail that rises by 30 % of the stick slope taken for a plateau.
#[test]
fn published_conditions_give_their_parameters_back() {
    let ([friction, stiffness, misfit], slips) = worst("elastic-Coulomb", |contact| {
        Box::new(array(contact, &[1.0]))
    });
    assert!(slips >= 24, "{slips} slip");
    assert!(
        friction < 0.01 && stiffness < 0.05 && misfit < 0.01,
        "{friction} {stiffness} {misfit}"
    );
    let limits: Vec<f64> = (0..24).map(|i| 0.5 + (f64::from(i) + 0.5) / 24.0).collect();
    let ([friction, stiffness, misfit], slips) =
        worst("Iwan", |contact| Box::new(array(contact, &limits)));
    assert!(slips >= 24, "{slips} slip");
    assert!(
        friction < 0.01 && stiffness < 0.05 && misfit < 0.05,
        "{friction} {stiffness} {misfit}"
    );
    let ([friction, _, misfit], slips) =
        worst("Bouc-Wen", |contact| Box::new(bouc_wen(contact, 2)));
    assert!(slips >= 20, "{slips} slip");
    assert!(friction < 0.02 && misfit > 0.01, "{friction} {misfit}");
}
