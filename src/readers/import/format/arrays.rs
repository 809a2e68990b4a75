//! Arrays of programs that compute with matrices: dense or sparse numbers become a symmetric matrix or a vector.

use std::path::Path;

use super::super::lines::MOST_ROWS;
use super::super::matrix::{Content, Entries, ImportedMatrix, Rows, Storage};
use super::super::role::Role;
use crate::file::FileError;
use crate::model::matrix_market::LARGEST;

/// Numbers of an array at most.
pub(super) const MOST_NUMBERS: usize = LARGEST * LARGEST;

/// Numbers, and how exactly the file states them.
#[derive(Debug)]
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    pub(super) digits: u32,
}

/// What an array of this name is to a model. With the name of a matrix or a force, or without a name, it must be one; others are
/// passed over if they are none, or a number alone.
///
/// # Errors
/// [`FileError`] with the name of the array.
pub(super) fn of_model(
    name: &str,
    found: Result<ImportedMatrix, FileError>,
) -> Result<Option<ImportedMatrix>, FileError> {
    let meant = name.is_empty() || Role::of_array(name).is_some();
    match found {
        Ok(matrix) if !meant && matrix.rows.count() == 1 => Ok(None),
        Err(_) if !meant => Ok(None),
        Err(FileError::Content { path, line, rule }) if !name.is_empty() => {
            let rule = format!("array {name:.40}: {rule}");
            Err(FileError::Content { path, line, rule })
        }
        found => found.map(Some),
    }
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
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        let value = values[at];
        let rule = format!("number {} = {value}: must be a finite number", at + 1);
        return Err(FileError::content(path, None, rule));
    }
    let (rows, content) = match *shape {
        [1] => (1, Content::Column(values)),
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
