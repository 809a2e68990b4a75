//! A table of a run once more as an Arrow IPC file (Feather version 2), for readers that know no Parquet.
//!
//! It is made from the Parquet file: columns, types, nulls and key-value metadata are described there alone.

use super::store::{StoreError, replace_file};
use arrow_ipc::writer::FileWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::fs::File;
use std::path::Path;

/// Rows per record batch: bounds the memory of a conversion to a few megabytes.
const BATCH: usize = 1 << 14;

/// Writes the table of the Parquet file `table` to `path`.
///
/// The same columns with the same names, types (Int64, Float64, Utf8), nulls and key-value metadata, in batches of up to
/// 16384 rows; not compressed, so that a reader can map it into memory. The same table gives the same bytes.
///
/// # Errors
/// [`StoreError`]; then `path` is as it was.
pub fn write_arrow(table: &Path, path: &Path) -> Result<(), StoreError> {
    let table_file = ParquetRecordBatchReaderBuilder::try_new(File::open(table)?)?;
    // The batches have lost the metadata.
    let schema = table_file.schema().clone();
    let batches = table_file.with_batch_size(BATCH).build()?;
    replace_file(path, |file| {
        let mut writer = FileWriter::try_new_buffered(file, &schema)?;
        for batch in batches {
            writer.write(&batch?)?;
        }
        Ok(writer.finish()?)
    })
}
