//! The page on files of measurements says what is read.

use microslip::record::quantity::Quantity;
use microslip::record::{TestConditions, read_pressure_map, read_response};

use crate::contact::contact;
use crate::csv::written;

const PAGE: &str = "docs/src/measurements.md";

/// The examples between fences.
fn examples() -> Vec<String> {
    let text = std::fs::read_to_string(PAGE).unwrap();
    let parts = text.split("```\n").skip(1).step_by(2);
    parts.map(str::to_owned).collect()
}

/// Seen to fail with a name taken out of the page.
#[test]
fn all_names_and_units_are_on_the_page() {
    let text = std::fs::read_to_string(PAGE).unwrap();
    let signals = (Quantity::SIGNALS.into_iter()).chain(Quantity::CONDITIONS);
    for quantity in signals {
        for name in quantity.names() {
            assert!(text.contains(&format!("`{name}`")), "{PAGE} lacks {name}");
        }
    }
    let tables = (Quantity::RESPONSE.into_iter()).chain([Quantity::Pressure, Quantity::Area]);
    for quantity in tables {
        let row = text.lines().filter(|line| line.starts_with('|'));
        let mut row = row.filter(|line| line.contains(&format!("| {}", quantity.name())));
        let row = row.next().unwrap();
        for name in &quantity.names()[1..] {
            assert!(row.contains(&format!("`{name}`")), "{PAGE} lacks {name}");
        }
        let units = quantity.dimension().in_words();
        let (_, units) = units.split_once(": ").unwrap();
        assert!(row.contains(units), "{row} lacks {units}");
    }
}

/// Seen to fail with another number in an example.
#[test]
fn examples_of_the_page_are_files() {
    let mut test = contact("rig");
    test.conditions = TestConditions {
        frequency_hz: Some(100.0),
        specimen: Some("A".to_owned()),
        ..TestConditions::default()
    };
    let text = written(&[test]);
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let examples = examples();
    assert_eq!(lines(&examples[0])[..], lines(&text)[1..7]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.csv");
    std::fs::write(&path, &examples[1]).unwrap();
    assert_eq!(read_pressure_map(&path).unwrap().cells.len(), 4);
    let path = folder.path().join("blade.csv");
    std::fs::write(&path, &examples[2]).unwrap();
    assert_eq!(read_response(&path).unwrap().points.len(), 3);
}
