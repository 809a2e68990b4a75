//! Restart-free generalised minimal residual method with right preconditioning.
//!
//! Source: Saad, Iterative Methods for Sparse Linear Systems, 2nd ed. 2003, algorithms 6.9 and 9.5.

/// Partial sums of an inner product.
const LANES: usize = 8;

/// What a GMRES run gives.
#[derive(Debug, Clone)]
pub struct GmresResult {
    /// Approximate solution.
    pub solution: Vec<f64>,
    /// Matrix–vector products spent.
    pub iterations: usize,
    /// ‖b − A x‖₂ / ‖b‖₂ as the recursion has it.
    pub relative_residual: f64,
}

/// Stop rules.
#[derive(Debug, Clone, Copy)]
pub struct GmresSettings {
    /// Relative residual to reach.
    pub tolerance: f64,
    /// Krylov vectors at the most.
    pub max_iterations: usize,
}

/// Solves A P⁻¹ y = b, x = P⁻¹ y, with `apply`(v) = A v and `precondition`(v) = P⁻¹ v.
#[must_use]
pub fn gmres(
    apply: impl Fn(&[f64]) -> Vec<f64>,
    precondition: impl Fn(&[f64]) -> Vec<f64>,
    b: &[f64],
    settings: GmresSettings,
) -> GmresResult {
    let beta = norm(b);
    if beta == 0.0 || !beta.is_finite() {
        return GmresResult {
            solution: vec![0.0; b.len()],
            iterations: 0,
            relative_residual: if beta == 0.0 { 0.0 } else { f64::NAN },
        };
    }
    let mut basis = vec![scaled(b, 1.0 / beta)];
    let mut triangle: Vec<Vec<f64>> = Vec::new();
    let mut rotations: Vec<(f64, f64)> = Vec::new();
    let mut rhs = vec![beta];
    for j in 0..settings.max_iterations {
        let mut w = apply(&precondition(&basis[j]));
        let (mut column, last) = orthogonalise(&mut w, &basis);
        for (i, &(c, s)) in rotations.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            column[i] = c * a + s * b;
            column[i + 1] = c * b - s * a;
        }
        let diagonal = column[j].hypot(last);
        let (c, s) = if diagonal == 0.0 {
            (1.0, 0.0)
        } else {
            (column[j] / diagonal, last / diagonal)
        };
        column[j] = diagonal;
        column.truncate(j + 1);
        triangle.push(column);
        rotations.push((c, s));
        rhs.push(-s * rhs[j]);
        rhs[j] *= c;
        let done = rhs[j + 1].abs() <= settings.tolerance * beta;
        if done || last == 0.0 || !last.is_finite() {
            break;
        }
        basis.push(scaled(&w, 1.0 / last));
    }
    let n = triangle.len();
    let y = back_substitute(&triangle, &rhs[..n]);
    let mut combination = vec![0.0; b.len()];
    for (weight, vector) in y.iter().zip(&basis) {
        axpy(*weight, vector, &mut combination);
    }
    GmresResult {
        solution: precondition(&combination),
        iterations: n,
        relative_residual: rhs[n].abs() / beta,
    }
}

/// Gram–Schmidt, twice ("twice is enough"): the coefficients, a slot for the norm, and the norm of what is left.
fn orthogonalise(w: &mut [f64], basis: &[Vec<f64>]) -> (Vec<f64>, f64) {
    let mut column = vec![0.0; basis.len() + 1];
    for _ in 0..2 {
        for (h, v) in column.iter_mut().zip(basis) {
            let projection = dot(w, v);
            *h += projection;
            axpy(-projection, v, w);
        }
    }
    (column, norm(w))
}

/// Solves the upper triangular system whose column j is `triangle[j]`.
fn back_substitute(triangle: &[Vec<f64>], rhs: &[f64]) -> Vec<f64> {
    let mut y = rhs.to_vec();
    for j in (0..y.len()).rev() {
        y[j] /= triangle[j][j];
        for i in 0..j {
            y[i] -= triangle[j][i] * y[j];
        }
    }
    y
}

/// Inner product in eight partial sums, in a fixed order: the compiler can use vector registers without changing bits.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a
        .remainder()
        .iter()
        .zip(b.remainder())
        .map(|(x, y)| x * y)
        .sum();
    let mut sums = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for ((sum, x), y) in sums.iter_mut().zip(a).zip(b) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn scaled(a: &[f64], factor: f64) -> Vec<f64> {
    a.iter().map(|x| x * factor).collect()
}

fn axpy(factor: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
