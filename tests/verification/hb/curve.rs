//! The forced response around a peak against a densely followed one.

use super::invariants::settings;
use super::models::plane;
use super::polyline::{distance, half_width, points};
use crate::response::over_band;
use crate::two_blade::folded;
use microslip::contact::{Events, FrictionLaw};
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::response::curve::{CURVE_ERROR, ResponseCurve, response_curve};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{Balance, LinearModel, Problem, SliderAnchor, Solution};
use std::f64::consts::TAU;

/// Largest amplitude of the points of `dense` that lie beyond all before them in the direction `sign` of the frequency: those that a
/// slow sweep meets, which jumps at folds.
fn met<'a>(dense: impl Iterator<Item = &'a Solution>, sign: f64) -> f64 {
    let mut front = f64::NEG_INFINITY;
    let ahead = dense.filter(|s| {
        let ahead = sign * s.omega > front;
        front = front.max(sign * s.omega);
        ahead
    });
    ahead.map(|s| s.amplitude(0)).fold(0.0, f64::max)
}

/// What sweeps meet against the dense branch. Whether there are several solutions at some frequency.
fn check_sweeps(curve: &ResponseCurve, dense: &[Solution], [width, top]: [f64; 2]) -> bool {
    let sweeps = curve.sweeps.expect("a branch through the band");
    let upward = met(dense.iter(), 1.0);
    let downward = met(dense.iter().rev(), -1.0);
    println!("sweeps {sweeps:?}, dense {upward:.6e} {downward:.6e}");
    for (found, dense) in [(sweeps.upward, upward), (sweeps.downward, downward)] {
        assert!(
            (found.amplitude - dense).abs() < 1.5 * CURVE_ERROR * top,
            "{found:?} {dense}"
        );
    }
    let pairs = || dense.windows(2);
    let back = pairs().filter(|s| s[1].omega < s[0].omega);
    let ends = back.fold(None, |ends: Option<[f64; 2]>, s| {
        let [low, high] = ends.unwrap_or([s[1].omega, s[0].omega]);
        Some([low.min(s[1].omega), high.max(s[0].omega)])
    });
    // folds narrower than the error of the curve are none
    let range = ends.map_or(0.0, |[low, high]| high - low);
    match sweeps.several {
        Some(_) => assert!(range > 0.0, "no fold: {sweeps:?}"),
        None => assert!(range < 2.0 * CURVE_ERROR * width, "missed: {ends:?}"),
    }
    for (found, dense) in sweeps.several.iter().flatten().zip(ends.iter().flatten()) {
        assert!(
            (found - dense).abs() < 2.0 * CURVE_ERROR * width,
            "{sweeps:?} {ends:?} {width}"
        );
    }
    sweeps.several.is_some()
}

/// The curves at some levels, on harmonics up to 3, against dense ones. Levels at which there are several solutions at some frequency.
fn check(problem: &Problem<'_>, band: Band, levels: &[f64]) -> Vec<f64> {
    let mut folded = Vec::new();
    let mut settings = settings(3, FrictionLaw::Box);
    settings.aft.events = Events::Located;
    settings.newton.tolerance = 1e-9;
    let search = PeakSettings {
        band,
        frequency_tolerance: 1e-7,
    };
    let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
    for found in track_peaks(problem, &settings, search, levels).expect("modes") {
        let peak = found.solution.expect("a peak");
        let dense = over_band(problem, &settings, found.level, band);
        let top = peak.amplitude(0);
        let width = half_width(&dense, top);
        let before = problem.effort.count();
        let curve = response_curve(&balance, &peak.point(), band, &settings);
        let count = problem.effort.count().since(before);
        if check_sweeps(&curve, &dense, [width, top]) {
            folded.push(found.level);
        }
        let curve = curve.points;
        let places: Vec<_> = (curve.iter())
            .map(|p| [p.omega / width, p.amplitude / top])
            .collect();
        let error = distance(&places, &points(&dense, [width, top]));
        println!(
            "{} N: {} points, {count:?}, error {error:.1e}",
            found.level,
            curve.len()
        );
        let ends = [curve[0].omega, curve[curve.len() - 1].omega];
        let margin = 0.2 * band.width();
        assert!(
            ends[0] < band.low + margin && ends[1] > band.high - margin,
            "{ends:?}"
        );
        assert!(curve.is_sorted_by(|a, b| a.omega < b.omega), "ascending");
        assert!(error < CURVE_ERROR, "{} N: {error:e}", found.level);
    }
    folded
}

