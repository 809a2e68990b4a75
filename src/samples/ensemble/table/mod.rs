//! Tables as Parquet files: typed columns are written, rows are read in batches.

mod column;
mod read;
mod write;

pub(super) use column::Column;
pub(super) use read::{RowCursor, Rows, TableReader, number, optional, real, whole};
pub(super) use write::{TableLayout, TableWriter};

use crate::file::{Fault, FileError};

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

/// Rows per row group, and per batch of a reader: bounds the memory of both to a few megabytes.
pub(super) const ROW_GROUP: usize = 4096;

/// Columns with their names, in order.
pub(super) type Table = Vec<(String, Column)>;

/// A number as a table stores it.
pub(super) fn count(value: impl TryInto<i64>) -> Option<i64> {
    value.try_into().ok()
}

/// A column or key that this program writes is absent.
pub(super) fn missing(name: &str) -> Fault {
    Fault::new(format!("{name} is missing or of another type"))
}
