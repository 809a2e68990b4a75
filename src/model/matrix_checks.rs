//! Properties that the matrices of a structure must have.

use faer::{Mat, Side};

/// Largest asymmetry accepted as round-off, relative to the largest entry.
const SYMMETRY_TOLERANCE: f64 = 1e-8;
/// Most negative eigenvalue accepted as round-off, of a matrix with unit diagonal.
const SEMIDEFINITE_TOLERANCE: f64 = 1e-9;
/// Least eigenvalue that counts as positive, of a matrix with unit diagonal.
const DEFINITE_TOLERANCE: f64 = 1e-12;

/// (A + Aᵀ)/2, if A is symmetric up to round-off.
///
/// # Errors
/// The rule that A breaks.
pub(super) fn symmetric(a: &Mat<f64>) -> Result<Mat<f64>, String> {
    let n = a.nrows();
    let mut largest = 0.0_f64;
    let mut worst = (0.0_f64, 0, 0);
    for j in 0..n {
        for i in 0..n {
            largest = largest.max(a[(i, j)].abs());
            let difference = (a[(i, j)] - a[(j, i)]).abs();
            if difference > worst.0 {
                worst = (difference, i.max(j), i.min(j));
            }
        }
    }
    let (difference, i, j) = worst;
    if difference > SYMMETRY_TOLERANCE * largest {
        return Err(format!(
            "must be symmetric: entries ({0}, {1}) = {2} and ({1}, {0}) = {3} differ",
            i + 1,
            j + 1,
            a[(i, j)],
            a[(j, i)]
        ));
    }
    Ok(Mat::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] + a[(j, i)])))
}

/// # Errors
/// The rule, unless A is positive semidefinite.
pub(super) fn positive_semidefinite(a: &Mat<f64>) -> Result<(), String> {
    if has_cholesky_factor(a, SEMIDEFINITE_TOLERANCE) {
        return Ok(());
    }
    Err("must be positive semidefinite, but has a negative eigenvalue".to_owned())
}

/// # Errors
/// The rule, unless A is positive definite.
pub(super) fn positive_definite(a: &Mat<f64>) -> Result<(), String> {
    if let Some(i) = (0..a.nrows()).find(|&i| a[(i, i)] <= 0.0) {
        let value = a[(i, i)];
        return Err(format!(
            "must be positive definite, but diagonal entry {} is {value}",
            i + 1
        ));
    }
    if has_cholesky_factor(a, -DEFINITE_TOLERANCE) {
        return Ok(());
    }
    Err("must be positive definite, but has an eigenvalue that is zero or negative".to_owned())
}

/// Whether D^(−1/2) A D^(−1/2) + shift, D = |diag A|, is positive definite.
///
/// The scaling makes the answer independent of the units of the degrees of freedom.
fn has_cholesky_factor(a: &Mat<f64>, shift: f64) -> bool {
    let n = a.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| match a[(i, i)].abs() {
            0.0 => 1.0,
            d => d.sqrt(),
        })
        .collect();
    let scaled = Mat::from_fn(n, n, |i, j| {
        let on_diagonal = if i == j { shift } else { 0.0 };
        a[(i, j)] / (scale[i] * scale[j]) + on_diagonal
    });
    scaled.llt(Side::Lower).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Springs 1 and k between three masses, no support: λ = 0 is semidefinite, also with k = 1e12; a spring of −0.01
    /// to the ground is not.
    ///
    /// Seen to fail with a tolerance of 1e-3.
    #[test]
    fn definiteness_at_its_edge() {
        let chain = |k: f64, ground: f64| {
            let rows = [[1.0 + ground, -1.0, 0.0], [-1.0, 1.0 + k, -k], [0.0, -k, k]];
            Mat::from_fn(3, 3, |i, j| rows[i][j])
        };
        assert!(positive_semidefinite(&chain(1e12, 0.0)).is_ok());
        assert!(positive_semidefinite(&chain(100.0, -0.01)).is_err());
        assert!(positive_semidefinite(&Mat::zeros(2, 2)).is_ok());
        assert!(positive_definite(&Mat::identity(4, 4)).is_ok());
        let singular = Mat::from_fn(2, 2, |_, _| 1.0);
        assert!(positive_definite(&singular).is_err());
        assert!(positive_semidefinite(&singular).is_ok());
    }
}
