//! Writes Matrix Market files.

use std::io::{BufWriter, Write};
use std::path::Path;

use super::matrix_checks::rounding;
use crate::file::{self, FileError};

/// Digits that a binary number of double precision has.
pub const DOUBLE_DIGITS: u32 = 17;

/// Writes a symmetric matrix of `n` rows by `entries` (row, column, value) of its lower triangle, indices from 0.
///
/// Numbers get the digits that their file had, so that nobody takes them for more exact; with [`DOUBLE_DIGITS`] as many as
/// tell them from every other number.
///
/// # Errors
/// [`FileError`] if the operating system refuses.
pub fn write_symmetric(
    path: &Path,
    n: usize,
    entries: &[(usize, usize, f64)],
    digits: u32,
) -> Result<(), FileError> {
    let written = file::replace(path, |out| {
        let mut out = BufWriter::new(out);
        writeln!(out, "%%MatrixMarket matrix coordinate real symmetric")?;
        writeln!(out, "{n} {n} {}", entries.len())?;
        for (row, column, value) in entries {
            let value = rounded(*value, digits);
            writeln!(out, "{} {} {value}", row + 1, column + 1)?;
        }
        out.flush()
    });
    written.map(|_| ())
}

/// Writes a vector; `digits` as in [`write_symmetric`].
///
/// # Errors
/// [`FileError`] if the operating system refuses.
pub fn write_column(path: &Path, values: &[f64], digits: u32) -> Result<(), FileError> {
    let written = file::replace(path, |out| {
        let mut out = BufWriter::new(out);
        writeln!(out, "%%MatrixMarket matrix array real general")?;
        writeln!(out, "{} 1", values.len())?;
        for value in values {
            writeln!(out, "{}", rounded(*value, digits))?;
        }
        out.flush()
    });
    written.map(|_| ())
}

fn rounded(value: f64, digits: u32) -> String {
    match digits {
        digits if rounding(digits) > 0.0 && digits < DOUBLE_DIGITS => {
            format!("{value:.*e}", digits as usize - 1)
        }
        _ => format!("{value:e}"),
    }
}