/// The rig from stick to lift-off, and lumped blades whose curve folds over at 40 N. Seen to fail with long steps over
/// folds: the rig's curve at 100 N jumps across the resonance and ends 9 Hz above it; and without added solutions: 3.6e-3
/// at 5 N.
#[test]
fn curves_are_as_exact_as_they_say() {
    let band = |low: f64, high: f64| Band {
        low: low * TAU,
        high: high * TAU,
    };
    let anchor = SliderAnchor::Unloaded;
    let (linear, contacts) = folded(1.0, 0.4);
    let problem = Problem::new(&linear, contacts, 1.0, anchor).expect("held");
    let rig = check(&problem, band(2605.0, 2635.0), &[0.1, 5.0, 20.0, 100.0]);
    let case = plane(-1.0);
    let linear = LinearModel::new(&case.model).expect("definite");
    let problem = Problem::new(&linear, case.contacts, 1.0, anchor).expect("held");
    let blades = check(&problem, band(320.0, 450.0), &[1.0, 20.0, 40.0]);
    println!("several solutions at {rig:?} N and {blades:?} N");
    assert!(
        rig.contains(&5.0) && !rig.contains(&0.1),
        "contacts that open lean the curve over"
    );
    assert_eq!(blades, [40.0], "contacts that open lean the curve over");
}

/// Random samples of the rig, at levels at which every contact sticks, and at higher ones, which must not be taken for linear. Seen to
/// fail at 8 N with 5.2 times the stiffness and a friction coefficient of 0.12: the continuation is 3.2e-3 wrong there, which
/// `docs/src/limits.md` states.
#[test]
fn curves_of_random_samples_are_as_exact_as_they_say() {
    let band = Band {
        low: 2605.0 * TAU,
        high: 2635.0 * TAU,
    };
    for (scale, mu, levels) in [
        (0.13, 0.71, &[0.02, 0.1, 1.0, 8.0][..]),
        (0.31, 0.16, &[0.02, 0.1, 1.0, 8.0]),
        (0.62, 0.44, &[0.02, 0.1, 1.0, 8.0]),
        (1.4, 0.27, &[0.02, 0.1, 1.0, 8.0]),
        (2.7, 0.58, &[0.02, 0.1, 1.0, 8.0]),
        (5.2, 0.12, &[0.02, 0.1, 1.0]),
    ] {
        println!("stiffness x {scale}, friction coefficient {mu}");
        let (linear, contacts) = folded(scale, mu);
        let problem = Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held");
        check(&problem, band, levels);
    }
}

/// At 0.1 N every contact of the rig sticks: the curve takes no continuation, which took 78 iterations there on all harmonics and so
/// failed this test. At 20 N pairs slip, and it does take it.
///
/// Seen to fail with every curve followed as one of slipping contacts.
#[test]
fn curves_of_sticking_contacts_are_cheap() {
    let band = Band {
        low: 2605.0 * TAU,
        high: 2635.0 * TAU,
    };
    let (linear, contacts) = folded(1.0, 0.4);
    let problem = Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held");
    let mut settings = settings(3, FrictionLaw::Box);
    settings.aft.events = Events::Located;
    let search = PeakSettings {
        band,
        frequency_tolerance: 1e-7,
    };
    let balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
    let found = track_peaks(&problem, &settings, search, &[0.1, 20.0]).expect("modes");
    let steps = found.into_iter().map(|found| {
        let peak = found.solution.expect("a peak").point();
        let before = problem.effort.count();
        let curve = response_curve(&balance, &peak, band, &settings);
        assert!(
            curve.sweeps.is_some(),
            "from one end of the band to the other"
        );
        problem.effort.count().since(before).iterations
    });
    let steps: Vec<usize> = steps.collect();
    println!("Newton iterations {steps:?}");
    assert!(steps[0] < 40 && steps[1] > 60, "{steps:?}");
}
