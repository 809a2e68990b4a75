//! A few linear equations.

/// Gaussian elimination for a symmetric positive definite matrix; none where the equations do not determine the unknowns.
pub(super) fn solve<const N: usize>(mut m: [[f64; N]; N], mut v: [f64; N]) -> Option<[f64; N]> {
    let size = (0..N).map(|i| m[i][i]).fold(0.0, f64::max);
    for k in 0..N {
        let pivot = m[k];
        if pivot[k] <= SINGULAR * size {
            return None;
        }
        for i in k + 1..N {
            let factor = m[i][k] / pivot[k];
            for j in k..N {
                m[i][j] -= factor * pivot[j];
            }
            v[i] -= factor * v[k];
        }
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| m[k][j] * v[j]).sum();
        v[k] = (v[k] - known) / m[k][k];
    }
    Some(v)
}

/// Pivot over the largest diagonal entry at which rounding is all that is left.
const SINGULAR: f64 = 1e-13;
