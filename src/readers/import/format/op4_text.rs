//! OUTPUT4 as text: dense columns, or sparse ones in strings (BIGMAT or not).

use std::path::Path;

use super::super::lines::{Lines, number, whole};
use super::super::matrix::ImportedMatrix;
use super::op4::{Growing, MOST_MATRICES, MatrixHeader};
use crate::file::{FileError, significant_digits};

/// Width of a whole number.
const WHOLE: usize = 8;
/// Numbers of a line, and their width, where the header states no format.
const USUAL_FORMAT: [usize; 2] = [5, 16];
/// Numbers of a line, and their width, at most.
const LARGEST_FORMAT: [i64; 2] = [1_000, 64];

/// Reads all matrices.
pub(in crate::import) fn read(path: &Path, text: &str) -> Result<Vec<ImportedMatrix>, FileError> {
    let mut lines = Lines::new(path, text);
    let mut found = Vec::new();
    let mut count = 0;
    while let Some(line) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        count += 1;
        if count > MOST_MATRICES {
            return Err(lines.fault(format!("has more than {MOST_MATRICES} matrices")));
        }
        let stated = header(line).map_err(|rule| lines.fault(rule))?;
        let (header, format) = stated;
        let mut numbers = TextNumbers {
            lines: &mut lines,
            format,
        };
        found.extend(numbers.matrix(path, header)?);
    }
    Ok(found)
}

/// Whether a line is the header of a matrix.
pub(in crate::import) fn is_header(line: &str) -> bool {
    header(line).is_ok()
}

/// `4I8, A8`, and the format of the numbers, such as `1P,3E23.16`.
fn header(line: &str) -> Result<(MatrixHeader, [usize; 2]), String> {
    let rule = "must be a header: columns, rows, form, type, name";
    if !line.is_ascii() || line.len() <= 4 * WHOLE {
        return Err(rule.to_owned());
    }
    let mut sizes = [0; 4];
    for (at, size) in sizes.iter_mut().enumerate() {
        let word = line[at * WHOLE..(at + 1) * WHOLE].trim();
        *size = word.parse().map_err(|_| rule.to_owned())?;
    }
    let rest = &line[4 * WHOLE..];
    let (name, format) = rest.split_at(WHOLE.min(rest.len()));
    Ok((MatrixHeader::new(sizes, name)?, number_format(format)?))
}

/// Numbers of a line, and their width.
fn number_format(text: &str) -> Result<[usize; 2], String> {
    let upper = text.trim().to_ascii_uppercase();
    if upper.is_empty() {
        return Ok(USUAL_FORMAT);
    }
    let rule = || format!("format {text:.40}: must be such as 1P,3E23.16");
    let inner = upper.trim_start_matches("1P").trim_start_matches(',');
    let (count, width) = inner.split_once(['E', 'D']).ok_or_else(rule)?;
    let width = width.split('.').next().unwrap_or_default();
    let [most, widest] = LARGEST_FORMAT;
    let count = whole("", count, 1, most).map_err(|_| rule())?;
    let width = whole("", width, 1, widest).map_err(|_| rule())?;
    Ok([count as usize, width as usize])
}

/// The lines of a matrix, and how numbers stand in them.
struct TextNumbers<'l, 't> {
    lines: &'l mut Lines<'t>,
    format: [usize; 2],
}

impl TextNumbers<'_, '_> {
    fn matrix(
        &mut self,
        path: &Path,
        header: MatrixHeader,
    ) -> Result<Option<ImportedMatrix>, FileError> {
        let mut growing = Growing::new(path, header);
        loop {
            let [column, row, words] = self.whole_numbers("a column")?;
            let inside = growing.begin(column);
            if !inside.map_err(|rule| self.lines.fault(rule))? {
                self.lines.need("the number after the last column")?;
                return growing.finish();
            }
            if words < 1 {
                return Err(self
                    .lines
                    .fault(format!("column {column}: {words} words: must be 1 or more")));
            }
            match row {
                0 => self.strings(&mut growing, words)?,
                row => self.string(&mut growing, row, words)?,
            }
        }
    }

    /// The strings of a sparse column.
    fn strings(&mut self, growing: &mut Growing, mut words: i64) -> Result<(), FileError> {
        let words_of_number = if growing.header.double { 2 } else { 1 };
        while words > 0 {
            let (length, row, own) = if growing.header.big {
                let [length, row] = self.whole_numbers("a string")?;
                (length - 1, row, 2)
            } else {
                let [packed] = self.whole_numbers("a string")?;
                let length = (packed >> 16) - 1;
                (length, packed - ((length + 1) << 16), 1)
            };
            words -= length.saturating_add(own);
            if length < 1 || length % words_of_number != 0 || words < 0 {
                let rule = format!(
                    "string of {length} words from row {row} on: does not fit the words of its column"
                );
                return Err(self.lines.fault(rule));
            }
            self.string(growing, row, length / words_of_number)?;
        }
        Ok(())
    }

    /// `count` numbers from `row` on.
    fn string(&mut self, growing: &mut Growing, row: i64, count: i64) -> Result<(), FileError> {
        let checked = growing.string(row, count);
        checked.map_err(|rule| self.lines.fault(rule))?;
        let [per_line, width] = self.format;
        let (mut line, mut left) = ("", 0);
        for at in 0..count {
            if left == 0 {
                (line, left) = (self.lines.need("numbers")?, per_line);
            }
            let end = width.min(line.len());
            let split = line.split_at_checked(end);
            let (word, rest) =
                split.ok_or_else(|| self.lines.fault("must be plain text (ASCII)"))?;
            (line, left) = (rest, left - 1);
            let word = word.trim();
            let value = number(word).map_err(|rule| self.lines.fault(rule))?;
            let place = (significant_digits(word), self.lines.number);
            let taken = growing.take(row, at / growing.header.parts, value, place);
            taken.map_err(|rule| self.lines.fault(rule))?;
        }
        match line.trim() {
            "" => Ok(()),
            _ => Err(self
                .lines
                .fault(format!("has more than the {count} numbers of its string"))),
        }
    }

    /// Whole numbers of a line: of eight characters each, or one alone.
    fn whole_numbers<const N: usize>(&mut self, what: &str) -> Result<[i64; N], FileError> {
        let line = self.lines.need(what)?;
        let mut numbers = [0; N];
        for (at, number) in numbers.iter_mut().enumerate() {
            let end = if N == 1 { line.len() } else { (at + 1) * WHOLE };
            let word = line.get(at * WHOLE..end.min(line.len()));
            let parsed = word.and_then(|word| word.trim().parse::<i32>().ok());
            let rule = || {
                self.lines
                    .fault(format!("must be {what}: {N} whole numbers"))
            };
            *number = i64::from(parsed.ok_or_else(rule)?);
        }
        Ok(numbers)
    }
}
