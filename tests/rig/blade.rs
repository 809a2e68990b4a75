//! The blade under a constant force, near its resonance: the march of its modes against the matrices of the whole model, by a linear
//! solve where the strip sticks and by harmonic balance where it slips.

use super::{STEADY_AIR, exact};
use faer::Mat;
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::branch::sweep::SweepDirection;
use microslip::hb::response::values::{SlowSweep, at_frequencies};
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, Solution, StabilityScope,
};
use microslip::model::two_blade::build;
use microslip::model::{ContactPair, ReducedModel, Response, SparseRow};
use microslip::rig::{Rig, Slip, VirtualTest};
use microslip::units::hz_to_rad_s;
use nalgebra::{Complex, DMatrix, DVector};

/// A rig whose blade is damped more than steel, so that it settles soon.
fn blade_rig(frequencies: &[f64], mu: f64, force: f64) -> Rig {
    exact(&format!(
        "[contact]\nfriction_coefficient = {mu}\n[strip]\ncontact_nodes = [3, 2]\n{STEADY_AIR}
        [excitation]\nfrequencies_hz = {frequencies:?}\nrun_in_cycles = 20\ncycles = 2\n
        [blade]\nforce_n = {force}\ndamping_ratio = 2e-3\nsettling_cycles = 700\n"
    ))
}

fn tests(rig: &Rig) -> Vec<VirtualTest> {
    let stand = rig.stand().unwrap();
    let all = 0..rig.number_of_tests();
    all.map(|index| rig.test(&stand, index)).collect()
}

/// Blade 1 of the two-blade model, whole, then the strip's moving half and the box: matrices, contact pairs and the response
/// of the platform. The numbers of strip and box are written down anew.
fn whole_model(rig: &Rig) -> ReducedModel {
    let settings = rig.blade.as_ref().unwrap().model(&rig.strip);
    let blades = build(&settings).unwrap().reduced;
    let n = (blades.dof_names.iter())
        .filter(|name| name.starts_with("blade1."))
        .count();
    let (strip, support): (f64, f64) = (210e9 * 50e-3 * 0.4e-3 / 2.95e-3, 150e6);
    let (moving, of_box) = (0.5 * 7850.0 * 10e-3 * 50e-3 * 0.4e-3, 0.15);
    let strip_loss = strip * 0.004 / hz_to_rad_s(1e3);
    let support_loss = 2.0 * 0.01 * f64::sqrt(support * of_box);
    let with = |blade: &Mat<f64>, between: f64, [of_strip, of_support]: [f64; 2]| {
        Mat::from_fn(n + 2, n + 2, |i, j| match (i, j) {
            _ if i < n && j < n => blade[(i, j)],
            _ if i == n && j == n => of_strip + between,
            _ if i == n + 1 && j == n + 1 => of_support + between,
            _ if i >= n && j >= n => -between,
            _ => 0.0,
        })
    };
    let interface = || blades.contacts.iter().filter(|pair| pair.interface == 0);
    let area: f64 = interface().map(|pair| pair.area).sum();
    let platform: SparseRow = interface()
        .map(|pair| (pair.t1[1].0, pair.area / area))
        .collect();
    let less_platform = platform.iter().map(|&(dof, weight)| (dof, -weight));
    let slide: SparseRow = [(n, 1.0)].into_iter().chain(less_platform).collect();
    let cells = rig.load_map().unwrap().cells;
    let pair = |(i, cell): (usize, &microslip::model::two_blade::InterfaceCell)| ContactPair {
        name: i.to_string(),
        t1: slide.clone(),
        t2: vec![],
        n: vec![],
        area: cell.area,
        interface: 0,
    };
    let mut force = blades.cosine_force[..n].to_vec();
    force.extend([0.0; 2]);
    ReducedModel {
        name: "blade, strip and box".to_owned(),
        dof_names: (0..n + 2).map(|i| i.to_string()).collect(),
        mass: with(&blades.mass, 0.0, [moving, of_box]),
        damping: with(&blades.damping, strip_loss, [0.0, support_loss]),
        stiffness: with(&blades.stiffness, strip, [0.0, support]),
        retention: None,
        contacts: cells.iter().enumerate().map(pair).collect(),
        static_force: vec![0.0; n + 2],
        loads: vec![],
        sine_force: vec![0.0; n + 2],
        cosine_force: force,
        responses: vec![Response {
            name: "platform".to_owned(),
            row: platform,
        }],
        mirror: None,
    }
}

/// Displacement of the platform per N with all pairs stuck: the complex dynamic stiffness at one frequency, solved.
fn stuck_receptance(model: &ReducedModel, k_t: f64, frequency_hz: f64) -> Complex<f64> {
    let omega = hz_to_rad_s(frequency_hz);
    let n = model.n_dofs();
    let mut stiffness = DMatrix::from_fn(n, n, |i, j| {
        let real = model.stiffness[(i, j)] - omega * omega * model.mass[(i, j)];
        Complex::new(real, omega * model.damping[(i, j)])
    });
    for &(i, a) in &model.contacts[0].t1 {
        for &(j, b) in &model.contacts[0].t1 {
            stiffness[(i, j)] += k_t * a * b;
        }
    }
    let force = DVector::from_fn(n, |i, _| Complex::new(model.cosine_force[i], 0.0));
    let moved = stiffness.lu().solve(&force).unwrap();
    let row = &model.responses[0].row;
    row.iter().map(|&(dof, weight)| moved[dof] * weight).sum()
}

