//! Tables as Parquet files: typed columns are written, rows are read by column name.

use super::columns::{DescribedColumn, described_schema};
use crate::file::{self, Fault, FileError, FileRecord};
use parquet::arrow::ARROW_SCHEMA_META_KEY;
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
use std::io::{Error as IoError, Write};
use std::path::Path;
use std::sync::Arc;

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// An input bears the name of another column.
    #[error("input {0:?}: the name is already a column of the result file")]
    DuplicateColumn(String),
}

/// Rows per row group: bounds the memory of a write to a few megabytes.
const ROW_GROUP: usize = 4096;

/// Columns with their names, in order.
pub(super) type Table = Vec<(String, Column)>;

/// One column of a table, nullable where its kind says so.
pub(super) enum Column {
    Count(Vec<Option<i64>>),
    Real(Vec<Option<f64>>),
    /// A list per row.
    Reals(Vec<Vec<f64>>),
    Text(Vec<Option<&'static str>>),
    Bytes(Vec<Vec<u8>>),
}

impl Column {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        let (physical, logical, repetition) = match self {
            Self::Count(_) => (Physical::INT64, None, Repetition::OPTIONAL),
            Self::Real(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
            Self::Reals(_) => return list_schema(name, Physical::DOUBLE),
            Self::Text(_) => (
                Physical::BYTE_ARRAY,
                Some(LogicalType::String),
                Repetition::OPTIONAL,
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
            (Self::Reals(lists), ColumnWriter::DoubleColumnWriter(w)) => {
                let (present, levels, repetitions) = flatten(lists);
                w.write_batch(&present, Some(&levels), Some(&repetitions))?;
            }
            (Self::Text(values), ColumnWriter::ByteArrayColumnWriter(w)) => {
                let (present, levels) = split(values);
                let bytes: Vec<ByteArray> = present.into_iter().map(ByteArray::from).collect();
                w.write_batch(&bytes, Some(&levels), None)?;
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

/// Values of all lists, the definition level of each (0 = an empty list) and its repetition level (0 = a list begins).
fn flatten<T: Copy>(lists: &[Vec<T>]) -> (Vec<T>, Vec<i16>, Vec<i16>) {
    let (mut levels, mut repetitions) = (Vec::new(), Vec::new());
    for list in lists {
        levels.extend(std::iter::repeat_n(
            i16::from(!list.is_empty()),
            list.len().max(1),
        ));
        repetitions.push(0);
        repetitions.extend(list.iter().skip(1).map(|_| 1));
    }
    (lists.concat(), levels, repetitions)
}

/// A list that may be empty, of values that are always there.
fn list_schema(name: &str, physical: Physical) -> Result<TypePtr, ParquetError> {
    let element = Type::primitive_type_builder("element", physical)
        .with_repetition(Repetition::REQUIRED)
        .build()?;
    let list = Type::group_type_builder("list")
        .with_repetition(Repetition::REPEATED)
        .with_fields(vec![Arc::new(element)])
        .build()?;
    let field = Type::group_type_builder(name)
        .with_logical_type(Some(LogicalType::List))
        .with_repetition(Repetition::REQUIRED)
        .with_fields(vec![Arc::new(list)])
        .build()?;
    Ok(Arc::new(field))
}

/// A number as a table stores it.
pub(super) fn count(value: usize) -> Option<i64> {
    i64::try_from(value).ok()
}

/// What goes into a Parquet file.
pub(super) struct TableContent<'t, T, F> {
    /// Key-value metadata.
    pub metadata: Vec<KeyValue>,
    /// What columns of these names mean.
    pub described: &'t [DescribedColumn],
    /// The rows.
    pub rows: &'t [T],
    /// The columns of a part of the rows.
    pub table: F,
}

impl<T, F: Fn(&[T]) -> Table> TableContent<'_, T, F> {
    /// Writes the file, whole or not at all.
    pub(super) fn into_file(self, path: &Path) -> Result<FileRecord, TableError> {
        let columns = self.columns()?;
        Ok(file::replace(path, |file| self.fill(&columns, file))?)
    }

    /// The bytes of the file.
    pub(super) fn into_bytes(self) -> Result<Vec<u8>, TableError> {
        let columns = self.columns()?;
        let mut bytes = Vec::new();
        let filled = self.fill(&columns, &mut bytes);
        filled.map_err(|source| FileError::system("a table in memory".as_ref(), source))?;
        Ok(bytes)
    }

    /// The columns without rows; a name may not stand twice.
    fn columns(&self) -> Result<Table, TableError> {
        let columns = (self.table)(&[]);
        let mut names = BTreeSet::new();
        match columns.iter().find(|(name, _)| !names.insert(name)) {
            Some((name, _)) => Err(TableError::DuplicateColumn(name.clone())),
            None => Ok(columns),
        }
    }

    fn fill(self, columns: &Table, file: impl Write + Send) -> Result<(), IoError> {
        let mut metadata = self.metadata;
        let fill = || {
            let schema = schema(columns)?;
            if !self.described.is_empty() {
                let arrow = described_schema(&schema, self.described, &metadata)?;
                metadata.push(arrow);
            }
            let properties = WriterProperties::builder()
                .set_compression(Compression::SNAPPY)
                .set_key_value_metadata(Some(metadata))
                .build();
            let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
            for part in self.rows.chunks(ROW_GROUP) {
                let mut group = writer.next_row_group()?;
                for (_, column) in (self.table)(part) {
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
    }
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

/// Key-value metadata of a file, but for its schema in Arrow's words.
pub(super) fn metadata(reader: &SerializedFileReader<File>) -> BTreeMap<String, String> {
    let stored = reader.metadata().file_metadata().key_value_metadata();
    stored
        .into_iter()
        .flatten()
        .filter(|pair| pair.key != ARROW_SCHEMA_META_KEY)
        .filter_map(|pair| Some((pair.key.clone(), pair.value.clone()?)))
        .collect()
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
    pub(super) fn number(&self, name: &str) -> Result<f64, Fault> {
        Ok(self.optional(name)?.unwrap_or(f64::NAN))
    }

    pub(super) fn reals(&self, name: &str) -> Result<Vec<f64>, Fault> {
        let Some(Field::ListInternal(list)) = self.0.get(name) else {
            return Err(missing(name));
        };
        let elements = list.elements().iter().map(|element| match element {
            Field::Double(value) => Ok(*value),
            _ => Err(missing(name)),
        });
        elements.collect()
    }

    pub(super) fn count(&self, name: &str) -> Result<usize, Fault> {
        match self.0.get(name) {
            Some(Field::Long(value)) => usize::try_from(*value).map_err(|_| missing(name)),
            _ => Err(missing(name)),
        }
    }

    /// One of `all`, by the name that it bears in files; none where there is no text.
    pub(super) fn named<T: Copy>(
        &self,
        name: &str,
        all: &[T],
        name_of: fn(T) -> &'static str,
    ) -> Result<Option<T>, Fault> {
        let text = match self.0.get(name) {
            Some(Field::Str(text)) => text,
            Some(Field::Null) => return Ok(None),
            _ => return Err(missing(name)),
        };
        let known = all.iter().find(|&&one| name_of(one) == text);
        known.copied().map(Some).ok_or_else(|| missing(name))
    }

    pub(super) fn bytes(&self, name: &str) -> Result<&[u8], Fault> {
        match self.0.get(name) {
            Some(Field::Bytes(value)) => Ok(value.data()),
            _ => Err(missing(name)),
        }
    }
}
