//! The motion of the contact against formulas that know nothing of its march.

use super::{STEADY_AIR, exact, first_test};
use microslip::rig::Slip;

/// Work of T over the recorded cycles (J), by the trapezoidal rule.
fn work(u: &[f64], t: &[f64]) -> f64 {
    let steps = u.windows(2).zip(t.windows(2));
    steps
        .map(|(u, t)| 0.5 * (t[0] + t[1]) * (u[1] - u[0]))
        .sum()
}

/// Work per cycle in gross slip is the sum over pairs of 4 μN (U − μN/k), with U half of the swing of u.
///
/// Seen to fail with the mean load as that of every pair.
#[test]
fn gross_slip_dissipates_what_masing_says() {
    for load in [
        "kind = \"air\"\nregulator_noise_percent = 0",
        "kind = \"punch\"",
    ] {
        let text = format!(
            "[loading]\n{load}\n[excitation]\nfrequencies_hz = [5]\ncycles = 2\nrun_in_cycles = 2\nsamples_per_cycle = 1000"
        );
        let rig = exact(&text);
        let map = rig.load_map().unwrap();
        let test = first_test(&rig);
        assert_eq!(test.slip, Slip::Gross, "{load}");
        let (u, t) = (&test.motion.displacement, &test.motion.tangential);
        // one whole cycle: from a sample to the same phase
        let found = work(&u[..=1000], &t[..=1000]);
        let swing = |x: &[f64]| {
            let most = x.iter().fold(f64::MIN, |m, x| m.max(*x));
            0.5 * (most - x.iter().fold(f64::MAX, |m, x| m.min(*x)))
        };
        let amplitude = swing(u);
        let area: f64 = map.cells.iter().map(|cell| cell.area).sum();
        let pairs = map.cells.iter().zip(&map.loads);
        let expected: f64 = pairs
            .map(|(cell, load)| {
                let limit = 0.6 * load;
                4.0 * limit * (amplitude - limit / (233e6 * cell.area / area))
            })
            .sum();
        assert!(
            (found / expected - 1.0).abs() < 2e-4,
            "{load}: {found} {expected} J"
        );
        let plateau = 0.6 * map.loads.iter().sum::<f64>();
        assert!(
            (swing(t) / plateau - 1.0).abs() < 1e-9,
            "{load}: {} N",
            swing(t)
        );
    }
}

/// A contact that sticks is a chain of springs: platform, k_t, strip (with the punch beside it), box. At 5 Hz the mass of neither matters.
///
/// Seen to fail with the whole overlap in the strip's free length, with twice K11, and without the punch's stiffness.
#[test]
fn a_sticking_contact_is_springs_in_series() {
    let contact = "[contact]\nfriction_coefficient = 5\n";
    let excitation =
        "[excitation]\nfrequencies_hz = [5]\namplitude_um = 0.5\ncycles = 1\nrun_in_cycles = 2";
    for (loading, beside) in [(STEADY_AIR, 0.0), ("[loading]\nkind = \"punch\"\n", 50e6)] {
        let rig = exact(&format!("{contact}{loading}{excitation}"));
        let test = first_test(&rig);
        assert_eq!(test.slip, Slip::Partial, "{:?}", test.motion.mobilised);
        let k_t: f64 = 233e6;
        // E l t over the gap and half of the overlap: 0.6 + 2.35 mm
        let strip: f64 = 210e9 * 50e-3 * 0.4e-3 / 2.95e-3 + beside;
        let series = 1.0 / (1.0 / k_t + 1.0 / strip + 1.0 / 150e6);
        let largest = |signal: &[f64]| signal.iter().fold(0.0f64, |m, x| m.max(*x));
        let most = largest(&test.motion.tangential);
        let ratio = most / (series * 0.5e-6);
        assert!((ratio - 1.0).abs() < 1e-4, "{loading}: {most} N, {ratio}");
        let u = largest(&test.motion.displacement);
        assert!((u / (most / k_t) - 1.0).abs() < 1e-6, "{loading}: {u} m");
    }
}

/// Inertia of the box, of strip and punch: the transducer's force over that of the contact while it sticks, from the
/// linear equations at one frequency without damping.
///
/// Seen to fail with the mass of the punch or that of the box left out.
#[test]
fn inertia_is_in_the_measured_force() {
    let contact = "[contact]\nfriction_coefficient = 5\n";
    let excitation =
        "[excitation]\nfrequencies_hz = [600]\namplitude_um = 0.5\ncycles = 1\nrun_in_cycles = 30";
    let punch = "[loading]\nkind = \"punch\"\n";
    let rig = exact(&format!("{contact}{punch}{excitation}"));
    let test = first_test(&rig);
    let amplitude = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0f64, |m, x| m.max(x.abs()));
    let felt = amplitude(&mut test.motion.felt.iter().map(|felt| felt[0]));
    let contact = amplitude(&mut test.motion.tangential.iter().copied());
    let square = (std::f64::consts::TAU * 600.0).powi(2);
    let strip = 210e9 * 50e-3 * 0.4e-3 / 2.95e-3 + 50e6;
    let moving = 0.05 + 0.5 * 7850.0 * 10e-3 * 50e-3 * 0.4e-3;
    let to_box = 150e6 - 0.15 * square;
    // box per contact force: [k + to_box, ...] with the moving mass on the spring k
    let share = strip / (strip - moving * square);
    let expected = share / (to_box + strip - strip * share) * 150e6;
    assert!((expected - 1.0) > 0.01, "{expected}: nothing to see");
    assert!(
        (felt / contact / expected - 1.0).abs() < 2e-3,
        "{} {expected}",
        felt / contact
    );
}

/// The march is converged, with friction and the punch's mass at 300 Hz: four times the steps change the displacement by less than
/// 1e-3 of its largest value in the root mean square, and the force, which the punch makes ring after each reversal, by 6e-3.
///
/// Seen to fail with velocities by differences of first order.
#[test]
fn the_march_is_converged() {
    let with = |samples: usize| {
        let text = format!(
            "[loading]\nkind = \"punch\"\n[excitation]\nfrequencies_hz = [300]\ncycles = 1\nrun_in_cycles = 3\nsamples_per_cycle = {samples}"
        );
        first_test(&exact(&text)).motion
    };
    let (coarse, fine) = (with(1000), with(4000));
    let largest = |x: &[f64]| x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    for (name, coarse, fine, most) in [
        ("u", &coarse.displacement, &fine.displacement, 1e-3),
        ("T", &coarse.tangential, &fine.tangential, 6e-3),
    ] {
        let difference = coarse.iter().zip(fine.iter().step_by(4));
        let difference: Vec<f64> = difference.map(|(a, b)| a - b).collect();
        let square: f64 = difference.iter().map(|d| d * d).sum();
        let share = (square / difference.len() as f64).sqrt() / largest(fine);
        println!("{name}: {share:.1e}");
        assert!(share < most, "{name}: {share}");
    }
}
