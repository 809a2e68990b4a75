//! Parquet files: what is written can be read back, and files appear whole or not at all.

use crate::synthetic::{SyntheticStudy, provenance};
use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_ipc::reader::FileReader as ArrowReader;
use microslip::ensemble::arrow::write_arrow;
use microslip::ensemble::outcome::{MaybeReal, PeakRecord};
use microslip::ensemble::store::{StoredSamples, read_samples, write_samples};
use microslip::ensemble::table::TableError;
use microslip::file::{FileRecord, replace};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::Path;

/// The samples of a study, written to a file and read back.
fn round_trip(study: &SyntheticStudy) -> StoredSamples {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.parquet");
    write_samples(
        &path,
        &study.record.provenance,
        &study.input_names(),
        &study.outcomes,
    )
    .unwrap();
    read_samples(&path).unwrap()
}

/// Inputs, statuses, peaks and counts come back bit by bit, over more than one row group; failed samples have
/// nulls. Seen to fail with the definition levels swapped (1 for absent), and with lists that all begin anew at each value.
#[test]
fn samples_survive_the_round_trip() {
    let mut study = SyntheticStudy::new(4200);
    if let Some(peak) = &mut study.outcomes[3].levels[1].peak {
        peak.truncation_error = MaybeReal::NONE;
    }
    let stored = round_trip(&study);
    assert_eq!(stored.input_names, study.input_names());
    assert_eq!(stored.metadata["study"], "Two blades with a strip");
    assert_eq!(stored.metadata["seed"], "20260731");
    assert_eq!(stored.metadata["anchor"], "static-equilibrium");
    assert_eq!(stored.metadata["law"], "box");
    assert_eq!(stored.metadata["harmonics"], "[0,1,2,3]");
    assert_eq!(stored.outcomes.len(), study.outcomes.len());
    let mut failed = 0;
    for (read, written) in stored.outcomes.iter().zip(&study.outcomes) {
        assert_eq!((read.index, &read.inputs), (written.index, &written.inputs));
        assert_eq!(read.levels.len(), written.levels.len());
        for (read, written) in read.levels.iter().zip(&written.levels) {
            assert_eq!((read.level, read.status), (written.level, written.status));
            assert_eq!(read.peak, written.peak);
            assert_eq!(read.around.others(), written.around.others());
            assert_eq!(read.newton_iterations, written.newton_iterations);
            assert_eq!(read.factorizations, written.factorizations);
            failed += usize::from(read.peak.is_none());
        }
    }
    assert!(failed > 0, "the study must contain failures");
}

/// Numbers of a failed solve and numbers that are not finite are null, never NaN.
/// Seen to fail without the filter for finite numbers.
#[test]
fn failed_and_non_finite_numbers_are_null() {
    let mut study = SyntheticStudy::new(2);
    study.outcomes[0].levels[0].status = microslip::hb::Status::NonFinite;
    if let Some(peak) = &mut study.outcomes[1].levels[0].peak {
        peak.truncation_error = Some(f64::NAN).into();
    }
    let stored = round_trip(&study);
    assert!(stored.outcomes[0].levels[0].peak.is_none());
    assert_eq!(
        stored.outcomes[1].levels[0]
            .peak
            .unwrap()
            .truncation_error
            .get(),
        None
    );
}

/// Seen to fail with the first point of each curve left out.
#[test]
fn curves_have_one_row_per_point() {
    let study = SyntheticStudy::new(3);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("curves.parquet");
    study.write_tables(folder.path(), &study.outcomes);
    let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
    let levels = study.outcomes.iter().flat_map(|o| &o.levels);
    let n_points: usize = levels.map(|l| l.around.curve().len()).sum();
    assert_eq!(
        reader.metadata().file_metadata().num_rows() as usize,
        n_points
    );
    assert_eq!(reader.get_row_iter(None).unwrap().count(), n_points);
}

/// Seen to fail without the look for duplicates.
#[test]
fn inputs_named_like_columns_are_refused() {
    let study = SyntheticStudy::new(1);
    let names = ["level".to_owned(), "mu".to_owned()];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.parquet");
    let refused = write_samples(&path, &provenance(), &names, &study.outcomes);
    assert!(matches!(refused, Err(TableError::DuplicateColumn(name)) if name == "level"));
    assert!(!path.exists(), "a refused write must leave nothing");
}

/// A write that breaks off leaves the old file and no other. Seen to fail with a plain `File::create`.
#[test]
fn a_broken_write_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("summary.json");
    replace(&path, |file| file.write_all(b"old")).unwrap();
    let broken = replace(&path, |file| {
        file.write_all(b"new, but")?;
        Err(std::io::Error::other("the disk is full"))
    });
    let message = broken.unwrap_err().to_string();
    let expected = format!("{}: the disk is full", path.display());
    assert_eq!(message, expected, "the message names the file");
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A cell of an Arrow table as the reader of Parquet gives it.
fn cell(batch: &RecordBatch, column: usize, row: usize) -> Field {
    let column = batch.column(column);
    if column.is_null(row) {
        return Field::Null;
    }
    if let Some(counts) = column.as_primitive_opt::<Int64Type>() {
        return Field::Long(counts.value(row));
    }
    if let Some(numbers) = column.as_primitive_opt::<Float64Type>() {
        return Field::Double(numbers.value(row));
    }
    Field::Str(column.as_string::<i32>().value(row).to_owned())
}

/// A list of an Arrow table.
fn numbers(batch: &RecordBatch, column: usize, row: usize) -> Vec<f64> {
    let list = batch.column(column).as_list::<i32>().value(row);
    list.as_primitive::<Float64Type>().values().to_vec()
}

