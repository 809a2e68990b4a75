//! The equivalent damping ratio of a resonance against modal damping, half-power width and the closed form of a slipping
//! element.

use super::invariants::settings;
use super::models::{Case, jenkins};
use crate::two_blade::contacts;
use faer::Mat;
use microslip::aft::AftSettings;
use microslip::contact::FrictionLaw;
use microslip::hb::newton::rest::stiffness_at_rest;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::response::curve::response_curve;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{Balance, LinearModel, Problem, SliderAnchor, Solution};
use microslip::linalg::symmetric_generalized_eigen;
use microslip::model::ReducedModel;
use microslip::model::two_blade::{TwoBladeSettings, build};
use microslip::units::hz_to_rad_s;
use std::f64::consts::PI;

/// Peak of a Jenkins oscillator with so many harmonics.
fn peak(case: &Case, highest: usize, n_time: usize, level: f64) -> Solution {
    let linear = LinearModel::new(&case.model).expect("definite");
    let anchor = SliderAnchor::Unloaded;
    let problem = Problem::new(&linear, case.contacts.clone(), 1.0, anchor).expect("held");
    let mut settings = settings(highest, FrictionLaw::Box);
    settings.aft.n_time = n_time;
    let search = PeakSettings {
        band: Band {
            low: 0.5,
            high: 2.0,
        },
        frequency_tolerance: 1e-8,
    };
    let found = track_peaks(&problem, &settings, search, &[level]).expect("modes");
    let found = &found[0];
    found
        .solution
        .clone()
        .unwrap_or_else(|| panic!("{:?}", found.status))
}

/// A linear oscillator has its own damping ratio ζ, but for the place of the maximum: the displacement is largest at
/// ω₀ √(1 − 2ζ²), so that c / (2 m ω) is ζ / √(1 − 2ζ²).
#[test]
fn a_linear_oscillator_has_its_own_damping_ratio() {
    let k_t: f64 = 0.5;
    let omega_0 = (1.0 + k_t).sqrt();
    for zeta in [1e-3, 0.02, 0.1] {
        let stuck = jenkins(2.0 * zeta * omega_0, k_t, 1e4);
        let found = peak(&stuck, 3, 128, 1.0).damping_ratio().expect("moves");
        let expected = zeta / (1.0 - 2.0 * zeta * zeta).sqrt();
        println!("{zeta}: {:.1e}", found / expected - 1.0);
        assert!(
            (found / expected - 1.0).abs() < 2e-6,
            "{found}, not {expected}"
        );
    }
}

/// A slipping element dissipates 4 µN (X − X_c) per cycle beside π c ω X², and the mass has ½ ω² X².
#[test]
fn slip_adds_its_work_over_the_energy() {
    let (k_t, limit, c) = (0.5, 1.0, 0.01);
    let found = peak(&jenkins(c, k_t, limit), 1, 1024, 0.8);
    let (x, omega) = (found.amplitude(0), found.omega);
    let friction = 4.0 * limit * (x - limit / k_t);
    let viscous = PI * c * omega * x * x;
    let energy = 0.5 * omega * omega * x * x;
    let expected = (friction + viscous) / (4.0 * PI * energy);
    let ratio = found.damping_ratio().expect("moves");
    println!(
        "X {x:.5} damping ratio {ratio:.6}, {:.1e}",
        ratio / expected - 1.0
    );
    assert!(ratio > 0.05, "it must slip: {ratio}");
    assert!(
        (ratio / expected - 1.0).abs() < 1e-5,
        "{ratio}, not {expected}"
    );
}

/// Half the width of a curve at 1/√2 of its top, over the frequency there.
fn half_power(curve: &[(f64, f64)]) -> f64 {
    let higher = |a: &usize, b: &usize| curve[*a].1.total_cmp(&curve[*b].1);
    let top = (0..curve.len()).max_by(higher).expect("points");
    let level = curve[top].1 / 2f64.sqrt();
    let crossing = |[(x0, y0), (x1, y1)]: [(f64, f64); 2]| {
        ((y0 - level) * (y1 - level) <= 0.0).then(|| x0 + (level - y0) / (y1 - y0) * (x1 - x0))
    };
    let crossings: Vec<f64> = (curve.windows(2))
        .filter_map(|w| crossing([w[0], w[1]]))
        .collect();
    assert_eq!(crossings.len(), 2, "two flanks");
    0.5 * (crossings[1] - crossings[0]) / curve[top].0
}

