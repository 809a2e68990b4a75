//! Samples from CSV and Parquet files.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its design fails"
)]

use arrow_array::{
    ArrayRef, Decimal128Array, Float32Array, Int8Array, Int16Array, RecordBatch, UInt32Array,
    UInt64Array,
};
use microslip::sampling::{DesignSettings, DesignTable, Input, SampleTable};
use parquet::arrow::ArrowWriter;
use parquet::data_type::DoubleType;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::path::Path;
use std::sync::Arc;

fn csv(text: &str) -> Result<SampleTable, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("measured.csv");
    std::fs::write(&path, text).unwrap();
    SampleTable::read(&path).map_err(|error| error.to_string())
}

/// Seen to fail with the rows read in the order of the inputs instead of the columns.
#[test]
fn a_csv_file_gives_its_rows() {
    let text = "# rig 2\nfriction_coefficient, stiffness_scale\n0.3, 1.5\n0.31, 2e-1\n";
    let table = csv(text).unwrap();
    assert_eq!(
        table.inputs,
        [Input::FrictionCoefficient, Input::StiffnessScale]
    );
    assert_eq!(table.rows, [[0.3, 1.5], [0.31, 0.2]]);
    let settings = DesignSettings {
        design: toml::from_str::<DesignTable>("kind = \"file\"\npath = \"x.csv\"").unwrap(),
        file: Some(table),
        ..DesignSettings::default()
    };
    let design = settings.build().unwrap();
    assert_eq!(design.samples(), 2);
    assert_eq!(design.sample(0), [1.5, 0.3]);
    assert_eq!(design.sample(1), [0.2, 0.31]);
}

#[test]
fn bad_csv_files_name_line_and_column() {
    let head = "stiffness_scale,friction_coefficient\n";
    let cases = [
        ("".to_owned(), ": is empty"),
        (head.to_owned(), ":1: must have a row"),
        (format!("{head}1,0.3\n1\n"), ":3: has 1 fields: must have 2"),
        (
            format!("{head}1,0.3\n\n1,x\n"),
            ":4: friction_coefficient = \"x\": must be a number",
        ),
        (
            format!("{head}0,0.3\n"),
            ":2: stiffness_scale = 0: must be > 0",
        ),
        (
            format!("{head}1,-0.3\n"),
            ":2: friction_coefficient = -0.3: must be >= 0",
        ),
        (format!("{head}1,NaN\n"), ":2: friction_coefficient = NaN"),
        (
            "mu\n1\n".to_owned(),
            ":1: column \"mu\": unknown input; known are stiffness_scale",
        ),
        (
            "stiffness_scale,stiffness_scale\n1,1\n".to_owned(),
            ":1: column \"stiffness_scale\": must be there once",
        ),
    ];
    for (text, expected) in cases {
        let error = csv(&text).unwrap_err();
        assert!(
            error.contains(expected) && error.contains("measured.csv"),
            "{text:?}: {error}"
        );
    }
}

fn write(path: &Path, schema: &str, columns: &[&[f64]]) {
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let file = std::fs::File::create(path).unwrap();
    let properties = Arc::new(WriterProperties::default());
    let mut writer = SerializedFileWriter::new(file, schema, properties).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for values in columns {
        let mut column = group.next_column().unwrap().unwrap();
        column
            .typed::<DoubleType>()
            .write_batch(values, None, None)
            .unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

#[test]
fn a_parquet_file_gives_its_rows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("measured.parquet");
    let schema =
        "message m { REQUIRED DOUBLE friction_coefficient; REQUIRED DOUBLE static_load_scale; }";
    write(&path, schema, &[&[0.3, 0.4], &[1.0, 0.9]]);
    let table = SampleTable::read(&path).unwrap();
    assert_eq!(
        table.inputs,
        [Input::FrictionCoefficient, Input::StaticLoadScale]
    );
    assert_eq!(table.rows, [[0.3, 1.0], [0.4, 0.9]]);
    write(&path, schema, &[&[0.3, -0.4], &[1.0, 0.9]]);
    let error = SampleTable::read(&path).unwrap_err().to_string();
    assert!(
        error.contains("measured.parquet:2: friction_coefficient = -0.4"),
        "{error}"
    );
}

/// Columns of every type of number. Seen to fail before: "friction_coefficient = 1: must be a number" for small and for unsigned whole
/// numbers and for decimals.
#[test]
fn every_type_of_number_is_read() {
    let decimals = Decimal128Array::from(vec![150, 75])
        .with_precision_and_scale(10, 2)
        .unwrap();
    let columns: [(ArrayRef, [f64; 2]); 6] = [
        (Arc::new(Int8Array::from(vec![1, 2])), [1.0, 2.0]),
        (Arc::new(Int16Array::from(vec![1, 2])), [1.0, 2.0]),
        (Arc::new(UInt32Array::from(vec![1, 2])), [1.0, 2.0]),
        (Arc::new(UInt64Array::from(vec![1, 2])), [1.0, 2.0]),
        (Arc::new(Float32Array::from(vec![0.5, 2.0])), [0.5, 2.0]),
        (Arc::new(decimals), [1.5, 0.75]),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("numbers.parquet");
    for (column, expected) in columns {
        let kind = column.data_type().clone();
        let batch = RecordBatch::try_from_iter([("stiffness_scale", column)]).unwrap();
        let file = std::fs::File::create(&path).unwrap();
        let mut writer = ArrowWriter::try_new(file, batch.schema(), None).unwrap();
        writer.write(&batch).unwrap();
        writer.close().unwrap();
        let table = SampleTable::read(&path).unwrap();
        assert_eq!(table.rows, [[expected[0]], [expected[1]]], "{kind}");
    }
}

/// A Parquet file with any byte of its footer changed is read or refused with its name, never a panic.
///
/// The library alone (60.1) panics on some damaged footers: `report` on a `samples.parquet` with one byte changed was seen to.
#[test]
fn a_damaged_parquet_file_is_a_message() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("measured.parquet");
    let schema =
        "message m { REQUIRED DOUBLE friction_coefficient; REQUIRED DOUBLE static_load_scale; }";
    write(&path, schema, &[&[0.3, 0.4], &[1.0, 0.9]]);
    let whole = std::fs::read(&path).unwrap();
    let mut refused = 0;
    for at in 4..whole.len() {
        for change in [0x01, 0x02, 0x10, 0x40, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= change;
            std::fs::write(&path, &bytes).unwrap();
            if let Err(error) = SampleTable::read(&path) {
                let error = error.to_string();
                assert!(error.contains("measured.parquet"), "byte {at}: {error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 100, "{refused} of {} bytes", whole.len());
}
