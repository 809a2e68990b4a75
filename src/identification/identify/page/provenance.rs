//! What a study reads, and what produced the numbers.

use super::view::View;
use crate::identify::found::identified::GivenPressure;
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::with_digits;
use crate::page::sheet::{fields, sheet};
use crate::sampling::Distribution;

pub(super) fn section(view: &View) -> Section {
    let found = view.found;
    let program = ("Program".to_owned(), format!("microslip {}", found.version));
    let stated = found.settings.as_ref().map(fields).unwrap_or_default();
    let stated = stated
        .into_iter()
        .map(|(key, value)| (with_unit(&key), value));
    let pressure = found.pressure_map.as_ref().map(pressure_map);
    let rows = [program].into_iter().chain(stated).chain(pressure);
    let mut blocks = vec![
        distributions(view),
        sheet("Identification", "settings", rows),
    ];
    if !found.files.is_empty() {
        blocks.push(files(view));
    }
    Section {
        id: "provenance",
        title: "For a study, and provenance".to_owned(),
        blocks,
    }
}

/// A row on the pressure map; its hash stands among those of the files.
fn pressure_map(given: &GivenPressure) -> (String, String) {
    let name = &given.file.name;
    let (cells, percent) = (given.cells, with_digits(100.0 * given.even_area, 2));
    let words =
        format!("{name}: {cells} cells, {percent} % of their area within a tenth of the mean");
    ("Pressure map".to_owned(), words)
}

/// The distributions of `identified.json`, with their correlation.
fn distributions(view: &View) -> Block {
    let found = view.found;
    let rows = found.inputs.iter().map(|input| {
        let distribution = Distribution::new(input.shape, None);
        let words = distribution.map_or_else(|fault| fault.to_string(), |d| four_digits(&d));
        (input.parameter.in_words().to_owned(), words)
    });
    let count = found.inputs.len();
    let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
    let correlations = pairs.filter_map(|(a, b)| {
        let value = *found.correlation.get(a)?.get(b)?;
        let names = [a, b].map(|k| found.inputs[k].parameter.in_words());
        Some((
            format!("correlation of {} and {}", names[0], names[1]),
            with_digits(value, 3),
        ))
    });
    sheet(
        "Distributions that a study reads from identified.json",
        "inputs",
        rows.chain(correlations),
    )
}

/// A distribution in words, with as many digits as a reader wants; `identified.json` has all.
fn four_digits(distribution: &Distribution) -> String {
    distribution.in_words(|value| with_digits(value, 4))
}

/// The name of a setting with its unit as people write it.
fn with_unit(key: &str) -> String {
    let units = [
        (" n per um", " (N/µm)"),
        (" percent", " (%)"),
        (" n", " (N)"),
    ];
    let found = units
        .into_iter()
        .find_map(|(end, unit)| Some(format!("{}{unit}", key.strip_suffix(end)?)));
    found.unwrap_or_else(|| key.to_owned())
}

fn files(view: &View) -> Block {
    let mut table = Table::of(
        "Files that were read",
        "files",
        &[("File", &["file"]), ("BLAKE3 of its content", &["blake3"])],
    );
    for file in &view.found.files {
        table.row(vec![
            Cell::text(&file.name).with_class("text brief"),
            Cell::text(&file.blake3).with_class("text wide code"),
        ]);
    }
    table.block()
}
