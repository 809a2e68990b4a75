//! Floquet multipliers against time integration of the full nonlinear equations, closed forms and the balance equations.
//!
//! `disturbed` gives the tests that compare with time integration; `relations` holds what multipliers obey by themselves.

mod curve;
mod disk;
mod disturbed;
mod relations;

use super::models::plane;
use crate::response::over_band;
use crate::two_blade::RIG;
use microslip::aft::{AftSettings, Laps};
use microslip::contact::{ContactParameters, Events, FrictionLaw};
use microslip::harmonics::HarmonicSet;
use microslip::hb::newton::{Condition, Iterate, solve};
use microslip::hb::peak::search::PeakSettings;
use microslip::hb::peak::track::track_peaks;
use microslip::hb::stability::period_map::PeriodicMotion;
use microslip::hb::structure::resonance::Band;
use microslip::hb::{
    Balance, HbSettings, LinearModel, NewtonSettings, Problem, SliderAnchor, Solution,
    StabilityScope,
};
use microslip::model::ReducedModel;
use std::f64::consts::TAU;

fn settings(highest: usize) -> HbSettings {
    HbSettings {
        harmonics: HarmonicSet::up_to(highest),
        aft: AftSettings {
            n_time: 1024,
            law: FrictionLaw::Box,
            events: Events::Located,
            laps: Laps::Periodic,
        },
        anchor: SliderAnchor::Unloaded,
        newton: NewtonSettings {
            tolerance: 1e-9,
            ..NewtonSettings::default()
        },
        alert: None,
        stability: StabilityScope::All,
    }
}

/// The two lumped blades, forces in phase (1) or against each other (−1), the strip with the damping `strip` (1/s).
fn blades(phase: f64, strip: f64) -> (LinearModel, Vec<ContactParameters<f64>>) {
    let mut case = plane(phase);
    for (dof, mass) in [(2, 1.58e-3), (3, 1.58e-3), (4, 1.58e-3 * 1e-4 / 12.0)] {
        case.model.damping[(dof, dof)] = strip * mass;
    }
    let linear = LinearModel::new(&case.model).expect("definite");
    (linear, case.contacts)
}

/// The branch at one level over a band (Hz).
fn branch(problem: &Problem<'_>, level: f64, [low, high]: [f64; 2]) -> Vec<Solution> {
    let band = Band {
        low: low * TAU,
        high: high * TAU,
    };
    let mut curve = over_band(problem, &settings(5), level, band);
    curve.retain(|s| s.status.has_solution());
    curve
}

/// The solution at `hertz` where the branch passes this frequency for the `nth` time.
fn passing(curve: &[Solution], hertz: f64, nth: usize) -> &Solution {
    let below = |s: &Solution| s.omega < hertz * TAU;
    let mut pairs = curve.windows(2).filter(|w| below(&w[0]) != below(&w[1]));
    &pairs.nth(nth).expect("the branch passes there")[0]
}

/// The solution next to `start`, at `hertz`, on harmonics up to 36.
fn raised<'p>(
    problem: &'p Problem<'p>,
    start: &Solution,
    hertz: f64,
    law: FrictionLaw,
) -> (Balance<'p>, Iterate<'p>) {
    let mut settings = settings(5);
    settings.aft.law = law;
    let mut point = start.point();
    point.omega = hertz * TAU;
    let mut balance = Balance::new(problem, start.harmonics.clone(), settings.aft);
    let fixed = Condition::FixedFrequency;
    let mut iterate = solve(&balance, point, fixed, settings.newton).expect("a solution");
    for highest in [9, 15, 24, 36] {
        let larger = Balance::new(problem, HarmonicSet::up_to(highest), settings.aft);
        let padded = iterate.point.padded(&balance, &larger);
        iterate = solve(&larger, padded, fixed, settings.newton).expect("a solution");
        balance = larger;
    }
    (balance, iterate)
}

fn motion<'a>(balance: &'a Balance<'_>, iterate: &'a Iterate<'_>) -> PeriodicMotion<'a> {
    PeriodicMotion {
        harmonics: &balance.harmonics,
        relative: &iterate.point.r,
        omega: iterate.point.omega,
        law: balance.law(),
    }
}

/// The rig, with the force on one of its blades turned round or not.
fn rig(turned: bool) -> ReducedModel {
    let mut model = RIG.reduced.clone();
    let image = &model.mirror.as_ref().expect("a mirror").image;
    for (i, force) in model.cosine_force.iter_mut().enumerate() {
        if turned && image[i].0 < i {
            *force = -*force;
        }
    }
    model
}

/// Peaks of the rig at ascending levels.
fn rig_peaks(problem: &Problem<'_>, levels: &[f64], law: FrictionLaw) -> Vec<Solution> {
    let free = RIG.free_neck_bending();
    let search = PeakSettings {
        band: Band {
            low: (free - 8.0) * TAU,
            high: (free + 22.0) * TAU,
        },
        frequency_tolerance: 1e-9,
    };
    let mut settings = settings(3);
    settings.aft.n_time = 128;
    settings.aft.law = law;
    let found = track_peaks(problem, &settings, search, levels).expect("modes");
    found.into_iter().filter_map(|peak| peak.solution).collect()
}
