//! `identified.json`: the joint distribution of the contact parameters, which a study reads by `[inputs] from`.

pub use super::parameter::ContactParameter;
use super::pooled_result::Pooled;
use super::result::TestResult;
use crate::file::FileRecord;
use crate::identify::settings::IdentifySettings;
use crate::sampling::Shape;

/// Version of the format of `identified.json`.
pub const FORMAT: u32 = 1;

/// What was found, for a study.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Identified {
    /// Version of the format.
    pub format: u32,
    /// Parameters with their distributions.
    pub inputs: Vec<IdentifiedInput>,
    /// Correlation of the normal scores of the parameters. Shape: square, in the order of `inputs`.
    pub correlation: Vec<Vec<f64>>,
    /// What a reader should know, in sentences: what is not in the distributions, what could not be found.
    #[serde(default)]
    pub notes: Vec<String>,
    /// What was stated for the identification; absent in a file that was written by hand.
    #[serde(default)]
    pub settings: Option<IdentifySettings>,
    /// Pressure map that was given for all tests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure_map: Option<GivenPressure>,
    /// All tests together; absent in a file that was written by hand.
    #[serde(default)]
    pub pooled: Option<Pooled>,
    /// Each test.
    #[serde(default)]
    pub tests: Vec<TestResult>,
    /// Files that were read, with the hash of their content.
    #[serde(default)]
    pub files: Vec<FileRecord>,
    /// Version of the program.
    #[serde(default)]
    pub version: String,
}

/// A pressure map that was given.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GivenPressure {
    /// Its file, which is among `files`, too.
    pub file: FileRecord,
    /// Cells with pressure.
    pub cells: usize,
    /// Share of their area whose pressure is within a tenth of its mean.
    pub even_area: f64,
}

/// A parameter of the contact and its distribution.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct IdentifiedInput {
    /// Which one.
    pub parameter: ContactParameter,
    /// Distribution of its value at a further contact of the same kind: scatter, and what the tests leave unknown.
    pub shape: Shape,
}
