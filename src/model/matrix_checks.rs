//! Properties that the matrices of a structure must have.

use faer::{Mat, Side};

/// Largest asymmetry accepted as round-off, relative to the largest entry.
const SYMMETRY_TOLERANCE: f64 = 1e-8;
/// Most negative eigenvalue accepted as round-off, and least that counts as positive, of a matrix with unit diagonal.
const SEMIDEFINITE_TOLERANCE: f64 = 1e-9;
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
    let least = least_scaled_eigenvalue(a);
    if least >= -SEMIDEFINITE_TOLERANCE {
        return Ok(());
    }
    Err(format!(
        "must be positive semidefinite, but has a negative eigenvalue ({least:.2e} after scaling the diagonal to 1)"
    ))
}

/// # Errors
/// The rule, unless A is positive definite.
pub(super) fn positive_definite(a: &Mat<f64>) -> Result<(), String> {
    let without = (0..a.nrows()).find(|&i| a[(i, i)] <= 0.0);
    if let Some(i) = without {
        let value = a[(i, i)];
        return Err(format!(
            "must be positive definite, but diagonal entry {} is {value}",
            i + 1
        ));
    }
    let least = least_scaled_eigenvalue(a);
    if least > DEFINITE_TOLERANCE {
        return Ok(());
    }
    Err(format!(
        "must be positive definite, but its least eigenvalue is {least:.2e} after scaling the diagonal to 1"
    ))
}

/// Least eigenvalue of D^(−1/2) A D^(−1/2), D = |diag A|: the same whatever units the degrees of freedom have.
fn least_scaled_eigenvalue(a: &Mat<f64>) -> f64 {
    let n = a.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| match a[(i, i)].abs() {
            0.0 => 1.0,
            d => d.sqrt(),
        })
        .collect();
    let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] / (scale[i] * scale[j]));
    scaled
        .self_adjoint_eigenvalues(Side::Lower)
        .ok()
        .and_then(|values| values.first().copied())
        .unwrap_or(f64::NEG_INFINITY)
}
