//! Files of hysteresis tests, written as tables that read back to the same bits.

use std::io::{Result as IoResult, Write};
use std::path::Path;

use super::condition::{SPECIMEN, TEST};
use super::quantity::{Quantity, written_unit as unit};
use super::signals::HysteresisRecord;
use crate::file::{FileError, FileRecord, replace, shortest_decimal};

/// A value on a grid of steps of `resolution`, as a sensor gives it: the shortest decimals of such values have few digits.
///
/// Both are in the same unit; a resolution of 0 or less changes nothing.
#[must_use]
pub fn quantised(value: f64, resolution: f64) -> f64 {
    let steps = (value / resolution).round();
    if !(resolution > 0.0 && steps.is_finite()) {
        return value;
    }
    // 3 steps of 1e-8 are 3 / 1e8: rounded once, where 3 * 1e-8 is rounded twice
    let per_unit = (1.0 / resolution).round();
    match (1.0 / resolution / per_unit - 1.0).abs() <= f64::EPSILON {
        true => steps / per_unit,
        false => steps * resolution,
    }
}

/// Writes tests as a table in s, µm and N with comments of their conditions; each number is the shortest decimal that reads back.
///
/// One test has the name of its file; several get a column with their names. Conditions that differ get columns. `notes` become
/// comments at the beginning.
///
/// # Errors
/// [`FileError`] if there is no test, the signals of a test are not equally long, some tests state what others do not, or the
/// file cannot be written.
pub fn write_hysteresis(
    path: &Path,
    tests: &[HysteresisRecord],
    notes: &[&str],
) -> Result<FileRecord, FileError> {
    let fault = |rule: &str| FileError::content(path, None, rule);
    let layout = FileLayout::of(tests).map_err(fault)?;
    replace(path, |file| {
        let mut file = std::io::BufWriter::new(file);
        write_notes(&mut file, notes)?;
        for (name, value) in &layout.comments {
            writeln!(file, "# {name} = {value}")?;
        }
        writeln!(file, "{}", layout.heading())?;
        for test in tests {
            let end: String = (layout.columns.iter())
                .map(|column| format!(",{}", quoted(&(column.value)(test).unwrap_or_default())))
                .collect();
            for at in 0..test.time.len() {
                let numbers = Quantity::SIGNALS.into_iter().filter_map(|quantity| {
                    let value = *signal(test, quantity)?.get(at)?;
                    Some(shortest_decimal(value, unit(quantity).1))
                });
                let numbers: Vec<_> = numbers.collect();
                writeln!(file, "{}{end}", numbers.join(","))?;
            }
        }
        file.flush()
    })
}

/// Notes as comments of a table.
pub(super) fn write_notes(file: &mut impl Write, notes: &[&str]) -> IoResult<()> {
    let mut lines = notes.iter().flat_map(|note| note.lines());
    lines.try_for_each(|line| writeln!(file, "# {line}"))
}

/// A text that is the same in a whole test.
struct Constant {
    name: String,
    value: fn(&HysteresisRecord) -> Option<String>,
}

/// What stands where.
struct FileLayout {
    approach: bool,
    comments: Vec<(String, String)>,
    columns: Vec<Constant>,
}

impl FileLayout {
    fn of(tests: &[HysteresisRecord]) -> Result<Self, &'static str> {
        let first = tests.first().ok_or("must get a test")?;
        let approach = first.approach.is_some();
        for test in tests {
            let lengths = Quantity::SIGNALS.map(|q| signal(test, q).map(<[f64]>::len));
            if lengths.iter().flatten().any(|n| *n != test.time.len()) {
                return Err("signals of a test must be equally long");
            }
            if test.approach.is_some() != approach {
                return Err("all tests or none must have a normal displacement");
            }
        }
        let mut layout = Self {
            approach,
            comments: Vec::new(),
            columns: Vec::new(),
        };
        if tests.len() > 1 {
            layout.columns.push(Constant {
                name: TEST[0].to_owned(),
                value: |test| Some(test.name.clone()),
            });
        }
        let [frequency, even] = Quantity::CONDITIONS;
        layout.place(
            tests,
            Constant {
                name: format!("{} [{}]", frequency.name(), unit(frequency).0),
                value: |test| Some(shortest_decimal(test.conditions.frequency_hz?, 0)),
            },
        )?;
        layout.place(
            tests,
            Constant {
                name: format!("{} [{}]", even.name(), unit(even).0),
                value: |test| {
                    let area = test.conditions.even_area?;
                    Some(shortest_decimal(area, unit(Quantity::EvenArea).1))
                },
            },
        )?;
        layout.place(
            tests,
            Constant {
                name: SPECIMEN[0].to_owned(),
                value: |test| test.conditions.specimen.clone(),
            },
        )?;
        Ok(layout)
    }

    /// A condition of all tests is a comment; one that differs is a column.
    fn place(
        &mut self,
        tests: &[HysteresisRecord],
        condition: Constant,
    ) -> Result<(), &'static str> {
        let values: Vec<_> = tests.iter().map(condition.value).collect();
        match &values[0] {
            None if values.iter().all(Option::is_none) => {}
            _ if values.iter().any(Option::is_none) => {
                return Err("all tests or none must state a condition");
            }
            Some(first) if values.iter().flatten().all(|value| value == first) => {
                (self.comments).push((condition.name, first.clone()));
            }
            _ => self.columns.push(condition),
        }
        Ok(())
    }

    fn heading(&self) -> String {
        let signals = Quantity::SIGNALS.into_iter();
        let signals = signals.filter(|quantity| self.approach || *quantity != Quantity::Approach);
        let signals = signals.map(|quantity| format!("{} [{}]", quantity.name(), unit(quantity).0));
        let columns = self.columns.iter().map(|column| column.name.clone());
        signals.chain(columns).collect::<Vec<_>>().join(",")
    }
}

fn signal(test: &HysteresisRecord, quantity: Quantity) -> Option<&[f64]> {
    match quantity {
        Quantity::Time => Some(&test.time),
        Quantity::Displacement => Some(&test.displacement),
        Quantity::TangentialForce => Some(&test.tangential_force),
        Quantity::NormalForce => Some(&test.normal_force),
        Quantity::Approach => test.approach.as_deref(),
        _ => None,
    }
}

/// A text as a field of a table.
fn quoted(text: &str) -> String {
    match text.contains([',', '"']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
