//! The surrogate that a study wants: `[surrogate]` of its file.

use crate::setting::BadSetting;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Share that is held out at a time if the study does not say.
const DEFAULT_HOLD_OUT: f64 = 0.2;

/// Kind of a surrogate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SurrogateKind {
    /// Sparse polynomial chaos.
    PolynomialChaos,
}

/// A surrogate per level for resonance frequency and amplitude, in a section of its own; without the table there is none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurrogateSettings {
    /// Kind of the surrogate.
    pub kind: SurrogateKind,
    /// Share of the samples that are held out at a time: predicted by a fit to the others.
    #[schemars(range(min = 0.05, max = 0.5), extend("default" = DEFAULT_HOLD_OUT))]
    hold_out: Option<f64>,
}

impl SurrogateSettings {
    /// Share of the samples that are held out at a time.
    #[must_use]
    pub fn hold_out(&self) -> f64 {
        self.hold_out.unwrap_or(DEFAULT_HOLD_OUT)
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[surrogate]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        let share = self.hold_out();
        let rule = "must be from 0.05 to 0.5";
        BadSetting::unless((0.05..=0.5).contains(&share), "hold_out", share, rule)
    }
}
