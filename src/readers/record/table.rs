//! Tables of measurements in text: which column holds what, and its numbers in SI units.
//!
//! The first line names the columns with their units. Comma, semicolon or tab separate; beside the latter two a decimal comma is
//! read. Decimal point and decimal comma in one file are refused, since one of them may divide thousands.

use std::collections::BTreeMap;
use std::path::Path;

use super::channels::{MOST_NUMBERS, MOST_TESTS};
use super::condition::{SPECIMEN, TEST, is_one_of, label};
use super::quantity::{Quantity, Unit, name_and_unit, written_unit};
use crate::file::delimited::is_passed_over;
use crate::file::{FileError, Row, Rows, scaled_number, shortest_decimal};

/// Columns at most.
const MOST_COLUMNS: usize = 1000;
/// Characters of a number that a message shows without an exponent.
const LONGEST_PLAIN: usize = 10;

/// A column of texts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Label {
    Test,
    Specimen,
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Number(Quantity, Unit),
    Text(Label),
    /// Its name begins with `_`.
    PassedOver,
}

/// What a file may hold.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected<'e> {
    pub(super) needed: &'e [Quantity],
    pub(super) optional: &'e [Quantity],
    pub(super) labels: &'e [Label],
}

/// The numbers of a table.
#[derive(Debug, Default)]
pub(super) struct NumberTable {
    /// Line of the names of the columns.
    pub(super) heading: u64,
    /// 1-based line of each row.
    pub(super) lines: Vec<u64>,
    /// A number in SI units for each row.
    pub(super) numbers: BTreeMap<Quantity, Vec<f64>>,
    /// From which row on a column has which text.
    pub(super) texts: BTreeMap<Label, Vec<(usize, String)>>,
}

/// The mark between a number and its decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    Point,
    Comma,
}

/// Reads rows of numbers.
struct RowReader<'t> {
    path: &'t Path,
    columns: Vec<Column>,
    separator: char,
    /// The mark that was seen first.
    mark: Option<Mark>,
    table: NumberTable,
}

impl NumberTable {
    /// Refuses the first number of a column outside of a range in SI units. The message is in the unit in which files are written.
    pub(super) fn require_within(
        &self,
        path: &Path,
        quantity: Quantity,
        [least, most]: [f64; 2],
    ) -> Result<(), FileError> {
        let numbers = self.numbers.get(&quantity).map_or(&[][..], Vec::as_slice);
        let outside = |value: &f64| !(least..=most).contains(value);
        let Some(row) = numbers.iter().position(outside) else {
            return Ok(());
        };
        let (name, (unit, power)) = (quantity.name(), written_unit(quantity));
        let [found, least, most] = [numbers[row], least, most].map(|value| shown(value, power));
        let rule = format!("{name} = {found} {unit}: must be from {least} to {most} {unit}");
        Err(FileError::content(path, Some(self.lines[row]), rule))
    }
}

/// A number over ten to a power, with an exponent where it is long.
fn shown(value: f64, power: i32) -> String {
    let plain = shortest_decimal(value, power);
    match plain.parse::<f64>() {
        Ok(number) if plain.len() > LONGEST_PLAIN => format!("{number:e}"),
        _ => plain,
    }
}

/// Reads a table of `text`.
///
/// # Errors
/// [`FileError`] with the line and the rule that it breaks.
pub(super) fn read(
    path: &Path,
    text: &str,
    expected: Expected<'_>,
) -> Result<NumberTable, FileError> {
    let separator = separator(text);
    let mut rows = Rows::new(path, text, separator);
    let Some(heading) = rows.next().transpose()? else {
        return Err(FileError::content(path, None, "is empty"));
    };
    let fault = |rule: String| FileError::content(path, Some(heading.line), rule);
    let columns = columns(&heading, expected).map_err(fault)?;
    let mut table = NumberTable {
        heading: heading.line,
        ..NumberTable::default()
    };
    for column in &columns {
        match *column {
            Column::Number(quantity, _) => drop(table.numbers.insert(quantity, Vec::new())),
            Column::Text(label) => drop(table.texts.insert(label, Vec::new())),
            Column::PassedOver => {}
        }
    }
    let mut reader = RowReader {
        path,
        columns,
        separator,
        mark: None,
        table,
    };
    for row in rows {
        reader.take(&row?)?;
    }
    Ok(reader.table)
}

/// What separates the names of the columns.
fn separator(text: &str) -> char {
    let heading = text.lines();
    let heading = heading.into_iter().find(|line| !is_passed_over(line));
    let heading = heading.unwrap_or_default();
    let found = [';', '\t'].into_iter().find(|c| heading.contains(*c));
    found.unwrap_or(',')
}

