//! The measuring box on its L-shaped support: two force transducers at right angles.
//!
//! The box has a mass and the stiffnesses K11 and K22 along the transducers, and K12 = K21 between them. Transducer i feels
//! K_ii times its displacement: with K11 ~ K22 >> K12 it is the force along i and the share K12/K22 of the other one. At low
//! frequencies; towards the box's own resonance the force of its mass adds. A force whose line passes beside the
//! transducers' is shared: by the decoupling factor of i at the largest offset transducer i reads so much of it, the other one the rest.

use crate::setting::{BadSetting, non_negative, positive, within};
use crate::units::{n_per_um_to_n_per_m, rad_s_to_hz};

/// Masses of a measuring box that can be meant (kg).
const MASS_KG: [f64; 2] = [1e-6, 1e3];
/// Stiffnesses of its support that can be meant (N/µm).
const STIFFNESS_N_PER_UM: [f64; 2] = [1e-6, 1e6];

/// The support.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SupportSettings {
    /// Mass of the measuring box (kg).
    pub box_mass_kg: f64,
    /// K11: tangential stiffness (N/µm).
    pub k11_n_per_um: f64,
    /// K22: normal stiffness (N/µm).
    pub k22_n_per_um: f64,
    /// K12 = K21 (N/µm).
    pub k12_n_per_um: f64,
    /// Damping ratio of the box on K11.
    pub damping_ratio: f64,
    /// Decoupling factors of the tangential and the normal transducer at the largest offset.
    #[serde(deserialize_with = "crate::setting::exactly")]
    pub decoupling: [f64; 2],
    /// Largest offset of the force's line (mm), to which `decoupling` belongs.
    pub largest_offset_mm: f64,
    /// Standard deviation of the offset of a test (mm); beyond the largest it is drawn anew.
    pub offset_mm: f64,
}

impl Default for SupportSettings {
    fn default() -> Self {
        Self {
            box_mass_kg: 0.15,
            k11_n_per_um: 150.0,
            k22_n_per_um: 150.0,
            k12_n_per_um: 0.5,
            damping_ratio: 0.01,
            decoupling: [0.995, 0.991],
            largest_offset_mm: 1.5,
            offset_mm: 0.5,
        }
    }
}

impl SupportSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[support]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        within("box_mass_kg", self.box_mass_kg, MASS_KG)?;
        within("k11_n_per_um", self.k11_n_per_um, STIFFNESS_N_PER_UM)?;
        within("k22_n_per_um", self.k22_n_per_um, STIFFNESS_N_PER_UM)?;
        let bound = self.k11_n_per_um.min(self.k22_n_per_um);
        let rule = "must be smaller than k11_n_per_um and k22_n_per_um";
        let small = self.k12_n_per_um.abs() < bound;
        BadSetting::unless(small, "k12_n_per_um", self.k12_n_per_um, rule)?;
        within("damping_ratio", self.damping_ratio, [0.0, 1.0])?;
        for factor in self.decoupling {
            within("decoupling", factor, [0.5, 1.0])?;
        }
        positive("largest_offset_mm", self.largest_offset_mm)?;
        non_negative("offset_mm", self.offset_mm)?;
        let rule = "must not be larger than largest_offset_mm";
        let inside = self.offset_mm <= self.largest_offset_mm;
        BadSetting::unless(inside, "offset_mm", self.offset_mm, rule)
    }

    /// K11, K22 and K12 (N/m).
    #[must_use]
    pub fn stiffness(&self) -> [f64; 3] {
        [self.k11_n_per_um, self.k22_n_per_um, self.k12_n_per_um].map(n_per_um_to_n_per_m)
    }

    /// Frequency of the box on K11 alone (Hz).
    #[must_use]
    pub fn own_frequency_hz(&self) -> f64 {
        let [k11, ..] = self.stiffness();
        rad_s_to_hz((k11 / self.box_mass_kg).sqrt())
    }

    /// Damping over stiffness (s): 2ζ/ω of the box on K11.
    #[must_use]
    pub fn damping_time(&self) -> f64 {
        let [k11, ..] = self.stiffness();
        2.0 * self.damping_ratio / (k11 / self.box_mass_kg).sqrt()
    }

    /// What the transducers read of the forces [T, N] that pass at an offset (mm).
    #[must_use]
    pub fn decoupled(&self, [t, n]: [f64; 2], offset_mm: f64) -> [f64; 2] {
        let share = offset_mm / self.largest_offset_mm;
        let lost = self.decoupling.map(|factor| (1.0 - factor) * share);
        [
            (1.0 - lost[0].abs()) * t + lost[1] * n,
            (1.0 - lost[1].abs()) * n + lost[0] * t,
        ]
    }
}
