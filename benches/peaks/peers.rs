//! The reference problem blades-strip-oop.

use crate::iteration::print_iteration;
use crate::rates::measured;
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{Events, FrictionLaw};
use microslip::ensemble::{Ensemble, SampleSolver};
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::maxima::PeakChoice;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{Balance, HbSettings, LinearModel, Problem, StabilityScope};
use microslip::sampling::{Design, Distribution, Input, Shape};
use microslip::study::Study;
use microslip::units::hz_to_rad_s;
use std::path::Path;

pub(crate) fn peers() {
    let path = Path::new("tests/reference/blades-strip-oop/study.toml");
    let study = Study::read(path).expect("the reference study");
    let model = study.build_model().expect("the reference model");
    let linear = LinearModel::new(&model.reduced).expect("definite");
    let settings = HbSettings {
        harmonics: HarmonicSet::up_to(5),
        aft: AftSettings {
            n_time: 256,
            law: FrictionLaw::Circle,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        alert: None,
        stability: StabilityScope::Off,
        ..study.solver.clone()
    };
    let design = wide_box();
    // that of the reference ends at 325 Hz; stiff contacts with much friction peak at up to 331 Hz
    let [low, high] = [270.0, 340.0].map(hz_to_rad_s);
    let ensemble = Ensemble {
        linear: &linear,
        strips: None,
        mistuned: None,
        contacts: &model.contacts,
        interfaces: &[],
        loads: &[],
        design: &design,
        levels: &[0.5],
        settings: &settings,
        peak: PeakSettings {
            band: Band { low, high },
            frequency_tolerance: 1e-6,
        },
        choice: PeakChoice::Highest,
        mode_numbers: &[],
        curve_samples: 0,
        gpu: None,
        solver: SampleSolver::HarmonicBalance,
    };
    println!("pairs  H    compliance  contact  motion  Jacobian and two solves (ms, fastest of 5)");
    for mu in [0.2, 0.5, 0.8] {
        let mut contacts = model.contacts.clone();
        contacts.iter_mut().for_each(|c| c.mu = mu);
        let problem = Problem::new(&linear, contacts, 1.0, settings.anchor).expect("held");
        let peak = track_peaks(&problem, &settings, ensemble.peak, &[0.5]).expect("modes");
        let balance = Balance::new(&problem, settings.harmonics.clone(), settings.aft);
        print_iteration(&balance, peak[0].solution.as_ref().expect("a peak"));
    }
    for samples in [256, 1024, 4096] {
        measured("blades-strip-oop", &ensemble, samples);
    }
}

/// A decade around the stiffnesses of the reference, on both sides, and friction coefficients from 0.1 to 0.9.
fn wide_box() -> Design {
    let new = |shape| Distribution::new(shape, None).expect("valid");
    let factor = || Shape::LogUniform {
        low: 0.1,
        high: 10.0,
    };
    let mu = Shape::Uniform {
        low: 0.1,
        high: 0.9,
    };
    let inputs = vec![
        (Input::NormalStiffnessScale, new(factor())),
        (Input::TangentialStiffnessScale, new(factor())),
        (Input::FrictionCoefficient, new(mu)),
    ];
    Design::new(3, inputs).expect("valid")
}
