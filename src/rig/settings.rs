//! What `rig.toml` says of the specimen, of the strip and of the measured resonances.

use crate::hb::branch::sweep::SweepDirection;
use crate::model::interface::{InterfaceSettings, STIFFNESS_N_PER_UM};
use crate::model::two_blade::TwoBladeSettings;
use crate::setting::{
    BadSetting, Plain, friction_coefficient, non_negative, positive, within, without_round_off,
};
use crate::units::n_per_m_to_n_per_um;
use std::path::PathBuf;

/// Specimens at most.
const MOST_SPECIMENS: u64 = 10_000;

/// Largest standard deviation of a measured frequency or amplitude over the number itself: 0 lies ten deviations away then, so that no
/// draw is negative.
const LARGEST_DEVIATION: f64 = 0.1;

/// Steps at most.
const MOST_STEPS: usize = 501;
/// Cycles of a step at most.
const MOST_CYCLES: usize = 100_000;
/// Samples of a cycle at most.
const MOST_SAMPLES: usize = 500;
/// Fewest steps of a fit: three decide the curve, the others its error.
pub(super) const FEWEST_STEPS: usize = 5;

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
            tangential_stiffness_n_per_um: n_per_m_to_n_per_um(interface.tangential_stiffness),
            normal_stiffness_n_per_um: n_per_m_to_n_per_um(interface.normal_stiffness),
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

/// What presses the strip of configuration b.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PressedBy {
    /// The centrifugal load of the study, with its `pressure_weights`.
    #[default]
    Study,
    /// That of `[loading]`, as in configuration a; a punch adds its mass and stiffness to the strip.
    Loading,
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
    /// Distance of the contact pairs from each other next to the gap, over that of Gauss' rule.
    pub contact_spacing_at_gap: f64,
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
            contact_spacing_at_gap: 1.0,
            youngs_modulus_gpa: model.youngs_modulus_gpa,
            density_kg_m3: model.density_kg_m3,
            loss_at_1_khz: 2.0 * model.strip_damping_ratio,
        }
    }
}

impl StripSettings {
    /// The strip of two blades.
    #[must_use]
    pub fn of(blades: &TwoBladeSettings) -> Self {
        let (youngs_modulus_gpa, density_kg_m3) = blades.strip_material();
        Self {
            strip_mm: blades.strip_mm,
            gap_mm: blades.gap_mm,
            contact_nodes: blades.contact_nodes,
            contact_spacing_at_gap: blades.contact_spacing_at_gap,
            youngs_modulus_gpa,
            density_kg_m3,
            loss_at_1_khz: 2.0 * blades.strip_damping_ratio,
        }
    }

    /// The two-blade rig with this strip.
    #[must_use]
    pub fn model(&self) -> TwoBladeSettings {
        TwoBladeSettings {
            strip_mm: self.strip_mm,
            gap_mm: self.gap_mm,
            contact_nodes: self.contact_nodes,
            contact_spacing_at_gap: self.contact_spacing_at_gap,
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
        within("loss_at_1_khz", self.loss_at_1_khz, [0.0, 1.0])?;
        self.model().validate()
    }

    /// Width of the strip on one side of the gap (mm).
    #[must_use]
    pub fn overlap_mm(&self) -> f64 {
        self.model().strip_overlap_mm()
    }

    /// Mass (kg).
    #[must_use]
    pub fn mass(&self) -> f64 {
        let volume: f64 = self.strip_mm.iter().map(|side| side * 1e-3).product();
        self.density_kg_m3 * volume
    }

    /// Mass of the strip's half that moves with the contact (kg); the other is held by the box.
    #[must_use]
    pub fn moving_mass(&self) -> f64 {
        0.5 * self.mass()
    }

    /// Stiffness between the middle of the contact and the box (N/m): E l t over gap and half of the overlap.
    #[must_use]
    pub fn axial_stiffness(&self) -> f64 {
        self.stiffness_over(self.gap_mm + 0.5 * self.overlap_mm())
    }

    /// Stiffness between the middles of the contacts with two blades (N/m): E l t over gap and overlap.
    #[must_use]
    pub fn stiffness_between_blades(&self) -> f64 {
        self.stiffness_over(self.gap_mm + self.overlap_mm())
    }

    fn stiffness_over(&self, free_mm: f64) -> f64 {
        let [_, length, thickness] = self.strip_mm;
        self.youngs_modulus_gpa * 1e9 * length * thickness / free_mm * 1e-3
    }
}

/// Step-sine of constant force around each resonance.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StepSineSettings {
    /// Steps, evenly apart.
    pub steps: usize,
    /// How far they reach on either side of the resonance, in half-power half-widths.
    pub half_widths: f64,
    /// Which way the steps go: where the response jumps, only one of both meets the peak.
    pub sweep: SweepDirection,
    /// Cycles of a step that are recorded; the vibration has settled before.
    pub cycles: usize,
    /// Samples of a cycle.
    pub samples_per_cycle: usize,
}

