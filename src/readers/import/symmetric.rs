//! A symmetric matrix by its lower triangle, as sparse as its file.

use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

use crate::model::lower_triangle::lower;
use crate::model::matrix_checks::semidefinite;

/// Share by which rounding may make an entry larger than its diagonal entries allow.
const ALLOWED: f64 = 1e-5;

/// A symmetric matrix by the entries of its lower triangle, column by column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Symmetric {
    /// Number of rows.
    pub n: usize,
    /// Row, column, value; row ≥ column.
    pub lower: Vec<(usize, usize, f64)>,
}

impl Symmetric {
    /// Of both triangles of a dense matrix; zeros are left out.
    #[must_use]
    pub fn of_dense(dense: &Mat<f64>) -> Self {
        Self {
            n: dense.nrows(),
            lower: lower(dense).collect(),
        }
    }

    /// The same with row i at `places[i]` of `n` rows.
    pub(super) fn placed(&self, places: &[usize], n: usize) -> Self {
        let mut lower: Vec<_> = (self.lower.iter())
            .map(|&(row, column, value)| {
                let (a, b) = (places[row], places[column]);
                (a.max(b), a.min(b), value)
            })
            .collect();
        lower.sort_by_key(|&(row, column, _)| (column, row));
        Self { n, lower }
    }

    /// Both triangles.
    #[must_use]
    pub fn to_dense(&self) -> Mat<f64> {
        let mut dense = Mat::zeros(self.n, self.n);
        for &(row, column, value) in &self.lower {
            dense[(row, column)] = value;
            dense[(column, row)] = value;
        }
        dense
    }

    /// Both triangles.
    pub(super) fn to_sparse(&self) -> SparseColMat<usize, f64> {
        let both = |&(row, column, value): &(usize, usize, f64)| {
            let mirrored = (row != column).then_some(Triplet::new(column, row, value));
            std::iter::once(Triplet::new(row, column, value)).chain(mirrored)
        };
        sparse(self.n, self.lower.iter().flat_map(both).collect())
    }

    /// Shape: `[n]`.
    pub(super) fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.n];
        for &(row, _, value) in self.lower.iter().filter(|(row, column, _)| row == column) {
            diagonal[row] = value;
        }
        diagonal
    }

    /// # Errors
    /// The rule, unless no entry is larger than its diagonal entries allow: what every positive semidefinite matrix obeys.
    pub(super) fn allowed_by_diagonal(&self) -> Result<(), String> {
        let diagonal = self.diagonal();
        let too_large = |&&(row, column, value): &&(usize, usize, f64)| {
            let (a, b) = (diagonal[row], diagonal[column]);
            a < 0.0 || value.abs() > (1.0 + ALLOWED) * (a * b).max(0.0).sqrt()
        };
        match self.lower.iter().find(too_large) {
            None => Ok(()),
            Some((row, column, value)) => Err(format!(
                "must be positive semidefinite, but entry ({}, {}) = {value} is not possible beside the diagonal entries {} and {}",
                row + 1,
                column + 1,
                diagonal[*row],
                diagonal[*column]
            )),
        }
    }

    /// # Errors
    /// The rule, unless it is positive semidefinite up to round-off and to the rounding of its numbers to so many `digits`.
    pub(super) fn positive_semidefinite(&self, digits: u32) -> Result<(), String> {
        let scale: Vec<f64> = (self.diagonal().iter())
            .map(|d| if *d == 0.0 { 1.0 } else { d.abs().sqrt() })
            .collect();
        let mut sums = vec![0.0; self.n];
        let scaled: Vec<_> = (self.lower.iter())
            .map(|&(row, column, value)| {
                let value = value / (scale[row] * scale[column]);
                sums[row] += value.abs();
                if row != column {
                    sums[column] += value.abs();
                }
                Triplet::new(row, column, value)
            })
            .collect();
        let definite_with = |shift: f64| {
            let shifts = (0..self.n).map(|i| Triplet::new(i, i, shift));
            let shifted = sparse(self.n, scaled.iter().copied().chain(shifts).collect());
            shifted.sp_cholesky(Side::Lower).is_ok()
        };
        semidefinite(definite_with, sums.into_iter().fold(0.0, f64::max), digits)
    }
}

/// The sum of entries.
fn sparse(n: usize, entries: Vec<Triplet<usize, usize, f64>>) -> SparseColMat<usize, f64> {
    SparseColMat::try_new_from_triplets(n, n, &entries)
        .unwrap_or_else(|_| unreachable!("indices are below n"))
}
