//! The largest eigenvalues of a matrix that is only known by its products, by Arnoldi's method.
//!
//! Source: Saad, Numerical Methods for Large Eigenvalue Problems, 2nd ed. 2011, section 6.2.

use super::vector::{axpy, dot, norm};
use faer::prelude::*;

/// A new direction below this share of the product is rounding: the space holds all products of its vectors.
const EXHAUSTED: f64 = 1e-13;

/// A Krylov space with an orthonormal basis.
#[derive(Debug, Clone)]
pub struct Krylov {
    /// Shape: `[dimension, and one more unless it is exhausted][n]`.
    basis: Vec<Vec<f64>>,
    /// Columns of the Hessenberg matrix. Shape: `[dimension][column + 2]`.
    columns: Vec<Vec<f64>>,
    exhausted: bool,
}

/// An eigenvalue of the projection, which approximates one of the matrix.
#[derive(Debug, Clone)]
pub struct Ritz {
    /// The eigenvalue.
    pub value: c64,
    /// Norm of the residual of its unit vector.
    pub residual: f64,
    /// Its unit vector in the basis.
    coefficients: Vec<c64>,
}

impl Krylov {
    /// The space of `start` alone.
    #[must_use]
    pub fn new(start: Vec<f64>) -> Self {
        let mut space = Self {
            basis: Vec::new(),
            columns: Vec::new(),
            exhausted: false,
        };
        space.push(start);
        space
    }

    /// Number of products that it knows.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.columns.len()
    }

    /// Whether it holds all products of its vectors: more of them add nothing.
    #[must_use]
    pub fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// Adds products by `apply` until there are `dimension` of them, or the space is exhausted.
    pub fn grow(&mut self, dimension: usize, apply: impl Fn(&[f64]) -> Vec<f64>) {
        while self.dimension() < dimension && !self.exhausted {
            let mut next = apply(&self.basis[self.dimension()]);
            let size = norm(&next);
            let mut column = vec![0.0; self.basis.len() + 1];
            // twice: once leaves rounding of the size of what was taken away
            for _ in 0..2 {
                for (direction, entry) in self.basis.iter().zip(&mut column) {
                    let along = dot(direction, &next);
                    axpy(-along, direction, &mut next);
                    *entry += along;
                }
            }
            let left = norm(&next);
            let last = self.basis.len();
            self.exhausted = left <= EXHAUSTED * size || last == next.len();
            column[last] = if self.exhausted { 0.0 } else { left };
            self.columns.push(column);
            if !self.exhausted {
                self.push(next);
            }
        }
    }

    fn push(&mut self, mut direction: Vec<f64>) {
        let scale = 1.0 / norm(&direction);
        direction.iter_mut().for_each(|x| *x *= scale);
        self.basis.push(direction);
    }

    /// Eigenvalues of the projection, the largest modulus first; `None` if they were not found.
    #[must_use]
    pub fn eigenvalues(&self) -> Option<Vec<Ritz>> {
        let n = self.dimension();
        let projection = Mat::from_fn(n, n, |i, j| self.columns[j].get(i).copied().unwrap_or(0.0));
        let found = projection.eigen().ok()?;
        let below = self.columns.last().map_or(0.0, |column| column[n]);
        let mut all: Vec<Ritz> = (0..n)
            .map(|k| {
                let vector = found.U().col(k);
                let scale = 1.0 / vector.norm_l2();
                Ritz {
                    value: found.S()[k],
                    residual: below * scale * vector[n - 1].norm(),
                    coefficients: vector.iter().map(|x| x * scale).collect(),
                }
            })
            .collect();
        all.sort_by(|a, b| b.value.norm_sqr().total_cmp(&a.value.norm_sqr()));
        Some(all)
    }

    /// Real and imaginary part of the unit vector of `ritz`. Shape: `[n]` each.
    #[must_use]
    pub fn vector(&self, ritz: &Ritz) -> [Vec<f64>; 2] {
        let zeros = || vec![0.0; self.basis[0].len()];
        let mut parts = [zeros(), zeros()];
        for (direction, c) in self.basis.iter().zip(&ritz.coefficients) {
            axpy(c.re, direction, &mut parts[0]);
            axpy(c.im, direction, &mut parts[1]);
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with a pair of complex eigenvalues outside the circle that all others lie on or in.
    fn matrix() -> Mat<f64> {
        let n = 60;
        let blocks = Mat::from_fn(n, n, |i, j| {
            let (size, angle) = match i / 2 {
                0 => (1.05, 0.7),
                k => (1.0 - 0.004 * k as f64, 0.3 * k as f64),
            };
            match (i / 2 == j / 2, i % 2, j % 2) {
                (false, ..) => 0.0,
                (true, 0, 1) => -size * libm::sin(angle),
                (true, 1, 0) => size * libm::sin(angle),
                _ => size * libm::cos(angle),
            }
        });
        // not normal: a shear of neighbours
        let shear = Mat::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) + 0.1 * f64::from(u8::from(j == i + 1))
        });
        let sheared = &shear * blocks;
        shear
            .partial_piv_lu()
            .solve(sheared.transpose())
            .transpose()
            .to_owned()
    }

    /// Against all eigenvalues by the dense routine: to 1e-2 with three quarters of the space, whose others fill the circle, and to rounding with
    /// all of it. The stated residual is that of the vector. Seen to fail with the entries of the first pass of the orthogonalisation left out.
    #[test]
    fn finds_the_largest_pair() {
        let matrix = matrix();
        let apply = |x: &[f64]| -> Vec<f64> {
            let y = &matrix * Col::from_fn(x.len(), |i| x[i]);
            y.iter().copied().collect()
        };
        let n = matrix.nrows();
        let start: Vec<f64> = (0..n)
            .map(|i| libm::sin(1.0 + i as f64 * i as f64))
            .collect();
        let mut space = Krylov::new(start);
        space.grow(45, apply);
        let found = space.eigenvalues().expect("eigenvalues");
        let all = matrix.eigenvalues().expect("eigenvalues");
        let largest = all.iter().map(|m| m.norm()).fold(0.0, f64::max);
        assert!(
            (found[0].value.norm() - largest).abs() < 1e-2,
            "{:?}",
            found[0].value
        );
        let [re, im] = space.vector(&found[0]);
        let [a_re, a_im] = [&re, &im].map(|x| apply(x));
        let value = found[0].value;
        let missing = (0..n)
            .map(|i| (c64::new(a_re[i], a_im[i]) - value * c64::new(re[i], im[i])).norm_sqr());
        let residual = missing.sum::<f64>().sqrt();
        assert!(
            (residual - found[0].residual).abs() < 1e-9,
            "{residual:e} {:e}",
            found[0].residual
        );
        space.grow(2 * n, apply);
        assert!(space.is_exhausted() && space.dimension() == n);
        let found = space.eigenvalues().expect("eigenvalues");
        assert!((found[0].value.norm() - largest).abs() < 1e-8);
    }
}
