//! Unit and meaning of every column: in the files themselves, and the same on the page of the book.

use crate::synthetic::SyntheticStudy;
use arrow_ipc::reader::FileReader as ArrowReader;
use microslip::ensemble::arrow::write_arrow;
use microslip::ensemble::columns::{CURVE_COLUMNS, DescribedColumn, SAMPLE_COLUMNS};
use microslip::ensemble::store::FollowedMode;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::arrow::parquet_to_arrow_schema;
use parquet::file::reader::{FileReader, SerializedFileReader};
use std::fs::File;
use std::path::Path;

/// Inputs by name, unit and the first words of their description.
const INPUTS: [(&str, &str, &str); 4] = [
    ("friction_coefficient", "1", "Friction coefficient of every"),
    ("strip_thickness_mm", "mm", "Thickness of the strip"),
    (
        "pressure_mode_2",
        "1",
        "Standard normal coefficient of mode 2 ",
    ),
    (
        "blade_3_frequency_deviation",
        "1",
        "Relative deviation of the frequency of blade 3",
    ),
];

/// Tables of a study whose samples have outer points, replicates and places, with the inputs above, that of a mistuned disk among
/// them, and that follows all modes.
fn store(folder: &Path) {
    let mut study = SyntheticStudy::new(20);
    let more = study.record.inputs[0].clone();
    study.record.inputs.extend([more.clone(), more]);
    for (record, (name, _, _)) in study.record.inputs.iter_mut().zip(INPUTS) {
        record.name = name.to_owned();
    }
    assert_eq!(study.input_names().len(), INPUTS.len(), "inputs");
    study.record.provenance.followed_modes = vec![FollowedMode {
        mode: 2,
        stuck_frequency_hz: 2973.95,
    }];
    for outcome in &mut study.outcomes {
        outcome.inputs = outcome.inputs.iter().copied().chain([0.5, 0.01]).collect();
        outcome.group.outer = Some((outcome.index % 3) as u32);
        outcome.group.replicate = Some(0);
        outcome.group.place = Some(1);
    }
    study.store(folder);
}

/// Metadata of every column, in the Parquet file and in the Arrow file made from it; types and nulls are those that the
/// Parquet schema has without the Arrow schema beside it, so that no reader can find them in disagreement.
///
/// Seen to fail with the unit of `strip_thickness_mm` as 1.
#[test]
fn every_column_says_unit_and_meaning() {
    let folder = tempfile::tempdir().unwrap();
    store(folder.path());
    let tables: [(&str, &[DescribedColumn]); 2] =
        [("samples", &SAMPLE_COLUMNS), ("curves", &CURVE_COLUMNS)];
    for (table, columns) in tables {
        let path = |extension: &str| folder.path().join(table).with_extension(extension);
        let (parquet, arrow) = (path("parquet"), path("arrow"));
        write_arrow(&parquet, &arrow).unwrap();
        let file = || File::open(&parquet).unwrap();
        let plain = SerializedFileReader::new(file()).unwrap();
        let plain = plain.metadata().file_metadata().schema_descr_ptr();
        let plain = parquet_to_arrow_schema(&plain, None).unwrap();
        let of_parquet = ParquetRecordBatchReaderBuilder::try_new(file()).unwrap();
        let of_arrow = ArrowReader::try_new(File::open(&arrow).unwrap(), None).unwrap();
        for found in [of_parquet.schema(), &of_arrow.schema()] {
            let mut described = 0;
            for (field, plain) in found.fields().iter().zip(plain.fields()) {
                let bare = field
                    .as_ref()
                    .clone()
                    .with_metadata(plain.metadata().clone());
                assert_eq!(&bare, plain.as_ref(), "{table}");
                let says = |key: &str| field.metadata().get(key).map(|text| text.to_string());
                let (unit, description) = (says("unit"), says("description").unwrap());
                let column = columns.iter().find(|c| c.name == field.name());
                let input = INPUTS.iter().find(|(name, _, _)| name == field.name());
                let expected = match (column, input) {
                    (Some(column), _) => {
                        assert_eq!(description, column.description);
                        column.unit
                    }
                    (None, Some((_, unit, words))) => {
                        assert!(description.starts_with(words), "{description}");
                        unit
                    }
                    (None, None) => panic!("{table}: {} is not described", field.name()),
                };
                assert_eq!(unit.unwrap_or_default(), expected, "{}", field.name());
                described += 1;
            }
            let inputs = if table == "samples" { INPUTS.len() } else { 0 };
            assert_eq!(described, columns.len() + inputs, "{table}");
        }
    }
}

/// The Arrow schema alone has all pairs of the file, too: pyarrow shows no others once a file has such a schema.
///
/// Seen to fail with an Arrow schema without pairs.
#[test]
fn pairs_of_the_file_stand_in_its_arrow_schema() {
    let folder = tempfile::tempdir().unwrap();
    store(folder.path());
    for table in ["samples.parquet", "curves.parquet"] {
        let reader = SerializedFileReader::new(File::open(folder.path().join(table)).unwrap());
        let reader = reader.unwrap();
        let file = reader.metadata().file_metadata();
        let pairs = file.key_value_metadata().unwrap().clone();
        let (arrow, pairs): (Vec<_>, Vec<_>) = pairs
            .into_iter()
            .partition(|pair| pair.key == "ARROW:schema");
        let found = parquet_to_arrow_schema(file.schema_descr(), Some(&arrow)).unwrap();
        assert!(pairs.len() > 10, "{pairs:?}");
        for pair in pairs {
            assert_eq!(
                found.metadata().get(pair.key.as_str()),
                pair.value.as_ref(),
                "{}",
                pair.key
            );
        }
    }
}

/// The same samples give the same bytes. Seen to fail with the time of day in the description of the columns.
#[test]
fn tables_are_the_same_bytes_again() {
    let [first, second] = [(); 2].map(|()| {
        let folder = tempfile::tempdir().unwrap();
        store(folder.path());
        ["samples.parquet", "curves.parquet"]
            .map(|name| std::fs::read(folder.path().join(name)).unwrap())
    });
    assert!(first == second, "other bytes");
}

/// Rows of the first table below a heading, without links in brackets.
fn rows(page: &str, heading: &str) -> Vec<[String; 3]> {
    let (_, section) = page.split_once(&format!("\n## {heading}\n")).unwrap();
    let lines = section
        .lines()
        .skip_while(|line| !line.starts_with("| ---"));
    let lines = lines.skip(1).take_while(|line| line.starts_with('|'));
    let cells = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, name, unit, meaning, _] = cells.as_slice() else {
            panic!("{heading}: {line}");
        };
        let meaning = meaning.split(" ([").next().unwrap_or_default();
        [name.trim_matches('`'), unit, meaning].map(str::to_owned)
    };
    lines.map(cells).collect()
}

/// The book says of every column what the files say of it. Seen to fail with a unit changed on the page, and with a column
/// taken out of it.
#[test]
fn the_page_of_the_outputs_has_the_same_columns() {
    let page = std::fs::read_to_string("docs/src/outputs.md").unwrap();
    let of_table = |columns: &[DescribedColumn]| -> Vec<[String; 3]> {
        let cells = |c: &DescribedColumn| [c.name, c.unit, c.description].map(str::to_owned);
        columns.iter().map(cells).collect()
    };
    let mut samples = rows(&page, "samples.parquet");
    samples.retain(|[name, ..]| name != "name of an input");
    assert_eq!(samples, of_table(&SAMPLE_COLUMNS));
    assert_eq!(rows(&page, "curves.parquet"), of_table(&CURVE_COLUMNS));
}
