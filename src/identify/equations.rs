//! Three linear equations.

/// Cramer's rule; none where the equations do not determine the unknowns.
pub(super) fn solve(m: [[f64; 3]; 3], v: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |m: [[f64; 3]; 3]| {
        let minor = |a: usize, b: usize| m[1][a] * m[2][b] - m[1][b] * m[2][a];
        m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
    };
    let whole = determinant(m);
    let column = |k: usize| {
        let mut replaced = m;
        for i in 0..3 {
            replaced[i][k] = v[i];
        }
        determinant(replaced) / whole
    };
    (whole > 0.0).then(|| [column(0), column(1), column(2)])
}
