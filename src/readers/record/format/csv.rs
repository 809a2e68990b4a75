//! Tables of hysteresis tests in text.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::channels::Channels;
use super::super::quantity::{Quantity, written_unit as unit};
use super::super::signals::TestConditions;
use super::super::table::{self, Expected, Label, NumberTable};
use crate::file::{FileError, shortest_decimal};

/// What a table of hysteresis tests holds.
const EXPECTED: Expected<'static> = Expected {
    needed: &[
        Quantity::Time,
        Quantity::Displacement,
        Quantity::TangentialForce,
        Quantity::NormalForce,
    ],
    optional: &[Quantity::Approach, Quantity::Frequency, Quantity::EvenArea],
    labels: &[Label::Test, Label::Specimen],
};

/// The tests of a table: all rows, or those with one name in the column of tests.
///
/// # Errors
/// [`FileError`] with the line and the rule that it breaks.
pub(in crate::record) fn read(path: &Path, text: &str) -> Result<Vec<Channels>, FileError> {
    let mut conditions = TestConditions::default();
    for (number, line) in (1..).zip(text.lines()) {
        if let Some(comment) = line.trim_start().strip_prefix('#') {
            let taken = conditions.take_line(comment);
            taken.map_err(|rule| FileError::content(path, Some(number), rule))?;
        }
    }
    let mut table = table::read(path, text, EXPECTED)?;
    if table.lines.is_empty() {
        let rule = "must be followed by rows of numbers";
        return Err(FileError::content(path, Some(table.heading), rule));
    }
    let fault = |row: usize, rule: String| FileError::content(path, Some(table.lines[row]), rule);
    let tests = table.texts.remove(&Label::Test);
    let tests = tests.unwrap_or_else(|| vec![(0, String::new())]);
    let mut seen = BTreeMap::new();
    for (row, test) in &tests {
        if seen.insert(test, *row).is_some() {
            let rule = format!("test {test}: rows of a test must stand together");
            return Err(fault(*row, rule));
        }
    }
    let ends = tests.iter().skip(1).map(|(row, _)| *row);
    let ends = ends.chain([table.lines.len()]);
    let ranges = tests.iter().zip(ends);
    let cut = ranges.map(|((first, label), end)| {
        let mut channels = test(&table, *first..end, conditions.clone())
            .map_err(|(row, rule)| fault(row, rule))?;
        channels.label = Some(label.clone()).filter(|label| !label.is_empty());
        Ok(channels)
    });
    cut.collect()
}

/// One test: a range of rows.
///
/// # Errors
/// Row and rule.
fn test(
    table: &NumberTable,
    rows: std::ops::Range<usize>,
    mut conditions: TestConditions,
) -> Result<Channels, (usize, String)> {
    let mut signals = BTreeMap::new();
    for (quantity, numbers) in &table.numbers {
        let numbers = &numbers[rows.clone()];
        if !Quantity::CONDITIONS.contains(quantity) {
            signals.insert(*quantity, numbers.to_vec());
            continue;
        }
        if let Some(at) = numbers.iter().position(|value| *value != numbers[0]) {
            let (unit, power) = unit(*quantity);
            let [first, value] = [numbers[0], numbers[at]].map(|v| shortest_decimal(v, power));
            let name = quantity.name();
            let rule = format!("{name} = {value} {unit}: must be {first} {unit} in the whole test");
            return Err((rows.start + at, rule));
        }
        let set = conditions.set(*quantity, numbers[0]);
        set.map_err(|rule| (rows.start, rule))?;
    }
    if let Some(runs) = table.texts.get(&Label::Specimen) {
        let last = runs.partition_point(|(row, _)| *row <= rows.start);
        let (_, specimen) = &runs[last - 1];
        if let Some((row, other)) = runs.get(last).filter(|(row, _)| *row < rows.end) {
            let rule = format!("specimen {other}: must be {specimen} in the whole test");
            return Err((*row, rule));
        }
        let set = conditions.set_specimen(specimen);
        set.map_err(|rule| (rows.start, rule))?;
    }
    Ok(Channels {
        label: None,
        signals,
        conditions,
        lines: table.lines[rows].to_vec(),
    })
}
