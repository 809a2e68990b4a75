//! Jumps of the derivatives of the tractions, and what they add to the forces.
//!
//! The force coefficients are sums over the samples. Where the first two derivatives of the integrand jump by J₁ and J₂, at the
//! share x of an interval of length h, such a sum lacks ½ h² B₂(x) J₁ − ⅙ h³ B₃(x) J₂ (Euler and Maclaurin; B₂ = x² − x + 1/6,
//! B₃ = x³ − 3/2 x² + ½ x). The integrand is a traction times a basis function b: J₁ = J b and J₂ = K b + 2 J b', where J and K
//! are the jumps of the traction. In a stick much shorter than the step both terms are as large, and cancel.
//!
//! K leaves out how the traction turns in slip: slip is integrated to second order, and the turn between two samples is not
//! resolved where the motion is large against its limit.

use super::sensitivity::{Blocks, KinkRows, Row, add_row, add_signal, set_rows};
use crate::aft::lanes::masks::clear;
use crate::aft::plan::AftPlan;
use crate::aft::signals::polynomial::basis_row;
use crate::contact::Real;
use pulp::Simd;
use std::f64::consts::TAU;

/// Jumps of the derivatives of the tractions at an event.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kink<T> {
    /// Phase of the event.
    pub theta: T,
    /// First phase and length of the cell around it, if an interval between samples has several.
    pub cell: Option<[T; 2]>,
    /// Change of the first derivative of both tractions by the phase (N per radian).
    pub jump: [T; 2],
    /// Change of the second one (N per square radian).
    pub bend: [T; 2],
}

impl<T: Real> Kink<T> {
    /// Adds what the kink contributes to the traction coefficients; `row` takes the basis row, `missing` what one traction lacks.
    /// Shape: `force` `[2][m]`.
    pub(super) fn add_force(
        &self,
        plan: &AftPlan<T>,
        [row, missing]: [&mut Vec<T>; 2],
        force: &mut [T],
    ) {
        let [_, second, third] = self.weights(plan);
        row.resize(plan.m, T::ONE);
        basis_row(plan, self.theta, row);
        for (d, force) in force.chunks_exact_mut(plan.m).enumerate() {
            let (jump, bend) = (self.jump[d], self.bend[d]);
            let factors = [
                second * jump - third * bend,
                -(third + third) * jump,
                T::ZERO,
            ];
            clear(missing, plan.m);
            add_signal(plan, missing, row, factors);
            for ((force, &missing), &w) in force.iter_mut().zip(&*missing).zip(&plan.weight) {
                *force += w * missing;
            }
        }
    }

    /// Adds the derivatives of that. `blocks.kink` holds the derivatives of the jumps, `row` is the basis row at the kink and
    /// `instant` holds the derivatives of its phase.
    #[inline(always)]
    pub(super) fn add_tangent<S: Simd>(
        &self,
        simd: S,
        plan: &AftPlan<T>,
        blocks: &mut Blocks<T>,
        row: &[T],
        instant: &Row<T>,
    ) {
        let [first, second, third] = self.weights(plan);
        let twice = third + third;
        // For b, b' and b'': the factors of dJ, dK and dθ.
        let factors = |j: T, k: T| {
            [
                [second, -third, first * j - second * k],
                [-twice, T::ZERO, -(second * j + third * k)],
                [T::ZERO, T::ZERO, -(twice * j)],
            ]
        };
        for derivative in 0..3 {
            let KinkRows { jump, bend } = &blocks.kink;
            for (d, traction) in blocks.traction.iter_mut().enumerate() {
                let [by_jump, by_bend, by_instant] =
                    factors(self.jump[d], self.bend[d])[derivative];
                set_rows(traction, [&jump[d], &bend[d]], |_, jump, bend| {
                    by_jump * jump + by_bend * bend
                });
                add_row(traction, by_instant, instant);
            }
            let mut of_basis = [T::ZERO; 3];
            of_basis[derivative] = T::ONE;
            blocks.weigh(simd, plan, row, of_basis);
        }
    }

    /// B₁(x) = x − ½, ½ h B₂(x) and ⅙ h² B₃(x): each is the derivative of the next one by the phase. In a cell of another length than
    /// the interval between samples they have its share of that interval as a factor.
    #[inline(always)]
    fn weights(&self, plan: &AftPlan<T>) -> [T; 3] {
        let n = plan.n_time() as f64;
        let theta = self.theta.to_f64();
        let (share, h, x) = match self.cell {
            None => (1.0, TAU / n, (theta * (n / TAU)).fract()),
            Some([start, length]) => {
                let h = length.to_f64();
                (h * (n / TAU), h, (theta - start.to_f64()) / h)
            }
        };
        [
            share * (x - 0.5),
            share * (0.5 * h * (x * x - x + 1.0 / 6.0)),
            share * (h * h / 6.0 * x * (x - 0.5) * (x - 1.0)),
        ]
        .map(T::from_f64)
    }
}
