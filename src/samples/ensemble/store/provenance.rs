//! What a result must carry to be understood and repeated.

use crate::contact::{Events, FrictionLaw};
use crate::ensemble::program::Program;
use crate::hb::SliderAnchor;
use parquet::file::metadata::KeyValue;

/// What a result must carry to be understood and repeated.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Provenance {
    /// Name of the study.
    pub study: String,
    /// Root seed of the samples.
    pub seed: u64,
    /// Version of this program.
    pub version: String,
    /// Commit that it was built from, as stated at its build; absent if nobody stated one.
    pub commit: Option<String>,
    /// Instruction set of the dense solves, on which the last bits depend: `avx512`, `avx2`, `neon` or `baseline`; `pinned-avx2` and so
    /// on of a program that was built to take no wider one than AVX2.
    pub instruction_set: String,
    /// Programs that solved a part of the samples, where another one than this was accepted.
    #[serde(default)]
    pub other_programs: Vec<Program>,
    /// Name of the model.
    pub model: String,
    /// Friction law.
    pub law: FrictionLaw,
    /// How events between the samples were resolved.
    pub events: Events,
    /// Slider anchor at the start.
    pub anchor: SliderAnchor,
    /// Harmonics of the first solution.
    pub harmonics: Vec<usize>,
    /// Time points per period of the contact evaluation.
    pub time_points: usize,
    /// Whether the contacts of one side of a mirror-symmetric model stood for both.
    pub folded: bool,
    /// Truncation error above which harmonics are added; absent if not estimated.
    pub truncation_threshold: Option<f64>,
    /// Harmonics are raised up to this order; absent if they are fixed.
    pub highest_harmonic: Option<usize>,
    /// Fewest harmonics on which a solution was compared before it was accepted; absent if it was not, or not stated by the program.
    #[serde(default)]
    pub compared_with: Option<usize>,
    /// The modes that are searched in the band, where the study follows all modes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub followed_modes: Vec<FollowedMode>,
    /// Number of the mode whose maximum is the peak, as `inspect` counts the stuck frequencies; absent where it is the highest one of the band.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_mode: Option<usize>,
}

/// A mode that a study follows.
#[derive(
    Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct FollowedMode {
    /// Its number among the stuck frequencies, 1 for the lowest.
    pub mode: u32,
    /// Its stuck frequency at nominal inputs (Hz).
    pub stuck_frequency_hz: f64,
}

impl Provenance {
    /// The provenance as pairs; texts as they are, everything else as JSON.
    pub(super) fn key_values(&self) -> Result<Vec<KeyValue>, serde_json::Error> {
        let value = serde_json::to_value(self)?;
        let fields = value.as_object().into_iter().flatten();
        Ok(fields
            .map(|(key, value)| {
                let text = value
                    .as_str()
                    .map_or_else(|| value.to_string(), str::to_owned);
                KeyValue::new(key.clone(), text)
            })
            .collect())
    }
}
