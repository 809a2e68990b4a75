//! Configuration b: resonances of two blades with the strip, as a laboratory would measure them.

use super::noise::{Noise, Purpose};
use super::read::Rig;
use super::settings::ResponseSettings;
use crate::Error;
use crate::ensemble::stop::Stop;
use crate::sampling::DesignSettings;
use crate::study::{EvaluationError, Evaluator, ModelSettings, Study};
use crate::units::{m_to_um, n_per_um_to_n_per_m};

/// A resonance of one specimen at one level, true and measured.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MeasuredResonance {
    /// Index of the specimen, 0-based.
    pub specimen: u64,
    /// Excitation level (N).
    pub level: f64,
    /// How the search for the peak ended.
    pub status: &'static str,
    /// The peak, if found.
    pub peak: Option<MeasuredPeak>,
}

/// Frequency and amplitude of a resonance.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct MeasuredPeak {
    /// Measured (Hz).
    pub frequency_hz: f64,
    /// Measured (µm).
    pub amplitude_um: f64,
    /// Standard deviation of the measured frequency (Hz).
    pub frequency_deviation_hz: f64,
    /// Standard deviation of the measured amplitude (µm).
    pub amplitude_deviation_um: f64,
    /// True frequency (Hz).
    pub true_frequency_hz: f64,
    /// True amplitude (µm).
    pub true_amplitude_um: f64,
}

impl Rig {
    /// Resonances of every specimen at every level of the study; empty without `[response]`.
    ///
    /// # Errors
    /// What the model of the study refuses.
    pub fn resonances(&self) -> Result<Vec<MeasuredResonance>, Error> {
        let (Some(settings), Some(study)) = (&self.response, &self.study) else {
            return Ok(Vec::new());
        };
        let mut all = Vec::new();
        for index in 0..self.contact.specimens {
            all.extend(self.of_specimen(settings, index, study.clone())?);
        }
        Ok(all)
    }

    fn of_specimen(
        &self,
        settings: &ResponseSettings,
        index: u64,
        mut study: Study,
    ) -> Result<Vec<MeasuredResonance>, Error> {
        let truth = self.specimen(index);
        if let ModelSettings::TwoBladeStrip { interface, .. } = &mut study.model {
            interface.friction_coefficient = truth.friction_coefficient;
            interface.tangential_stiffness =
                n_per_um_to_n_per_m(truth.tangential_stiffness_n_per_um);
            interface.normal_stiffness = n_per_um_to_n_per_m(truth.normal_stiffness_n_per_um);
        }
        let without_inputs = DesignSettings {
            samples: Some(1),
            ..DesignSettings::default()
        };
        study.design = (without_inputs.build()).map_err(|bad| study.bad_setting(&bad))?;
        study.output.curve_samples = 0;
        let path = study.path.clone();
        let never = Stop::default();
        let failed = |error: EvaluationError| Error::unfit(&path, error.to_string());
        let model = Evaluator::solved(study.into_prepared()?, 0, &never, |_| {});
        let model = model.map_err(failed)?;
        let nominal: [&[f64]; 1] = [&[]];
        let levels = model.evaluate(&nominal, &never).map_err(failed)?;
        let mut noise = Noise::new(self.seed, Purpose::Response, index);
        let measured = levels.into_iter().flatten().map(|level| {
            let errors = [noise.normal(), noise.normal()];
            let peak = level.peak.map(|peak| {
                let true_amplitude_um = m_to_um(peak.amplitude_m);
                let share = 1e-2 * settings.amplitude_deviation_percent;
                let deviations = [settings.frequency_deviation_hz, share * true_amplitude_um];
                MeasuredPeak {
                    frequency_hz: peak.frequency_hz + deviations[0] * errors[0],
                    amplitude_um: true_amplitude_um + deviations[1] * errors[1],
                    frequency_deviation_hz: deviations[0],
                    amplitude_deviation_um: deviations[1],
                    true_frequency_hz: peak.frequency_hz,
                    true_amplitude_um,
                }
            });
            MeasuredResonance {
                specimen: index,
                level: level.level,
                status: level.status.name(),
                peak,
            }
        });
        Ok(measured.collect())
    }
}
