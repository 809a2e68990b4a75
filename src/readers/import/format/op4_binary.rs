//! OUTPUT4 as Fortran's unformatted records, in either byte order, with whole numbers of 32 or 64 bits.

use std::path::Path;

use super::super::matrix::{DOUBLE_DIGITS, ImportedMatrix, SINGLE_DIGITS};
use super::op4::{Growing, MOST_MATRICES, MatrixHeader};
use crate::file::FileError;

/// Bytes of the first record: four whole numbers and a name, of 32 and of 64 bits.
const HEADER_BYTES: [usize; 2] = [24, 48];

/// How the bytes are to be read.
#[derive(Debug, Clone, Copy)]
struct WordLayout {
    big_endian: bool,
    /// Bytes of a word.
    word: usize,
}

impl WordLayout {
    /// By the length of the first record.
    fn of(bytes: &[u8]) -> Option<Self> {
        let marker: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
        let lengths = [
            (false, u32::from_le_bytes(marker)),
            (true, u32::from_be_bytes(marker)),
        ];
        lengths.into_iter().find_map(|(big_endian, length)| {
            let at = HEADER_BYTES.iter().position(|h| *h == length as usize)?;
            let word = 4 * (at + 1);
            Some(Self { big_endian, word })
        })
    }

    /// The whole number of the bytes: four or eight.
    fn whole(self, bytes: &[u8]) -> i64 {
        let mut bits = [0; 8];
        let n = bytes.len().min(8);
        bits[..n].copy_from_slice(&bytes[..n]);
        if self.big_endian {
            bits[..n].reverse();
        }
        match n {
            4 => i64::from(i32::from_le_bytes([bits[0], bits[1], bits[2], bits[3]])),
            _ => i64::from_le_bytes(bits),
        }
    }

    fn real(self, bytes: &[u8]) -> f64 {
        match (bytes.len(), self.whole(bytes)) {
            (4, bits) => f64::from(f32::from_bits(bits as u32)),
            (_, bits) => f64::from_bits(bits as u64),
        }
    }
}

/// Whether the bytes begin as such a file.
pub(in crate::import) fn begins(bytes: &[u8]) -> bool {
    WordLayout::of(bytes).is_some()
}

/// Reads all matrices.
pub(in crate::import) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<ImportedMatrix>, FileError> {
    let fault = |rule: String| FileError::content(path, None, rule);
    let layout = WordLayout::of(bytes).ok_or_else(|| fault("is no OUTPUT4 file".to_owned()))?;
    let mut records = Records {
        layout,
        bytes,
        number: 0,
    };
    let mut found = Vec::new();
    for count in 0.. {
        let Some(record) = records.next().map_err(fault)? else {
            break;
        };
        if count == MOST_MATRICES {
            return Err(fault(format!("has more than {MOST_MATRICES} matrices")));
        }
        let header = header(layout, record);
        let header = header.map_err(|rule| fault(format!("record {}: {rule}", records.number)))?;
        let growing = Growing::new(path, header);
        found.extend(matrix(&mut records, growing, &fault)?);
    }
    Ok(found)
}

fn header(layout: WordLayout, record: &[u8]) -> Result<MatrixHeader, String> {
    let word = layout.word;
    if record.len() != 6 * word {
        return Err("must be the header of a matrix".to_owned());
    }
    let sizes = [0, 1, 2, 3].map(|at| layout.whole(&record[at * word..(at + 1) * word]));
    MatrixHeader::new(sizes, &String::from_utf8_lossy(&record[4 * word..]))
}

/// Columns until the one behind the last.
fn matrix(
    records: &mut Records<'_>,
    mut growing: Growing,
    fault: &impl Fn(String) -> FileError,
) -> Result<Option<ImportedMatrix>, FileError> {
    loop {
        let record = records.next().map_err(fault)?;
        let name = growing.header.name.clone();
        let record = record.ok_or_else(|| {
            fault(format!(
                "matrix {name}: the file ends before its last column"
            ))
        })?;
        let number = records.number;
        let column = BinaryColumn::new(records.layout, record).map_err(fault)?;
        let at = |rule| fault(format!("record {number}: {rule}"));
        if !growing.begin(column.number).map_err(at)? {
            return growing.finish();
        }
        column.whole().map_err(at)?;
        match column.row {
            0 => column.strings(&mut growing).map_err(at)?,
            row => column.string(&mut growing, row, column.words).map_err(at)?,
        }
    }
}

