//! The blade that carries the platform: what a constant force on its airfoil makes of the platform's motion.
//!
//! Its modes are those of blade 1 of the two-blade rig (`model::two_blade`). Modes up to 20 kHz move; the others follow at rest,
//! as a flexibility of the platform. The strip's traction acts on the platform against the displacement, so that near a resonance
//! amplitude and phase of the platform are those of blade and strip together.

use super::settings::StripSettings;
use crate::model::ModelError;
use crate::model::two_blade::{BladeModes, TwoBladeSettings, blade_modes};
use crate::setting::{BadSetting, positive, within};
use crate::units::{hz_to_rad_s, rad_s_to_hz};

/// Modes up to this frequency (Hz) move; those above are at rest.
const KEPT_HZ: f64 = 20e3;
/// Frequencies of a test (Hz): four harmonics are below `KEPT_HZ`; slower tests have too many steps.
const FREQUENCY_HZ: [f64; 2] = [1.0, 5e3];
/// Steps of the fastest mode's period.
const STEPS_OF_FASTEST: f64 = 20.0;
/// Steps in 1/ω of the kept modes on the contact's stiffness. The scheme of the modes is stable up to a step of √12/ω.
const STEPS_OF_CONTACT: f64 = 2.0;
/// Settling cycles at most.
const MOST_CYCLES: usize = 1_000_000;

/// `[blade]`: the force, and the blade that it excites. Geometry, names and defaults are those of `[model]` in a study file.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BladeSettings {
    /// Amplitude of the force (N), the same at every frequency.
    pub force_n: f64,
    /// Cycles under the whole force before the record begins: a lightly damped blade takes 1/damping ratio of them to settle.
    pub settling_cycles: usize,
    /// Neck, x × y × z (mm).
    #[serde(deserialize_with = "crate::setting::exactly")]
    pub neck_mm: [f64; 3],
    /// Platform, x × y × z (mm).
    #[serde(deserialize_with = "crate::setting::exactly")]
    pub platform_mm: [f64; 3],
    /// Airfoil, x × y × z (mm).
    #[serde(deserialize_with = "crate::setting::exactly")]
    pub airfoil_mm: [f64; 3],
    /// Offset of the airfoil in y (mm).
    pub airfoil_offset_mm: f64,
    /// Damping ratio of every mode.
    pub damping_ratio: f64,
    /// Height of the excited point over the airfoil's root, as a fraction of the airfoil.
    pub excitation_height: f64,
    /// Direction of the force.
    #[serde(deserialize_with = "crate::setting::exactly")]
    pub excitation_direction: [f64; 3],
}

impl Default for BladeSettings {
    fn default() -> Self {
        let model = TwoBladeSettings::default();
        Self {
            force_n: 100.0,
            settling_cycles: 3000,
            neck_mm: model.neck_mm,
            platform_mm: model.platform_mm,
            airfoil_mm: model.airfoil_mm,
            airfoil_offset_mm: model.airfoil_offset_mm,
            damping_ratio: model.blade_damping_ratio,
            excitation_height: model.excitation_height,
            excitation_direction: model.excitation_direction,
        }
    }
}

impl BladeSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[blade]`.
    pub fn validate(&self, strip: &StripSettings) -> Result<(), BadSetting> {
        positive("force_n", self.force_n)?;
        within("force_n", self.force_n, [0.0, 1e6])?;
        within("damping_ratio", self.damping_ratio, [0.0, 0.5])?;
        let few = self.settling_cycles <= MOST_CYCLES;
        let rule = format!("must be at most {MOST_CYCLES}");
        BadSetting::unless(few, "settling_cycles", self.settling_cycles, &rule)?;
        self.model(strip).validate()
    }

    /// Refuses frequencies that a blade with few modes does not show.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[excitation]`.
    pub fn check_frequencies(&self, frequencies_hz: &[f64]) -> Result<(), BadSetting> {
        let [least, most] = FREQUENCY_HZ;
        let rule = format!(
            "must be from {least} to {most} with [blade], whose modes move up to {KEPT_HZ} Hz"
        );
        for (i, &frequency) in frequencies_hz.iter().enumerate() {
            let shown = (least..=most).contains(&frequency);
            BadSetting::unless(shown, &format!("frequencies_hz[{i}]"), frequency, &rule)?;
        }
        Ok(())
    }

    /// The two-blade rig with this blade and this strip, whose contact is as fine as that of a study: the blade shows the mean
    /// displacement of its contact only.
    #[must_use]
    pub fn model(&self, strip: &StripSettings) -> TwoBladeSettings {
        let TwoBladeSettings {
            contact_nodes,
            contact_spacing_at_gap,
            ..
        } = TwoBladeSettings::default();
        TwoBladeSettings {
            neck_mm: self.neck_mm,
            platform_mm: self.platform_mm,
            airfoil_mm: self.airfoil_mm,
            airfoil_offset_mm: self.airfoil_offset_mm,
            blade_damping_ratio: self.damping_ratio,
            excitation_height: self.excitation_height,
            excitation_direction: self.excitation_direction,
            contact_nodes,
            contact_spacing_at_gap,
            ..strip.model()
        }
    }
}

