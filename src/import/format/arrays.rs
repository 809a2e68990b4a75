//! Arrays of programs that compute with matrices: dense or sparse numbers become a symmetric matrix or a vector.

use std::path::Path;

use super::super::lines::MOST_ROWS;
use super::super::matrix::{Content, Entries, ImportedMatrix, Rows, Storage};
use crate::file::FileError;
use crate::model::matrix_market::LARGEST;

/// Numbers of an array at most.
pub(super) const MOST_NUMBERS: usize = LARGEST * LARGEST;

/// How the bytes of a number are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Of 4 or 8 bytes.
    Float,
    Signed,
    Unsigned,
}

/// The number that one to eight `bytes` are.
pub(super) fn number(bytes: &[u8], kind: Kind, big_endian: bool) -> f64 {
    let width = bytes.len();
    let mut bits = [0; 8];
    bits[..width].copy_from_slice(bytes);
    if big_endian {
        bits[..width].reverse();
    }
    let raw = u64::from_le_bytes(bits);
    match kind {
        Kind::Float if width == 4 => f64::from(f32::from_bits(raw as u32)),
        Kind::Float => f64::from_bits(raw),
        Kind::Signed => {
            // the sign moves to the first bit and back
            let free = 64 - 8 * width;
            ((raw << free) as i64 >> free) as f64
        }
        Kind::Unsigned => raw as f64,
    }
}

/// Numbers, and how exactly the file states them.
#[derive(Debug)]
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    pub(super) digits: u32,
}

/// What a dense array of this shape is: a square matrix or a vector; nothing for others. With `by_columns` its first index runs
/// fastest.
///
/// # Errors
/// [`FileError`] if a number is not finite, or the matrix is not symmetric.
pub(super) fn dense(
    path: &Path,
    name: String,
    shape: &[usize],
    by_columns: bool,
    Numbers { values, digits }: Numbers,
) -> Result<Option<ImportedMatrix>, FileError> {
    let shown = if name.is_empty() {
        String::new()
    } else {
        format!("array {name:.40}: ")
    };
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        let value = values[at];
        let rule = format!(
            "{shown}number {} = {value}: must be a finite number",
            at + 1
        );
        return Err(FileError::content(path, None, rule));
    }
    let (rows, content) = match *shape {
        [n] | [n, 1] | [1, n] if n > 1 => (n, Content::Column(values)),
        [n, columns] if n == columns && (1..=LARGEST).contains(&n) => {
            let mut entries = Entries::default();
            for (at, value) in values.into_iter().enumerate().filter(|(_, v)| *v != 0.0) {
                let (row, column) = match by_columns {
                    true => (at % n, at / n),
                    false => (at / n, at % n),
                };
                entries.add(row, column, value, 0);
            }
            (
                n,
                Content::Symmetric(entries.symmetric(path, n, Storage::Full)?),
            )
        }
        _ => return Ok(None),
    };
    if rows > MOST_ROWS {
        return Ok(None);
    }
    Ok(Some(ImportedMatrix {
        name,
        path: path.to_owned(),
        rows: Rows::Numbered(rows),
        content,
        digits,
    }))
}

/// A square matrix of `n` rows by the places of its entries.
///
/// # Errors
/// [`FileError`] if an entry is outside, not finite or given twice, or the matrix is not symmetric.
pub(super) fn sparse(
    path: &Path,
    name: String,
    n: usize,
    places: impl Iterator<Item = (usize, usize)>,
    Numbers { values, digits }: Numbers,
) -> Result<ImportedMatrix, FileError> {
    let mut entries = Entries::default();
    for ((row, column), value) in places.zip(values) {
        if row >= n || column >= n || !value.is_finite() {
            let rule =
                format!("entry ({row}, {column}) = {value}: must be finite and inside {n} rows");
            return Err(FileError::content(path, None, rule));
        }
        entries.add(row, column, value, 0);
    }
    Ok(ImportedMatrix {
        name,
        path: path.to_owned(),
        rows: Rows::Numbered(n),
        content: Content::Symmetric(entries.symmetric(path, n, Storage::Unknown)?),
        digits,
    })
}

/// The row of each of `entries` entries, from where each of `n` rows begins. `what` is the name of the list.
///
/// # Errors
/// The rule if it does not ascend.
pub(super) fn expanded(
    what: &str,
    pointers: &[usize],
    n: usize,
    entries: usize,
) -> Result<Vec<usize>, String> {
    let ordered = pointers.len() == n + 1
        && pointers.first() == Some(&0)
        && pointers.last() == Some(&entries)
        && pointers.windows(2).all(|two| two[0] <= two[1]);
    if !ordered {
        return Err(format!(
            "{what}: must ascend from 0 to {entries} in {} numbers",
            n + 1
        ));
    }
    let rows = pointers.windows(2).enumerate();
    let rows = rows.flat_map(|(row, two)| std::iter::repeat_n(row, two[1] - two[0]));
    Ok(rows.collect())
}
