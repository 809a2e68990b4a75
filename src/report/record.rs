//! `run.json`: all of a run that its tables do not hold, so that a report needs no solver.

use super::requirement::Requirements;
use super::surrogate::SurrogateSettings;
use super::{ReportError, ReportInput};
use crate::ensemble::backend::BackendReport;
use crate::ensemble::one_at_a_time::OneAtATime;
use crate::ensemble::outcome::{CurvePoint, SampleOutcome, number};
use crate::ensemble::store::{Provenance, StoreError, read_curves, read_samples, replace_file};
use crate::sampling::{Distribution, Growth};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

/// Name of the record in a result folder.
pub const RECORD: &str = "run.json";
/// Names of the tables in a result folder: samples, curves.
pub const TABLES: [&str; 2] = ["samples.parquet", "curves.parquet"];

/// Everything of a run that its tables do not hold.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Study, seed, version, law and settings.
    pub provenance: Provenance,
    /// What evaluated the contacts.
    pub backend: BackendReport,
    /// Sampled inputs, in the order of [`SampleOutcome::inputs`].
    pub inputs: Vec<InputRecord>,
    /// How the samples were chosen.
    pub design: DesignRecord,
    /// Relative change of frequency at which a peak counts as located.
    pub frequency_tolerance: f64,
    /// Excitation levels, in the order of [`SampleOutcome::levels`].
    pub levels: Vec<f64>,
    /// Samples with a forced response curve: the first so many.
    pub curve_samples: u64,
    /// Which bands of these curves the page shows.
    pub bands: Bands,
    /// Unit of the excitation levels, such as `N`.
    pub level_unit: String,
    /// Structure without contact forces.
    pub free: LinearRecord,
    /// Structure with all contacts stuck, nominal inputs.
    pub stuck: LinearRecord,
    /// Outcome at the nominal inputs, if computed.
    pub nominal: Option<SampleOutcome>,
    /// Results along each input alone, if wanted.
    pub one_at_a_time: Option<OneAtATime>,
    /// Components that the model was reduced from; none for the user's own matrices.
    pub components: Vec<ComponentRecord>,
    /// What the designer asks for.
    pub requirements: Requirements,
    /// The surrogate that is wanted, if any.
    pub surrogate: Option<SurrogateSettings>,
    /// The study file.
    pub study_file: FileRecord,
    /// The tables of the run.
    pub tables: Vec<FileRecord>,
    /// Wall time of the run (s).
    pub wall_time_s: f64,
}

/// How the bands of whole curves are formed.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Bands {
    /// Pointwise quantiles, stretched by one factor until they hold the stated share of whole curves.
    #[default]
    Simultaneous,
    /// What the deepest curves span, of as many as hold that share.
    Depth,
    /// As `Simultaneous`, each curve over its frequency divided by that of its peak.
    PeakAligned,
}

/// A sampled input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InputRecord {
    /// Name.
    pub name: String,
    /// Its distribution in words: what every probability of the report depends on.
    pub prior: String,
    /// The distribution that it is drawn from; absent where it is fixed, an interval or from a file.
    pub distribution: Option<Distribution>,
}

/// How the samples were chosen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DesignRecord {
    /// In words.
    pub description: String,
    /// Whether the samples are independent draws of one population, as confidence intervals presume.
    pub independent: bool,
    /// To which numbers of samples, at each outer point, `extend` can go.
    pub growth: Growth,
    /// Outer points of a nested design, 1 of any other.
    pub outer_points: u64,
    /// Inputs, by their number, that the mixed samples of a pick-freeze design take from B, in the order of their places;
    /// empty for any other design.
    pub mixed_inputs: Vec<usize>,
}

/// A linear limit of the structure.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LinearRecord {
    /// Resonance frequency (Hz).
    #[serde(deserialize_with = "number")]
    pub frequency_hz: f64,
    /// Response; amplitude per unit level. May be empty.
    pub curve: Vec<CurvePoint>,
}

/// A component that was reduced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComponentRecord {
    /// Name.
    pub name: String,
    /// Fixed-interface modes that were kept.
    pub modes: usize,
    /// First one left out (Hz); absent if none was.
    pub first_left_out_hz: Option<f64>,
}

/// A file and the hash of its content.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Name, without folder.
    pub name: String,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

impl FileRecord {
    /// Record of a file with the given content.
    #[must_use]
    pub fn of(name: &str, content: &[u8]) -> Self {
        Self {
            name: name.to_owned(),
            blake3: blake3::hash(content).to_hex().to_string(),
        }
    }

    /// Record of a file in `folder`.
    ///
    /// # Errors
    /// The operating system's, if it cannot be read.
    pub fn in_folder(folder: &Path, name: &str) -> std::io::Result<Self> {
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(std::fs::File::open(folder.join(name))?)?;
        Ok(Self {
            name: name.to_owned(),
            blake3: hasher.finalize().to_hex().to_string(),
        })
    }
}

/// A run read back from its folder.
#[derive(Debug, Clone)]
pub struct StoredRun {
    /// `run.json`.
    pub record: RunRecord,
    /// Outcomes of the population with their curves.
    pub outcomes: Vec<SampleOutcome>,
    /// Outcomes of the mixed samples of a pick-freeze design, which belong to no population.
    pub mixed: Vec<SampleOutcome>,
    /// Tables whose content is not that of the run.
    pub changed: Vec<String>,
}

impl RunRecord {
    /// Writes `run.json`, whole or not at all.
    ///
    /// # Errors
    /// The operating system's.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        let json = serde_json::to_string_pretty(self)?;
        replace_file(&folder.join(RECORD), |file| file.write_all(json.as_bytes()))
    }

    fn read(path: &Path) -> Result<Self, StoreError> {
        let text = std::fs::read_to_string(path)?;
        serde_json::from_str(&text).map_err(|error| StoreError::File(error.into()))
    }
}

impl StoredRun {
    /// What a report is made from.
    #[must_use]
    pub fn input(&self) -> ReportInput<'_> {
        ReportInput {
            record: &self.record,
            outcomes: &self.outcomes,
            mixed: &self.mixed,
            changed: &self.changed,
        }
    }

    /// Reads what a run left in `folder`.
    ///
    /// # Errors
    /// [`ReportError::Stored`] with the file that is absent or not what a run writes.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        let at = |name: &str| {
            let path = folder.join(name);
            move |source: StoreError| ReportError::Stored { path, source }
        };
        let record = RunRecord::read(&folder.join(RECORD)).map_err(at(RECORD))?;
        let [samples, curves] = TABLES;
        let mut stored = read_samples(&folder.join(samples)).map_err(at(samples))?;
        read_curves(&folder.join(curves), &mut stored.outcomes).map_err(at(curves))?;
        let mut changed = Vec::new();
        for table in &record.tables {
            let found = FileRecord::in_folder(folder, &table.name);
            if found.map_err(|e| at(&table.name)(e.into()))? != *table {
                changed.push(table.name.clone());
            }
        }
        let shape = |o: &SampleOutcome| {
            o.levels.len() == record.levels.len() && o.inputs.len() == record.inputs.len()
        };
        if !stored.outcomes.iter().all(shape) {
            let what = format!("a sample with the levels and inputs of {RECORD}");
            return Err(at(samples)(StoreError::Missing(what)));
        }
        let of_population = |outcome: &SampleOutcome| outcome.group.of_population();
        let (outcomes, mixed) = stored.outcomes.into_iter().partition(of_population);
        Ok(Self {
            record,
            outcomes,
            mixed,
            changed,
        })
    }
}