/// The rig on coarse blades while nothing slips: the damping ratio is the modal one of the stuck structure, at a tenth, one and
/// ten times the stiffness, and that of the half-power width of the curve.
#[test]
fn the_stuck_rig_has_modal_damping() {
    let coarse = TwoBladeSettings {
        blade_element_mm: [20.0, 50.0, 20.0],
        blade_cut_off_hz: 8e3,
        strip_cut_off_hz: 3e3,
        contact_nodes: [3, 2],
        ..TwoBladeSettings::default()
    };
    let rig = build(&coarse).expect("builds");
    let free = rig.free_neck_bending();
    let band = Band {
        low: hz_to_rad_s(free - 5.0),
        high: hz_to_rad_s(free + 25.0),
    };
    let linear = LinearModel::new(&rig.reduced).expect("definite");
    for scale in [0.1, 1.0, 10.0] {
        let contacts = contacts(&rig.reduced, scale, 0.6);
        let problem = Problem::new(&linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held");
        let settings = settings(1, FrictionLaw::Box);
        let search = PeakSettings {
            band,
            frequency_tolerance: 1e-8,
        };
        let found = track_peaks(&problem, &settings, search, &[1e-4]).expect("modes");
        let stiffness = stuck(&rig.reduced, &problem, settings.aft, band.low);
        let solution = found[0].solution.as_ref().expect("a peak");
        let ratio = solution.damping_ratio().expect("moves");
        let modal = modal_ratio(&stiffness, &rig.reduced, solution.omega);
        let balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
        let curve = response_curve(&balance, &solution.point(), band, &settings);
        let points: Vec<(f64, f64)> = curve
            .points
            .iter()
            .map(|p| (p.omega, p.amplitude))
            .collect();
        let width = half_power(&points);
        println!(
            "stiffness {scale}: damping ratio {ratio:.6e}, modal {:.1e}, half-power {:.1e}",
            ratio / modal - 1.0,
            ratio / width - 1.0
        );
        assert!((ratio / modal - 1.0).abs() < 1e-5, "{ratio}, not {modal}");
        assert!((ratio / width - 1.0).abs() < 0.02, "{ratio}, width {width}");
    }
}

/// Stiffness of the structure with the contacts that are closed at rest: on a coarse grid some are open.
fn stuck(model: &ReducedModel, problem: &Problem<'_>, aft: AftSettings, omega: f64) -> Mat<f64> {
    let mut stiffness = model.stiffness.clone();
    let springs = stiffness_at_rest(problem, aft, omega);
    let pairs = model.contacts.iter();
    let rows = (pairs.clone().map(|pair| &pair.t1))
        .chain(pairs.clone().map(|pair| &pair.t2))
        .chain(pairs.map(|pair| &pair.n));
    for (row, k) in rows.zip(springs) {
        for (i, a) in row {
            for (j, b) in row {
                stiffness[(*i, *j)] += k * a * b;
            }
        }
    }
    stiffness
}

/// φᵀCφ / (2ω), for φᵀMφ = 1, of the mode near `omega` that the force excites: in phase and out of phase lie close together.
fn modal_ratio(stiffness: &Mat<f64>, model: &ReducedModel, omega: f64) -> f64 {
    let (lambda, phi) =
        symmetric_generalized_eigen(stiffness.as_ref(), model.mass.as_ref()).expect("definite");
    let force = |mode: usize| -> f64 {
        let products = model.cosine_force.iter().enumerate();
        products.map(|(i, f)| f * phi[(i, mode)]).sum::<f64>().abs()
    };
    let near = |mode: &usize| (lambda[*mode].max(0.0).sqrt() / omega - 1.0).abs() < 1e-3;
    let modes = (0..lambda.len()).filter(near);
    let excited = modes.max_by(|a, b| force(*a).total_cmp(&force(*b)));
    let mode = excited.expect("a mode");
    let shape = phi.col(mode);
    (shape.transpose() * &model.damping * shape) / (2.0 * lambda[mode].sqrt())
}
