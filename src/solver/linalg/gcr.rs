//! Generalised conjugate residual method for several right-hand sides.
//!
//! Source: Eisenstat, Elman & Schultz 1983, SIAM J. Numer. Anal. 20, 345–357; equal to GMRES where that does not
//! stagnate. The search directions are kept: the next right-hand side starts with all of them.
//!
//! The directions z stay as they were found; only their products are made orthonormal, A Z = Q R. A residual loses its
//! part in Q, and the solution Z R⁻¹ Qᵀ b is put together at the end.

use super::vector::{axpy, dot, norm};
use pulp::{Arch, Simd, WithSimd};

/// Stop rules.
#[derive(Debug, Clone, Copy)]
pub struct GcrSettings {
    /// ‖b − A x‖₂ / ‖b‖₂ to reach.
    pub tolerance: f64,
    /// Directions added for one right-hand side at the most.
    pub max_iterations: usize,
}

/// What a run gives.
#[derive(Debug, Clone)]
pub struct GcrResult {
    /// Approximate solution.
    pub solution: Vec<f64>,
    /// Matrix–vector products spent.
    pub iterations: usize,
    /// Whether the residual is as small as wanted.
    pub converged: bool,
}

/// Search directions of one matrix A with their products.
#[derive(Debug, Default)]
pub struct SearchSpace {
    /// Z.
    directions: Vec<Vec<f64>>,
    /// Q.
    products: Vec<Vec<f64>>,
    /// Columns of R down to the diagonal.
    columns: Vec<Vec<f64>>,
}

/// Share of a product that the others must leave for its remainder to be orthogonal to them; a smaller remainder is
/// made so once more ("twice is enough").
const CANCELLED: f64 = 0.5;

impl SearchSpace {
    /// Adds directions until the residuals of all right-hand sides `b` are as small as wanted, with `product` as in
    /// [`Self::solve`] for several vectors at once. Each side may use the directions of the others, so that together they
    /// need fewer, and fewer readings of A.
    pub fn explore(
        &mut self,
        product: impl Fn(&[&[f64]]) -> Vec<(Vec<f64>, Vec<f64>)>,
        b: &[&[f64]],
        settings: GcrSettings,
    ) {
        let goals: Vec<f64> = b.iter().map(|b| settings.tolerance * norm(b)).collect();
        let mut residuals: Vec<Vec<f64>> = b.iter().map(|b| b.to_vec()).collect();
        let mut known = 0;
        for _ in 0..=settings.max_iterations {
            for residual in &mut residuals {
                without(&self.products[known..], residual);
            }
            let open: Vec<&[f64]> = (residuals.iter().zip(&goals))
                .filter(|(residual, goal)| norm(residual) > **goal)
                .map(|(residual, _)| residual.as_slice())
                .collect();
            if open.is_empty() {
                return;
            }
            known = self.products.len();
            for (z, w) in product(&open) {
                self.add(z, w);
            }
            if self.products.len() == known {
                return;
            }
        }
    }

    /// Solves A x = b with `product`(v) = (z, A z), z = P⁻¹ v: preconditioners such as a Gauss–Seidel sweep have most of
    /// A z when they have z.
    pub fn solve(
        &mut self,
        product: impl Fn(&[f64]) -> (Vec<f64>, Vec<f64>),
        b: &[f64],
        settings: GcrSettings,
    ) -> GcrResult {
        let goal = settings.tolerance * norm(b);
        let mut residual = b.to_vec();
        let mut parts = without(&self.products, &mut residual);
        let mut iterations = 0;
        while norm(&residual) > goal && iterations < settings.max_iterations {
            let (z, w) = product(&residual);
            iterations += 1;
            if !self.add(z, w) {
                break;
            }
            let newest = &self.products[self.products.len() - 1..];
            parts.extend(without(newest, &mut residual));
        }
        GcrResult {
            solution: self.combined(parts, b.len()),
            iterations,
            converged: norm(&residual) <= goal,
        }
    }

