//! The default rig, its settings and the box of the default study.

use microslip::aft::{AftSettings, Laps};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::ensemble::{Ensemble, SampleSolver};
use microslip::harmonics::HarmonicSet;
use microslip::hb::peak::maxima::PeakChoice;
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    AlertSettings, HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, StabilityScope,
};
use microslip::model::ReducedModel;
use microslip::model::two_blade::{TwoBladeSettings, build};
use microslip::sampling::{Design, Distribution, Input, Shape};
use microslip::units::hz_to_rad_s;

pub(crate) const LEVELS: [f64; 7] = [0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// The default rig on half of its contacts.
pub(crate) struct Rig {
    pub(crate) linear: LinearModel,
    pub(crate) contacts: Vec<ContactParameters<f64>>,
}

impl Rig {
    pub(crate) fn new(contact_nodes: [usize; 2]) -> Self {
        let settings = TwoBladeSettings {
            contact_nodes,
            ..TwoBladeSettings::default()
        };
        let model = build(&settings).expect("valid").reduced;
        let each = 0.5 * model.n_contacts() as f64;
        let contact = ContactParameters {
            k_n: 1e9 / each,
            k_t: [2.33e8 / each; 2],
            mu: 0.6,
            n_0: 0.0,
            anchor: [0.0; 2],
        };
        Self::folded(&model, vec![contact; model.n_contacts()])
    }

    /// A rig with these pairs, on half of them.
    pub(crate) fn folded(model: &ReducedModel, mut contacts: Vec<ContactParameters<f64>>) -> Self {
        let linear = LinearModel::folded(model, &contacts)
            .expect("definite")
            .expect("a mirror");
        contacts.truncate(linear.n_contacts());
        Self { linear, contacts }
    }

    pub(crate) fn problem(&self, scale: f64, mu: f64) -> Problem<'_> {
        let scaled = |c: &ContactParameters<f64>| ContactParameters {
            k_n: c.k_n * scale,
            k_t: c.k_t.map(|k| k * scale),
            mu,
            ..*c
        };
        let contacts = self.contacts.iter().map(scaled).collect();
        Problem::new(&self.linear, contacts, 1.0, SliderAnchor::Unloaded).expect("held")
    }

    pub(crate) fn ensemble<'a>(
        &'a self,
        design: &'a Design,
        levels: &'a [f64],
        settings: &'a HbSettings,
    ) -> Ensemble<'a> {
        Ensemble {
            linear: &self.linear,
            strips: None,
            mistuned: None,
            contacts: &self.contacts,
            interfaces: &[],
            loads: &[],
            design,
            levels,
            settings,
            peak: search(),
            choice: PeakChoice::Highest,
            mode_numbers: &[],
            curve_samples: 0,
            gpu: None,
            solver: SampleSolver::HarmonicBalance,
        }
    }
}

pub(crate) fn search() -> PeakSettings {
    PeakSettings {
        band: Band {
            low: hz_to_rad_s(2605.0),
            high: hz_to_rad_s(2635.0),
        },
        frequency_tolerance: 1e-9,
    }
}

pub(crate) fn settings(highest: usize, alert: Option<AlertSettings>) -> HbSettings {
    HbSettings {
        harmonics: HarmonicSet::up_to(highest),
        aft: AftSettings {
            n_time: (12 * highest).next_power_of_two().max(128),
            law: FrictionLaw::Box,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        anchor: SliderAnchor::Unloaded,
        newton: NewtonSettings::default(),
        alert,
        stability: StabilityScope::Off,
    }
}

/// The box of the default study.
pub(crate) fn design(seed: u64) -> Design {
    let new = |shape| Distribution::new(shape, None).expect("valid");
    let log_uniform = Shape::LogUniform {
        low: 0.1,
        high: 10.0,
    };
    let uniform = Shape::Uniform {
        low: 0.1,
        high: 0.8,
    };
    let inputs = vec![
        (Input::StiffnessScale, new(log_uniform)),
        (Input::FrictionCoefficient, new(uniform)),
    ];
    Design::new(seed, inputs).expect("valid")
}
