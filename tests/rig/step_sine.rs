//! Resonances of two blades by force cell and vibrometer, step by step.

use super::command::{RIG, run};
use super::response::coarse_study;
use microslip::record::read_response;
use microslip::rig::Rig;
use microslip::rig::chain::VibrometerSettings;
use microslip::rig::noise::{Noise, Purpose};
use microslip::rig::settings::StepSineSettings;
use microslip::rig::step_sine::{Step, fitted_peak};

/// A vibrometer shows the first harmonic of a motion with an offset, a drift and a third harmonic to the noise of its samples; a motion beyond its
/// range is cut. Seen to fail with the drift left in.
#[test]
fn a_step_shows_the_first_harmonic() {
    let settings = StepSineSettings::default();
    let vibrometer = VibrometerSettings::default();
    let motion = [5e-6, 3e-6, 4e-6, 1e-6, -2e-6];
    let mut noise = Noise::new(1, Purpose::Response, 0);
    let seen = |motion: &[f64], noise: &mut Noise| {
        settings.step(&vibrometer, (100.0, 5e-6), (&[0, 1, 3], motion), noise)
    };
    let step = seen(&motion, &mut noise);
    // noise and steps of 0.08 um of 2000 samples
    let deviation = (0.04e-6_f64.powi(2) + 0.08e-6_f64.powi(2) / 12.0).sqrt() / 1000_f64.sqrt();
    assert!(
        (step.amplitude_m - 5e-6).abs() < 4.0 * deviation,
        "{step:?}"
    );
    assert_eq!(step.out_of_range, 0);
    let large = seen(&[0.0, 210e-6, 0.0, 0.0, 0.0], &mut noise);
    assert!(
        large.out_of_range > 100 && large.amplitude_m < 210e-6,
        "{large:?}"
    );
}

/// Steps at these frequencies (Hz) of a response of this amplitude (m), with a relative error `error` each.
fn steps(
    frequencies: Vec<f64>,
    amplitude: impl Fn(f64) -> f64,
    error: f64,
    noise: &mut Noise,
) -> Vec<Step> {
    let step = |frequency_hz: f64| Step {
        frequency_hz,
        amplitude_m: amplitude(frequency_hz) * (1.0 + error * noise.normal()),
        out_of_range: 0,
    };
    frequencies.into_iter().map(step).collect()
}

/// Amplitudes of an oscillator with a relative error `error` each.
fn oscillator(settings: &StepSineSettings, error: f64, noise: &mut Noise) -> Vec<Step> {
    let (f0, zeta) = (2620.0, 1e-3);
    let amplitude = |f: f64| {
        let x: f64 = f / f0;
        2.0 * zeta * 1e-5 / (1.0 - x * x).hypot(2.0 * zeta * x)
    };
    let frequencies = settings.frequencies(f0, zeta * f0, 0.0);
    steps(frequencies, amplitude, error, noise)
}

/// The maximum of an oscillator is found exactly, and with errors within two of its deviations in 92 % of the tests: nine fitted steps leave four
/// degrees of freedom, which alone make 88 %, and the deviations also hold what a degree less of the polynomial changes. Seen to fail with equal
/// weights.
#[test]
fn a_fitted_peak_knows_its_error() {
    let settings = StepSineSettings::default();
    let mut noise = Noise::new(2, Purpose::Response, 0);
    let exact = fitted_peak(&oscillator(&settings, 0.0, &mut noise)).unwrap();
    assert!(
        (exact.frequency_hz / 2620.0 - 1.0).abs() < 2e-6,
        "{exact:?}"
    );
    assert!((exact.amplitude_m / 1e-5 - 1.0).abs() < 1e-4, "{exact:?}");
    let n = 2000;
    let mut inside = [0; 2];
    for _ in 0..n {
        let found = fitted_peak(&oscillator(&settings, 0.01, &mut noise)).unwrap();
        let missed = [
            (found.frequency_hz - 2620.0) / found.frequency_deviation_hz,
            (found.amplitude_m - 1e-5) / found.amplitude_deviation_m,
        ];
        for (inside, missed) in inside.iter_mut().zip(missed) {
            *inside += i32::from(missed.abs() < 2.0);
        }
    }
    let shares = inside.map(|inside| f64::from(inside) / f64::from(n));
    println!("within two deviations: {shares:?}");
    for share in shares {
        assert!((0.88..0.94).contains(&share), "{shares:?}");
    }
    let flank: Vec<Step> = oscillator(&settings, 0.0, &mut noise).split_off(9);
    assert_eq!(fitted_peak(&flank), None, "a flank has no maximum");
}

