//! Tables of results as streams of Arrow's C interface, which other packages read without a copy and without this one.

use crate::errors::StudyError;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::fs::File;
use std::path::PathBuf;

/// A capsule with the stream of the Parquet file `path`: `arrow_array_stream` of the Arrow PyCapsule interface.
#[pyfunction]
pub(crate) fn stream(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyCapsule>> {
    let unreadable = |error: &dyn std::fmt::Display| {
        let message = format!("{}: {error}", path.display());
        StudyError::new_err(message)
    };
    let file = File::open(&path)?;
    let reader = ParquetRecordBatchReaderBuilder::try_new(file)
        .and_then(ParquetRecordBatchReaderBuilder::build)
        .map_err(|error| unreadable(&error))?;
    let stream = FFI_ArrowArrayStream::new(Box::new(reader));
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}
