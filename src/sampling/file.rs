//! Samples from a file: one column per input, one row per sample.

use super::Input;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Why a file gives no samples.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SampleFileError {
    /// The file cannot be opened or read.
    #[error("{}: {message}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system or the library said.
        message: String,
    },
    /// A line breaks a rule.
    #[error("{}:{line}: {message}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// 1-based line, or row of a Parquet file.
        line: u64,
        /// Column, value and rule.
        message: String,
    },
}

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
    /// [`SampleFileError`] on the first column or value that cannot be taken, with its line.
    pub fn read(path: &Path) -> Result<Self, SampleFileError> {
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
    fn csv(&self) -> Result<SampleTable, SampleFileError> {
        let text = std::fs::read_to_string(self.path)
            .map_err(|error| self.unreadable(&error.to_string()))?;
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let header = reader.headers().map_err(|error| self.csv_error(&error))?;
        let line = line_of(&text, header.position());
        let inputs = self.columns(header.iter(), line)?;
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| self.csv_error(&error))?;
            let line = line_of(&text, record.position());
            let row = record.iter().zip(&inputs).map(|(text, input)| {
                let value = text.parse().map_err(|_| {
                    self.at(
                        line,
                        format!("{} = {text:?}: must be a number", input.name()),
                    )
                })?;
                self.accepted(*input, value, line)
            });
            rows.push(row.collect::<Result<_, _>>()?);
        }
        Ok(SampleTable { inputs, rows })
    }

    fn parquet(&self) -> Result<SampleTable, SampleFileError> {
        let failed = |error: ParquetError| self.unreadable(&error.to_string());
        let file = File::open(self.path).map_err(|error| self.unreadable(&error.to_string()))?;
        let reader = SerializedFileReader::new(file).map_err(failed)?;
        let schema = reader.metadata().file_metadata().schema().get_fields();
        let inputs = self.columns(schema.iter().map(|field| field.name()), 1)?;
        let mut rows = Vec::new();
        for (line, row) in (1..).zip(reader.get_row_iter(None).map_err(failed)?) {
            let row = row.map_err(failed)?;
            let values = row
                .get_column_iter()
                .zip(&inputs)
                .map(|((_, field), input)| {
                    let value = number(field).ok_or_else(|| {
                        self.at(
                            line,
                            format!("{} = {field}: must be a number", input.name()),
                        )
                    })?;
                    self.accepted(*input, value, line)
                });
            rows.push(values.collect::<Result<_, _>>()?);
        }
        Ok(SampleTable { inputs, rows })
    }

    fn columns<'n>(
        &self,
        names: impl Iterator<Item = &'n str>,
        line: u64,
    ) -> Result<Vec<Input>, SampleFileError> {
        let mut inputs = Vec::new();
        for name in names {
            let known: Vec<_> = Input::ALL.iter().map(|input| input.name()).collect();
            let Some(input) = Input::from_name(name) else {
                let known = known.join(", ");
                return Err(self.at(
                    line,
                    format!("column {name:?}: unknown input; known are {known}"),
                ));
            };
            if inputs.contains(&input) {
                return Err(self.at(line, format!("column {name:?}: must be there once")));
            }
            inputs.push(input);
        }
        Ok(inputs)
    }

    fn accepted(&self, input: Input, value: f64, line: u64) -> Result<f64, SampleFileError> {
        match input.accepts_value(input.name(), value) {
            Ok(()) => Ok(value),
            Err(bad) => Err(self.at(line, bad.to_string())),
        }
    }

    fn csv_error(&self, error: &csv::Error) -> SampleFileError {
        match error.kind() {
            csv::ErrorKind::UnequalLengths {
                pos: Some(pos),
                expected_len,
                len,
            } => self.at(
                pos.line(),
                format!("{len} values, but the first line names {expected_len} columns"),
            ),
            _ => self.unreadable(&error.to_string()),
        }
    }

    fn unreadable(&self, message: &str) -> SampleFileError {
        SampleFileError::Unreadable {
            path: self.path.to_owned(),
            message: message.to_owned(),
        }
    }

    fn at(&self, line: u64, message: String) -> SampleFileError {
        SampleFileError::Line {
            path: self.path.to_owned(),
            line,
            message,
        }
    }
}

/// Line of a record; the library counts from where it began to look for one, before empty lines and comments.
fn line_of(text: &str, start: Option<&csv::Position>) -> u64 {
    let Some(start) = start else { return 1 };
    let byte = usize::try_from(start.byte()).unwrap_or(usize::MAX);
    let ahead = text.get(byte..).unwrap_or_default().lines();
    let skipped = ahead.take_while(|line| line.trim().is_empty() || line.starts_with('#'));
    start.line() + skipped.count() as u64
}

fn number(field: &Field) -> Option<f64> {
    match *field {
        Field::Double(value) => Some(value),
        Field::Float(value) => Some(f64::from(value)),
        Field::Int(value) => Some(f64::from(value)),
        Field::Long(value) => Some(value as f64),
        _ => None,
    }
}