/// Records between their lengths.
struct Records<'b> {
    layout: WordLayout,
    bytes: &'b [u8],
    /// 1-based number of the record that was given last.
    number: usize,
}

impl<'b> Records<'b> {
    /// The next record; nothing at the end.
    fn next(&mut self) -> Result<Option<&'b [u8]>, String> {
        if self.bytes.is_empty() {
            return Ok(None);
        }
        self.number += 1;
        let rule = || {
            format!(
                "record {}: its two lengths must agree and fit the file",
                self.number
            )
        };
        let marker = self.bytes.get(..4).ok_or_else(rule)?;
        let length = usize::try_from(self.layout.whole(marker)).map_err(|_| rule())?;
        let end = length.checked_add(4).ok_or_else(rule)?;
        let record = self.bytes.get(4..end).ok_or_else(rule)?;
        let after = end
            .checked_add(4)
            .and_then(|after| self.bytes.get(end..after));
        if after != Some(marker) {
            return Err(rule());
        }
        self.bytes = &self.bytes[end + 4..];
        Ok(Some(record))
    }
}

/// A column: its number, first row (0: in strings), number of words, words.
struct BinaryColumn<'b> {
    layout: WordLayout,
    number: i64,
    row: i64,
    stated: i64,
    words: &'b [u8],
}

impl<'b> BinaryColumn<'b> {
    fn new(layout: WordLayout, record: &'b [u8]) -> Result<Self, String> {
        let word = layout.word;
        if record.len() < 3 * word {
            return Err("a column must have its number, first row and words".to_owned());
        }
        let [number, row, stated] =
            [0, 1, 2].map(|at| layout.whole(&record[at * word..(at + 1) * word]));
        Ok(Self {
            layout,
            number,
            row,
            stated,
            words: &record[3 * word..],
        })
    }

    /// Requires that the record has the words that it states. The one behind the last column may hold more.
    fn whole(&self) -> Result<(), String> {
        let (word, length) = (self.layout.word, self.words.len());
        let fits = usize::try_from(self.stated).ok() == Some(length / word);
        match fits && length.is_multiple_of(word) {
            true => Ok(()),
            false => Err(format!(
                "column {}: states {} words, but its record has {}",
                self.number,
                self.stated,
                length / word
            )),
        }
    }

    /// Strings, each with its length and first row before it.
    fn strings(&self, growing: &mut Growing) -> Result<(), String> {
        let word = self.layout.word;
        let mut rest = self.words;
        while !rest.is_empty() {
            let whole = |at: usize| {
                rest.get(at * word..(at + 1) * word)
                    .map(|b| self.layout.whole(b))
            };
            let stated = match growing.header.big {
                true => whole(0)
                    .zip(whole(1))
                    .map(|(length, row)| (length.saturating_sub(1), row, 2)),
                false => whole(0).map(|packed| {
                    let length = (packed >> 16).saturating_sub(1);
                    (length, packed - ((length + 1) << 16), 1)
                }),
            };
            let (length, row, own) = stated.ok_or("ends within a string")?;
            let end = usize::try_from(length).ok().filter(|length| *length > 0);
            let end = end.and_then(|length| (length + own).checked_mul(word));
            let numbers = end.and_then(|end| rest.get(own * word..end));
            let numbers = numbers.ok_or_else(|| {
                format!("string of {length} words from row {row} on: does not fit its column")
            })?;
            self.string(growing, row, numbers)?;
            rest = &rest[own * word + numbers.len()..];
        }
        Ok(())
    }

    /// Numbers from `row` on.
    fn string(&self, growing: &mut Growing, row: i64, numbers: &[u8]) -> Result<(), String> {
        let double = growing.header.double;
        let bytes = if double { 8 } else { self.layout.word };
        if !numbers.len().is_multiple_of(bytes) {
            return Err(format!(
                "string from row {row} on: must hold whole numbers of {bytes} bytes"
            ));
        }
        growing.string(row, (numbers.len() / bytes) as i64)?;
        let digits = if bytes == 8 {
            DOUBLE_DIGITS
        } else {
            SINGLE_DIGITS
        };
        for (at, number) in (0..).zip(numbers.chunks_exact(bytes)) {
            let value = self.layout.real(number);
            growing.take(row, at / growing.header.parts, value, (digits, 0))?;
        }
        Ok(())
    }
}
