//! Configuration b: resonances of two blades with the strip, as a laboratory would measure them: with errors of a stated size, or step by step by
//! force cell and vibrometer (`step_sine`).

use super::chain::{Calibration, DEVIATIONS_OF_LIMIT};
use super::noise::{Noise, Purpose};
use super::read::Rig;
use super::settings::{PressedBy, ResponseSettings, StepSineSettings};
use super::step_sine::{Step, fitted_peak, largest_step};
use crate::Error;
use crate::ensemble::atlas::Atlas;
use crate::ensemble::outcome::{LevelOutcome, PeakRecord};
use crate::hb::response::values::{SlowSweep, at_frequencies};
use crate::sampling::DesignSettings;
use crate::study::{ModelSettings, PreparedStudy, Study};
use crate::units::{hz_to_rad_s, m_to_um, n_per_um_to_n_per_m, um_to_m};

/// Status of a resonance that was not found among the steps.
const NO_MAXIMUM: &str = "no maximum among the steps";

/// A resonance of one specimen at one level, true and measured.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MeasuredResonance {
    /// Index of the specimen, 0-based.
    pub specimen: u64,
    /// Excitation level (N), as the laboratory has it.
    pub level: f64,
    /// Amplitude of the force that acts (N).
    pub force_n: f64,
    /// Static load that presses the strip on both blades (N).
    pub strip_load_n: f64,
    /// How the search for the peak ended.
    pub status: &'static str,
    /// The peak, if found.
    pub peak: Option<MeasuredPeak>,
    /// The steps that it was measured by; empty where its errors have a stated size.
    #[serde(skip)]
    pub steps: Vec<Step>,
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
    /// True frequency under the force that acts (Hz).
    pub true_frequency_hz: f64,
    /// True amplitude under the force that acts (µm).
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
        study: Study,
    ) -> Result<Vec<MeasuredResonance>, Error> {
        let (mut study, strip_load_n) = self.study_of(settings, index, study)?;
        let stated = study.levels.clone();
        let gain = match settings.step_sine {
            None => 1.0,
            Some(_) => self.gain_of_force(index),
        };
        // the force is held where its cell shows the level
        study.levels.iter_mut().for_each(|level| *level /= gain);
        let prepared = study.prepared()?;
        let levels = prepared.ensemble(None).levels(&[], &Atlas::default());
        let mut noise = Noise::new(self.seed, Purpose::Response, index);
        let mut places = Noise::new(self.seed, Purpose::Steps, index);
        let mut measured = Vec::new();
        for (level, stated) in levels.iter().zip(stated) {
            let (peak, steps) = match &settings.step_sine {
                None => {
                    let errors = [noise.normal(), noise.normal()];
                    let measured = level.peak.map(|peak| with_errors(&peak, settings, errors));
                    (measured, Vec::new())
                }
                Some(step_sine) => {
                    let shift = places.even() - 0.5;
                    let steps = self.steps((step_sine, shift), &prepared, level, &mut noise)?;
                    let found = level.peak.and_then(|peak| self.found_by(&steps, &peak));
                    (found, steps)
                }
            };
            measured.push(MeasuredResonance {
                specimen: index,
                level: stated,
                force_n: level.level,
                strip_load_n,
                status: status(level, peak.is_some()),
                peak,
                steps,
            });
        }
        Ok(measured)
    }

    /// The study with the contact of a specimen, the load that presses its strip, and neither inputs nor curves; and that load (N).
    fn study_of(
        &self,
        settings: &ResponseSettings,
        index: u64,
        mut study: Study,
    ) -> Result<(Study, f64), Error> {
        let truth = self.specimen(index);
        let mut strip_load_n = 0.0;
        if let ModelSettings::TwoBladeStrip {
            interface, blades, ..
        } = &mut study.model
        {
            if settings.pressed_by == PressedBy::Loading {
                *blades = self.loading.pressed(blades)?;
            }
            strip_load_n = blades.centrifugal_load_n;
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
        Ok((study, strip_load_n))
    }

    /// Gain of the cell that measures the force on the blades.
    fn gain_of_force(&self, specimen: u64) -> f64 {
        let calibrated = match self.force_cells.calibration {
            Calibration::PerTest => specimen,
            Calibration::PerRig => 0,
        };
        let mut noise = Noise::new(self.seed, Purpose::ForceOfResponse, calibrated);
        1.0 + self.force_deviation() * noise.normal()
    }

    /// Standard deviation of the gain of a force cell.
    fn force_deviation(&self) -> f64 {
        1e-2 * self.force_cells.error_percent / DEVIATIONS_OF_LIMIT
    }

    /// What the vibrometer shows of every step through the resonance of a level; none without a resonance. The middle of the steps is `shift`
    /// of them away from it.
    fn steps(
        &self,
        (settings, shift): (&StepSineSettings, f64),
        prepared: &PreparedStudy<'_>,
        level: &LevelOutcome,
        noise: &mut Noise,
    ) -> Result<Vec<Step>, Error> {
        let Some(peak) = level.peak else {
            return Ok(Vec::new());
        };
        let ratio = peak.damping_ratio.get().unwrap_or_default();
        let frequencies = settings.frequencies(peak.frequency_hz, ratio * peak.frequency_hz, shift);
        let omega: Vec<f64> = frequencies.iter().map(|f| hz_to_rad_s(*f)).collect();
        let problem = prepared.nominal_problem()?;
        let sweep = SlowSweep {
            band: prepared.band(),
            direction: settings.sweep,
            omega: &omega,
        };
        let solver = &prepared.study.solver;
        let response = at_frequencies(&problem, solver, level.level, sweep, |_| {});
        let drift = um_to_m(self.vibrometer.drift_um_per_s * noise.normal());
        let solved = response.solutions.iter().zip(frequencies);
        let solved = solved.filter(|(solution, _)| solution.status.has_solution());
        let steps = solved.map(|(solution, frequency_hz)| {
            let width = solution.responses.len() / solution.harmonics.n_coefficients();
            let motion: Vec<f64> = solution.responses.iter().step_by(width).copied().collect();
            let orders = solution.harmonics.orders();
            settings.step(
                &self.vibrometer,
                (frequency_hz, drift),
                (orders, &motion),
                noise,
            )
        });
        Ok(steps.collect())
    }

    /// The peak that steps show; the limit of the force cell's gain is known, and an error of the force is one of the amplitude.
    fn found_by(&self, steps: &[Step], truth: &PeakRecord) -> Option<MeasuredPeak> {
        let found = fitted_peak(steps).or_else(|| largest_step(steps))?;
        let by_force = self.force_deviation() * found.amplitude_m;
        Some(MeasuredPeak {
            frequency_hz: found.frequency_hz,
            amplitude_um: m_to_um(found.amplitude_m),
            frequency_deviation_hz: found.frequency_deviation_hz,
            amplitude_deviation_um: m_to_um(found.amplitude_deviation_m.hypot(by_force)),
            true_frequency_hz: truth.frequency_hz,
            true_amplitude_um: m_to_um(truth.amplitude_m),
        })
    }
}

/// A peak with errors of the stated size.
fn with_errors(peak: &PeakRecord, settings: &ResponseSettings, errors: [f64; 2]) -> MeasuredPeak {
    let true_amplitude_um = m_to_um(peak.amplitude_m);
    let [hertz, percent] = settings.deviations();
    let deviations = [hertz, 1e-2 * percent * true_amplitude_um];
    MeasuredPeak {
        frequency_hz: peak.frequency_hz + deviations[0] * errors[0],
        amplitude_um: true_amplitude_um + deviations[1] * errors[1],
        frequency_deviation_hz: deviations[0],
        amplitude_deviation_um: deviations[1],
        true_frequency_hz: peak.frequency_hz,
        true_amplitude_um,
    }
}

/// How the search for the peak ended, or that the steps do not show it.
fn status(level: &LevelOutcome, is_measured: bool) -> &'static str {
    match (level.peak, is_measured) {
        (Some(_), false) => NO_MAXIMUM,
        _ => level.status.name(),
    }
}
