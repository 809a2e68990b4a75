//! Dense generalised symmetric eigenvalue problem, accurate at the low end of a wide spectrum.

use super::LinalgError;
use faer::{Mat, MatRef, Side};
use nalgebra::DMatrix;

/// Eigenvalues closer than this (relative) form a cluster: any orthonormal basis of it serves.
const CLUSTER: f64 = 1e-5;

/// All eigenpairs of K φ = λ M φ: λ ascending and Φ with Φᵀ M Φ = I.
///
/// K is positive semidefinite (rigid-body modes allowed), M positive definite. With M = L Lᵀ the routine diagonalises
/// L⁻¹ K L⁻ᵀ, which leaves the lowest modes with a relative error of round-off times the spread of λ (many decades for
/// finite elements); one step of refinement on K and M themselves gives them their digits back.
///
/// Shape: K, M, Φ n × n, λ `[n]`. Source: Golub & Van Loan 2013, §8.7.2.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`] if M has no Cholesky factor.
pub fn symmetric_generalized_eigen(
    stiffness: MatRef<'_, f64>,
    mass: MatRef<'_, f64>,
) -> Result<(Vec<f64>, Mat<f64>), LinalgError> {
    let n = stiffness.nrows();
    assert!(
        stiffness.ncols() == n && mass.nrows() == n && mass.ncols() == n,
        "K and M must be square and of equal size"
    );
    if n == 0 {
        return Ok((Vec::new(), Mat::zeros(0, 0)));
    }
    let factor = mass
        .llt(Side::Lower)
        .map_err(|_| LinalgError::NotPositiveDefinite { matrix: "mass" })?;
    let lower = factor.L();
    let mut standard = stiffness.to_owned();
    lower.solve_lower_triangular_in_place(&mut standard);
    let mut standard = standard.transpose().to_owned();
    lower.solve_lower_triangular_in_place(&mut standard);
    // nalgebra's QR iteration: the divide-and-conquer of faer 0.24.4 leaves residuals of 1e-3 |A| where two identical
    // components give double eigenvalues
    let eigen = DMatrix::from_fn(n, n, |i, j| standard[(i, j)])
        .try_symmetric_eigen(f64::EPSILON, 100 * n)
        .ok_or(LinalgError::EigenNotConverged { residual: f64::INFINITY })?;
    let mut phi = Mat::from_fn(n, n, |i, j| eigen.eigenvectors[(i, j)]);
    lower.transpose().solve_upper_triangular_in_place(&mut phi);
    Ok(refined(stiffness, mass, &phi))
}

/// One step of iterative refinement of all pairs, in ascending order of λ.
///
/// With K̂ = ΦᵀKΦ and M̂ = ΦᵀMΦ, φⱼ ← φⱼ + Σᵢ cᵢⱼ φᵢ, cᵢⱼ = (λⱼ M̂ᵢⱼ − K̂ᵢⱼ)/(λᵢ − λⱼ), cⱼⱼ = (1 − M̂ⱼⱼ)/2; within
/// a cluster only the mass is orthogonalised. λ is the Rayleigh quotient.
/// Source: Ogita & Aishima, Japan J. Indust. Appl. Math. 35 (2018) 1007, carried over to the pencil.
fn refined(
    stiffness: MatRef<'_, f64>,
    mass: MatRef<'_, f64>,
    phi: &Mat<f64>,
) -> (Vec<f64>, Mat<f64>) {
    let n = phi.ncols();
    let k = phi.transpose() * stiffness * phi;
    let m = phi.transpose() * mass * phi;
    let quotient: Vec<f64> = (0..n).map(|i| k[(i, i)] / m[(i, i)]).collect();
    // smaller quotients are round-off of the largest one: rigid-body modes, a cluster of their own
    let floor = n as f64 * f64::EPSILON * quotient.iter().fold(0.0, |a: f64, l| a.max(*l));
    let correction = Mat::from_fn(n, n, |i, j| {
        let (a, b) = (quotient[i], quotient[j]);
        if i == j {
            0.5 * (1.0 - m[(i, i)])
        } else if (a - b).abs() <= CLUSTER * a.abs().max(b.abs()) + floor {
            -0.5 * m[(i, j)]
        } else {
            (b * m[(i, j)] - k[(i, j)]) / (a - b)
        }
    });
    let corrected = phi + phi * correction;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| quotient[a].total_cmp(&quotient[b]));
    let lambda = order.iter().map(|&j| quotient[j]).collect();
    (lambda, Mat::from_fn(n, n, |i, j| corrected[(i, order[j])]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Graded pencil K = T Λ Tᵀ, M = T Tᵀ with T = I + ½ superdiagonal: two rigid-body modes, then 1e7 … 1e14.
    /// Seen to fail: without the refinement the lowest λ were off by up to 5e-10.
    #[test]
    fn low_eigenvalues_keep_relative_accuracy_over_seven_decades() {
        let n = 60;
        let exact: Vec<f64> = (0..n)
            .map(|i| match i {
                0 | 1 => 0.0,
                _ => 10f64.powf(7.0 + 7.0 * (i - 2) as f64 / (n - 3) as f64),
            })
            .collect();
        let t = Mat::from_fn(n, n, |i, j| match j.wrapping_sub(i) {
            0 => 1.0,
            1 => 0.5,
            _ => 0.0,
        });
        let scaled = Mat::from_fn(n, n, |i, j| t[(i, j)] * exact[j]);
        let k = scaled * t.transpose();
        let m = &t * t.transpose();
        let (lambda, phi) = symmetric_generalized_eigen(k.as_ref(), m.as_ref()).expect("definite");
        for (got, want) in lambda.iter().zip(&exact) {
            let error = (got - want) / want.max(1e7);
            assert!(error.abs() < 1e-12, "{want:.3e}: {error:.1e}");
        }
        let gram = phi.transpose() * &m * &phi - Mat::<f64>::identity(n, n);
        assert!(
            gram.norm_max() < 1e-8,
            "orthonormality {:.1e}",
            gram.norm_max()
        );
    }

    #[test]
    fn indefinite_mass_is_an_error() {
        let k = Mat::<f64>::identity(2, 2);
        let m = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 - 2.0 * i as f64 } else { 0.0 });
        assert!(
            symmetric_generalized_eigen(k.as_ref(), m.as_ref()).is_err(),
            "no real modes"
        );
    }
}
