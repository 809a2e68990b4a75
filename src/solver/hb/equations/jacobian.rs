//! The Jacobian I + G dg of the balance equations and its inverse.
//!
//! With R = r − r^stuck + G g (see [`super::balance`]) the Jacobian is J = ∂R/∂r = I + G dg, dg = ∂F/∂r − K_c.
//!
//! - **Elimination.** dg has no rows for a force whose contact sticks over the whole period. So J x = b is solved for the other
//!   forces only (`capacitance`); the displacements then follow by substitution.
//! - **Small systems** (up to 150 unknowns) are factorised by dense LU.
//! - **Large systems** are solved by generalised conjugate residuals (Eisenstat, Elman and Schultz, SIAM J. Numer. Anal. 20,
//!   1983). The preconditioner is one Gauss–Seidel sweep. Each of its blocks holds one force component of neighbouring pairs
//!   with all harmonics: slip and separation couple the harmonics of one pair strongly, the structure couples pairs and
//!   components weakly. So the number of iterations hardly grows with the harmonics.
//! - **Precision.** Sweeps are in single precision. Where the solve must be more exact, its residual is computed in double
//!   precision and solved for again (iterative refinement).

mod capacitance;
mod gauss_seidel;

use super::layout::{Layout, PairTangent};
use super::problem::Problem;
use crate::hb::structure::compliance::Compliance;
use crate::linalg::gcr::{GcrSettings, SearchSpace};
use crate::linalg::vector::{axpy, norm};
use capacitance::Capacitance;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use gauss_seidel::GaussSeidel;
use std::cell::{OnceCell, RefCell};

/// Up to this number of unknowns a dense factorisation is cheaper than the setup and two solves by conjugate residuals (equal
/// cost at 130, three times the cost at 330).
pub const DENSE_LIMIT: usize = 150;

/// Up to this number of unknowns a dense factorisation replaces a solve by conjugate residuals that does not converge.
pub const DENSE_FALLBACK_LIMIT: usize = 4000;

/// Relative residual of the forces in an exact solve. The relative error of the displacements, and so of the tangents to the
/// branch, is then about 1e-9.
pub const EXACT: f64 = 1e-10;

/// Smallest relative residual that a solve in single precision can reach: below it round-off decides.
const SINGLE: f64 = 1e-5;

/// If one refinement leaves more than this share of the residual, further ones would not reach the tolerance.
const STALLED: f64 = 0.5;

/// A solve ends at this multiple of the residual asked for: the estimate in single precision is smaller than the true one.
const ENOUGH: f64 = 2.0;

/// Most directions of one solve by conjugate residuals. An exact solve takes 5 to 60 of them for one half of the two-blade
/// rig, and up to 365 for the whole rig with 21 harmonics.
const MAX_ITERATIONS: usize = 400;

/// J = I + G dg at one point, prepared for solves with it.
#[derive(Debug)]
pub struct Jacobian {
    capacitance: Capacitance,
    solver: Solver,
}

#[derive(Debug)]
enum Solver {
    Dense(PartialPivLu<f64>),
    Krylov(Krylov),
}

/// Solver of large systems.
#[derive(Debug)]
struct Krylov {
    /// Relative residual of the forces at which a solve ends.
    tolerance: f64,
    /// Preconditioner.
    sweep: GaussSeidel,
    /// Directions of the solves before this one, which the next solve uses first.
    space: RefCell<SearchSpace>,
    /// Dense factorisation, made when a solve has not converged.
    dense: OnceCell<PartialPivLu<f64>>,
}

impl Jacobian {
    /// Factorises what the solves need. A solve of a large system ends at the relative residual `tolerance`.
    #[must_use]
    pub fn new(
        layout: &Layout,
        problem: &Problem<'_>,
        compliance: &Compliance<'_>,
        active: &[PairTangent],
        tolerance: f64,
    ) -> Self {
        let static_compliance = &problem.stuck_static.compliance;
        let capacitance = Capacitance::new(layout, static_compliance, compliance, active);
        let solver = if capacitance.size() <= DENSE_LIMIT {
            Solver::Dense(dense_factors(&capacitance))
        } else {
            Solver::Krylov(Krylov {
                tolerance,
                sweep: GaussSeidel::new(&capacitance),
                space: RefCell::default(),
                dense: OnceCell::new(),
            })
        };
        Self {
            capacitance,
            solver,
        }
    }

