//! The control variate that a study wants: `[control_variate]` of its file.

use crate::hb::settings::HIGHEST_HARMONIC;
use crate::sampling::design_settings::MOST_SAMPLES;
use crate::setting::BadSetting;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Highest harmonic of the control if the study does not say.
const DEFAULT_HARMONIC: usize = 1;
/// Samples of the control if the study does not say.
const DEFAULT_SAMPLES: u64 = 4096;
/// Samples of the control over those of the study, at least: with fewer it cannot halve an interval.
const LEAST_RATIO: u64 = 2;

/// The samples of the study and further ones are solved on few harmonics, too, which is cheap. Means, and probabilities of
/// exceeding a limit of the amplitude, are stated once more with their help, in a section of its own; without the table
/// they are not. For independent samples of one population.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControlVariateSettings {
    /// Highest harmonic of the cheap solutions; below that of the study's own.
    #[schemars(range(min = 1, max = HIGHEST_HARMONIC - 1), extend("default" = DEFAULT_HARMONIC))]
    harmonics: Option<usize>,
    /// Number of samples that are solved so, the first of them those of the study; at least twice as many as these.
    #[schemars(range(min = 2, max = MOST_SAMPLES), extend("default" = DEFAULT_SAMPLES))]
    samples: Option<u64>,
}

impl ControlVariateSettings {
    /// Highest harmonic of the cheap solutions.
    #[must_use]
    pub fn highest_harmonic(&self) -> usize {
        self.harmonics.unwrap_or(DEFAULT_HARMONIC)
    }

    /// Number of samples that are solved on these harmonics.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples.unwrap_or(DEFAULT_SAMPLES)
    }

    /// Checks the settings for a study of so many samples on harmonics up to `highest`.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[control_variate]`.
    pub fn validate(&self, samples: u64, highest: usize) -> Result<(), BadSetting> {
        let (h, n) = (self.highest_harmonic(), self.samples());
        let rule = match highest {
            0 | 1 => {
                "no number fits: `solver.harmonics` must be 2 or more for a cheaper control variate"
                    .to_owned()
            }
            most => format!(
                "must be from 1 to {}: cheaper than the study's own harmonics",
                most - 1
            ),
        };
        BadSetting::unless((1..highest).contains(&h), "harmonics", h, &rule)?;
        let least = LEAST_RATIO.saturating_mul(samples);
        let rule =
            format!("must be from {least} (twice the samples of the study) to {MOST_SAMPLES}");
        BadSetting::unless((least..=MOST_SAMPLES).contains(&n), "samples", n, &rule)
    }
}
