//! A table of a run once more as an Arrow IPC file (Feather version 2), for readers that know no Parquet.
//!
//! It is made from the Parquet file: columns, types, nulls and key-value metadata are described there alone.

use crate::file::{self, FileError, FileRecord};
use arrow_ipc::writer::FileWriter;
use arrow_schema::ArrowError;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::io::Error as IoError;
use std::path::Path;

/// Rows per record batch: bounds the memory of a conversion to a few megabytes.
const BATCH: usize = 1 << 14;

/// Writes the table of the Parquet file `table` to `path`.
///
/// The same columns with the same names, types (Int64, Float64, Utf8), nulls and key-value metadata, in batches of up to
/// 16384 rows; not compressed, so that a reader can map it into memory. The same table gives the same bytes.
///
/// # Errors
/// [`FileError`]; then `path` is as it was.
pub fn write_arrow(table: &Path, path: &Path) -> Result<FileRecord, FileError> {
    let unreadable = |rule: String| FileError::content(table, None, rule);
    let table_file = ParquetRecordBatchReaderBuilder::try_new(file::open(table)?)
        .map_err(|error| unreadable(error.to_string()))?;
    // The batches have lost the metadata.
    let schema = table_file.schema().clone();
    let batches = table_file.with_batch_size(BATCH).build();
    let batches = batches.map_err(|error| unreadable(error.to_string()))?;
    file::replace(path, |file| {
        let fill = || {
            let mut writer = FileWriter::try_new_buffered(file, &schema)?;
            for batch in batches {
                writer.write(&batch?)?;
            }
            writer.finish()
        };
        fill().map_err(plain)
    })
}

/// What the operating system said, where the library wraps that.
fn plain(error: ArrowError) -> IoError {
    match error {
        ArrowError::IoError(_, source) => source,
        other => IoError::other(other),
    }
}
