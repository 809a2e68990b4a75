//! Complex matrices from Matrix Market files; real ones as complex.

use super::matrix_market::{Collects, Entry, Given, LARGEST, MatrixShape, place, read_entries};
use crate::file::FileError;
use faer::{Mat, c64};
use std::path::Path;

/// Imaginary part of a diagonal entry of a Hermitian matrix, over the real one, that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// A complex matrix, and how exactly its file states it.
#[derive(Debug)]
pub(super) struct StatedComplex {
    pub(super) matrix: Mat<c64>,
    /// Most significant digits of a real part.
    pub(super) digits: u32,
}

/// Reads a complex, real or integer matrix: as [`super::matrix_market::read_matrix`], and complex ones may be `hermitian`.
///
/// # Errors
/// As there.
pub(super) fn read_complex(path: &Path) -> Result<StatedComplex, FileError> {
    let (dense, digits) = read_entries::<Complex>(path, LARGEST)?;
    Ok(StatedComplex {
        matrix: dense.matrix,
        digits,
    })
}

/// A dense matrix with both triangles.
struct Complex {
    shape: MatrixShape,
    matrix: Mat<c64>,
    given: Given,
}

impl Collects for Complex {
    const COMPLEX: bool = true;

    fn empty(shape: MatrixShape, coordinate: bool) -> Self {
        Self {
            shape,
            matrix: Mat::zeros(shape.rows, shape.columns),
            given: Given::none(shape, coordinate),
        }
    }

    fn add(&mut self, entry: Entry) -> Result<(), String> {
        let Entry { row, column, .. } = entry;
        self.given.add(entry)?;
        let mut value = c64::new(entry.value, entry.imaginary);
        let on_diagonal = self.shape.hermitian && row == column;
        if on_diagonal && entry.imaginary.abs() <= ROUND_OFF * entry.value.abs() {
            value.im = 0.0;
        }
        if on_diagonal && value.im != 0.0 {
            let place = place(row, column);
            return Err(format!(
                "{place} = {value}: must be real in a Hermitian matrix"
            ));
        }
        self.matrix[(row, column)] = value;
        if self.shape.symmetric && row != column {
            self.matrix[(column, row)] = match self.shape.hermitian {
                true => value.conj(),
                false => value,
            };
        }
        Ok(())
    }
}
