//! What `rig.toml` says of the specimen, of the strip and of the measured resonances.

use crate::model::interface::{InterfaceSettings, STIFFNESS_N_PER_UM};
use crate::model::two_blade::TwoBladeSettings;
use crate::setting::{
    BadSetting, Plain, friction_coefficient, non_negative, positive, within, without_round_off,
};
use std::path::PathBuf;

/// Specimens at most.
const MOST_SPECIMENS: u64 = 10_000;

/// Largest standard deviation of a measured frequency or amplitude over the number itself: 0 lies ten deviations away then, so that no
/// draw is negative.
const LARGEST_DEVIATION: f64 = 0.1;

/// The true contact of the specimens: what a test is to find.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactTruth {
    /// Friction coefficient: median over the specimens.
    pub friction_coefficient: f64,
    /// Tangential stiffness of the interface (N/µm): median over the specimens.
    pub tangential_stiffness_n_per_um: f64,
    /// Normal stiffness of the interface (N/µm): median over the specimens.
    pub normal_stiffness_n_per_um: f64,
    /// Specimens that are tested.
    pub specimens: u64,
    /// Scatter between specimens: standard deviation of ln mu (%).
    pub friction_scatter_percent: f64,
    /// The same of both stiffnesses, which scatter together.
    pub stiffness_scatter_percent: f64,
}

impl Default for ContactTruth {
    fn default() -> Self {
        let interface = InterfaceSettings::default();
        Self {
            friction_coefficient: interface.friction_coefficient,
            tangential_stiffness_n_per_um: interface.tangential_stiffness * 1e-6,
            normal_stiffness_n_per_um: interface.normal_stiffness * 1e-6,
            specimens: 1,
            friction_scatter_percent: 0.0,
            stiffness_scatter_percent: 0.0,
        }
    }
}

impl ContactTruth {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[contact]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        friction_coefficient("friction_coefficient", self.friction_coefficient)?;
        positive("friction_coefficient", self.friction_coefficient)?;
        for (key, stiffness) in [
            (
                "tangential_stiffness_n_per_um",
                self.tangential_stiffness_n_per_um,
            ),
            ("normal_stiffness_n_per_um", self.normal_stiffness_n_per_um),
        ] {
            within(key, stiffness, STIFFNESS_N_PER_UM)?;
        }
        let rule = format!("must be from 1 to {MOST_SPECIMENS}");
        let some = (1..=MOST_SPECIMENS).contains(&self.specimens);
        BadSetting::unless(some, "specimens", self.specimens, &rule)?;
        for (key, scatter) in [
            ("friction_scatter_percent", self.friction_scatter_percent),
            ("stiffness_scatter_percent", self.stiffness_scatter_percent),
        ] {
            non_negative(key, scatter)?;
            within(key, scatter, [0.0, 100.0])?;
        }
        Ok(())
    }
}

/// The strip; names and defaults are those of `[model]` in a study file.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StripSettings {
    /// Strip, x × y × z (mm).
    #[serde(deserialize_with = "crate::setting::exactly")]
    pub strip_mm: [f64; 3],
    /// Gap between blade and measuring box, or between both blades (mm).
    pub gap_mm: f64,
    /// Contact pairs of the interface, [across the gap, along it].
    #[serde(deserialize_with = "crate::setting::exactly")]
    pub contact_nodes: [usize; 2],
    /// Young's modulus (GPa).
    pub youngs_modulus_gpa: f64,
    /// Density (kg/m³).
    pub density_kg_m3: f64,
    /// Loss of the strip's spring, at 1 kHz: twice its damping ratio there.
    pub loss_at_1_khz: f64,
}

impl Default for StripSettings {
    fn default() -> Self {
        let model = TwoBladeSettings::default();
        Self {
            strip_mm: model.strip_mm,
            gap_mm: model.gap_mm,
            // finer than the model: slip spreads over the interface pair by pair
            contact_nodes: [8, 12],
            youngs_modulus_gpa: model.youngs_modulus_gpa,
            density_kg_m3: model.density_kg_m3,
            loss_at_1_khz: 2.0 * model.strip_damping_ratio,
        }
    }
}

impl StripSettings {
    /// The two-blade rig with this strip.
    #[must_use]
    pub fn model(&self) -> TwoBladeSettings {
        TwoBladeSettings {
            strip_mm: self.strip_mm,
            gap_mm: self.gap_mm,
            contact_nodes: self.contact_nodes,
            youngs_modulus_gpa: self.youngs_modulus_gpa,
            density_kg_m3: self.density_kg_m3,
            ..TwoBladeSettings::default()
        }
    }

    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[strip]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        non_negative("loss_at_1_khz", self.loss_at_1_khz)?;
        self.model().validate()
    }

    /// Width of the strip on one side of the gap (mm).
    #[must_use]
    pub fn overlap_mm(&self) -> f64 {
        self.model().strip_overlap_mm()
    }

    /// Mass of the strip's half that moves with the contact (kg); the other is held by the box.
    #[must_use]
    pub fn moving_mass(&self) -> f64 {
        let volume: f64 = self.strip_mm.iter().map(|side| side * 1e-3).product();
        0.5 * self.density_kg_m3 * volume
    }

    /// Stiffness between the middle of the contact and the box (N/m): E l t over gap and half of the overlap.
    #[must_use]
    pub fn axial_stiffness(&self) -> f64 {
        let [_, length, thickness] = self.strip_mm;
        let free = self.gap_mm + 0.5 * self.overlap_mm();
        self.youngs_modulus_gpa * 1e9 * length * thickness / free * 1e-3
    }
}

/// What is measured of two blades.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponseSettings {
    /// Study of kind "two-blade-strip", relative to the rig file: its structure, levels, band and solver. Its contact is
    /// replaced by that of the specimen, its random inputs are left out.
    pub study: PathBuf,
    /// Standard deviation of a resonance frequency (Hz).
    #[serde(default = "default_frequency_deviation")]
    pub frequency_deviation_hz: f64,
    /// Standard deviation of an amplitude over the amplitude (%).
    #[serde(default = "default_amplitude_deviation")]
    pub amplitude_deviation_percent: f64,
}

fn default_frequency_deviation() -> f64 {
    0.05
}

fn default_amplitude_deviation() -> f64 {
    1.0
}

impl ResponseSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[response]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        non_negative("frequency_deviation_hz", self.frequency_deviation_hz)?;
        let most = 100.0 * LARGEST_DEVIATION;
        let percent = self.amplitude_deviation_percent;
        within("amplitude_deviation_percent", percent, [0.0, most])
    }

    /// Refuses frequencies that might be measured as negative, in a band from `lowest_hz` (Hz) on.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[response]`.
    pub fn check_band(&self, lowest_hz: f64) -> Result<(), BadSetting> {
        let most = LARGEST_DEVIATION * lowest_hz;
        let rule = format!(
            "must be at most a tenth of the frequency at which the band of the study begins: {} Hz",
            Plain(without_round_off(most))
        );
        let deviation = self.frequency_deviation_hz;
        let key = "frequency_deviation_hz";
        BadSetting::unless(deviation <= most, key, Plain(deviation), &rule)
    }
}
