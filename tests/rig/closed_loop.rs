//! The closed loop: what the identification finds in virtual tests. The whole map is `cargo bench --bench closed_loop`.

use super::{STEADY_AIR, exact, first_test, rig};
use microslip::identify::{
    IdentifySettings, KnownPressure, TestResult, TestStatus, identify_pressed_test, identify_test,
};
use microslip::rig::{Slip, VirtualTest};

fn found(test: &VirtualTest) -> TestResult {
    identify_test(&test.record, &IdentifySettings::default())
}

/// Relative errors of friction coefficient and stiffness.
fn errors(test: &VirtualTest, result: &TestResult) -> [f64; 2] {
    let estimate = result.estimate.as_ref().unwrap();
    let friction = estimate.friction.unwrap().coefficient.value;
    let stiffness = estimate.tangential.stiffness_n_per_um.value;
    [
        friction / test.truth.friction_coefficient - 1.0,
        stiffness / test.truth.tangential_stiffness_n_per_um - 1.0,
    ]
}

fn contact(mu: f64, scale: f64, amplitude_um: f64, cycles: usize) -> String {
    format!(
        "[contact]\nfriction_coefficient = {mu}\ntangential_stiffness_n_per_um = {}\n\
         [excitation]\namplitude_um = {amplitude_um}\nrun_in_cycles = 2\ncycles = {cycles}\n",
        233.0 * scale
    )
}

/// Without errors of the instruments: friction within 1 % and stiffness within 5 % at the corners of the range and inside, under
/// air and punch.
///
/// Seen to fail with reversals where the smooth motion turns: friction 2 % low under air, 5 % low under the punch, at mu 1.2 and
/// ten times the stiffness.
#[test]
fn exact_instruments_give_the_truth() {
    for (mu, scale, amplitude) in [
        (0.1, 0.1, 2.0),
        (0.6, 1.0, 5.0),
        (1.2, 0.1, 20.0),
        (0.1, 10.0, 1.0),
        (1.2, 10.0, 5.0),
    ] {
        for loading in [STEADY_AIR, "[loading]\nkind = \"punch\"\n"] {
            let rig = exact(&format!("{}{loading}", contact(mu, scale, amplitude, 3)));
            let test = first_test(&rig);
            let case = format!("mu {mu}, scale {scale}, {loading}");
            assert_eq!(test.slip, Slip::Gross, "{case}");
            let [friction, stiffness] = errors(&test, &found(&test));
            println!("{case}: {friction:.4} {stiffness:.4}");
            assert!(friction.abs() < 0.01, "{case}: friction {friction}");
            assert!(stiffness.abs() < 0.05, "{case}: stiffness {stiffness}");
        }
    }
}

/// Sixteen samples of a cycle show no plateau of a contact that slips: it is no contact that sticks, which would have a lower bound of the friction
/// coefficient. Seen to fail without a look at how flat the loop is: at least 0.602 where the truth is 0.6.
#[test]
fn a_loop_of_few_samples_is_no_stuck_contact() {
    let few = contact(0.6, 1.0, 5.0, 20) + "samples_per_cycle = 16\n";
    let test = first_test(&exact(&format!("{few}{STEADY_AIR}")));
    assert_eq!(test.slip, Slip::Gross);
    match found(&test).status {
        TestStatus::Unusable(reason) => assert!(
            reason.contains("slips, but no plateau is told from its turns: more samples"),
            "{reason}"
        ),
        other => panic!("{other:?}"),
    }
}

/// With the noise, steps and drift of the vibrometer, and noise and drift of the cells.
///
/// Seen to fail with the displacement replaced by six harmonics wherever single samples look like noise: the stiffness is then 6 %
/// high.
#[test]
fn steps_and_noise_average_out() {
    let gains = "[force_cells]\nerror_percent = 0\n[support]\noffset_mm = 0\n";
    for (mu, scale, amplitude) in [(0.3, 0.3, 1.72), (0.6, 1.0, 2.0)] {
        let text = contact(mu, scale, amplitude, 100);
        let text = format!("name = \"noise\"\nseed = 1\n{text}{STEADY_AIR}{gains}");
        let test = first_test(&rig(&text));
        let [friction, stiffness] = errors(&test, &found(&test));
        println!("mu {mu}, scale {scale}: {friction:.4} {stiffness:.4}");
        assert!(
            friction.abs() < 0.01,
            "mu {mu}, scale {scale}: friction {friction}"
        );
        assert!(
            stiffness.abs() < 0.05,
            "mu {mu}, scale {scale}: stiffness {stiffness}"
        );
    }
}

/// An elastic travel of 0.17 and 0.034 um, below the steps of 0.08 um: all samples of the cycle tell the displacement of the few that stick.
///
/// Seen to fail without the multiple of the force in the displacement: no smooth motion is found, and the stiffness is far off.
#[test]
fn a_travel_below_a_step_is_found() {
    let gains = "[force_cells]\nerror_percent = 0\n[support]\noffset_mm = 0\n";
    for (mu, scale, amplitude, tolerance) in [(0.9, 3.0, 2.2, 0.03), (0.6, 10.0, 1.25, 0.06)] {
        let text = contact(mu, scale, amplitude, 100);
        let rig = rig(&format!(
            "name = \"small\"\nseed = 1\n{text}{STEADY_AIR}{gains}"
        ));
        let test = first_test(&rig);
        let result = found(&test);
        let [friction, stiffness] = errors(&test, &result);
        let case = format!("mu {mu}, scale {scale}: {friction:.4} {stiffness:.4}");
        assert!(friction.abs() < 0.01, "{case}");
        assert!(stiffness.abs() < tolerance, "{case}");
        assert!(
            holds_stiffness(&test, &result),
            "{case}: not in its interval"
        );
    }
}

