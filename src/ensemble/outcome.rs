//! What one sample gives: inputs, and one record per excitation level.

use crate::hb::{PeakRoute, Status};
use crate::sampling::SampleGroup;
use serde::{Deserialize, Deserializer, Serialize};

/// All that is stored of one sample.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SampleOutcome {
    /// Index of the sample in the study, 0-based.
    pub index: u64,
    /// Outer point, replicate and place in a row, where the design has such.
    pub group: SampleGroup,
    /// Sampled inputs, in the order of the study's input names.
    pub inputs: Vec<f64>,
    /// One record per excitation level, in the order of the study's levels.
    pub levels: Vec<LevelOutcome>,
}

impl SampleOutcome {
    /// Whether every level has a solution.
    #[must_use]
    pub fn is_solved(&self) -> bool {
        let mut levels = self.levels.iter();
        levels.all(|level| level.status.has_solution())
    }
}

/// Resonance of one sample at one excitation level.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LevelOutcome {
    /// Excitation level (N for the built-in model).
    pub level: f64,
    /// How the solve ended; without a solution the numbers of `peak` are absent.
    pub status: Status,
    /// The resonance peak, if found.
    pub peak: Option<PeakRecord>,
    /// Lower maxima of the amplitude, highest first: of other modes that compete, or found in the search for the peak.
    pub others: Vec<OtherMaximum>,
    /// Forced response around the peak, ascending in frequency, single-valued; may be empty.
    pub curve: Vec<CurvePoint>,
    /// What slow sweeps through the band meet; absent without a curve from one end of the band to the other, and in results of an
    /// older program.
    #[serde(default)]
    pub sweeps: Option<SweepRecord>,
    /// Newton iterations spent on this level.
    pub newton_iterations: usize,
    /// Linear factorisations spent on this level.
    pub factorizations: usize,
}

/// Newton iterations on all levels of a sample.
#[must_use]
pub fn newton_iterations(levels: &[LevelOutcome]) -> u64 {
    levels
        .iter()
        .map(|level| level.newton_iterations as u64)
        .sum()
}

/// Numbers of one resonance peak.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PeakRecord {
    /// Resonance frequency (Hz).
    #[serde(deserialize_with = "number")]
    pub frequency_hz: f64,
    /// Amplitude |q̂₁| of the first response coordinate (m).
    #[serde(deserialize_with = "number")]
    pub amplitude_m: f64,
    /// How it was found; absent where no solver did.
    pub route: Option<PeakRoute>,
    /// Stated relative error of the amplitude by the harmonics left out; absent without an alert, or where nothing was found
    /// with twice the harmonics.
    pub truncation_error: Option<f64>,
    /// Floquet multiplier of the largest modulus, its real and its imaginary part (not negative); absent where stability was not
    /// assessed, and in results of an older program.
    #[serde(default)]
    pub multiplier: Option<[f64; 2]>,
    /// Highest harmonic of the solution.
    pub highest_harmonic: usize,
    /// Share of (pair, time) that sticks.
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub stick_fraction: f64,
    /// Share of (pair, time) that slips in at least one direction.
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub slip_fraction: f64,
    /// Share of (pair, time) that is separated.
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub separated_fraction: f64,
    /// Work of the excitation per cycle (J).
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub work_input_j: f64,
    /// Work dissipated by the damping matrix per cycle (J).
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub work_viscous_j: f64,
    /// Work dissipated by friction per cycle (J).
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub work_friction_j: f64,
    /// Equivalent damping ratio of the resonance: energy lost per cycle over 4π times the kinetic energy of the first harmonic.
    /// Absent where nothing is dissipated, and in results of an older program, which did not compute it.
    pub damping_ratio: Option<f64>,
    /// Largest component of the residual over the fixed displacement scale.
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub residual: f64,
}

/// A maximum that is not the highest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OtherMaximum {
    /// Frequency (Hz).
    #[serde(deserialize_with = "number")]
    pub frequency_hz: f64,
    /// Amplitude |q̂₁| of the first response coordinate (m).
    #[serde(deserialize_with = "number")]
    pub amplitude_m: f64,
}

/// What slow sweeps through the band meet. They differ where the curve folds over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SweepRecord {
    /// The largest amplitude of the sweep from low to high frequencies.
    pub upward: CurvePoint,
    /// The largest amplitude of the sweep from high to low frequencies.
    pub downward: CurvePoint,
    /// Lowest and highest frequency (Hz) between which there are several solutions; absent where every frequency has one.
    pub several_hz: Option<[f64; 2]>,
}

/// One point of a forced response curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Frequency (Hz).
    #[serde(deserialize_with = "number")]
    pub frequency_hz: f64,
    /// Amplitude of the first response coordinate (m).
    #[serde(deserialize_with = "number")]
    pub amplitude_m: f64,
}

/// Reads a number; JSON has no NaN, so `null` stands for it.
///
/// # Errors
/// Those of the deserializer.
pub fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let number = Option::<f64>::deserialize(deserializer)?;
    Ok(number.unwrap_or(f64::NAN))
}
