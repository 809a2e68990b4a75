//! Generalised conjugate residual method for several right-hand sides.
//!
//! Source: Eisenstat, Elman & Schultz 1983, SIAM J. Numer. Anal. 20, 345–357; equal to GMRES where that does not
//! stagnate. The search directions are kept: the next right-hand side starts with all of them.

use super::vector::{axpy, dot, norm};

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

/// Search directions z of one matrix A with their products A z, which are orthonormal.
#[derive(Debug, Default)]
pub struct SearchSpace {
    directions: Vec<Vec<f64>>,
    products: Vec<Vec<f64>>,
}

impl SearchSpace {
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
        let mut solution = vec![0.0; b.len()];
        for i in 0..self.products.len() {
            self.descend(i, &mut residual, &mut solution);
        }
        let mut iterations = 0;
        while norm(&residual) > goal && iterations < settings.max_iterations {
            let (z, w) = product(&residual);
            iterations += 1;
            if !self.add(z, w) {
                break;
            }
            self.descend(self.products.len() - 1, &mut residual, &mut solution);
        }
        GcrResult {
            solution,
            iterations,
            converged: norm(&residual) <= goal,
        }
    }

    /// The step along direction `i` that makes the residual smallest.
    fn descend(&self, i: usize, residual: &mut [f64], solution: &mut [f64]) {
        let length = dot(&self.products[i], residual);
        axpy(length, &self.directions[i], solution);
        axpy(-length, &self.products[i], residual);
    }

    /// Adds a direction, its product orthogonalised by Gram–Schmidt, twice ("twice is enough"); false if nothing is left
    /// of it.
    fn add(&mut self, mut z: Vec<f64>, mut w: Vec<f64>) -> bool {
        let before = norm(&w);
        for _ in 0..2 {
            for (direction, product) in self.directions.iter().zip(&self.products) {
                let projection = dot(product, &w);
                axpy(-projection, product, &mut w);
                axpy(-projection, direction, &mut z);
            }
        }
        let after = norm(&w);
        let new = after > f64::EPSILON * before;
        if new {
            [&mut z, &mut w]
                .into_iter()
                .for_each(|v| v.iter_mut().for_each(|v| *v /= after));
            self.directions.push(z);
            self.products.push(w);
        }
        new
    }
}