/// At 400 and 600 Hz the box of the published rig, itself at 5 kHz, vibrates with a fifth of the force, and the contact sticks for a
/// moment before it reverses. With the map of the pressure friction and stiffness are as near as at 100 Hz; its frequency, that of box and half the strip
/// on K11, is found.
///
/// The benchmark `closed_loop -- frequencies` has the figures without the correction: friction 4.9 % low and a stiffness 26 times too large at
/// mu 0.3, scale 0.3 and 600 Hz. With the mean of the whole plateau friction was 1.9 % low at mu 0.6, scale 1 and 400 Hz; with a displacement that follows
/// the force of the cell alone stiffnesses of a short travel were up to 80 % off.
#[test]
fn the_mass_before_the_force_cell_is_taken_out() {
    let gains = "[force_cells]\nerror_percent = 0\n[support]\noffset_mm = 0\n";
    for (mu, scale, amplitude) in [(0.3, 0.3, 1.72), (0.6, 1.0, 2.0), (0.9, 3.0, 2.2)] {
        for frequency in [400.0, 600.0] {
            let text = contact(mu, scale, amplitude, 100);
            let text = format!(
                "name = \"fast\"\nseed = 1\n{text}frequencies_hz = [{frequency}]\n{STEADY_AIR}{gains}"
            );
            let rig = rig(&text);
            let stand = rig.stand().unwrap();
            let test = rig.test(&stand, 0);
            let map = KnownPressure::new(&stand.map.pressure_map());
            let result = identify_pressed_test(&test.record, &IdentifySettings::default(), &map);
            let [friction, stiffness] = errors(&test, &result);
            let resonance = result.cycles.unwrap().force_resonance.unwrap();
            let case = format!(
                "mu {mu}, scale {scale}, {frequency} Hz: {friction:.4} {stiffness:.4} {resonance:?}"
            );
            println!("{case}");
            assert!(friction.abs() < 0.002, "{case}");
            assert!(stiffness.abs() < 0.02, "{case}");
            let own = (150e6_f64 / 0.15).sqrt() / std::f64::consts::TAU;
            assert!((resonance.frequency_hz / own - 1.0).abs() < 0.01, "{case}");
            assert!((resonance.damping_ratio - 0.01).abs() < 0.001, "{case}");
            let told = |note: &String| note.contains("the force cell has a resonance at 50");
            assert!(result.notes.iter().any(told), "{case}: {:?}", result.notes);
        }
    }
}

fn holds_stiffness(test: &VirtualTest, result: &TestResult) -> bool {
    let estimate = result.estimate.as_ref().unwrap();
    let interval = estimate.tangential.stiffness_n_per_um;
    (interval.lower..=interval.upper).contains(&test.truth.tangential_stiffness_n_per_um)
}

/// Of 20 tests of a contact with `scale` times the stiffness under a noise of a quarter of a step: those whose interval holds the truth.
fn held_with_steps(scale: f64, amplitude_um: f64) -> usize {
    let text = contact(0.6, scale, amplitude_um, 20)
        .replace("[excitation]", "[excitation]\nrepetitions = 20");
    let chain = "[force_cells]\nerror_percent = 0\n[support]\noffset_mm = 0\n\
                 [vibrometer]\nnoise_um = 0.02\ndrift_um_per_s = 0.02\n";
    let rig = rig(&format!(
        "name = \"steps\"\nseed = 1\n{text}{STEADY_AIR}{chain}"
    ));
    let stand = rig.stand().unwrap();
    let tests = (0..20).map(|index| rig.test(&stand, index));
    tests
        .filter(|test| holds_stiffness(test, &found(test)))
        .count()
}

/// Noise of a quarter of a step leaves the same error in all cycles; the intervals know of it. Of 20 intervals of 95 % fewer than 17
/// hold the truth once in 60.
///
/// Seen to fail without the parts of the phase that are left out in turn.
#[test]
fn intervals_know_of_steps_that_do_not_average_out() {
    let held = held_with_steps(1.0, 2.0);
    assert!(held >= 17, "{held} of 20");
}

/// Where the elastic travel, 0.03 µm, is shorter than a step of 0.08 µm, the parts of the phase do not tell the error of steps, either.
///
/// Seen to fail without the error of a slope by the steps that are left.
#[test]
fn intervals_know_of_steps_longer_than_the_travel() {
    let held = held_with_steps(10.0, 1.0);
    assert!(held >= 17, "{held} of 20");
}

/// A motion that is too small for slip: no friction coefficient, a bound below the truth, and the stiffness.
///
/// Seen to fail with tails that rise taken for plateaus.
#[test]
fn a_contact_that_sticks_is_told() {
    let rig = exact(&format!("{}{STEADY_AIR}", contact(1.2, 0.1, 2.0, 3)));
    let test = first_test(&rig);
    assert_eq!(test.slip, Slip::Partial, "{:?}", test.motion.mobilised);
    let result = found(&test);
    assert_eq!(result.status, TestStatus::NoSlip, "{:?}", result.notes);
    let estimate = result.estimate.unwrap();
    assert!(estimate.friction.is_none(), "{:?}", estimate.friction);
    let bound = estimate.friction_at_least.unwrap();
    assert!(bound > 0.1 && bound < 1.2, "{bound}");
    let stiffness = estimate.tangential.stiffness_n_per_um.value / 23.3 - 1.0;
    assert!(stiffness.abs() < 0.05, "{stiffness}");
}
