//! Outcomes on disk: `samples.parquet` (one row per sample and level) and `curves.parquet` (one row per point).
//!
//! A sample without a solution keeps its row: status and work counts are there, the numbers of the peak are null.
//! No column ever holds NaN. Files appear whole or not at all.

use super::outcome::{CurvePoint, LevelOutcome, OtherMaximum, PeakRecord, SampleOutcome};
use crate::contact::{Events, FrictionLaw};
use crate::file::{self, Fault, FileError, FileRecord};
use crate::hb::{SliderAnchor, Status};
use crate::sampling::SampleGroup;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::{Field, Row};
use parquet::schema::types::{Type, TypePtr};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Error as IoError;
use std::path::Path;
use std::sync::Arc;

/// What a result must carry to be understood and repeated.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Provenance {
    /// Name of the study.
    pub study: String,
    /// Root seed of the samples.
    pub seed: u64,
    /// Version of this program.
    pub version: String,
    /// Commit that it was built from, as stated at its build; absent if nobody stated one.
    pub commit: Option<String>,
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

/// Why outcomes could not be stored.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// An input bears the name of another column.
    #[error("input {0:?}: the name is already a column of the result file")]
    DuplicateColumn(String),
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

/// Samples per row group: bounds the memory of a write to a few megabytes.
const ROW_GROUP: usize = 4096;
const INPUTS_KEY: &str = "inputs";
/// Columns of what a sample belongs to.
type GroupColumn = (&'static str, fn(&SampleGroup) -> Option<u64>);
const GROUP_COLUMNS: [GroupColumn; 3] = [
    ("outer", |group| group.outer),
    ("replicate", |group| group.replicate),
    ("place", |group| group.place),
];

/// Writes one row per sample and level.
///
/// Columns: `sample`, those of [`SampleGroup`] that the design has, the inputs by name, `level`, `status`, then the fields
/// of [`PeakRecord`] (null without a solution), `newton_iterations`, `factorizations`. Units are those of [`PeakRecord`].
///
/// # Errors
/// [`StoreError`]; then `path` is as it was.
pub fn write_samples(
    path: &Path,
    provenance: &Provenance,
    input_names: &[String],
    outcomes: &[SampleOutcome],
) -> Result<FileRecord, StoreError> {
    let system = |error: serde_json::Error| FileError::system(path, error.into());
    let mut metadata = key_values(provenance).map_err(system)?;
    let names = serde_json::to_string(input_names).map_err(system)?;
    metadata.push(KeyValue::new(INPUTS_KEY.to_owned(), names));
    let group = outcomes
        .first()
        .map_or_else(SampleGroup::default, |o| o.group);
    let table = |part: &[SampleOutcome]| sample_columns(input_names, group, part);
    write_table(path, metadata, outcomes, table)
}

/// Writes the forced response curves: `sample`, `level`, `frequency_hz`, `amplitude_m`.
///
/// # Errors
/// [`StoreError`]; then `path` is as it was.
pub fn write_curves(
    path: &Path,
    provenance: &Provenance,
    outcomes: &[SampleOutcome],
) -> Result<FileRecord, StoreError> {
    let system = |error: serde_json::Error| FileError::system(path, error.into());
    let metadata = key_values(provenance).map_err(system)?;
    write_table(path, metadata, outcomes, curve_columns)
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
                    group: row.group(),
                    inputs: inputs?,
                    levels: Vec::new(),
                });
            }
            if let Some(outcome) = outcomes.last_mut() {
                outcome.levels.push(row.level_outcome()?);
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

/// Key-value metadata of a file.
pub(super) fn metadata(reader: &SerializedFileReader<File>) -> BTreeMap<String, String> {
    let stored = reader.metadata().file_metadata().key_value_metadata();
    stored
        .into_iter()
        .flatten()
        .filter_map(|pair| Some((pair.key.clone(), pair.value.clone()?)))
        .collect()
}

/// One column of a table, nullable where its kind says so.
pub(super) enum Column {
    Count(Vec<Option<i64>>),
    Real(Vec<Option<f64>>),
    Text(Vec<&'static str>),
    Bytes(Vec<Vec<u8>>),
}

impl Column {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        let (physical, logical, repetition) = match self {
            Self::Count(_) => (Physical::INT64, None, Repetition::OPTIONAL),
            Self::Real(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
            Self::Text(_) => (
                Physical::BYTE_ARRAY,
                Some(LogicalType::String),
                Repetition::REQUIRED,
            ),
            Self::Bytes(_) => (Physical::BYTE_ARRAY, None, Repetition::REQUIRED),
        };
        let field = Type::primitive_type_builder(name, physical)
            .with_logical_type(logical)
            .with_repetition(repetition)
            .build()?;
        Ok(Arc::new(field))
    }

    fn write(&self, writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
        match (self, writer) {
            (Self::Count(values), ColumnWriter::Int64ColumnWriter(w)) => {
                let (present, levels) = split(values);
                w.write_batch(&present, Some(&levels), None)?;
            }
            (Self::Real(values), ColumnWriter::DoubleColumnWriter(w)) => {
                let (present, levels) = split(values);
                w.write_batch(&present, Some(&levels), None)?;
            }
            (Self::Text(values), ColumnWriter::ByteArrayColumnWriter(w)) => {
                let bytes: Vec<ByteArray> = values.iter().map(|&text| text.into()).collect();
                w.write_batch(&bytes, None, None)?;
            }
            (Self::Bytes(values), ColumnWriter::ByteArrayColumnWriter(w)) => {
                let bytes: Vec<ByteArray> = values.iter().map(|v| v.clone().into()).collect();
                w.write_batch(&bytes, None, None)?;
            }
            _ => return Err(ParquetError::General("column of another type".to_owned())),
        }
        Ok(())
    }
}

/// Present values and the definition level of every row (1 = present), as Parquet wants them.
fn split<T: Copy>(values: &[Option<T>]) -> (Vec<T>, Vec<i16>) {
    let present = values.iter().flatten().copied().collect();
    let levels = values.iter().map(|v| i16::from(v.is_some())).collect();
    (present, levels)
}

pub(super) type Table = Vec<(String, Column)>;

fn count(value: usize) -> Option<i64> {
    i64::try_from(value).ok()
}

/// `group` tells which of its columns there are.
fn sample_columns(input_names: &[String], group: SampleGroup, outcomes: &[SampleOutcome]) -> Table {
    let rows: Vec<(&SampleOutcome, &LevelOutcome)> = outcomes
        .iter()
        .flat_map(|outcome| outcome.levels.iter().map(move |level| (outcome, level)))
        .collect();
    let finite = |value: f64| Some(value).filter(|v| v.is_finite());
    let peak = |level: &LevelOutcome| level.peak.filter(|_| level.status.has_solution());
    let real = |f: fn(&PeakRecord) -> Option<f64>| {
        let value = |(_, level): &(_, &LevelOutcome)| peak(level).as_ref().and_then(f);
        Column::Real(rows.iter().map(|row| value(row).and_then(finite)).collect())
    };
    let mut table: Table = Vec::new();
    let mut add = |name: &str, column: Column| table.push((name.to_owned(), column));
    let index = |outcome: &SampleOutcome| i64::try_from(outcome.index).ok();
    add(
        "sample",
        Column::Count(rows.iter().map(|(o, _)| index(o)).collect()),
    );
    for (name, of) in GROUP_COLUMNS {
        if of(&group).is_some() {
            let number = |o: &SampleOutcome| of(&o.group).and_then(|n| i64::try_from(n).ok());
            add(
                name,
                Column::Count(rows.iter().map(|(o, _)| number(o)).collect()),
            );
        }
    }
    for (i, name) in input_names.iter().enumerate() {
        let input = |o: &SampleOutcome| o.inputs.get(i).copied().and_then(finite);
        add(
            name,
            Column::Real(rows.iter().map(|(o, _)| input(o)).collect()),
        );
    }
    add(
        "level",
        Column::Real(rows.iter().map(|(_, l)| finite(l.level)).collect()),
    );
    add(
        "status",
        Column::Text(rows.iter().map(|(_, l)| l.status.name()).collect()),
    );
    add("frequency_hz", real(|p| Some(p.frequency_hz)));
    add("amplitude_m", real(|p| Some(p.amplitude_m)));
    add("truncation_error", real(|p| p.truncation_error));
    let highest = |l: &LevelOutcome| peak(l).and_then(|p| count(p.highest_harmonic));
    add(
        "highest_harmonic",
        Column::Count(rows.iter().map(|(_, l)| highest(l)).collect()),
    );
    add("stick_fraction", real(|p| Some(p.stick_fraction)));
    add("slip_fraction", real(|p| Some(p.slip_fraction)));
    add("separated_fraction", real(|p| Some(p.separated_fraction)));
    add("work_input_j", real(|p| Some(p.work_input_j)));
    add("work_viscous_j", real(|p| Some(p.work_viscous_j)));
    add("work_friction_j", real(|p| Some(p.work_friction_j)));
    add("residual", real(|p| Some(p.residual)));
    let others = |l: &LevelOutcome| peak(l).and_then(|p| count(p.other_maxima));
    add(
        "other_maxima",
        Column::Count(rows.iter().map(|(_, l)| others(l)).collect()),
    );
    add(
        "next_frequency_hz",
        real(|p| p.next.map(|n| n.frequency_hz)),
    );
    add("next_amplitude_m", real(|p| p.next.map(|n| n.amplitude_m)));
    let newton = rows.iter().map(|(_, l)| count(l.newton_iterations));
    add("newton_iterations", Column::Count(newton.collect()));
    let factorizations = rows.iter().map(|(_, l)| count(l.factorizations));
    add("factorizations", Column::Count(factorizations.collect()));
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

/// Writes `rows`, as the columns that `table` makes of a part of them.
pub(super) fn write_table<T>(
    path: &Path,
    metadata: Vec<KeyValue>,
    rows: &[T],
    table: impl Fn(&[T]) -> Table,
) -> Result<FileRecord, StoreError> {
    let columns = table(&[]);
    let mut names = BTreeSet::new();
    if let Some((name, _)) = columns.iter().find(|(name, _)| !names.insert(name)) {
        return Err(StoreError::DuplicateColumn(name.clone()));
    }
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata))
        .build();
    let written = file::replace(path, |file| {
        let fill = || {
            let schema = schema(&columns)?;
            let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
            for part in rows.chunks(ROW_GROUP) {
                let mut group = writer.next_row_group()?;
                for (_, column) in table(part) {
                    if let Some(mut target) = group.next_column()? {
                        column.write(target.untyped())?;
                        target.close()?;
                    }
                }
                group.close()?;
            }
            writer.close()
        };
        fill().map(drop).map_err(plain)
    });
    Ok(written?)
}

fn schema(columns: &Table) -> Result<TypePtr, ParquetError> {
    let fields: Result<Vec<TypePtr>, _> = columns.iter().map(|(name, c)| c.schema(name)).collect();
    let schema = Type::group_type_builder("schema").with_fields(fields?);
    Ok(Arc::new(schema.build()?))
}

/// What the operating system said, where the library wraps that.
fn plain(error: ParquetError) -> IoError {
    match error {
        ParquetError::External(source) => match source.downcast::<IoError>() {
            Ok(source) => *source,
            Err(other) => IoError::other(other),
        },
        other => IoError::other(other),
    }
}

/// A column or key that this program writes is absent.
pub(super) fn missing(name: &str) -> Fault {
    Fault::new(format!("{name} is missing or of another type"))
}

/// A row by column name.
pub(super) struct Record(BTreeMap<String, Field>);

impl Record {
    pub(super) fn of(row: Row) -> Self {
        Self(row.into_columns().into_iter().collect())
    }

    pub(super) fn optional(&self, name: &str) -> Result<Option<f64>, Fault> {
        match self.0.get(name) {
            Some(Field::Double(value)) => Ok(Some(*value)),
            Some(Field::Null) => Ok(None),
            _ => Err(missing(name)),
        }
    }

    pub(super) fn real(&self, name: &str) -> Result<f64, Fault> {
        self.optional(name)?.ok_or_else(|| missing(name))
    }

    /// A number that was not finite when it was written is NaN again.
    fn number(&self, name: &str) -> Result<f64, Fault> {
        Ok(self.optional(name)?.unwrap_or(f64::NAN))
    }

    pub(super) fn count(&self, name: &str) -> Result<usize, Fault> {
        match self.0.get(name) {
            Some(Field::Long(value)) => usize::try_from(*value).map_err(|_| missing(name)),
            _ => Err(missing(name)),
        }
    }

    pub(super) fn bytes(&self, name: &str) -> Result<&[u8], Fault> {
        match self.0.get(name) {
            Some(Field::Bytes(value)) => Ok(value.data()),
            _ => Err(missing(name)),
        }
    }

    fn group(&self) -> SampleGroup {
        let number = |name: &str| Some(self.count(name).ok()? as u64);
        let [outer, replicate, place] = GROUP_COLUMNS.map(|(name, _)| number(name));
        SampleGroup {
            outer,
            replicate,
            place,
        }
    }

    fn status(&self) -> Result<Status, Fault> {
        let Some(Field::Str(name)) = self.0.get("status") else {
            return Err(missing("status"));
        };
        let known = Status::ALL.into_iter().find(|status| status.name() == name);
        known.ok_or_else(|| missing("status"))
    }

    fn level_outcome(&self) -> Result<LevelOutcome, Fault> {
        Ok(LevelOutcome {
            level: self.real("level")?,
            status: self.status()?,
            peak: self.peak()?,
            curve: Vec::new(),
            newton_iterations: self.count("newton_iterations")?,
            factorizations: self.count("factorizations")?,
        })
    }

    fn peak(&self) -> Result<Option<PeakRecord>, Fault> {
        let place = (
            self.optional("frequency_hz")?,
            self.optional("amplitude_m")?,
        );
        let (Some(frequency_hz), Some(amplitude_m)) = place else {
            return Ok(None);
        };
        Ok(Some(PeakRecord {
            frequency_hz,
            amplitude_m,
            truncation_error: self.optional("truncation_error")?,
            highest_harmonic: self.count("highest_harmonic")?,
            stick_fraction: self.number("stick_fraction")?,
            slip_fraction: self.number("slip_fraction")?,
            separated_fraction: self.number("separated_fraction")?,
            work_input_j: self.number("work_input_j")?,
            work_viscous_j: self.number("work_viscous_j")?,
            work_friction_j: self.number("work_friction_j")?,
            residual: self.number("residual")?,
            other_maxima: self.count("other_maxima")?,
            next: (self.optional("next_frequency_hz")?)
                .zip(self.optional("next_amplitude_m")?)
                .map(|(frequency_hz, amplitude_m)| OtherMaximum {
                    frequency_hz,
                    amplitude_m,
                }),
        }))
    }
}
