//! Rows of a Parquet file, batch by batch.

use super::{ROW_GROUP, missing};
use crate::file::parquet::without_panic;
use crate::file::{self, Fault, FileError};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{
    Array, BinaryArray, Float64Array, Int64Array, ListArray, RecordBatch, StringArray,
};
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::arrow::{ARROW_SCHEMA_META_KEY, ProjectionMask};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A table that is being read.
pub(in crate::ensemble) struct TableReader {
    path: PathBuf,
    /// Key-value metadata, but for the schema in Arrow's words.
    pub metadata: BTreeMap<String, String>,
    batches: ParquetRecordBatchReader,
}

impl TableReader {
    /// Opens the file `path` for its columns `names`, or all where none is named.
    pub(in crate::ensemble) fn open(path: &Path, names: &[&str]) -> Result<Self, FileError> {
        let file = file::open(path)?;
        let opened = without_panic(|| {
            let builder =
                ParquetRecordBatchReaderBuilder::try_new(file)?.with_batch_size(ROW_GROUP);
            let stored = builder.metadata().file_metadata();
            let pairs = stored.key_value_metadata().into_iter().flatten();
            let own = pairs.filter(|pair| pair.key != ARROW_SCHEMA_META_KEY);
            let metadata = own.filter_map(|pair| Some((pair.key.clone(), pair.value.clone()?)));
            let metadata = metadata.collect();
            let mask = match names {
                [] => ProjectionMask::all(),
                _ => ProjectionMask::columns(builder.parquet_schema(), names.iter().copied()),
            };
            Ok((metadata, builder.with_projection(mask).build()?))
        });
        let found = opened.unwrap_or_else(|| Err(damaged()));
        let (metadata, batches) = found.map_err(|fault| in_file(path, fault))?;
        Ok(Self {
            path: path.to_owned(),
            metadata,
            batches,
        })
    }

    /// What `found` says of this file.
    pub(in crate::ensemble) fn checked<T>(&self, found: Result<T, Fault>) -> Result<T, FileError> {
        found.map_err(|fault| in_file(&self.path, fault))
    }

    /// The next rows; none at the end.
    pub(in crate::ensemble) fn next(&mut self) -> Result<Option<Rows>, FileError> {
        let batches = &mut self.batches;
        let next = match without_panic(|| batches.next().transpose()) {
            Some(Ok(next)) => Ok(next.map(Rows)),
            Some(Err(error)) => Err(Fault::new(format!("cannot be read: {error}"))),
            None => Err(damaged()),
        };
        self.checked(next)
    }
}

fn in_file(path: &Path, fault: Fault) -> FileError {
    FileError::content(path, fault.row, fault.rule)
}

fn damaged() -> Fault {
    Fault::new("is damaged: the Parquet library cannot read it")
}

/// Some rows of a table. A column is found by its name and type.
pub(in crate::ensemble) struct Rows(RecordBatch);

impl Rows {
    pub(in crate::ensemble) fn len(&self) -> usize {
        self.0.num_rows()
    }

    fn typed<'a, T>(
        &'a self,
        name: &str,
        typed: impl FnOnce(&'a dyn Array) -> Option<&'a T>,
    ) -> Result<&'a T, Fault> {
        let column = self.0.column_by_name(name);
        let column = column.and_then(|column| typed(column.as_ref()));
        column.ok_or_else(|| missing(name))
    }

    pub(in crate::ensemble) fn reals(&self, name: &str) -> Result<&Float64Array, Fault> {
        self.typed(name, |column| column.as_primitive_opt::<Float64Type>())
    }

    pub(in crate::ensemble) fn counts(&self, name: &str) -> Result<&Int64Array, Fault> {
        self.typed(name, |column| column.as_primitive_opt::<Int64Type>())
    }

    pub(in crate::ensemble) fn texts(&self, name: &str) -> Result<&StringArray, Fault> {
        self.typed(name, |column| column.as_string_opt::<i32>())
    }

    pub(in crate::ensemble) fn lists(&self, name: &str) -> Result<&ListArray, Fault> {
        self.typed(name, |column| column.as_list_opt::<i32>())
    }

    pub(in crate::ensemble) fn bytes(&self, name: &str) -> Result<&BinaryArray, Fault> {
        self.typed(name, |column| column.as_binary_opt::<i32>())
    }
}

/// Takes the columns of a batch by their names.
type ColumnsOf<B> = Box<dyn Fn(&Rows) -> Result<B, Fault>>;

/// The rows of a table one after the other, read as `B`, which holds the columns of a batch.
pub(in crate::ensemble) struct RowCursor<B> {
    pub reader: TableReader,
    columns: ColumnsOf<B>,
    batch: Option<B>,
    /// Place and number of rows in the batch.
    at: usize,
    rows: usize,
    /// Whether there are no further batches.
    ended: bool,
}

impl<B> RowCursor<B> {
    pub(in crate::ensemble) fn new(
        reader: TableReader,
        columns: impl Fn(&Rows) -> Result<B, Fault> + 'static,
    ) -> Self {
        Self {
            reader,
            columns: Box::new(columns),
            batch: None,
            at: 0,
            rows: 0,
            ended: false,
        }
    }

    /// The row at hand: the columns of its batch and its place there; none after the last row.
    pub(in crate::ensemble) fn row(&mut self) -> Result<Option<(&B, usize)>, FileError> {
        while self.at == self.rows && !self.ended {
            match self.reader.next()? {
                Some(rows) => {
                    self.batch = Some(self.reader.checked((self.columns)(&rows))?);
                    (self.at, self.rows) = (0, rows.len());
                }
                None => (self.batch, self.ended) = (None, true),
            }
        }
        Ok(self.batch.as_ref().map(|batch| (batch, self.at)))
    }

    /// What `of` makes of the row at hand, which is then passed; none after the last row.
    pub(in crate::ensemble) fn take<T>(
        &mut self,
        of: impl FnOnce(&B, usize) -> Result<T, Fault>,
    ) -> Result<Option<T>, FileError> {
        let Some((batch, at)) = self.row()? else {
            return Ok(None);
        };
        let found = of(batch, at);
        self.at += 1;
        self.reader.checked(found).map(Some)
    }
}

/// A number that is there.
pub(in crate::ensemble) fn real(
    column: &Float64Array,
    at: usize,
    name: &str,
) -> Result<f64, Fault> {
    optional(column, at).ok_or_else(|| missing(name))
}

/// A number, where there is one.
pub(in crate::ensemble) fn optional(column: &Float64Array, at: usize) -> Option<f64> {
    column.is_valid(at).then(|| column.value(at))
}

/// A count that is there.
pub(in crate::ensemble) fn whole<N: TryFrom<i64>>(
    column: &Int64Array,
    at: usize,
    name: &str,
) -> Result<N, Fault> {
    let value = column.is_valid(at).then(|| column.value(at));
    let value = value.and_then(|value| N::try_from(value).ok());
    value.ok_or_else(|| missing(name))
}

/// A number that was not finite when it was written is NaN again.
pub(in crate::ensemble) fn number(column: &Float64Array, at: usize) -> f64 {
    optional(column, at).unwrap_or(f64::NAN)
}
