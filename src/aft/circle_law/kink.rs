//! Jumps of the slope of the tractions, and what they add to the forces.
//!
//! The force coefficients are sums over the samples. Where the slope of the integrand jumps by J, at the share x of an interval
//! of length h, such a sum lacks −½ h² B₂(x) J (Euler and Maclaurin; B₂ = x² − x + 1/6).

use super::sensitivity::{Blocks, Row, add_row, scale, set_rows};
use crate::aft::plan::AftPlan;
use crate::aft::signals::polynomial::basis_row;
use crate::contact::Real;
use pulp::Simd;
use std::f64::consts::TAU;

/// A jump of the slope of the tractions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kink<T> {
    /// Phase of the event.
    pub theta: T,
    /// Change of the derivative of both tractions by the phase (N per radian).
    pub jump: [T; 2],
}

impl<T: Real> Kink<T> {
    /// Adds what the kink contributes to the traction coefficients; `row` takes the basis row. Shape: `force` `[2][m]`.
    pub(super) fn add_force(&self, plan: &AftPlan<T>, row: &mut Vec<T>, force: &mut [T]) {
        let weight = kink_weights(plan, self.theta)[0];
        row.resize(plan.m, T::ONE);
        basis_row(plan, self.theta, row);
        for (force, jump) in force.chunks_exact_mut(plan.m).zip(self.jump) {
            for ((force, &b), &w) in force.iter_mut().zip(row.iter()).zip(&plan.weight) {
                *force += w * (weight * jump * b);
            }
        }
    }

    /// Adds the derivatives of that. `blocks.traction` holds the derivatives of the jump, and is lost; `row` is the basis row at
    /// the kink and `instant` holds the derivatives of its phase.
    #[inline(always)]
    pub(super) fn add_tangent<S: Simd>(
        &self,
        simd: S,
        plan: &AftPlan<T>,
        blocks: &mut Blocks<T>,
        row: &[T],
        instant: &Row<T>,
    ) {
        let [weight, slope] = kink_weights(plan, self.theta);
        for (traction, &jump) in blocks.traction.iter_mut().zip(&self.jump) {
            scale(traction, weight);
            add_row(traction, slope * jump, instant);
        }
        blocks.weigh(simd, plan, row, [T::ONE, T::ZERO]);
        for (traction, &jump) in blocks.traction.iter_mut().zip(&self.jump) {
            set_rows(traction, [instant, instant], |_, instant, _| {
                weight * jump * instant
            });
        }
        blocks.weigh(simd, plan, row, [T::ZERO, T::ONE]);
    }
}

/// ½ h B₂(x) and its derivative by the phase.
#[inline(always)]
fn kink_weights<T: Real>(plan: &AftPlan<T>, theta: T) -> [T; 2] {
    let n = plan.n_time() as f64;
    let x = (theta.to_f64() * (n / TAU)).fract();
    [
        T::from_f64(0.5 * TAU / n * (x * x - x + 1.0 / 6.0)),
        T::from_f64(x - 0.5),
    ]
}