/// The test's amplitude (m) and phase as one complex number against the cosine of the force.
fn found(test: &VirtualTest) -> Complex<f64> {
    let platform = test.platform.unwrap();
    Complex::from_polar(1e-6 * platform.amplitude_um, -platform.lag_deg.to_radians())
}

/// The resonance of the stuck blade that moves the platform most, up to 5 kHz.
fn resonance(rig: &Rig, model: &ReducedModel) -> f64 {
    let listed = rig.blade_frequencies(&rig.stand().unwrap()).unwrap();
    let receptance = |f: &f64| stuck_receptance(model, 233e6, *f).norm();
    let tested = listed.stuck_hz.into_iter().filter(|f| *f < 5e3);
    tested
        .max_by(|a, b| receptance(a).total_cmp(&receptance(b)))
        .unwrap()
}

/// A strip that sticks: around the resonance amplitude and phase of the platform are those of the linear structure, whole and
/// without modes.
///
/// Seen to fail without the modes at rest, and with the traction on the platform left out.
#[test]
fn a_stuck_blade_has_its_linear_resonance() {
    let model = whole_model(&blade_rig(&[100.0], 10.0, 0.01));
    let peak = resonance(&blade_rig(&[100.0], 10.0, 0.01), &model);
    let frequencies = [0.9, 0.997, 1.0, 1.003, 1.1].map(|share| share * peak);
    let rig = blade_rig(&frequencies, 10.0, 0.01);
    let mut amplitudes = Vec::new();
    for (test, frequency) in tests(&rig).iter().zip(frequencies) {
        assert_eq!(test.slip, Slip::Partial, "{frequency} Hz");
        let expected = 0.01 * stuck_receptance(&model, 233e6, frequency);
        let found = found(test);
        let error = (found - expected).norm() / expected.norm();
        println!("{frequency:.1} Hz: {error:.1e}, {:.3e} m", found.norm());
        assert!(error < 1e-3, "{frequency} Hz: {found} {expected}");
        amplitudes.push(found.norm());
    }
    assert!(
        amplitudes[2] > 5.0 * amplitudes[0].max(amplitudes[4]),
        "no resonance: {amplitudes:?}"
    );
}

fn harmonic_balance(rig: &Rig, model: &ReducedModel, force: f64, hz: &[f64]) -> Vec<Solution> {
    let map = rig.load_map().unwrap();
    let area: f64 = map.cells.iter().map(|cell| cell.area).sum();
    let pairs = map.cells.iter().zip(&map.loads);
    let contacts = pairs.map(|(cell, load)| ContactParameters {
        k_n: 0.0,
        k_t: [233e6 * cell.area / area, 0.0],
        mu: 0.6,
        n_0: *load,
        anchor: [0.0; 2],
    });
    let linear = LinearModel::new(model).unwrap();
    let anchor = SliderAnchor::Unloaded;
    let problem = Problem::new(&linear, contacts.collect(), 1.0, anchor).unwrap();
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(31),
        aft: AftSettings {
            n_time: 256,
            law: FrictionLaw::Box,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        anchor,
        newton: NewtonSettings::default(),
        alert: None,
        stability: StabilityScope::Off,
    };
    let omega: Vec<f64> = hz.iter().map(|f| hz_to_rad_s(*f)).collect();
    let sweep = SlowSweep {
        band: Band {
            low: omega[0],
            high: omega[omega.len() - 1],
        },
        direction: SweepDirection::Upward,
        omega: &omega,
    };
    at_frequencies(&problem, &settings, force, sweep, |_| ()).solutions
}

/// A strip that slips: platform and work of friction per cycle around the resonance are those of harmonic balance with 31 harmonics of
/// the whole model. The force alone, without the traction, would move the platform otherwise.
///
/// Seen to fail with the traction on the platform left out, without the modes at rest, and with the phase ahead of the force.
#[test]
fn a_slipping_blade_is_that_of_harmonic_balance() {
    const FORCE: f64 = 300.0;
    let model = whole_model(&blade_rig(&[100.0], 0.6, FORCE));
    let peak = resonance(&blade_rig(&[100.0], 0.6, FORCE), &model);
    let frequencies = [0.98, 0.998, 1.0, 1.004].map(|share| share * peak);
    let rig = blade_rig(&frequencies, 0.6, FORCE);
    let solutions = harmonic_balance(&rig, &model, FORCE, &frequencies);
    for (test, solution) in tests(&rig).iter().zip(&solutions) {
        assert!(solution.status.has_solution(), "{:?}", solution.status);
        let frequency = test.record.conditions.frequency_hz.unwrap();
        let expected = solution.first_harmonic(0);
        let expected = Complex::new(expected.re, expected.im);
        let error = (found(test) - expected).norm() / expected.norm();
        let cycle = rig.excitation.samples_per_cycle;
        let (u, t) = (&test.motion.displacement, &test.motion.tangential);
        let work: f64 = (0..cycle)
            .map(|i| 0.5 * (t[i] + t[i + 1]) * (u[i + 1] - u[i]))
            .sum();
        let work_error = work / solution.work.friction - 1.0;
        println!(
            "{frequency:.1} Hz: {error:.1e}, work {work_error:.1e}, {:?}, {:.3e} m",
            test.slip,
            expected.norm()
        );
        assert!(error < 1e-3, "{frequency} Hz: {} {expected}", found(test));
        assert!(work_error.abs() < 1e-2, "{frequency} Hz: {work} J");
        assert_eq!(test.slip, Slip::Gross, "{frequency} Hz");
    }
}
