//! Step-sine: one frequency after the other at one amplitude, of the platform's motion or of the force on a blade.

use crate::setting::{BadSetting, positive, within};
use crate::units::{hz_to_rad_s, um_to_m};

/// Frequencies that can be meant (Hz).
const FREQUENCY_HZ: [f64; 2] = [1e-3, 1e5];
/// Samples of one test at most.
const MOST_SAMPLES: usize = 10_000_000;
/// Fewest samples of a cycle.
const FEWEST_SAMPLES: usize = 16;
/// Tests of a specimen at most.
const MOST_TESTS: u64 = 10_000;
/// Amplitude of the platform that is not given (µm).
const AMPLITUDE_UM: f64 = 5.0;

/// The step-sine, and how long it is recorded.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Excitation {
    /// Frequencies (Hz), in the order of the tests.
    pub frequencies_hz: Vec<f64>,
    /// Amplitude of the platform (µm), the same at every frequency; 5 if absent. A blade has a force in its place.
    pub amplitude_um: Option<f64>,
    /// Tests at each frequency.
    pub repetitions: u64,
    /// Cycles before the record begins, with an amplitude that grows to the whole.
    pub run_in_cycles: usize,
    /// Cycles of a record.
    pub cycles: usize,
    /// Samples of a cycle: the sampling rate follows the frequency.
    pub samples_per_cycle: usize,
}

impl Default for Excitation {
    fn default() -> Self {
        Self {
            frequencies_hz: vec![100.0],
            amplitude_um: None,
            repetitions: 1,
            run_in_cycles: 5,
            cycles: 20,
            samples_per_cycle: 500,
        }
    }
}

impl Excitation {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[excitation]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        let given = !self.frequencies_hz.is_empty();
        BadSetting::unless(given, "frequencies_hz", "[]", "must not be empty")?;
        for (i, frequency) in self.frequencies_hz.iter().enumerate() {
            within(&format!("frequencies_hz[{i}]"), *frequency, FREQUENCY_HZ)?;
        }
        if let Some(amplitude_um) = self.amplitude_um {
            positive("amplitude_um", amplitude_um)?;
            within("amplitude_um", amplitude_um, [0.0, 1e4])?;
        }
        let tests = self
            .repetitions
            .saturating_mul(self.frequencies_hz.len() as u64);
        let rule = format!("must be at least 1, and give at most {MOST_TESTS} tests");
        let some = (1..=MOST_TESTS).contains(&tests);
        BadSetting::unless(some, "repetitions", self.repetitions, &rule)?;
        let enough = self.samples_per_cycle >= FEWEST_SAMPLES;
        let rule = format!("must be at least {FEWEST_SAMPLES}: `identify` takes no fewer");
        BadSetting::unless(enough, "samples_per_cycle", self.samples_per_cycle, &rule)?;
        BadSetting::unless(
            self.cycles >= 1,
            "cycles",
            self.cycles,
            "must be at least 1",
        )?;
        let cycles = self.cycles.saturating_add(self.run_in_cycles);
        let samples = cycles.saturating_mul(self.samples_per_cycle);
        let rule = format!("gives more than {MOST_SAMPLES} samples, with run_in_cycles");
        BadSetting::unless(samples <= MOST_SAMPLES, "cycles", self.cycles, &rule)
    }

    /// Amplitude of the platform (m), where its motion is given.
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        um_to_m(self.amplitude_um.unwrap_or(AMPLITUDE_UM))
    }

    /// A sine of this amplitude at the time `t` (s) after its start from rest: it grows through the run-in.
    #[must_use]
    pub fn sine(&self, amplitude: f64, frequency_hz: f64, t: f64) -> f64 {
        let turns = frequency_hz * t;
        let grown = match self.run_in_cycles {
            0 => 1.0,
            cycles => (turns / cycles as f64).min(1.0),
        };
        // no jump of velocity or acceleration at either end
        let grown = grown * grown * grown * (10.0 + grown * (6.0 * grown - 15.0));
        amplitude * grown * libm::sin(hz_to_rad_s(frequency_hz) * t)
    }
}
