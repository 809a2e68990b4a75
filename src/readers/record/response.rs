//! Measured forced response, for calibration: resonance frequency and amplitude at excitation levels.

use std::io::Write;
use std::path::Path;

use super::quantity::{Quantity, written_unit as unit};
use super::read::LONGEST_FILE;
use super::table::{self, Expected};
use super::write::write_notes;
use crate::file::{self, FileError, FileRecord, replace, shortest_decimal};

/// Points of a response at most.
const MOST_POINTS: usize = 100_000;
/// Numbers of a response that can be meant, in SI units.
const MEANT: [f64; 2] = [1e-15, 1e12];

/// Measured forced response of one structure.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseRecord {
    /// Name for tables and messages: the file without its ending.
    pub name: String,
    /// One for each level and repetition, in the order of the file.
    pub points: Vec<ResponsePoint>,
    /// Line of each point in its file; empty of a record that was not read.
    pub lines: Vec<u64>,
}

/// Resonance at one excitation level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponsePoint {
    /// Excitation level: amplitude of the harmonic force (N).
    pub level_n: f64,
    /// Frequency of the largest amplitude (Hz).
    pub frequency_hz: f64,
    /// Largest amplitude of the response (m).
    pub amplitude_m: f64,
    /// Standard deviation of the measured frequency (Hz), where it is stated.
    pub frequency_deviation_hz: Option<f64>,
    /// Standard deviation of the measured amplitude (m), where it is stated.
    pub amplitude_deviation_m: Option<f64>,
}

/// Reads a table: level, resonance frequency and amplitude, and standard deviations of the latter two.
///
/// # Errors
/// [`FileError`] with the line and the rule that it breaks.
pub fn read_response(path: &Path) -> Result<ResponseRecord, FileError> {
    let text = file::text_of(path, file::read_bytes(path, LONGEST_FILE)?)?;
    let expected = Expected {
        needed: &[
            Quantity::Level,
            Quantity::ResonanceFrequency,
            Quantity::Amplitude,
        ],
        optional: &[Quantity::FrequencyDeviation, Quantity::AmplitudeDeviation],
        labels: &[],
    };
    let table = table::read(path, &text, expected)?;
    let rows = table.lines.len();
    if !(1..=MOST_POINTS).contains(&rows) {
        let rule = format!("has {rows} rows: must have 1 to {MOST_POINTS}");
        return Err(FileError::content(path, Some(table.heading), rule));
    }
    for quantity in table.numbers.keys() {
        table.require_within(path, *quantity, MEANT)?;
    }
    let at = |quantity, row: usize| table.numbers.get(&quantity).map(|numbers| numbers[row]);
    let needed = |quantity, row| at(quantity, row).unwrap_or_default();
    let points = (0..rows).map(|row| ResponsePoint {
        level_n: needed(Quantity::Level, row),
        frequency_hz: needed(Quantity::ResonanceFrequency, row),
        amplitude_m: needed(Quantity::Amplitude, row),
        frequency_deviation_hz: at(Quantity::FrequencyDeviation, row),
        amplitude_deviation_m: at(Quantity::AmplitudeDeviation, row),
    });
    let name = path.file_stem().unwrap_or_default();
    Ok(ResponseRecord {
        name: name.to_string_lossy().into_owned(),
        points: points.collect(),
        lines: table.lines,
    })
}

/// Writes the table that [`read_response`] reads. `notes` become comments at the beginning.
///
/// # Errors
/// [`FileError`] if there is no point, some points state a deviation and others not, or the file cannot be written.
pub fn write_response(
    path: &Path,
    record: &ResponseRecord,
    notes: &[&str],
) -> Result<FileRecord, FileError> {
    let fault = |rule: &str| FileError::content(path, None, rule);
    let first = record.points.first();
    let first = first.ok_or_else(|| fault("must get a point"))?;
    let is_stated = |point: &ResponsePoint| point.numbers().map(|value| value.is_some());
    let stated = is_stated(first);
    if record.points.iter().any(|point| is_stated(point) != stated) {
        return Err(fault("all points or none must state a deviation"));
    }
    let columns = Quantity::RESPONSE.into_iter().zip(stated);
    let columns: Vec<_> = columns.filter(|(_, stated)| *stated).collect();
    replace(path, |file| {
        let mut file = std::io::BufWriter::new(file);
        write_notes(&mut file, notes)?;
        let names = columns
            .iter()
            .map(|(q, _)| format!("{} [{}]", q.name(), unit(*q).0));
        writeln!(file, "{}", names.collect::<Vec<_>>().join(","))?;
        for point in &record.points {
            let numbers = Quantity::RESPONSE.into_iter().zip(point.numbers());
            let numbers =
                numbers.filter_map(|(q, value)| Some(shortest_decimal(value?, unit(q).1)));
            writeln!(file, "{}", numbers.collect::<Vec<_>>().join(","))?;
        }
        file.flush()
    })
}

impl ResponsePoint {
    /// In the order of [`Quantity::RESPONSE`].
    fn numbers(&self) -> [Option<f64>; 5] {
        [
            Some(self.level_n),
            Some(self.frequency_hz),
            Some(self.amplitude_m),
            self.frequency_deviation_hz,
            self.amplitude_deviation_m,
        ]
    }
}
