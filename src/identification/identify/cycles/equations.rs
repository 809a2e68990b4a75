//! A few linear equations.

/// Gaussian elimination for a symmetric positive definite matrix; none where the equations do not determine the unknowns.
fn solve<const N: usize>(mut m: [[f64; N]; N], mut v: [f64; N]) -> Option<[f64; N]> {
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

/// What least squares find.
pub(super) struct LeastSquares<const N: usize> {
    pub(super) coefficients: [f64; N],
    /// Sum of the squares that the fit holds, and of all values.
    pub(super) held: f64,
    pub(super) square: f64,
}

/// Least squares over rows and their values. Nothing is held where the rows do not determine the coefficients, which are 0 then.
pub(super) fn least_squares<const N: usize>(
    points: impl Iterator<Item = ([f64; N], f64)>,
) -> LeastSquares<N> {
    let (mut m, mut v, mut square) = ([[0.0; N]; N], [0.0; N], 0.0);
    for (row, value) in points {
        for i in 0..N {
            for j in 0..N {
                m[i][j] += row[i] * row[j];
            }
            v[i] += row[i] * value;
        }
        square += value * value;
    }
    let coefficients = solve(m, v).unwrap_or([0.0; N]);
    LeastSquares {
        held: coefficients.iter().zip(v).map(|(a, b)| a * b).sum(),
        coefficients,
        square,
    }
}

/// Pivot over the largest diagonal entry at which rounding is all that is left.
const SINGULAR: f64 = 1e-13;
