//! `run.json`: all of a run that its tables do not hold, so that a report needs no solver.

use super::ReportInput;
use super::requirement::Requirements;
use super::stopping::Stopping;
use super::summary::CONFIDENCE;
use super::surrogate::SurrogateSettings;
use crate::ensemble::backend::BackendReport;
use crate::ensemble::one_at_a_time::OneAtATime;
use crate::ensemble::outcome::{CurvePoint, SampleOutcome, number};
use crate::ensemble::store::{Provenance, read_curves, read_samples};
pub use crate::file::FileRecord;
use crate::file::{self, FileError};
use crate::sampling::{DesignKind, Distribution, Growth};
use crate::statistics::confidence_at;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

/// Name of the record in a result folder.
pub const RECORD: &str = "run.json";
/// Names of the tables in a result folder: samples, curves.
pub const TABLES: [&str; 2] = ["samples.parquet", "curves.parquet"];

/// Name of the table of samples beyond the outer points, where a study has such.
pub const FURTHER_POINTS: &str = "further_points.parquet";

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
    /// What the contact grid of the built-in rig changes; absent where nobody estimated it.
    pub contact_grid: Option<ContactGridRecord>,
    /// What the designer asks for.
    pub requirements: Requirements,
    /// How the number of samples came out of the results; absent where it was given.
    pub stopping: Option<Stopping>,
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
    /// What the deepest curves span, of as many as hold that share; needs more samples.
    Depth,
    /// As `simultaneous`, each curve over its frequency divided by that of its peak: the scatter of the shape without that of
    /// the place.
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
    /// Kind.
    pub kind: DesignKind,
    /// In words.
    pub description: String,
    /// Whether the samples are independent draws of one population, as confidence intervals presume.
    pub independent: bool,
    /// To which numbers of samples, at each outer point, `extend` can go.
    pub growth: Growth,
    /// Outer points of a nested design, 1 of any other.
    pub outer_points: u64,
    /// Further points of the box that the search for worst cases has met; their samples stand in [`FURTHER_POINTS`].
    pub further_points: u64,
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

/// Shift of a frequency by stuck contacts on the study's contact grid, and where it goes on finer ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContactGridRecord {
    /// Contact nodes per interface, across the gap and along it.
    pub contact_nodes: [usize; 2],
    /// Shift on this grid, at nominal stiffness (Hz).
    pub shift_hz: f64,
    /// Shift extrapolated from this grid and one twice as fine (Hz).
    pub limit_hz: f64,
    /// Error over the shift, without sign.
    pub relative: f64,
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
    /// Files whose content is not that of the run.
    pub changed: Vec<String>,
}

impl RunRecord {
    /// Number of the look at which the run ended, from 1; 0 where the number of samples was given.
    #[must_use]
    pub fn look(&self) -> usize {
        self.stopping.as_ref().map_or(0, |s| s.looks.len())
    }

    /// Confidence with which the samples at hand are judged, so that what is stated has [`CONFIDENCE`] over all looks.
    #[must_use]
    pub fn confidence(&self) -> f64 {
        confidence_at(self.look(), CONFIDENCE)
    }

    /// Writes `run.json`, whole or not at all. Its second line holds the hash of the bytes below.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn write(&self, folder: &Path) -> Result<(), FileError> {
        let path = folder.join(RECORD);
        let json = serde_json::to_string_pretty(self);
        let json = json.map_err(|error| FileError::system(&path, error.into()))?;
        let body = json.strip_prefix(OPENING).unwrap_or(&json);
        let hash = FileRecord::of(RECORD, body.as_bytes()).blake3;
        file::replace(&path, |file| {
            write!(file, "{OPENING}{HASH_KEY}{hash}{HASH_END}{body}")
        })?;
        Ok(())
    }

    /// The record in a result folder, whether or not it is what the run wrote.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be read.
    pub fn of_folder(folder: &Path) -> Result<Self, FileError> {
        Self::read(folder).map(|(record, _)| record)
    }

    /// Reads `run.json`, and whether it is what the run wrote.
    fn read(folder: &Path) -> Result<(Self, bool), FileError> {
        let path = folder.join(RECORD);
        let text = file::read_text(&path)?;
        let hashed = text
            .strip_prefix(OPENING)
            .and_then(|rest| rest.strip_prefix(HASH_KEY)?.split_once(HASH_END));
        let (json, intact) = match hashed {
            // an empty line in place of the hash, so that errors name the lines of the file
            Some((hash, body)) => (
                format!("{OPENING}\n{body}"),
                FileRecord::of(RECORD, body.as_bytes()).blake3 == hash,
            ),
            None => (text, false),
        };
        let record = serde_json::from_str(&json).map_err(|error| {
            let line = error.line() as u64;
            FileError::content(&path, Some(line), format!("is no record of a run: {error}"))
        })?;
        Ok((record, intact))
    }

    /// Names of the files in `folder` that are not those that the run wrote; absent ones among them.
    fn changed(&self, folder: &Path) -> Vec<String> {
        let differs = |table: &&FileRecord| {
            FileRecord::in_folder(folder, &table.name).ok().as_ref() != Some(*table)
        };
        let tables = self.tables.iter().filter(differs);
        tables.map(|table| table.name.clone()).collect()
    }
}

/// First bytes of `run.json`.
const OPENING: &str = "{\n";
/// What stands around the hash in its second line.
const HASH_KEY: &str = "  \"blake3_of_the_lines_below\": \"";
const HASH_END: &str = "\",\n";

/// Refuses a folder with files that are not those that the run wrote: what is computed from them would pass for its results.
///
/// # Errors
/// [`FileError`] on the first such file.
pub fn require_unchanged(folder: &Path) -> Result<(), FileError> {
    let (record, intact) = RunRecord::read(folder)?;
    let own = (!intact).then(|| RECORD.to_owned());
    match own.into_iter().chain(record.changed(folder)).next() {
        None => Ok(()),
        Some(name) => Err(FileError::content(&folder.join(name), None, CHANGED)),
    }
}

/// What is wrong with a changed file.
pub const CHANGED: &str = "is not the file that the run wrote";

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

    /// The same without the points that a search has met: they are others in each study, so that nothing pairs with them.
    #[must_use]
    pub fn without_search(mut self) -> Self {
        let of_design = |o: &SampleOutcome| o.group.outer < Some(self.record.design.outer_points);
        self.outcomes.retain(of_design);
        self
    }

    /// Reads what a run left in `folder`.
    ///
    /// # Errors
    /// [`FileError`] with the file that is absent or not what a run writes.
    pub fn read(folder: &Path) -> Result<Self, FileError> {
        let (record, intact) = RunRecord::read(folder)?;
        let [samples, curves] = TABLES.map(|name| folder.join(name));
        let mut stored = read_samples(&samples)?;
        read_curves(&curves, &mut stored.outcomes)?;
        if record.design.further_points > 0 {
            let further = read_samples(&folder.join(FURTHER_POINTS))?;
            stored.outcomes.extend(further.outcomes);
        }
        let own = (!intact).then(|| RECORD.to_owned());
        let changed = own.into_iter().chain(record.changed(folder)).collect();
        let shape = |o: &SampleOutcome| {
            o.levels.len() == record.levels.len() && o.inputs.len() == record.inputs.len()
        };
        if !stored.outcomes.iter().all(shape) {
            let rule = format!("must have the levels and inputs of {RECORD} in every sample");
            return Err(FileError::content(&samples, None, rule));
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
