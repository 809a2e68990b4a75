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

/// Passes over the period that can be asked for: a slider that is not periodic by then is not.
pub const MOST_LAPS: usize = 10_000;
/// Points per period that can be asked for.
pub const MOST_TIME_POINTS: usize = 65_536;

impl AftSettings {
    /// Checks the number of points against the highest harmonic (no aliasing of the Jacobian).
    ///
    /// # Errors
    /// [`BadSetting`] on `time_points` or `laps`.
    pub fn validate(&self, highest_harmonic: usize) -> Result<(), BadSetting> {
        BadSetting::unless(
            self.n_time > 4 * highest_harmonic && self.n_time <= MOST_TIME_POINTS,
            "time_points",
            self.n_time,
            "must be more than 4 times the highest harmonic and at most 65536",
        )?;
        let laps = match self.laps {
            Laps::Fixed(laps) => laps,
            Laps::Periodic => 1,
        };
        let rule = format!("must be from 1 to {MOST_LAPS}, or \"periodic\"");
        BadSetting::unless((1..=MOST_LAPS).contains(&laps), "laps", laps, &rule)
    }
}
