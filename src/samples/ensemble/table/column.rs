//! One column: its type, and how it is written.

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::schema::types::{Type, TypePtr};
use std::sync::Arc;

/// One column of a table, nullable where its kind says so.
pub(in crate::ensemble) enum Column {
    Count(Vec<Option<i64>>),
    Real(Vec<Option<f64>>),
    /// A list per row.
    Reals(Vec<Vec<f64>>),
    /// A list per row.
    Counts(Vec<Vec<i64>>),
    Text(Vec<Option<&'static str>>),
    Bytes(Vec<Vec<u8>>),
}

impl Column {
    pub(super) fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        let (physical, logical, repetition) = match self {
            Self::Count(_) => (Physical::INT64, None, Repetition::OPTIONAL),
            Self::Real(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
            Self::Reals(_) => return list_schema(name, Physical::DOUBLE),
            Self::Counts(_) => return list_schema(name, Physical::INT64),
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

    pub(super) fn write(&self, writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
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
            (Self::Counts(lists), ColumnWriter::Int64ColumnWriter(w)) => {
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
