//! Samples from a file: one column per input, one row per sample.

use super::Input;
use crate::file::{Fault, FileError, Rows, read_parquet, read_text};
use parquet::file::reader::FileReader;
use parquet::record::Field;
use std::path::Path;

/// Values of some inputs, one row per sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleTable {
    /// Inputs of the columns.
    pub inputs: Vec<Input>,
    /// Shape: rows × inputs.
    pub rows: Vec<Vec<f64>>,
}

impl SampleTable {
    /// Reads `path`: `.csv` with a line of names first (`#` starts a comment), or `.parquet`.
    ///
    /// Names are those of [`Input::name`], values as in the tables of a study: a column with a unit has it in its name.
    ///
    /// # Errors
    /// [`FileError`] on the first column or value that cannot be taken, with its line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let reader = Reader { path };
        let table = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => reader.csv()?,
            Some("parquet") => reader.parquet()?,
            _ => return Err(reader.unreadable("the name must end in .csv or .parquet")),
        };
        if table.rows.is_empty() {
            return Err(reader.at(1, "must have a row of values".to_owned()));
        }
        Ok(table)
    }
}

struct Reader<'p> {
    path: &'p Path,
}

impl Reader<'_> {
    fn csv(&self) -> Result<SampleTable, FileError> {
        let text = read_text(self.path)?;
        let mut table = Rows::new(self.path, &text, ',');
        let Some(heading) = table.next().transpose()? else {
            return Err(self.unreadable("is empty"));
        };
        let names = heading.fields.iter().map(AsRef::as_ref);
        let inputs = columns(names).map_err(|rule| self.at(heading.line, rule))?;
        let mut rows = Vec::new();
        let mut last = heading.line;
        for row in table {
            let row = row?;
            let values = row.fields.iter().zip(&inputs).map(|(text, input)| {
                let value = text
                    .parse()
                    .map_err(|_| not_a_number(*input, &format!("{text:?}")));
                value.and_then(|value| accepted(*input, value))
            });
            let values: Result<_, _> = values.collect();
            rows.push(values.map_err(|rule| self.at(row.line, rule))?);
            last = row.line;
        }
        // of one column an empty line may be a missing value
        let between = heading.line + 1..last;
        let is_empty =
            |(line, text): &(u64, &str)| between.contains(line) && text.trim().is_empty();
        if let (1, Some((line, _))) = (inputs.len(), (1..).zip(text.lines()).find(is_empty)) {
            let rule = "must have no empty line between values".to_owned();
            return Err(self.at(line, rule));
        }
        Ok(SampleTable { inputs, rows })
    }

    fn parquet(&self) -> Result<SampleTable, FileError> {
        read_parquet(self.path, |reader| {
            let schema = reader.metadata().file_metadata().schema().get_fields();
            let inputs = columns(schema.iter().map(|field| field.name())).map_err(Fault::new)?;
            let mut rows = Vec::new();
            for (line, row) in (1..).zip(reader.get_row_iter(None)?) {
                let row = row?;
                let values = row
                    .get_column_iter()
                    .zip(&inputs)
                    .map(|((_, field), input)| {
                        let value = number(field).ok_or_else(|| not_a_number(*input, field));
                        value.and_then(|value| accepted(*input, value))
                    });
                let values: Result<_, _> = values.collect();
                rows.push(values.map_err(|rule| Fault::at(line, rule))?);
            }
            Ok(SampleTable { inputs, rows })
        })
    }

    fn unreadable(&self, message: &str) -> FileError {
        FileError::content(self.path, None, message)
    }

    fn at(&self, line: u64, message: String) -> FileError {
        FileError::content(self.path, Some(line), message)
    }
}

/// The inputs that the columns name.
fn columns<'n>(names: impl Iterator<Item = &'n str>) -> Result<Vec<Input>, String> {
    let mut inputs = Vec::new();
    for name in names {
        let Some(input) = Input::from_name(name) else {
            let known = Input::ALL.map(Input::name).join(", ");
            return Err(format!("column {name:?}: unknown input; known are {known}"));
        };
        if inputs.contains(&input) {
            return Err(format!("column {name:?}: must be there once"));
        }
        inputs.push(input);
    }
    Ok(inputs)
}

fn accepted(input: Input, value: f64) -> Result<f64, String> {
    let valid = input.accepts_value(input.name(), value);
    valid.map(|()| value).map_err(|bad| bad.to_string())
}

fn not_a_number(input: Input, written: &dyn std::fmt::Display) -> String {
    format!("{} = {written}: must be a number", input.name())
}

fn number(field: &Field) -> Option<f64> {
    match field {
        Field::Double(value) => Some(*value),
        // the other numbers as they are written
        Field::Byte(_)
        | Field::Short(_)
        | Field::Int(_)
        | Field::Long(_)
        | Field::UByte(_)
        | Field::UShort(_)
        | Field::UInt(_)
        | Field::ULong(_)
        | Field::Decimal(_) => field.to_string().parse().ok(),
        Field::Float16(value) => Some(f64::from(*value)),
        Field::Float(value) => Some(f64::from(*value)),
        _ => None,
    }
}
