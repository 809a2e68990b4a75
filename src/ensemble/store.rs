//! Outcomes on disk: `samples.parquet` (one row per sample and level) and `curves.parquet` (one row per point).
//!
//! A sample without a solution keeps its row: status and work counts are there, the numbers of the peak are null.
//! No column ever holds NaN. Files appear whole or not at all.

use super::columns::{CURVE_COLUMNS, SAMPLE_COLUMNS};
use super::outcome::{CurvePoint, LevelOutcome, OtherMaximum, PeakRecord, SampleOutcome};
use super::program::Program;
use super::table::{Column, Record, Table, TableContent, TableError, count, metadata, missing};
use crate::contact::{Events, FrictionLaw};
use crate::file::{self, Fault, FileError, FileRecord};
use crate::hb::{PeakRoute, SliderAnchor, Status};
use crate::sampling::SampleGroup;
use parquet::file::metadata::KeyValue;
use parquet::file::reader::FileReader;
use std::collections::BTreeMap;
use std::path::Path;

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
    /// Instruction set of the processor as far as results depend on it: `avx512`, `avx2`, `neon` or `baseline`.
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
}

/// Samples read back from `samples.parquet`.
#[derive(Debug, Clone)]
pub struct StoredSamples {
    /// Key-value metadata of the file, one entry per field of [`Provenance`].
    pub metadata: BTreeMap<String, String>,
    /// Names of the inputs.
    pub input_names: Vec<String>,
    /// The outcomes, without their curves.
    pub outcomes: Vec<SampleOutcome>,
}

const INPUTS_KEY: &str = "inputs";
/// Columns of what a sample belongs to.
type GroupColumn = (&'static str, fn(&SampleGroup) -> Option<u64>);
const GROUP_COLUMNS: [GroupColumn; 3] = [
    ("outer", |group| group.outer),
    ("replicate", |group| group.replicate),
    ("place", |group| group.place),
];

/// Columns of the lower maxima: lists, highest maximum first.
type OtherColumn = (&'static str, fn(&OtherMaximum) -> f64);
const OTHER_COLUMNS: [OtherColumn; 2] = [
    ("other_frequencies_hz", |other| other.frequency_hz),
    ("other_amplitudes_m", |other| other.amplitude_m),
];

/// Writes one row per sample and level.
///
/// Columns: `sample`, those of [`SampleGroup`] that the design has, the inputs by name, `level`, `status`, then the fields
/// of [`PeakRecord`] (null without a solution), `other_frequencies_hz` and `other_amplitudes_m` (lists of the lower maxima,
/// highest first, empty without a solution), `newton_iterations`, `factorizations`. [`SAMPLE_COLUMNS`] has their units and
/// meanings, and so has the metadata of each column.
///
/// # Errors
/// [`TableError`]; then `path` is as it was.
pub fn write_samples(
    path: &Path,
    provenance: &Provenance,
    input_names: &[String],
    outcomes: &[SampleOutcome],
) -> Result<FileRecord, TableError> {
    let content = samples_content(provenance, input_names, outcomes);
    content
        .map_err(|error| FileError::system(path, error.into()))?
        .into_file(path)
}

/// What [`write_samples`] writes.
pub(super) fn samples_content<'t>(
    provenance: &Provenance,
    input_names: &'t [String],
    outcomes: &'t [SampleOutcome],
) -> Result<SamplesContent<'t, impl Fn(&[SampleOutcome]) -> Table>, serde_json::Error> {
    let mut metadata = key_values(provenance)?;
    let names = serde_json::to_string(input_names)?;
    metadata.push(KeyValue::new(INPUTS_KEY.to_owned(), names));
    let group = outcomes
        .first()
        .map_or_else(SampleGroup::default, |o| o.group);
    Ok(TableContent {
        metadata,
        described: &SAMPLE_COLUMNS,
        rows: outcomes,
        table: move |part: &[SampleOutcome]| sample_columns(input_names, group, part),
    })
}

/// A table of samples or curves.
type SamplesContent<'t, F> = TableContent<'t, SampleOutcome, F>;

/// Writes the forced response curves: `sample`, `level`, `frequency_hz`, `amplitude_m`.
///
/// # Errors
/// [`TableError`]; then `path` is as it was.
pub fn write_curves(
    path: &Path,
    provenance: &Provenance,
    outcomes: &[SampleOutcome],
) -> Result<FileRecord, TableError> {
    let content = curves_content(provenance, outcomes);
    content
        .map_err(|error| FileError::system(path, error.into()))?
        .into_file(path)
}

/// What [`write_curves`] writes.
pub(super) fn curves_content<'t>(
    provenance: &Provenance,
    outcomes: &'t [SampleOutcome],
) -> Result<SamplesContent<'t, impl Fn(&[SampleOutcome]) -> Table>, serde_json::Error> {
    Ok(TableContent {
        metadata: key_values(provenance)?,
        described: &CURVE_COLUMNS,
        rows: outcomes,
        table: curve_columns,
    })
}