    /// Adds a direction z and its product w; false if the others leave nothing of that.
    fn add(&mut self, z: Vec<f64>, mut w: Vec<f64>) -> bool {
        let whole = norm(&w);
        let mut column = without(&self.products, &mut w);
        let mut left = norm(&w);
        if left < CANCELLED * whole {
            let again = without(&self.products, &mut w);
            (column.iter_mut().zip(again)).for_each(|(part, more)| *part += more);
            left = norm(&w);
        }
        let new = left > f64::EPSILON * whole;
        if new {
            w.iter_mut().for_each(|w| *w /= left);
            column.push(left);
            self.directions.push(z);
            self.products.push(w);
            self.columns.push(column);
        }
        new
    }

    /// Z R⁻¹ `parts`. Shape: `[n]`.
    fn combined(&self, mut parts: Vec<f64>, n: usize) -> Vec<f64> {
        let mut solution = vec![0.0; n];
        for (j, (direction, column)) in self.directions.iter().zip(&self.columns).enumerate().rev()
        {
            let length = parts[j] / column[j];
            axpy(-length, &column[..j], &mut parts[..j]);
            axpy(length, direction, &mut solution);
        }
        solution
    }
}

/// Takes the parts of `v` in orthonormal `products` away and gives their lengths.
fn without(products: &[Vec<f64>], v: &mut [f64]) -> Vec<f64> {
    Arch::new().dispatch(Without { products, v })
}

/// The arguments of [`without`], for the instruction set that is found at run time.
struct Without<'a> {
    products: &'a [Vec<f64>],
    v: &'a mut [f64],
}

impl WithSimd for Without<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let Self { products, v } = self;
        // a closure would not be compiled for the instruction set
        let mut lengths = Vec::with_capacity(products.len() + 1);
        for product in products {
            lengths.push(dot(product, v));
        }
        for (length, product) in lengths.iter().zip(products) {
            axpy(-length, product, v);
        }
        lengths
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 60;

    /// Row i of a matrix that is not symmetric, whose diagonal goes from 1 to 1e4.
    fn times(x: &[f64]) -> Vec<f64> {
        let row = |i: usize| {
            let diagonal = 1e4_f64.powf(i as f64 / (N - 1) as f64);
            let above = if i + 1 < N { 0.5 * x[i + 1] } else { 0.0 };
            let below = if i > 0 { -0.25 * x[i - 1] } else { 0.0 };
            diagonal * x[i] + above + below
        };
        (0..N).map(row).collect()
    }

    /// The solution that is put together has the residual that the method followed, for a later right-hand side too, and
    /// that one needs fewer directions. Sides that were explored together need no more. Seen to fail with: the parts of R above
    /// its diagonal left out; the parts in the directions of the first right-hand side left out; only the first side
    /// explored.
    #[test]
    fn solutions_have_the_residual_that_was_asked_for() {
        let settings = GcrSettings {
            tolerance: 1e-11,
            max_iterations: 100,
        };
        let mut space = SearchSpace::default();
        let sides = [1.0, 1.1].map(|f| -> Vec<f64> {
            let entry = |i: usize| (f * i as f64).sin() + 2.0;
            (0..N).map(entry).collect()
        });
        let mut together = SearchSpace::default();
        let product = |v: &[f64]| (v.to_vec(), times(v));
        let products = |v: &[&[f64]]| v.iter().map(|v| product(v)).collect();
        let rough = GcrSettings {
            tolerance: 1e-4,
            ..settings
        };
        together.explore(products, &sides.each_ref().map(Vec::as_slice), rough);
        for b in &sides {
            let result = together.solve(product, b, rough);
            assert!(result.converged && result.iterations == 0, "{result:?}");
        }
        let [first, second] = sides.map(|b| {
            let result = space.solve(|v| (v.to_vec(), times(v)), &b, settings);
            let product = times(&result.solution);
            let left: Vec<f64> = b.iter().zip(&product).map(|(b, p)| b - p).collect();
            assert!(result.converged, "{result:?}");
            assert!(
                norm(&left) < 3e-11 * norm(&b),
                "{:e}",
                norm(&left) / norm(&b)
            );
            result.iterations
        });
        assert!(second < first / 2, "{first} then {second}");
    }
}
