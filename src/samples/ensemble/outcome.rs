//! What one sample gives: inputs, and one record per excitation level.

use crate::hb::{PeakRoute, Status};
use crate::sampling::SampleGroup;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// All that is stored of one sample.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SampleOutcome {
    /// Index of the sample in the study, 0-based.
    pub index: u64,
    /// Outer point, replicate and place in a row, where the design has such.
    pub group: SampleGroup,
    /// Sampled inputs, in the order of the study's input names.
    pub inputs: Box<[f64]>,
    /// One record per excitation level, in the order of the study's levels.
    pub levels: Box<[LevelOutcome]>,
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
    /// What is known beside the peak.
    #[serde(flatten)]
    pub around: AroundPeak,
    /// Newton iterations spent on this level.
    pub newton_iterations: u32,
    /// Linear factorisations spent on this level.
    pub factorizations: u32,
}

impl LevelOutcome {
    /// The resonance peak, if it is a solution.
    #[must_use]
    pub fn solved_peak(&self) -> Option<PeakRecord> {
        self.peak.filter(|_| self.status.has_solution())
    }
}

/// What is known beside the peak of a level. Most levels of most samples have nothing, and a report holds millions of levels: then
/// it takes one pointer.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(from = "KnownAround")]
pub struct AroundPeak(Option<Box<KnownAround>>);

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct KnownAround {
    others: Vec<Maximum>,
    curve: Vec<CurvePoint>,
    #[serde(default)]
    sweeps: Option<SweepRecord>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mistuned: Option<MistunedRecord>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modes: Option<FollowedModes>,
}

impl AroundPeak {
    /// Lower maxima of the amplitude, highest first: of other modes that compete, or found in the search for the peak.
    #[must_use]
    pub fn others(&self) -> &[Maximum] {
        self.0.as_ref().map_or(&[], |known| &known.others)
    }

    /// Forced response around the peak, ascending in frequency, single-valued.
    #[must_use]
    pub fn curve(&self) -> &[CurvePoint] {
        self.0.as_ref().map_or(&[], |known| &known.curve)
    }

    /// What slow sweeps through the band meet; absent without a curve from one end of the band to the other, and in results of an
    /// older program.
    #[must_use]
    pub fn sweeps(&self) -> Option<&SweepRecord> {
        self.0.as_ref()?.sweeps.as_ref()
    }

    /// What mistuning makes of the peak; absent of a tuned disk and any other model.
    #[must_use]
    pub fn mistuned(&self) -> Option<&MistunedRecord> {
        self.0.as_ref()?.mistuned.as_ref()
    }

    /// States what mistuning makes of the peak.
    pub fn set_mistuned(&mut self, record: MistunedRecord) {
        self.0.get_or_insert_default().mistuned = Some(record);
    }

    /// The modes of the maxima; absent where the study does not follow all modes.
    #[must_use]
    pub fn modes(&self) -> Option<&FollowedModes> {
        self.0.as_ref()?.modes.as_ref()
    }

    /// States the modes of the maxima.
    pub fn set_modes(&mut self, modes: FollowedModes) {
        self.0.get_or_insert_default().modes = Some(modes);
    }

    /// The forced response, to be changed.
    pub fn curve_mut(&mut self) -> &mut Vec<CurvePoint> {
        &mut self.0.get_or_insert_default().curve
    }

    /// These lower maxima, this forced response and what sweeps meet.
    #[must_use]
    pub fn new(others: Vec<Maximum>, curve: Vec<CurvePoint>, sweeps: Option<SweepRecord>) -> Self {
        KnownAround {
            others,
            curve,
            sweeps,
            mistuned: None,
            modes: None,
        }
        .into()
    }
}

impl From<KnownAround> for AroundPeak {
    fn from(known: KnownAround) -> Self {
        let empty = known.others.is_empty()
            && known.curve.is_empty()
            && known.sweeps.is_none()
            && known.mistuned.is_none()
            && known.modes.is_none();
        Self((!empty).then(|| Box::new(known)))
    }
}

impl Serialize for AroundPeak {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            Some(known) => known.serialize(serializer),
            None => KnownAround::default().serialize(serializer),
        }
    }
}

/// A number that may be absent, in the eight bytes of a number: NaN counts as absent, as it does in the tables.
#[derive(Clone, Copy)]
pub struct MaybeReal(f64);

impl MaybeReal {
    /// No number.
    pub const NONE: Self = Self(f64::NAN);

    /// The number, where there is one.
    #[must_use]
    pub fn get(self) -> Option<f64> {
        Some(self.0).filter(|value| !value.is_nan())
    }
}

impl From<Option<f64>> for MaybeReal {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Self::NONE, Self)
    }
}

impl Default for MaybeReal {
    fn default() -> Self {
        Self::NONE
    }
}

impl PartialEq for MaybeReal {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl std::fmt::Debug for MaybeReal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.get().fmt(f)
    }
}

impl Serialize for MaybeReal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.get().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for MaybeReal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Option::<f64>::deserialize(deserializer)?.into())
    }
}

