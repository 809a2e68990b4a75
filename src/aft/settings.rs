//! How one contact evaluation is done.

use crate::contact::{Events, FrictionLaw};
use crate::setting::BadSetting;

/// Passes over the period from the anchored slider to the steady cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Laps {
    /// So many passes; two are exact for the box law and for one tangential direction.
    Fixed(usize),
    /// Until the slider is periodic (the circle law needs it; the box law takes exactly two passes).
    Periodic,
}

/// Settings of the contact evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AftSettings {
    /// Points per period.
    pub n_time: usize,
    /// Friction law.
    pub law: FrictionLaw,
    /// How events between the samples are resolved.
    pub events: Events,
    /// Passes over the period.
    pub laps: Laps,
}

impl AftSettings {
    /// Checks the number of points against the highest harmonic (no aliasing of the Jacobian).
    ///
    /// # Errors
    /// [`BadSetting`] on `time_points` or `laps`.
    pub fn validate(&self, highest_harmonic: usize) -> Result<(), BadSetting> {
        BadSetting::unless(
            self.n_time > 4 * highest_harmonic && self.n_time <= 65_536,
            "time_points",
            self.n_time,
            "must be more than 4 times the highest harmonic and at most 65536",
        )?;
        BadSetting::unless(self.laps != Laps::Fixed(0), "laps", 0, "must be at least 1")
    }
}
