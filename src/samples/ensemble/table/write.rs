//! Rows to a Parquet file, group by group.

use super::super::columns::{DescribedColumn, described_schema};
use super::{ROW_GROUP, Table, TableError};
use crate::file::{FileError, FileRecord, NewFile};
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};
use std::collections::BTreeSet;
use std::io::{Error as IoError, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Makes the columns of some rows.
type ColumnsOf<'t, T> = Box<dyn Fn(&[T]) -> Table + 't>;

/// What a table of rows `T` is, beside these rows.
pub(in crate::ensemble) struct TableLayout<'t, T> {
    /// Key-value metadata.
    pub metadata: Vec<KeyValue>,
    /// What columns of these names mean.
    pub described: &'t [DescribedColumn],
    /// The columns of some rows.
    pub columns: ColumnsOf<'t, T>,
}

/// A table that is being written.
pub(in crate::ensemble) struct TableWriter<'t, T, W: Write + Send> {
    path: PathBuf,
    columns: ColumnsOf<'t, T>,
    writer: SerializedFileWriter<W>,
}

impl<'t, T> TableWriter<'t, T, NewFile> {
    /// Begins the file `path`.
    pub(in crate::ensemble) fn create(
        path: &Path,
        layout: TableLayout<'t, T>,
    ) -> Result<Self, TableError> {
        // before there is a file
        refuse_duplicates(&(layout.columns)(&[]))?;
        Self::begin(path, NewFile::begin(path)?, layout)
    }

    /// Ends the file, which then has its name.
    pub(in crate::ensemble) fn finish(self) -> Result<FileRecord, TableError> {
        let file = self.writer.into_inner();
        let file = file.map_err(|error| FileError::system(&self.path, plain(error)))?;
        Ok(file.finish()?)
    }
}

impl<'t, T> TableWriter<'t, T, Vec<u8>> {
    /// Begins a table in memory.
    pub(in crate::ensemble) fn in_memory(layout: TableLayout<'t, T>) -> Result<Self, TableError> {
        refuse_duplicates(&(layout.columns)(&[]))?;
        Self::begin("a table in memory".as_ref(), Vec::new(), layout)
    }

    /// Its bytes.
    pub(in crate::ensemble) fn into_bytes(self) -> Result<Vec<u8>, TableError> {
        let bytes = self.writer.into_inner();
        Ok(bytes.map_err(|error| FileError::system(&self.path, plain(error)))?)
    }
}

impl<'t, T, W: Write + Send> TableWriter<'t, T, W> {
    fn begin(path: &Path, out: W, layout: TableLayout<'t, T>) -> Result<Self, TableError> {
        let begun = || {
            let schema = schema(&(layout.columns)(&[]))?;
            let mut metadata = layout.metadata;
            if !layout.described.is_empty() {
                let arrow = described_schema(&schema, layout.described, &metadata)?;
                metadata.push(arrow);
            }
            let properties = WriterProperties::builder()
                .set_compression(Compression::SNAPPY)
                .set_key_value_metadata(Some(metadata))
                .build();
            SerializedFileWriter::new(out, schema, Arc::new(properties))
        };
        Ok(Self {
            path: path.to_owned(),
            writer: begun().map_err(|error| FileError::system(path, plain(error)))?,
            columns: layout.columns,
        })
    }

    /// Writes rows, in row groups of a fixed length from the first of these rows.
    pub(in crate::ensemble) fn write(&mut self, rows: &[T]) -> Result<(), TableError> {
        for group in rows.chunks(ROW_GROUP) {
            let columns = (self.columns)(group);
            let written = write_group(&mut self.writer, &columns);
            written.map_err(|error| FileError::system(&self.path, plain(error)))?;
        }
        Ok(())
    }
}

fn write_group<W: Write + Send>(
    writer: &mut SerializedFileWriter<W>,
    columns: &Table,
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for (_, column) in columns {
        if let Some(mut target) = group.next_column()? {
            column.write(target.untyped())?;
            target.close()?;
        }
    }
    group.close()?;
    Ok(())
}

/// A name may not stand twice.
fn refuse_duplicates(columns: &Table) -> Result<(), TableError> {
    let mut names = BTreeSet::new();
    match columns.iter().find(|(name, _)| !names.insert(name)) {
        Some((name, _)) => Err(TableError::DuplicateColumn(name.clone())),
        None => Ok(()),
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