/// Compares the Arrow file with the Parquet file it is made from; returns the number of cells, of nulls and of values in lists.
fn assert_same_table(table: &Path, arrow: &Path) -> (usize, usize, usize) {
    let parquet = SerializedFileReader::new(File::open(table).unwrap()).unwrap();
    let found = ArrowReader::try_new(File::open(arrow).unwrap(), None).unwrap();
    let stored = parquet.metadata().file_metadata();
    let pairs = stored.key_value_metadata().unwrap().iter();
    // the schema itself is none of the pairs of an Arrow file
    let expected: BTreeMap<_, _> = pairs
        .filter(|pair| pair.key != "ARROW:schema")
        .map(|pair| (pair.key.clone(), pair.value.clone().unwrap()))
        .collect();
    let schema = found.schema();
    let metadata = schema.metadata().iter();
    assert_eq!(
        metadata
            .map(|(key, value)| (key.clone(), value.clone()))
            .collect::<BTreeMap<_, _>>(),
        expected,
        "metadata"
    );
    let (mut cells, mut nulls, mut listed) = (0, 0, 0);
    let mut rows = parquet.get_row_iter(None).unwrap();
    for batch in found {
        let batch = batch.unwrap();
        for i in 0..batch.num_rows() {
            let row = rows.next().unwrap().unwrap();
            assert_eq!(row.len(), batch.num_columns(), "columns");
            for (j, (name, value)) in row.get_column_iter().enumerate() {
                assert_eq!(schema.field(j).name(), name, "order of the columns");
                match value {
                    Field::ListInternal(list) => {
                        let found = numbers(&batch, j, i).into_iter().map(Field::Double);
                        assert!(found.eq(list.elements().iter().cloned()), "{name}, row {i}");
                        listed += list.elements().len();
                    }
                    value => assert_eq!(&cell(&batch, j, i), value, "{name}, row {i}"),
                }
                cells += 1;
                nulls += usize::from(*value == Field::Null);
            }
        }
    }
    assert!(rows.next().is_none(), "the Arrow file has fewer rows");
    (cells, nulls, listed)
}

/// Every cell of both tables, over several row groups and record batches, failed samples (null) and outer points among
/// them. Seen to fail with a schema without metadata, and with the first batch alone.
#[test]
fn arrow_files_hold_the_same_tables() {
    let mut study = SyntheticStudy::new(4200);
    for outcome in &mut study.outcomes {
        outcome.group.outer = Some((outcome.index % 3) as u32);
    }
    let folder = tempfile::tempdir().unwrap();
    study.store(folder.path());
    let [samples, curves] = ["samples", "curves"].map(|name| {
        let path = |extension: &str| folder.path().join(name).with_extension(extension);
        let (table, arrow) = (path("parquet"), path("arrow"));
        write_arrow(&table, &arrow).unwrap();
        let first = std::fs::read(&arrow).unwrap();
        write_arrow(&table, &arrow).unwrap();
        assert!(first == std::fs::read(&arrow).unwrap(), "other bytes");
        assert_same_table(&table, &arrow)
    });
    assert!(samples.1 > 0, "the study must contain failures");
    assert!(samples.2 > 0, "the study must contain lower maxima");
    assert!(samples.0 > 16_384 * 20, "the study must fill a batch");
    assert!(curves.0 > 0, "the study must contain curves");
}

/// The record of a file is of the bytes that went to it. Seen to fail with the hash of an empty file.
#[test]
fn a_record_is_of_the_bytes_as_written() {
    let study = SyntheticStudy::new(50);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.parquet");
    let (provenance, names) = (&study.record.provenance, study.input_names());
    let written = write_samples(&path, provenance, &names, &study.outcomes).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(written, FileRecord::of("samples.parquet", &bytes));
}

/// A table of an older program has no damping ratios: the other numbers are read, and these are unknown.
#[test]
fn tables_without_damping_ratios_are_read() {
    let study = SyntheticStudy::new(50);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.parquet");
    let (provenance, names) = (&study.record.provenance, study.input_names());
    write_samples(&path, provenance, &names, &study.outcomes).unwrap();
    let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(&path).unwrap()).unwrap();
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let pairs = pairs
        .unwrap()
        .iter()
        .filter(|pair| pair.key != "ARROW:schema");
    let properties = WriterProperties::builder()
        .set_key_value_metadata(Some(pairs.cloned().collect()))
        .build();
    let fields = reader.schema().fields().clone();
    let younger = ["damping_ratio", "multiplier_real", "multiplier_imaginary"];
    let kept = (0..fields.len()).filter(|&i| !younger.contains(&fields[i].name().as_str()));
    let kept: Vec<usize> = kept.collect();
    assert_eq!(kept.len() + younger.len(), fields.len(), "the columns");
    let batches = reader.build().unwrap();
    let batches: Vec<RecordBatch> = batches
        .map(|b| b.unwrap().project(&kept).unwrap())
        .collect();
    let file = File::create(&path).unwrap();
    let mut writer = ArrowWriter::try_new(file, batches[0].schema(), Some(properties)).unwrap();
    for batch in &batches {
        writer.write(batch).unwrap();
    }
    writer.close().unwrap();
    let stored = read_samples(&path).unwrap();
    for (read, written) in stored.outcomes.iter().zip(&study.outcomes) {
        for (read, written) in read.levels.iter().zip(&written.levels) {
            let without = |peak: PeakRecord| PeakRecord {
                damping_ratio: MaybeReal::NONE,
                multiplier_real: MaybeReal::NONE,
                multiplier_imaginary: MaybeReal::NONE,
                ..peak
            };
            assert_eq!(read.peak, written.peak.map(without));
        }
    }
}