impl Default for StepSineSettings {
    fn default() -> Self {
        Self {
            steps: 15,
            half_widths: 1.5,
            // contacts that open let a branch lean to low frequencies
            sweep: SweepDirection::Downward,
            cycles: 100,
            samples_per_cycle: 20,
        }
    }
}

impl StepSineSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[response.step_sine]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        let counts = [
            ("steps", self.steps, [FEWEST_STEPS, MOST_STEPS]),
            ("cycles", self.cycles, [2, MOST_CYCLES]),
            (
                "samples_per_cycle",
                self.samples_per_cycle,
                [8, MOST_SAMPLES],
            ),
        ];
        for (key, count, [least, most]) in counts {
            let rule = format!("must be from {least} to {most}");
            BadSetting::unless((least..=most).contains(&count), key, count, &rule)?;
        }
        within("half_widths", self.half_widths, [0.1, 20.0])
    }
}

/// What is measured of two blades.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponseSettings {
    /// Study of kind "two-blade-strip", relative to the rig file: its structure, levels, band and solver. Its contact is
    /// replaced by that of the specimen, its random inputs are left out.
    pub study: PathBuf,
    /// What presses the strip.
    #[serde(default)]
    pub pressed_by: PressedBy,
    /// Standard deviation of a resonance frequency (Hz); 0.05 if absent. Not with `step_sine`.
    pub frequency_deviation_hz: Option<f64>,
    /// Standard deviation of an amplitude over the amplitude (%); 1 if absent. Not with `step_sine`.
    pub amplitude_deviation_percent: Option<f64>,
    /// Resonances are measured by force cell and vibrometer, step by step; absent, they have errors of the stated size.
    pub step_sine: Option<StepSineSettings>,
}

/// Standard deviation of a resonance frequency (Hz) where the file states none.
const FREQUENCY_DEVIATION_HZ: f64 = 0.05;
/// Standard deviation of an amplitude over the amplitude (%) where the file states none.
const AMPLITUDE_DEVIATION_PERCENT: f64 = 1.0;

impl ResponseSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[response]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        if let Some(step_sine) = &self.step_sine {
            let stated = [
                ("frequency_deviation_hz", self.frequency_deviation_hz),
                (
                    "amplitude_deviation_percent",
                    self.amplitude_deviation_percent,
                ),
            ];
            for (key, deviation) in stated {
                let rule = "must be absent with [response.step_sine], whose fit has it";
                let written = deviation.unwrap_or_default();
                BadSetting::unless(deviation.is_none(), key, Plain(written), rule)?;
            }
            return step_sine.validate().map_err(|bad| bad.under("step_sine"));
        }
        let [hertz, percent] = self.deviations();
        non_negative("frequency_deviation_hz", hertz)?;
        let most = 100.0 * LARGEST_DEVIATION;
        within("amplitude_deviation_percent", percent, [0.0, most])
    }

    /// Standard deviations where resonances have errors of a stated size: of the frequency (Hz), and of the amplitude (%).
    #[must_use]
    pub fn deviations(&self) -> [f64; 2] {
        [
            self.frequency_deviation_hz
                .unwrap_or(FREQUENCY_DEVIATION_HZ),
            self.amplitude_deviation_percent
                .unwrap_or(AMPLITUDE_DEVIATION_PERCENT),
        ]
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
        let [deviation, _] = self.deviations();
        let key = "frequency_deviation_hz";
        BadSetting::unless(deviation <= most, key, Plain(deviation), &rule)
    }
}