fn columns(heading: &Row<'_>, expected: Expected<'_>) -> Result<Vec<Column>, String> {
    let mut columns: Vec<Column> = Vec::new();
    if heading.fields.len() > MOST_COLUMNS {
        return Err(format!("has more than {MOST_COLUMNS} columns"));
    }
    for text in &heading.fields {
        let column = Column::named(text, expected)?;
        if columns.iter().any(|other| other.is_same(column)) {
            return Err(format!("column {text:.40}: must be given once"));
        }
        columns.push(column);
    }
    let has = |needed: &Quantity| {
        let same = |column: &Column| matches!(column, Column::Number(own, _) if own == needed);
        columns.iter().any(same)
    };
    match expected.needed.iter().find(|needed| !has(needed)) {
        None => Ok(columns),
        Some(missing) => {
            let (name, unit) = (missing.name(), missing.dimension().si());
            Err(format!("must have a column {name} [{unit}]"))
        }
    }
}

impl Column {
    fn named(text: &str, expected: Expected<'_>) -> Result<Self, String> {
        if text.starts_with('_') {
            return Ok(Self::PassedOver);
        }
        let (name, unit) = name_and_unit(text);
        for label in expected.labels {
            if is_one_of(name, label.names()) {
                return Ok(Self::Text(*label));
            }
        }
        let known = [expected.needed, expected.optional].concat();
        let Some(quantity) = Quantity::named(name, &known) else {
            let known = known.iter().map(|quantity| quantity.name());
            let known = known.chain(expected.labels.iter().map(|label| label.names()[0]));
            let known: Vec<_> = known.collect();
            return Err(format!(
                "column {text:.40}: the first line without # must name columns among {}; begin its name with _ to pass over it",
                known.join(", ")
            ));
        };
        Ok(Self::Number(quantity, quantity.unit(unit)?))
    }

    /// Whether both hold the same.
    fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::Number(a, _), Self::Number(b, _)) => a == b,
            (Self::Text(a), Self::Text(b)) => a == b,
            _ => false,
        }
    }
}

impl Label {
    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Test => &TEST,
            Self::Specimen => &SPECIMEN,
        }
    }
}

impl RowReader<'_> {
    fn take(&mut self, row: &Row<'_>) -> Result<(), FileError> {
        let path = self.path;
        let fault = |rule: String| FileError::content(path, Some(row.line), rule);
        let rows = self.table.lines.len();
        if (rows + 1) * self.table.numbers.len() > MOST_NUMBERS {
            return Err(fault(format!("has more than {MOST_NUMBERS} numbers")));
        }
        for at in 0..self.columns.len() {
            let text = row.fields[at].as_ref();
            match self.columns[at] {
                Column::PassedOver => {}
                Column::Number(quantity, unit) => {
                    let name = quantity.name();
                    let value = self.number(text, unit);
                    let value = value.map_err(|rule| fault(format!("{name} = {rule}")))?;
                    self.table.numbers.entry(quantity).or_default().push(value);
                }
                Column::Text(label) => self.take_text(label, text).map_err(fault)?,
            }
        }
        self.table.lines.push(row.line);
        Ok(())
    }

    fn take_text(&mut self, column: Label, text: &str) -> Result<(), String> {
        let rows = self.table.lines.len();
        let runs = self.table.texts.entry(column).or_default();
        if runs.last().is_some_and(|(_, last)| last == text) {
            return Ok(());
        }
        if runs.len() == MOST_TESTS {
            return Err(format!(
                "{}: must have at most {MOST_TESTS} names",
                column.names()[0]
            ));
        }
        runs.push((rows, label(column.names()[0], text)?));
        Ok(())
    }

    /// A number with a decimal point, or, where the comma separates nothing, with a decimal comma.
    fn number(&mut self, text: &str, unit: Unit) -> Result<f64, String> {
        if text.is_empty() {
            return Err("(empty): must be a number".to_owned());
        }
        let mark = match (text.contains(','), text.contains('.')) {
            (false, false) => None,
            (false, true) => Some(Mark::Point),
            (true, false) if self.separator != ',' => Some(Mark::Comma),
            (true, _) => {
                return Err(format!(
                    "{text:.40}: must be a number without marks of thousands"
                ));
            }
        };
        if mark.is_some() && self.mark.is_some() && mark != self.mark {
            return Err(format!(
                "{text:.40}: decimal point and decimal comma must not both be used in a file"
            ));
        }
        self.mark = self.mark.or(mark);
        match mark {
            Some(Mark::Comma) => scaled_number(&text.replacen(',', ".", 1), unit.power),
            _ => scaled_number(text, unit.power),
        }
    }
}
