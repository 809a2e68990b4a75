//! What each part of the rig adds to the signals, one at a time.

use super::{exact, first_test, rig};
use microslip::rig::VirtualTest;

const SLOW: &str =
    "[excitation]\nfrequencies_hz = [5]\ncycles = 20\nrun_in_cycles = 2\nsamples_per_cycle = 50\n";
const AIR: &str = "[loading]\nkind = \"air\"\nregulator_noise_percent = 0\n";

/// A test of a rig whose only errors are these.
fn with(errors: &str) -> VirtualTest {
    let text =
        format!("name = \"one\"\nseed = 4\n{AIR}{SLOW}[support]\nk12_n_per_um = 0\n{errors}");
    first_test(&rig(&text))
}

const QUIET_CELLS: &str = "[force_cells]\nnoise_n = 0\n";
const QUIET_VIBROMETER: &str = "[vibrometer]\nresolution_um = 0\nnoise_um = 0\n";

/// Gains, offset and drifts of a test are in its signals, as its truth states them.
///
/// Seen to fail without the gains, with the offset 0, and without either drift.
#[test]
fn stated_errors_are_in_the_signals() {
    let errors = format!(
        "{QUIET_CELLS}error_percent = 5\ndrift_n_per_s = 0.5\n{QUIET_VIBROMETER}drift_um_per_s = 0.5\n"
    );
    let test = with(&errors);
    let stated = test.instruments;
    let share = stated.offset_mm / 1.5;
    assert!(share.abs() > 0.05, "an offset that is seen: {share}");
    let lost = [0.005 * share, 0.009 * share];
    for (i, t) in test.motion.time.iter().enumerate() {
        let [t_cell, n_cell] = test.motion.felt[i];
        let read = [
            t_cell * (1.0 - lost[0].abs()) + lost[1] * n_cell,
            n_cell * (1.0 - lost[1].abs()) + lost[0] * t_cell,
        ];
        let measured = [test.record.tangential_force[i], test.record.normal_force[i]];
        for cell in 0..2 {
            let expected = stated.gains[cell] * read[cell] + stated.drift_n_per_s[cell] * t;
            let found = measured[cell];
            assert!(
                (found - expected).abs() < 1e-9,
                "cell {cell}, {t} s: {found} {expected}"
            );
        }
        let expected = test.motion.displacement[i] + 1e-6 * stated.drift_um_per_s * t;
        let found = test.record.displacement[i];
        assert!(
            (found - expected).abs() < 1e-15,
            "{t} s: {found} {expected} m"
        );
    }
    let all = [
        stated.gains[0] - 1.0,
        stated.gains[1] - 1.0,
        stated.drift_um_per_s,
    ];
    assert!(all.iter().all(|error| error.abs() > 1e-4), "{stated:?}");
}

/// K12 turns a share K12/K22 of the normal force into the tangential transducer, against the force along it.
///
/// Seen to fail without K12 in the stiffness.
#[test]
fn cross_stiffness_mixes_the_forces() {
    let crossed = |k12: f64| {
        let text = format!(
            "name = \"one\"\nseed = 4\n{AIR}{SLOW}[support]\nk12_n_per_um = {k12}\ndecoupling = [1, 1]\n{QUIET_CELLS}{QUIET_VIBROMETER}"
        );
        let test = first_test(&rig(&text));
        let felt = &test.motion.felt;
        let normal = test.motion.normal[0];
        (
            felt.iter().map(|felt| felt[0]).sum::<f64>() / felt.len() as f64,
            normal,
        )
    };
    let (found, normal) = crossed(15.0);
    let (without, _) = crossed(0.0);
    // the springs of the box: K11 b + K12 c = T, K12 b + K22 c = N
    let expected = -0.1 * normal / (1.0 - 0.01);
    let share = (found - without) / expected;
    assert!((share - 1.0).abs() < 0.05, "{found} {without} {expected} N");
}

/// The regulator: standard deviation and correlation over its time constant.
///
/// Seen to fail with white noise in place of the first-order process, and without it.
#[test]
fn the_regulator_fluctuates_as_stated() {
    let text = format!(
        "[loading]\nkind = \"air\"\nregulator_noise_percent = 2\nregulator_time_s = 0.1\n{}",
        SLOW.replace("cycles = 20", "cycles = 200")
    );
    let load = first_test(&exact(&text)).motion.normal;
    let n = load.len() as f64;
    let mean = load.iter().sum::<f64>() / n;
    let moment = |lag: usize| {
        let pairs = load.iter().zip(&load[lag..]);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n
    };
    // 40 s are 400 time constants: 5 % for the deviation
    let deviation = moment(0).sqrt() / mean;
    assert!((deviation / 0.02 - 1.0).abs() < 0.2, "{deviation}");
    // 25 samples are 0.1 s
    let correlation = moment(25) / moment(0);
    assert!(
        (correlation - (-1.0_f64).exp()).abs() < 0.15,
        "{correlation}"
    );
}

/// A hole that is narrower than its curtain is the throat: π d²/4 in place of π d h.
///
/// Seen to fail with the curtain as the throat of every hole.
#[test]
fn narrow_holes_are_throats() {
    let mean = |gap: f64| {
        let text = format!("[loading]\nkind = \"air\"\ngap_mm = {gap}\n{SLOW}");
        exact(&text).load_map().unwrap().pressure
    };
    // absolute pressure in the middle of the film: C n min(d h, d²/4) π / (2 (b + l) h) of the inlet's
    let film = |throat: f64, gap: f64| {
        0.87 * 20.0 * std::f64::consts::PI * throat / (120.0 * gap) * (0.75 + 0.101_325) - 0.101_325
    };
    let (narrow, wide) = (mean(0.3).mean_mpa, mean(0.1).mean_mpa);
    let expected = film(0.25, 0.3) / film(0.1, 0.1);
    assert!(
        (narrow / wide / expected - 1.0).abs() < 0.1,
        "{narrow} {wide} {expected}"
    );
}

/// The platform starts from rest and has its whole amplitude when the record begins.
///
/// Seen to fail with the whole amplitude from the start.
#[test]
fn the_motion_grows_through_the_run_in() {
    let excitation = exact(&format!("{AIR}{SLOW}")).excitation;
    let at = |cycles: f64| 1e6 * excitation.sine(5e-6, 5.0, cycles / 5.0);
    assert!(at(0.25) < 0.1, "{} um at the start", at(0.25));
    assert!((at(2.25) - 5.0).abs() < 1e-9, "{} um", at(2.25));
    assert!((at(1.0)).abs() < 1e-9, "{} um after one turn", at(1.0));
}