/// Amplitudes around a lopsided resonance, as that of a contact that slips, with a relative error of 0.1 % each.
fn lopsided(settings: &StepSineSettings, noise: &mut Noise) -> Vec<Step> {
    let (f0, half_width) = (2620.0, 2.62);
    let amplitude = |f: f64| {
        let u: f64 = (f - f0) / half_width;
        1e-5 / (1.0 + u * u - 0.4 * u.powi(3) + 0.1 * u.powi(4)).sqrt()
    };
    let frequencies = settings.frequencies(f0, half_width, noise.even() - 0.5);
    steps(frequencies, amplitude, 1e-3, noise)
}

/// The maximum of a lopsided resonance is found within the deviations, which are a small part of its width. A parabola alone is four of its
/// deviations away in the median, 0.22 Hz at most, and never within two. Seen to fail with it.
#[test]
fn the_maximum_of_a_lopsided_resonance_is_found() {
    let settings = StepSineSettings::default();
    let mut noise = Noise::new(3, Purpose::Response, 0);
    let n = 500;
    let (mut inside, mut worst) = (0, 0.0_f64);
    for _ in 0..n {
        let found = fitted_peak(&lopsided(&settings, &mut noise)).unwrap();
        let missed = (found.frequency_hz - 2620.0).abs();
        inside += i32::from(missed < 2.0 * found.frequency_deviation_hz);
        worst = worst.max(missed);
        assert!(found.frequency_deviation_hz < 0.2, "{found:?}");
        assert!((found.amplitude_m / 1e-5 - 1.0).abs() < 0.01, "{found:?}");
    }
    println!("{inside} of {n} within two deviations, at most {worst:.3} Hz away");
    assert!(inside >= n * 95 / 100, "{inside}");
    assert!(worst < 0.1, "{worst}");
}

/// Force cell and vibrometer find the resonance of a strip that sticks within the errors of the fit, and that of one that slips and opens, where the
/// response jumps, to a step. The force is wrong by the gain of its cell, which the deviation of the amplitude knows. Seen to fail with a cell without
/// error.
#[test]
fn resonances_are_found_step_by_step() {
    let folder = tempfile::tempdir().unwrap();
    let study = coarse_study().replace("levels = [20.0]", "levels = [1.0, 5.0]");
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let response = "[response]\nstudy = \"study.toml\"\n[response.step_sine]\nsteps = 15\n";
    let text = format!("{RIG}{response}").replace("specimens = 2", "specimens = 1");
    let output = run(folder.path(), &text, &[]);
    assert!(output.status.success(), "{output:?}");
    let rig = Rig::parse(&folder.path().join("rig.toml"), &text).unwrap();
    let found = rig.resonances().unwrap();
    assert_eq!(found.len(), 2, "two levels of one specimen");
    let read = read_response(&folder.path().join("out/response-0001.csv")).unwrap();
    for ((resonance, point), accuracy) in found.iter().zip(read.points).zip([0.003, 0.03]) {
        println!("{:?}", resonance.peak);
        let peak = resonance.peak.unwrap();
        let error = (resonance.force_n / resonance.level - 1.0).abs();
        assert!(error > 1e-5 && error < 0.03, "{resonance:?}");
        let missed = peak.frequency_hz - peak.true_frequency_hz;
        assert!(
            missed.abs() < 3.0 * peak.frequency_deviation_hz + 2e-3,
            "{peak:?}"
        );
        let missed = peak.amplitude_um / peak.true_amplitude_um - 1.0;
        assert!(missed.abs() < accuracy, "{peak:?}");
        assert!(
            peak.amplitude_deviation_um > 0.005 * peak.amplitude_um,
            "{peak:?}"
        );
        assert!((point.frequency_hz / peak.frequency_hz - 1.0).abs() < 1e-12);
    }
    let steps = std::fs::read_to_string(folder.path().join("out/steps-0001.csv")).unwrap();
    assert_eq!(steps.lines().count(), 2 + 2 * 15);
}

/// The fit states the deviations. Seen to fail with them taken in silence.
#[test]
fn stated_deviations_do_not_go_with_steps() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), coarse_study()).unwrap();
    for (keys, expected) in [
        (
            "frequency_deviation_hz = 0.1\n[response.step_sine]",
            "rig.toml:18: response.frequency_deviation_hz = 0.1: must be absent with [response.step_sine]",
        ),
        (
            "[response.step_sine]\nsteps = 3",
            "rig.toml:19: response.step_sine.steps = 3: must be from 5 to 501",
        ),
    ] {
        let text = format!("{RIG}[response]\nstudy = \"study.toml\"\n{keys}\n");
        let output = run(folder.path(), &text, &[]);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains(expected), "{error}");
    }
}
