//! From the inputs of a sample to its outcome, for many samples at once.
//!
//! The outcome of sample i is a function of the study and i alone: samples share nothing but read-only data, so the
//! number of threads and the order of the samples change no bit.

use super::outcome::{CurvePoint, LevelOutcome, PeakRecord, SampleOutcome};
use crate::contact::ContactParameters;
use crate::hb::curve::response_curve;
use crate::hb::peak::PeakSettings;
use crate::hb::track::{LevelPeak, track_peaks};
use crate::hb::{Balance, HbSettings, LinearModel, Problem, ProblemError, Solution, Status};
use crate::sampling::{Design, Input};
use crate::units::rad_s_to_hz;
use rayon::prelude::*;

/// What all samples of a study share.
#[derive(Debug, Clone, Copy)]
pub struct Ensemble<'a> {
    /// Linear part of the model.
    pub linear: &'a LinearModel,
    /// Nominal constants of the contact pairs.
    pub contacts: &'a [ContactParameters<f64>],
    /// Random inputs.
    pub design: &'a Design,
    /// Excitation levels, ascending.
    pub levels: &'a [f64],
    /// Solver.
    pub settings: &'a HbSettings,
    /// Where peaks are searched and how exactly.
    pub peak: PeakSettings,
}

impl Ensemble<'_> {
    /// Outcomes of the samples 0 … `samples` − 1, in that order; `done` is called after each, from any thread.
    #[must_use]
    pub fn run(&self, samples: u64, done: impl Fn() + Sync) -> Vec<SampleOutcome> {
        (0..samples)
            .into_par_iter()
            .map(|index| {
                let outcome = self.sample(index);
                done();
                outcome
            })
            .collect()
    }

    /// Outcome of one sample.
    #[must_use]
    pub fn sample(&self, index: u64) -> SampleOutcome {
        self.outcome(index, self.design.sample(index))
    }

    /// Outcome at the nominal constants of the study. Inputs are NaN-free but meaningless: none was sampled.
    #[must_use]
    pub fn nominal(&self) -> SampleOutcome {
        self.outcome(0, Vec::new())
    }

    /// Outcome at the given inputs, in the order of the design; nominal where `inputs` is empty.
    fn outcome(&self, index: u64, inputs: Vec<f64>) -> SampleOutcome {
        let values = self
            .design
            .inputs()
            .iter()
            .map(|(input, _)| *input)
            .zip(inputs.iter().copied());
        let (contacts, load_scale) = apply_inputs(self.contacts, values);
        let levels = Problem::new(self.linear, contacts, load_scale, self.settings.anchor)
            .and_then(|problem| self.levels_of(&problem))
            .unwrap_or_else(|error| self.without_problem(&error));
        SampleOutcome {
            index,
            inputs,
            levels,
        }
    }

    fn levels_of(&self, problem: &Problem<'_>) -> Result<Vec<LevelOutcome>, ProblemError> {
        let peaks = track_peaks(problem, self.settings, self.peak, self.levels)?;
        Ok(peaks
            .into_iter()
            .map(|peak| self.level(problem, peak))
            .collect())
    }

    /// Record of one level, with the forced response through its peak.
    fn level(&self, problem: &Problem<'_>, peak: LevelPeak) -> LevelOutcome {
        let mut count = peak.count;
        // the picture needs the study's own harmonics only; the peak may have more
        let curve = peak
            .on_first_harmonics
            .as_ref()
            .map_or_else(Vec::new, |start| {
                let harmonics = self.settings.harmonics.clone();
                let balance = Balance::new(problem, harmonics, self.settings.aft);
                let (curve, work) =
                    response_curve(&balance, start, self.peak.band, self.settings.newton);
                count += work;
                curve
            });
        LevelOutcome {
            level: peak.level,
            status: peak.status,
            peak: peak.solution.as_ref().map(record),
            curve: curve
                .iter()
                .map(|point| CurvePoint {
                    frequency_hz: rad_s_to_hz(point.omega),
                    amplitude_m: point.amplitude,
                })
                .collect(),
            newton_iterations: count.iterations,
            factorizations: count.factorizations,
        }
    }

    /// A sample whose constants make no harmonic balance problem fails at every level.
    fn without_problem(&self, error: &ProblemError) -> Vec<LevelOutcome> {
        let status = match error {
            ProblemError::Linalg(_) => Status::NonFinite,
            _ => Status::NotHeld,
        };
        (self.levels.iter())
            .map(|&level| LevelOutcome {
                level,
                status,
                peak: None,
                curve: Vec::new(),
                newton_iterations: 0,
                factorizations: 0,
            })
            .collect()
    }
}

/// Contact constants and factor on the static load at the given input values.
fn apply_inputs(
    nominal: &[ContactParameters<f64>],
    values: impl Iterator<Item = (Input, f64)>,
) -> (Vec<ContactParameters<f64>>, f64) {
    let mut contacts = nominal.to_vec();
    let mut load_scale = 1.0;
    for (input, value) in values {
        for contact in &mut contacts {
            match input {
                Input::StiffnessScale => {
                    contact.k_n *= value;
                    contact.k_t = contact.k_t.map(|k| k * value);
                }
                Input::NormalStiffnessScale => contact.k_n *= value,
                Input::TangentialStiffnessScale => contact.k_t = contact.k_t.map(|k| k * value),
                Input::FrictionCoefficient => contact.mu = value,
                Input::StaticLoadScale => {}
            }
        }
        if input == Input::StaticLoadScale {
            load_scale = value;
        }
    }
    (contacts, load_scale)
}

fn record(solution: &Solution) -> PeakRecord {
    PeakRecord {
        frequency_hz: rad_s_to_hz(solution.omega),
        amplitude_m: solution.amplitude(0),
        truncation_error: solution.truncation_error,
        highest_harmonic: solution.harmonics.highest(),
        stick_fraction: solution.contact.stick,
        slip_fraction: solution.contact.slip,
        separated_fraction: solution.contact.separated,
        work_input_j: solution.work.input,
        work_viscous_j: solution.work.viscous,
        work_friction_j: solution.work.friction,
        residual: solution.residual,
    }
}