/// Newton iterations on all levels of a sample.
#[must_use]
pub fn newton_iterations(levels: &[LevelOutcome]) -> u64 {
    levels
        .iter()
        .map(|level| u64::from(level.newton_iterations))
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
    /// with more harmonics.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    pub truncation_error: MaybeReal,
    /// Real part of the Floquet multiplier of the largest modulus; absent where stability was not assessed, and in results of an older
    /// program.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    pub multiplier_real: MaybeReal,
    /// Its imaginary part, not negative.
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    pub multiplier_imaginary: MaybeReal,
    /// Highest harmonic of the solution.
    pub highest_harmonic: u32,
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
    #[serde(default)]
    #[schemars(with = "Option<f64>")]
    pub damping_ratio: MaybeReal,
    /// Largest component of the residual over the fixed displacement scale.
    #[serde(deserialize_with = "number")]
    #[schemars(with = "Option<f64>")]
    pub residual: f64,
}

impl PeakRecord {
    /// Modulus of the Floquet multiplier, above 1 for an unstable peak; absent where stability was not assessed.
    #[must_use]
    pub fn multiplier_modulus(&self) -> Option<f64> {
        let [re, im] = [
            self.multiplier_real.get()?,
            self.multiplier_imaginary.get()?,
        ];
        Some((re * re + im * im).sqrt())
    }
}

/// A maximum of the response: one below the highest, or the largest amplitude of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Maximum {
    /// Frequency (Hz).
    #[serde(deserialize_with = "number")]
    pub frequency_hz: f64,
    /// Amplitude |q̂₁| of the first response coordinate (m).
    #[serde(deserialize_with = "number")]
    pub amplitude_m: f64,
}

/// The modes of the maxima of a level, where the study follows all modes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct FollowedModes {
    /// The mode of each maximum, the peak first, then the lower ones; empty without a peak.
    pub of_maxima: Vec<ModeOfMaximum>,
    /// Modes whose maximum was searched and not found, though nothing says that it lies outside the band.
    pub unfinished: u32,
}

/// The mode of a maximum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModeOfMaximum {
    /// Its number among the stuck frequencies of the nominal structure, 1 for the lowest; 0 where none is known.
    pub number: u32,
    /// Its part of the correlations with all modes.
    #[serde(deserialize_with = "number")]
    pub share: f64,
}

/// What slow sweeps through the band meet. They differ where the curve folds over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SweepRecord {
    /// The largest amplitude of the sweep from low to high frequencies.
    pub upward: Maximum,
    /// The largest amplitude of the sweep from high to low frequencies.
    pub downward: Maximum,
    /// Lowest and highest frequency (Hz) between which there are several solutions; absent where every frequency has one.
    pub several_hz: Option<[f64; 2]>,
}

/// What mistuning makes of the peak of a disk, whose amplitude is the largest of all blades.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MistunedRecord {
    /// The blade with the largest amplitude, from 0.
    pub blade: u32,
    /// Amplification factor: that amplitude over the peak of the tuned disk with the same inputs; absent where that was not found.
    pub amplification: MaybeReal,
    /// The same over the peak of the tuned disk with all contacts stuck, which is linear.
    pub over_linear: MaybeReal,
    /// Amplification factor of the linear disk: with all contacts stuck, mistuned over tuned.
    pub linear_amplification: MaybeReal,
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
    /// Whether it is unstable; absent where that was not assessed, as on the curves of samples, and between the solutions of a curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unstable: Option<bool>,
}

/// Reads a number; JSON has no NaN, so `null` stands for it.
///
/// # Errors
/// Those of the deserializer.
pub fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let number = Option::<f64>::deserialize(deserializer)?;
    Ok(number.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A report holds all samples in memory: `benches/README.md` has the figures of a million. Seen to fail with
    /// absent numbers as `Option<f64>`, and with the two lists beside each other.
    #[test]
    fn outcomes_are_small() {
        assert!(size_of::<LevelOutcome>() <= 144, "a level");
        assert!(size_of::<SampleOutcome>() <= 64, "a sample");
    }

    /// The names and values in `run.json`, with and without lists and numbers. Seen to fail with the lists under a name of their own.
    #[test]
    fn levels_keep_their_form_in_json() {
        for others in [r#"{"frequency_hz":1.5,"amplitude_m":0.25}"#, ""] {
            let text = format!(
                r#"{{"level":2.0,"status":"max-iterations","peak":null,"others":[{others}],"curve":[],"sweeps":null,"newton_iterations":3,"factorizations":2}}"#
            );
            let level: LevelOutcome = serde_json::from_str(&text).unwrap();
            assert_eq!(level.around.others().is_empty(), others.is_empty());
            assert_eq!(serde_json::to_string(&level).unwrap(), text);
        }
        let number = |text: &str| serde_json::from_str::<MaybeReal>(text).unwrap();
        for (text, expected) in [("null", None), ("0.1", Some(0.1))] {
            assert_eq!(number(text).get(), expected, "{text}");
            assert_eq!(serde_json::to_string(&number(text)).unwrap(), text);
        }
    }
}