/// Reads what [`write_samples`] wrote.
///
/// # Errors
/// [`FileError`] if the file cannot be read or lacks a column.
pub fn read_samples(path: &Path) -> Result<StoredSamples, FileError> {
    file::read_parquet(path, |reader| {
        let metadata = metadata(&reader);
        let input_names: Vec<String> = metadata
            .get(INPUTS_KEY)
            .and_then(|names| serde_json::from_str(names).ok())
            .ok_or_else(|| missing(INPUTS_KEY))?;
        let mut outcomes: Vec<SampleOutcome> = Vec::new();
        for row in reader.get_row_iter(None)? {
            let row = Record::of(row?);
            let index = row.count("sample")? as u64;
            if outcomes.last().is_none_or(|last| last.index != index) {
                let inputs: Result<_, _> = input_names.iter().map(|name| row.real(name)).collect();
                outcomes.push(SampleOutcome {
                    index,
                    group: group(&row),
                    inputs: inputs?,
                    levels: Vec::new(),
                });
            }
            if let Some(outcome) = outcomes.last_mut() {
                outcome.levels.push(level_outcome(&row)?);
            }
        }
        Ok(StoredSamples {
            metadata,
            input_names,
            outcomes,
        })
    })
}

/// Reads what [`write_curves`] wrote into the outcomes of the same run; their curves are empty before.
///
/// # Errors
/// [`FileError`] if the file cannot be read, lacks a column or belongs to other samples.
pub fn read_curves(path: &Path, outcomes: &mut [SampleOutcome]) -> Result<(), FileError> {
    let places: BTreeMap<u64, usize> = outcomes.iter().map(|o| o.index).zip(0..).collect();
    file::read_parquet(path, |reader| {
        for row in reader.get_row_iter(None)? {
            let row = Record::of(row?);
            let (sample, level) = (row.count("sample")? as u64, row.real("level")?);
            let outcome = places.get(&sample).and_then(|&i| outcomes.get_mut(i));
            let record = outcome.and_then(|o| o.levels.iter_mut().find(|l| l.level == level));
            let record = record.ok_or_else(|| missing("the sample of a curve"))?;
            record.curve.push(CurvePoint {
                frequency_hz: row.number("frequency_hz")?,
                amplitude_m: row.number("amplitude_m")?,
            });
        }
        Ok(())
    })
}

/// A sample at one of its levels: a row of the table of samples.
type LevelRow<'a> = (&'a SampleOutcome, &'a LevelOutcome);

/// `group` tells which of its columns there are.
fn sample_columns(input_names: &[String], group: SampleGroup, outcomes: &[SampleOutcome]) -> Table {
    let rows: Vec<LevelRow> = outcomes
        .iter()
        .flat_map(|outcome| outcome.levels.iter().map(move |level| (outcome, level)))
        .collect();
    let mut table = input_columns(input_names, group, &rows);
    table.extend(peak_columns(&rows));
    let newton = rows.iter().map(|(_, l)| count(l.newton_iterations));
    let factorizations = rows.iter().map(|(_, l)| count(l.factorizations));
    table.extend([
        named("newton_iterations", Column::Count(newton.collect())),
        named("factorizations", Column::Count(factorizations.collect())),
    ]);
    table
}

fn named(name: &str, column: Column) -> (String, Column) {
    (name.to_owned(), column)
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}

/// Which sample and level a row is of, and how the search for its peak ended.
fn input_columns(input_names: &[String], group: SampleGroup, rows: &[LevelRow]) -> Table {
    let index = |outcome: &SampleOutcome| i64::try_from(outcome.index).ok();
    let sample = rows.iter().map(|(o, _)| index(o));
    let mut table = vec![named("sample", Column::Count(sample.collect()))];
    for (name, of) in GROUP_COLUMNS {
        if of(&group).is_some() {
            let number = |o: &SampleOutcome| of(&o.group).and_then(|n| i64::try_from(n).ok());
            let numbers = rows.iter().map(|(o, _)| number(o));
            table.push(named(name, Column::Count(numbers.collect())));
        }
    }
    for (i, name) in input_names.iter().enumerate() {
        let input = |o: &SampleOutcome| o.inputs.get(i).copied().and_then(finite);
        let inputs = rows.iter().map(|(o, _)| input(o));
        table.push(named(name, Column::Real(inputs.collect())));
    }
    let level = rows.iter().map(|(_, l)| finite(l.level));
    let status = rows.iter().map(|(_, l)| Some(l.status.name()));
    table.extend([
        named("level", Column::Real(level.collect())),
        named("status", Column::Text(status.collect())),
    ]);
    table
}