    /// Number of factorisations so far: none without unknowns, else one, and one more if a solve has not converged.
    #[must_use]
    pub fn factorizations(&self) -> usize {
        let fallback = match &self.solver {
            Solver::Dense(_) => None,
            Solver::Krylov(krylov) => krylov.dense.get(),
        };
        usize::from(self.capacitance.size() > 0) + usize::from(fallback.is_some())
    }

    /// x = J⁻¹ b. Shape: `[n_coefficients][3·n_contacts]`.
    #[must_use]
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let (mut x, mut y) = self.capacitance.eliminated(b);
        match &self.solver {
            Solver::Dense(factors) => solve_in_place(factors, &mut y),
            Solver::Krylov(krylov) => krylov.solve(&self.capacitance, &mut y),
        }
        self.capacitance.substitute(&y, &mut x);
        x
    }

    /// x = J⁻¹ b for each b. Krylov solves of several right-hand sides together take less time than one after the other.
    #[must_use]
    pub(crate) fn solve_all<const K: usize>(&self, b: [&[f64]; K]) -> [Vec<f64>; K] {
        if let Solver::Krylov(krylov) = &self.solver {
            let y = b.map(|b| self.capacitance.eliminated(b).1);
            krylov.explore(&y.each_ref().map(Vec::as_slice));
        }
        b.map(|b| self.solve(b))
    }

    /// dg x. Shape: `[n_coefficients][3·n_contacts]`.
    #[must_use]
    pub fn deviation(&self, x: &[f64]) -> Vec<f64> {
        self.capacitance.deviation(x)
    }
}

impl Krylov {
    /// Adds the directions that solves for these right-hand sides need first.
    fn explore(&self, b: &[&[f64]]) {
        if self.dense.get().is_none() {
            let settings = GcrSettings {
                tolerance: self.tolerance.max(SINGLE),
                max_iterations: MAX_ITERATIONS,
            };
            (self.space.borrow_mut()).explore(|v| self.sweep.apply(v), b, settings);
        }
    }

    /// y ← C⁻¹ y.
    fn solve(&self, capacitance: &Capacitance, y: &mut [f64]) {
        if self.dense.get().is_none()
            && let Some(solution) = self.refined(capacitance, y)
        {
            y.copy_from_slice(&solution);
            return;
        }
        let factors = (self.dense).get_or_init(|| dense_factors(capacitance));
        solve_in_place(factors, y);
    }

    /// C⁻¹ `b` to `tolerance`, by solves in single precision and refinement; none if they do not reach it and the system is
    /// small enough for a dense factorisation.
    fn refined(&self, capacitance: &Capacitance, b: &[f64]) -> Option<Vec<f64>> {
        let goal = self.tolerance * norm(b);
        let mut solution = vec![0.0; b.len()];
        let mut left = b.to_vec();
        while norm(&left) > ENOUGH * goal {
            let size = norm(&left);
            let settings = GcrSettings {
                tolerance: (goal / size).max(SINGLE),
                max_iterations: MAX_ITERATIONS,
            };
            let result =
                (self.space.borrow_mut()).solve(|v| self.sweep.apply_to(v), &left, settings);
            axpy(1.0, &result.solution, &mut solution);
            if result.converged && self.tolerance >= SINGLE {
                break;
            }
            left = capacitance.residual(b, &solution);
            if !result.converged || norm(&left) > STALLED * size {
                return (b.len() > DENSE_FALLBACK_LIMIT).then_some(solution);
            }
        }
        Some(solution)
    }
}

/// LU factors of C.
fn dense_factors(capacitance: &Capacitance) -> PartialPivLu<f64> {
    let all = 0..capacitance.slots.len();
    capacitance.matrix(all).partial_piv_lu()
}

/// x ← A⁻¹ x.
fn solve_in_place(factors: &PartialPivLu<f64>, x: &mut [f64]) {
    factors.solve_in_place(ColMut::from_slice_mut(x));
}
