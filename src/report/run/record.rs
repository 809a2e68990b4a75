//! `run.json`: all of a run that its tables do not hold, so that a report needs no solver.

use crate::ensemble::backend::BackendReport;
use crate::ensemble::one_at_a_time::OneAtATime;
use crate::ensemble::outcome::{CurvePoint, SampleOutcome};
use crate::ensemble::parts::PartFolder;
use crate::ensemble::store::Provenance;
use crate::file::{self, FileError};
use crate::report::asked::bands::Bands;
use crate::report::asked::control_variate::ControlVariateSettings;
use crate::report::asked::requirement::Requirements;
use crate::report::asked::stopping::Stopping;
use crate::report::asked::surrogate::SurrogateSettings;
use crate::report::convention::CONFIDENCE;
use crate::sampling::{DesignKind, Distribution, Growth, Input};
use crate::statistics::confidence_at;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

pub use crate::file::FileRecord;

/// Name of the record in a result folder.
pub const RECORD: &str = "run.json";
/// Names of the tables in a result folder: samples, curves.
pub const TABLES: [&str; 2] = ["samples.parquet", "curves.parquet"];

/// Name of the table of samples beyond the outer points, where a study has such.
pub const FURTHER_POINTS: &str = "further_points.parquet";
/// Name of the table of samples on few harmonics, where a study has a control variate.
pub const CONTROL_VARIATE: &str = "control_variate.parquet";

/// Everything of a run that its tables do not hold.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Study, seed, version, law and settings.
    pub provenance: Provenance,
    /// Whether a GPU improved the predicted peaks.
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
    /// What a finer contact grid changes at nominal inputs; absent for the user's own matrices, where it would take long, and in records of
    /// an older program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finer_grid: Option<FinerGridRecord>,
    /// The load against which performance curves show the excitation; absent for the user's own matrices, and in records of an
    /// older program.
    pub static_load: Option<StaticLoadRecord>,
    /// The tuned disk that the model is a sector of; absent for other models.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disk: Option<DiskRecord>,
    /// What the designer asks for.
    pub requirements: Requirements,
    /// How the number of samples came out of the results; absent where it was given.
    pub stopping: Option<Stopping>,
    /// The surrogate that is wanted, if any.
    pub surrogate: Option<SurrogateSettings>,
    /// The control variate that is wanted, if any; absent in records of an older program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control_variate: Option<ControlVariateSettings>,
    /// The study file.
    pub study_file: FileRecord,
    /// The files that the study names.
    pub files: Vec<FileRecord>,
    /// The tables of the run.
    pub tables: Vec<FileRecord>,
    /// Wall time of the command that wrote the results (s).
    pub wall_time_s: f64,
}

/// A sampled input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct InputRecord {
    /// Name.
    pub name: String,
    /// Its distribution in words: what every probability of the report depends on.
    pub prior: String,
    /// File that states it, relative to the study file; absent where the study file does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<String>,
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
    /// Whether inputs are correlated, so that their joint density is no product.
    #[serde(default)]
    pub correlated: bool,
}

impl InputRecord {
    /// Whether its values only number the draws of a field: nothing is to be told along it.
    #[must_use]
    pub fn numbers_draws(&self) -> bool {
        Input::of_column(&self.name).is_some_and(Input::numbers_draws)
    }

    /// Its distribution in words, with the file that states it.
    #[must_use]
    pub fn assumption(&self) -> String {
        match &self.origin {
            Some(file) => format!("{}, from {file}", self.prior),
            None => self.prior.clone(),
        }
    }
}

/// A linear limit of the structure.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LinearRecord {
    /// Resonance frequency (Hz); absent where the band holds no natural frequency of this structure.
    pub frequency_hz: Option<f64>,
    /// Response over the band; amplitude per unit level. May be empty.
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

/// Peaks at nominal inputs on a contact grid half again as fine, against those on the study's own, on its first harmonics. Absent where one
/// of the two was not found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FinerGridRecord {
    /// Contact nodes per interface of the finer grid, across the gap and along it.
    pub contact_nodes: [usize; 2],
    /// Resonance frequency over that of the structure without contacts, on the finer grid minus on that of the study (Hz). Shape: `[levels]`.
    pub shift_change_hz: Vec<Option<f64>>,
    /// Amplitude on it over that on the grid of the study, minus 1. Shape: `[levels]`.
    pub amplitude_change: Vec<Option<f64>>,
}

/// The centrifugal load on the strip of the built-in rig.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StaticLoadRecord {
    /// At nominal inputs (N).
    pub load_n: f64,
    /// Thickness of the nominal strip (mm): the load grows with it.
    pub strip_thickness_mm: f64,
}

/// A tuned disk under an engine order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiskRecord {
    /// Number of sectors.
    pub sectors: usize,
    /// The engine order that excites it.
    pub engine_order: u32,
    /// The nodal diameter that it excites.
    pub nodal_diameter: usize,
    /// Linear frequencies at nominal inputs, by nodal diameter.
    pub nodal_diameters: Vec<NodalRecord>,
    /// Hash of what the study states of a sector: runs of one disk have the same. Absent in records of an older program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sector: Option<String>,
}

/// First natural frequencies of a nodal diameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NodalRecord {
    /// The nodal diameter.
    pub nodal_diameter: usize,
    /// Number of rigid-body modes without contact forces, which `free_hz` leaves out. Absent in records of an older program.
    #[serde(default)]
    pub rigid_modes: usize,
    /// Flexible ones without contact forces (Hz).
    pub free_hz: Vec<f64>,
    /// With all contacts stuck (Hz).
    pub stuck_hz: Vec<f64>,
}

impl RunRecord {
    /// Whether an input is drawn from a distribution or from a file. The samples of a population differ in nothing else: where none is,
    /// each of them is the same.
    #[must_use]
    pub fn has_random_inputs(&self) -> bool {
        let drawn = |input: &InputRecord| input.distribution.is_some();
        self.design.kind == DesignKind::File || self.inputs.iter().any(drawn)
    }

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
    pub(super) fn read(folder: &Path) -> Result<(Self, bool), FileError> {
        file::finish_placing(folder)?;
        let path = folder.join(RECORD);
        if !path.exists() {
            return Err(FileError::content(&path, None, absent(folder)));
        }
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
    pub(super) fn changed(&self, folder: &Path) -> Vec<String> {
        let differs = |table: &&FileRecord| {
            FileRecord::in_folder(folder, &table.name).ok().as_ref() != Some(*table)
        };
        let tables = self.tables.iter().filter(differs);
        tables.map(|table| table.name.clone()).collect()
    }
}

/// Why a folder has no record.
fn absent(folder: &Path) -> &'static str {
    match PartFolder::of(folder).path().exists() {
        true => {
            "does not exist: the run in this folder is not finished, and the command that began it goes on (`microslip status` shows how far it has come)"
        }
        false => "does not exist: no results of `run` are in this folder",
    }
}

/// First bytes of `run.json`.
const OPENING: &str = "{\n";
/// What stands around the hash in its second line.
const HASH_KEY: &str = "  \"blake3_of_the_lines_below\": \"";
const HASH_END: &str = "\",\n";
