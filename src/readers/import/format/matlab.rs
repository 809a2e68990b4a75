//! MATLAB: variables of a `.mat` file that are matrices or vectors of a model.

use std::path::Path;

use super::super::lines::MOST_ROWS;
use super::super::matrix::{Content, DOUBLE_DIGITS, ImportedMatrix, Rows, SINGLE_DIGITS};
use super::arrays::{self, Numbers};
use crate::file::FileError;
use crate::file::matlab::{self, Values, Variable};

/// Reads all variables that are square matrices or vectors of real numbers.
///
/// # Errors
/// [`FileError`] if the file is damaged, or a variable with a name such as K is none of these.
pub(in crate::import) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<ImportedMatrix>, FileError> {
    let fault = |rule: String| FileError::content(path, None, rule);
    let mut found = Vec::new();
    for variable in matlab::read(bytes).map_err(fault)? {
        let name = variable.name.clone();
        found.extend(arrays::of_model(&name, content(path, variable))?);
    }
    match found.is_empty() {
        true => Err(fault("has no square matrix and no vector".to_owned())),
        false => Ok(found),
    }
}

/// A square matrix or a vector of real numbers.
fn content(path: &Path, variable: Variable) -> Result<ImportedMatrix, FileError> {
    let Variable {
        name,
        shape,
        values,
    } = variable;
    let fault = |rule: String| FileError::content(path, None, rule);
    let sizes: Vec<_> = shape.iter().map(usize::to_string).collect();
    let sizes = sizes.join(" x ");
    let neither = || {
        fault(format!(
            "is {sizes}: must be square or a vector, of 1 to {MOST_ROWS} rows"
        ))
    };
    let no_numbers = |what: &str| fault(format!("is {what}: must be real numbers"));
    match values {
        Values::Other(what) => Err(no_numbers(what)),
        Values::Text(_) | Values::Structure(_) => Err(no_numbers("no array of numbers")),
        Values::Dense { numbers, single } => {
            let digits = if single { SINGLE_DIGITS } else { DOUBLE_DIGITS };
            let numbers = Numbers {
                values: numbers,
                digits,
            };
            let found = arrays::dense(path, name, &shape, true, numbers)?;
            found.ok_or_else(neither)
        }
        Values::Sparse {
            rows,
            columns,
            numbers,
        } => {
            let numbers = Numbers {
                values: numbers,
                digits: DOUBLE_DIGITS,
            };
            match shape[..] {
                [n, 1] if (2..=MOST_ROWS).contains(&n) => Ok(ImportedMatrix {
                    name,
                    path: path.to_owned(),
                    rows: Rows::Numbered(n),
                    digits: numbers.digits,
                    content: Content::Column(filled(n, &rows, &numbers.values).map_err(fault)?),
                }),
                [n, m] if n == m && (1..=MOST_ROWS).contains(&n) => {
                    let places = rows.into_iter().zip(columns);
                    arrays::sparse(path, name, n, places, numbers)
                }
                _ => Err(neither()),
            }
        }
    }
}

/// The column of `n` rows with these entries.
fn filled(n: usize, rows: &[usize], values: &[f64]) -> Result<Vec<f64>, String> {
    let mut column = vec![0.0; n];
    for (&row, value) in rows.iter().zip(values) {
        let place = column.get_mut(row).filter(|_| value.is_finite());
        let rule = || format!("entry {row} = {value}: must be finite and inside {n} rows");
        *place.ok_or_else(rule)? = *value;
    }
    Ok(column)
}
