//! What a user states about rig, tests and study.

use crate::setting::{BadSetting, non_negative, positive, within};

/// Settings of an identification.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IdentifySettings {
    /// Confidence of the intervals.
    pub confidence: f64,
    /// Tangential stiffness of the rig between the points of the displacement sensor, in series with the contact (N/µm).
    pub series_stiffness_n_per_um: Option<f64>,
    /// Standard uncertainty of the gain of each force sensor (%), independent for T and N, the same for all tests.
    pub force_error_percent: f64,
    /// Standard uncertainty of the gain of the displacement sensors (%), the same for all tests.
    pub displacement_error_percent: f64,
    /// Offset of the normal force that is subtracted (N): loops of one load do not show it.
    pub normal_force_offset_n: f64,
    /// Cycles left out at the start; found from the loops where not stated.
    pub run_in_cycles: Option<usize>,
    /// Greatest friction coefficient that is possible, for tests that never slip.
    pub friction_at_most: Option<f64>,
    /// Area of the study's interface over that of the tested contact: stiffness is proportional to it.
    pub interface_area_ratio: f64,
}

impl Default for IdentifySettings {
    fn default() -> Self {
        Self {
            confidence: 0.95,
            series_stiffness_n_per_um: None,
            force_error_percent: 0.0,
            displacement_error_percent: 0.0,
            normal_force_offset_n: 0.0,
            run_in_cycles: None,
            friction_at_most: None,
            interface_area_ratio: 1.0,
        }
    }
}

impl IdentifySettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`BadSetting`] with the key and the rule.
    pub fn validate(&self) -> Result<(), BadSetting> {
        within("confidence", self.confidence, [0.5, 0.9999])?;
        if let Some(stiffness) = self.series_stiffness_n_per_um {
            positive("series_stiffness_n_per_um", stiffness)?;
        }
        non_negative("force_error_percent", self.force_error_percent)?;
        within("force_error_percent", self.force_error_percent, [0.0, 50.0])?;
        let (key, value) = (
            "displacement_error_percent",
            self.displacement_error_percent,
        );
        within(key, value, [0.0, 50.0])?;
        let (key, offset) = ("normal_force_offset_n", self.normal_force_offset_n);
        BadSetting::unless(offset.is_finite(), key, offset, "must be a finite number")?;
        if let Some(most) = self.friction_at_most {
            positive("friction_at_most", most)?;
        }
        positive("interface_area_ratio", self.interface_area_ratio)
    }
}
