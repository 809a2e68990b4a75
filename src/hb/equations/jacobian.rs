//! The Jacobian I + G dg of the balance equations and its inverse.
//!
//! dg = dF − K_c is zero for a force that sticks all period long, so the system is solved for the other forces only
//! (`capacitance`, where springs make them easier); the displacements follow by substitution. Few unknowns are
//! factorised densely, many are solved by conjugate residuals. Their preconditioner is one Gauss–Seidel sweep over blocks
//! of one force component of neighbouring pairs with all their harmonics: slip and lift-off couple the harmonics of a pair
//! strongly, the structure couples pairs and components weakly, so the number of iterations hardly grows with the
//! harmonics. Sweeps are in single precision; the residual of a solve that asks for more is refined in double.

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

/// Up to so many unknowns a dense factor is cheaper than setup and two Krylov solves (equal at 130, three times dearer
/// at 330).
const DENSE_LIMIT: usize = 150;

/// Up to so many a dense factor replaces a Krylov solve that does not converge.
const DENSE_FALLBACK_LIMIT: usize = 4000;

/// Residual of the forces in an exact solve; the displacements, and so the tangents, are then exact to about 1e-9.
pub const EXACT: f64 = 1e-10;

/// Share of a residual that sweeps in single precision leave; what they believe to be left below is round-off.
const SINGLE: f64 = 1e-5;

/// A refinement that leaves more of the residual will not end.
const STALLED: f64 = 0.5;

/// So many times the residual that was asked for are taken for it, as single precision believes it to be smaller.
const ENOUGH: f64 = 2.0;

/// Directions of one Krylov solve at the most. Halves of the two-blade rig take 5 to 60 in an exact solve, the whole rig
/// at 21 harmonics up to 365.
const MAX_ITERATIONS: usize = 400;

/// J = I + G dg at one iterate, ready to be solved with.
#[derive(Debug)]
pub struct Jacobian<'a> {
    static_compliance: &'a Mat<f64>,
    compliance: &'a Compliance<'a>,
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
    /// Residual of the forces over those asked for.
    tolerance: f64,
    /// Preconditioner.
    sweep: GaussSeidel,
    /// What earlier right-hand sides have explored; later ones need less.
    space: RefCell<SearchSpace>,
    /// Dense factor, once a solve did not converge.
    dense: OnceCell<PartialPivLu<f64>>,
}

impl<'a> Jacobian<'a> {
    /// Factorises what the solves need. Those of large systems leave `tolerance` of the forces.
    #[must_use]
    pub fn new(
        layout: &Layout,
        problem: &'a Problem<'_>,
        compliance: &'a Compliance<'a>,
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
            static_compliance,
            compliance,
            capacitance,
            solver,
        }
    }

    /// Number of factorisations so far: one for any unknowns, one more for Krylov solves that did not converge.
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
        self.capacitance.solve(b, |y| match &self.solver {
            Solver::Dense(factors) => solve_in_place(factors, y),
            Solver::Krylov(krylov) => krylov.solve(&self.capacitance, y),
        })
    }

    /// dg x. Shape: `[n_coefficients][3·n_contacts]`.
    #[must_use]
    pub fn deviation(&self, x: &[f64]) -> Vec<f64> {
        self.capacitance.deviation(x)
    }

    /// y += G x, harmonic by harmonic.
    pub fn add_compliance(&self, x: &[f64], y: &mut [f64]) {
        let n = self.static_compliance.nrows();
        for (j, &x) in x[..n].iter().enumerate() {
            axpy(x, self.static_compliance.col_as_slice(j), &mut y[..n]);
        }
        for (h, (x, y)) in (self.compliance.harmonics.iter()).zip(
            x[n..]
                .chunks_exact(2 * n)
                .zip(y[n..].chunks_exact_mut(2 * n)),
        ) {
            let (y_c, y_s) = y.split_at_mut(n);
            h.add_real((&x[..n], &x[n..]), (y_c, y_s));
        }
    }
}

impl Krylov {
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

    /// C⁻¹ `b`, refined as far as sweeps in single precision leave of it; none if it was not reached and a dense factor can
    /// be had.
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
            let result = (self.space.borrow_mut()).solve(|v| self.sweep.apply(v), &left, settings);
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