/// A mode that moves, mass-normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeMode {
    /// Natural angular frequency (rad/s).
    pub omega: f64,
    /// Work of the unit force on its shape (1/√kg).
    pub excited: f64,
    /// Displacement of the platform per modal coordinate (1/√kg).
    pub platform: f64,
}

/// The blade in the coordinates of its modes.
#[derive(Debug, Clone, PartialEq)]
pub struct Blade {
    /// Modes that move.
    pub modes: Vec<BladeMode>,
    /// Damping ratio of each.
    pub damping_ratio: f64,
    /// Displacement of the platform by the modes at rest (m/N), per force of the excitation and per force on the platform.
    pub at_rest: [f64; 2],
    /// Amplitude of the force (N).
    pub force: f64,
    /// Cycles under the whole force before the record.
    pub settling_cycles: usize,
}

impl Blade {
    /// The blade of the settings.
    ///
    /// # Errors
    /// [`ModelError`] if its model cannot be made.
    pub fn new(settings: &BladeSettings, strip: &StripSettings) -> Result<Self, ModelError> {
        let found = blade_modes(&settings.model(strip))?;
        Ok(Self::of_modes(&found, settings))
    }

    fn of_modes(found: &BladeModes, settings: &BladeSettings) -> Self {
        let all = (0..found.omega.len()).map(|i| BladeMode {
            omega: found.omega[i],
            excited: found.excited[i],
            platform: found.platform[i],
        });
        let (modes, resting): (Vec<BladeMode>, Vec<BladeMode>) =
            all.partition(|mode| mode.omega <= hz_to_rad_s(KEPT_HZ));
        let sum = |at: fn(&BladeMode) -> f64| -> f64 {
            let each = resting
                .iter()
                .map(|mode| mode.platform * at(mode) / mode.omega.powi(2));
            each.sum()
        };
        Self {
            at_rest: [sum(|mode| mode.excited), sum(|mode| mode.platform)],
            modes,
            damping_ratio: settings.damping_ratio,
            force: settings.force_n,
            settling_cycles: settings.settling_cycles,
        }
    }

    /// Fewest steps of a cycle at a frequency (Hz), with a contact of the stiffness `k_t` (N/m).
    #[must_use]
    pub fn least_steps(&self, frequency_hz: f64, k_t: f64) -> usize {
        let fastest = self
            .modes
            .iter()
            .fold(0.0, |most: f64, mode| most.max(mode.omega));
        let mobility: f64 = self.modes.iter().map(|mode| mode.platform.powi(2)).sum();
        let on_contact = STEPS_OF_CONTACT * (k_t * mobility).sqrt();
        let per_second = (STEPS_OF_FASTEST * rad_s_to_hz(fastest)).max(on_contact);
        (per_second / frequency_hz).ceil() as usize
    }

    /// Displacement of the platform (m) that the force gives at rest, the modes' parts counted as positive: a scale.
    #[must_use]
    pub fn scale(&self) -> f64 {
        let of = |mode: &BladeMode| (mode.platform * mode.excited).abs() / mode.omega.powi(2);
        self.force * (self.at_rest[0].abs() + self.modes.iter().map(of).sum::<f64>())
    }
}
