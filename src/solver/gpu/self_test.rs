//! Does the device compute right? One known batch against the processor, before a run believes it.

use super::adapter::Device;
use super::audit::{decide, differences};
use super::error::GpuError;
use super::kernels::Kernels;
use super::scaled::ScaledStates;
use super::settings::Precision;
use super::settings::{Fault, GpuSettings};
use super::shader::ShaderKey;
use crate::aft::AftForces;
use crate::aft::AftPlan;
use crate::aft::{AftBatch, Want};
use crate::aft::{AftScratch, evaluate};
use crate::aft::{AftSettings, Laps};
use crate::contact::{ContactParameters, FrictionLaw};
use crate::harmonics::HarmonicSet;

/// States of the test: more than one workgroup.
const STATES: usize = 96;
/// States that may be left to the processor.
const UNDECIDED: usize = STATES / 8;
/// Largest differences of forces and derivatives that rounding explains; in the circle law it decides where the search of
/// the steady cycle ends.
const fn limits(law: FrictionLaw) -> [f64; 2] {
    match law {
        FrictionLaw::Box => [2e-5, 2e-3],
        FrictionLaw::Circle => [2e-4, 2e-2],
    }
}

/// Evaluates stuck, slipping and lifting states on the device and compares them with the processor's. Returns the largest difference of the
/// forces, over the largest force that the motion of the state could cause, and that of the derivatives, over its largest stiffness.
///
/// # Errors
/// [`GpuError::SelfTest`] if they differ, and whatever the device says.
pub fn self_test(device: &Device, settings: &GpuSettings) -> Result<[f64; 2], GpuError> {
    let set = HarmonicSet::up_to(3);
    let aft = AftSettings {
        n_time: 64,
        law: settings.law,
        events: settings.events,
        laps: Laps::Periodic,
    };
    let plan = AftPlan::new(&set, aft);
    let batch = known_states(&set);
    let failed = |message: String| GpuError::SelfTest { message };
    let shape = ShaderKey::of(&plan, Precision::F32).ok_or_else(|| {
        failed(format!(
            "there is no shader of the {:?} law with {:?} events",
            settings.law, settings.events
        ))
    })?;
    let states = ScaledStates::new(&batch).ok_or_else(|| failed("no states".to_owned()))?;
    let kernels = Kernels::new(device, shape)?;
    let buffers = kernels.buffers(device, STATES)?;
    let result = kernels.evaluate(device, &buffers, &[&states], Want::ForcesAndTangents)?;
    let scaled = match result.parts.first() {
        Some(scaled) if scaled.undecided.len() <= UNDECIDED => scaled,
        _ => return Err(failed("known states are undecided".to_owned())),
    };
    let (mut found, mut exact) = (AftForces::default(), AftForces::default());
    states.unscale(&plan, &batch, scaled, &mut found);
    decide(&plan, &batch, &scaled.undecided, &mut found);
    if settings.fault == Some(Fault::WrongSelfTest) {
        found.forces[STATES / 2] *= 1.01;
    }
    let scratch = &mut AftScratch::default();
    evaluate(&plan, &batch, Want::ForcesAndTangents, scratch, &mut exact);
    let differences = differences(&batch, &found, &exact);
    let limits = limits(settings.law);
    match differences.iter().zip(limits).all(|(d, limit)| *d <= limit) {
        true => Ok(differences),
        false => Err(failed(format!(
            "forces differ by {:.1e}, derivatives by {:.1e}",
            differences[0], differences[1]
        ))),
    }
}

/// Stuck, slipping and lifting states, from a formula.
fn known_states(set: &HarmonicSet) -> AftBatch<f64> {
    let m = set.n_coefficients();
    let wave = |i: usize| (1.7 * i as f64 + 0.3).sin();
    let displacement = (0..3 * m * STATES).map(|i| {
        let (row, state) = (i / STATES, i % STATES);
        let order = set.orders()[(row % m).div_ceil(2)].max(1) as f64;
        let size = 0.2 + 3.0 * state as f64 / STATES as f64;
        1e-7 * size * wave(i) / (order * order)
    });
    let parameters = (0..STATES).map(|i| ContactParameters {
        k_n: 2e7,
        k_t: [1.1e7, 0.9e7],
        mu: 0.4 + 0.2 * wave(i),
        n_0: 2.0,
        anchor: [2e-8, -1e-8],
    });
    AftBatch {
        n_states: STATES,
        displacement: displacement.collect(),
        parameters: parameters.collect(),
    }
}

/// What `devices` says of one adapter.
#[must_use]
pub fn examined(index: usize) -> String {
    let device = match Device::open(Some(&index.to_string()), 0, Precision::F32) {
        Ok(device) => device,
        Err(error) => return format!("failed: {error}"),
    };
    let laws = [
        (FrictionLaw::Box, "box law"),
        (FrictionLaw::Circle, "circle law"),
    ];
    let tested = laws.map(|(law, name)| {
        let settings = GpuSettings {
            law,
            ..GpuSettings::default()
        };
        match self_test(&device, &settings) {
            Ok([force, derivative]) => {
                format!("{name} passed (forces {force:.1e}, derivatives {derivative:.1e})")
            }
            Err(error) => format!("{name}: {error}"),
        }
    });
    tested.join("; ")
}