/// The peaks of the rows, and the lower maxima; empty where the search has no solution.
fn peak_columns(rows: &[LevelRow]) -> Table {
    let peak = |level: &LevelOutcome| level.peak.filter(|_| level.status.has_solution());
    let real = |name: &str, f: fn(&PeakRecord) -> Option<f64>| {
        let value = |(_, level): &LevelRow| peak(level).as_ref().and_then(f).and_then(finite);
        named(name, Column::Real(rows.iter().map(value).collect()))
    };
    let route = |(_, l): &LevelRow| peak(l).and_then(|p| p.route).map(PeakRoute::name);
    let highest = |(_, l): &LevelRow| peak(l).and_then(|p| count(p.highest_harmonic));
    let mut table = vec![
        real("frequency_hz", |p| Some(p.frequency_hz)),
        real("amplitude_m", |p| Some(p.amplitude_m)),
        named("route", Column::Text(rows.iter().map(route).collect())),
        real("truncation_error", |p| p.truncation_error),
        named(
            "highest_harmonic",
            Column::Count(rows.iter().map(highest).collect()),
        ),
        real("stick_fraction", |p| Some(p.stick_fraction)),
        real("slip_fraction", |p| Some(p.slip_fraction)),
        real("separated_fraction", |p| Some(p.separated_fraction)),
        real("work_input_j", |p| Some(p.work_input_j)),
        real("work_viscous_j", |p| Some(p.work_viscous_j)),
        real("work_friction_j", |p| Some(p.work_friction_j)),
        real("residual", |p| Some(p.residual)),
    ];
    for (name, of) in OTHER_COLUMNS {
        let others = |(_, l): &LevelRow| match peak(l) {
            Some(_) => l.others.iter().map(of).collect(),
            None => Vec::new(),
        };
        table.push(named(
            name,
            Column::Reals(rows.iter().map(others).collect()),
        ));
    }
    table
}

fn curve_columns(outcomes: &[SampleOutcome]) -> Table {
    let (mut sample, mut level) = (Vec::new(), Vec::new());
    let (mut frequency, mut amplitude) = (Vec::new(), Vec::new());
    for outcome in outcomes {
        for record in &outcome.levels {
            for point in &record.curve {
                sample.push(i64::try_from(outcome.index).ok());
                level.push(Some(record.level).filter(|v| v.is_finite()));
                frequency.push(Some(point.frequency_hz).filter(|v| v.is_finite()));
                amplitude.push(Some(point.amplitude_m).filter(|v| v.is_finite()));
            }
        }
    }
    vec![
        ("sample".to_owned(), Column::Count(sample)),
        ("level".to_owned(), Column::Real(level)),
        ("frequency_hz".to_owned(), Column::Real(frequency)),
        ("amplitude_m".to_owned(), Column::Real(amplitude)),
    ]
}

/// The provenance as pairs; texts as they are, everything else as JSON.
fn key_values(provenance: &Provenance) -> Result<Vec<KeyValue>, serde_json::Error> {
    let value = serde_json::to_value(provenance)?;
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

fn group(row: &Record) -> SampleGroup {
    let number = |name: &str| Some(row.count(name).ok()? as u64);
    let [outer, replicate, place] = GROUP_COLUMNS.map(|(name, _)| number(name));
    SampleGroup {
        outer,
        replicate,
        place,
    }
}

fn status(row: &Record) -> Result<Status, Fault> {
    let known = row.named("status", &Status::ALL, Status::name)?;
    known.ok_or_else(|| missing("status"))
}

fn level_outcome(row: &Record) -> Result<LevelOutcome, Fault> {
    Ok(LevelOutcome {
        level: row.real("level")?,
        status: status(row)?,
        peak: peak(row)?,
        others: others(row)?,
        curve: Vec::new(),
        newton_iterations: row.count("newton_iterations")?,
        factorizations: row.count("factorizations")?,
    })
}

fn others(row: &Record) -> Result<Vec<OtherMaximum>, Fault> {
    let [(frequencies, _), (amplitudes, _)] = OTHER_COLUMNS;
    let places = (row.reals(frequencies)?.into_iter()).zip(row.reals(amplitudes)?);
    let others = places.map(|(frequency_hz, amplitude_m)| OtherMaximum {
        frequency_hz,
        amplitude_m,
    });
    Ok(others.collect())
}

fn peak(row: &Record) -> Result<Option<PeakRecord>, Fault> {
    let place = (row.optional("frequency_hz")?, row.optional("amplitude_m")?);
    let (Some(frequency_hz), Some(amplitude_m)) = place else {
        return Ok(None);
    };
    Ok(Some(PeakRecord {
        frequency_hz,
        amplitude_m,
        route: row.named("route", &PeakRoute::ALL, PeakRoute::name)?,
        truncation_error: row.optional("truncation_error")?,
        highest_harmonic: row.count("highest_harmonic")?,
        stick_fraction: row.number("stick_fraction")?,
        slip_fraction: row.number("slip_fraction")?,
        separated_fraction: row.number("separated_fraction")?,
        work_input_j: row.number("work_input_j")?,
        work_viscous_j: row.number("work_viscous_j")?,
        work_friction_j: row.number("work_friction_j")?,
        residual: row.number("residual")?,
    }))
}
