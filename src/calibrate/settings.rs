//! What a calibration is asked for.

use crate::setting::{BadSetting, within};

/// Settings of a calibration.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct CalibrationSettings {
    /// Samples of the study that are solved to shape the surrogates; absent = those of the study.
    pub samples: Option<u64>,
    /// Markov chains: ensembles of walkers, independent of each other.
    pub chains: usize,
    /// Draws of each chain that are kept, of all its walkers together.
    pub draws: usize,
    /// Draws of each chain before these, while its walkers find the posterior.
    pub warm_up: usize,
    /// Seed of the chains.
    pub seed: u64,
    /// Draws of the posterior that are solved to check the surrogates, in each round.
    pub checked: usize,
    /// What the model may be wrong by beyond its inputs.
    pub discrepancy: Discrepancy,
}

/// What the model may be wrong by at each level, whatever its inputs: standard deviation of a normal number, itself uncertain by a
/// factor e (lognormal with this median and a logarithm of standard deviation 1). 0 = nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Discrepancy {
    /// Of the resonance frequency (Hz).
    pub frequency_hz: f64,
    /// Of the amplitude, relative.
    pub amplitude: f64,
}

/// Chains that can be meant.
pub const CHAINS: [usize; 2] = [2, 64];
/// Draws of a chain that can be meant.
pub const DRAWS: [usize; 2] = [100, 100_000];
/// Largest discrepancy of the amplitude that can be meant, relative: the model would say nothing.
const MOST_DISCREPANCY: f64 = 1.0;
/// Largest discrepancy of the frequency that can be meant (Hz).
const MOST_DISCREPANCY_HZ: f64 = 1e4;

impl Default for CalibrationSettings {
    fn default() -> Self {
        Self {
            samples: None,
            chains: 4,
            draws: 1000,
            warm_up: 500,
            seed: 0,
            checked: 32,
            discrepancy: Discrepancy::default(),
        }
    }
}

impl CalibrationSettings {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with the name of the option.
    pub fn validate(&self) -> Result<(), BadSetting> {
        for (key, value, [least, most]) in [
            ("chains", self.chains, CHAINS),
            ("draws", self.draws, DRAWS),
        ] {
            let rule = format!("must be from {least} to {most}");
            let inside = (least..=most).contains(&value);
            BadSetting::unless(inside, key, value, &rule)?;
        }
        let amplitude = 100.0 * self.discrepancy.amplitude;
        let most = 100.0 * MOST_DISCREPANCY;
        within("discrepancy-percent", amplitude, [0.0, most])?;
        let (key, most) = ("discrepancy-hz", MOST_DISCREPANCY_HZ);
        within(key, self.discrepancy.frequency_hz, [0.0, most])
    }
}
