//! The balance equations evaluated at one point (r, ω, level): contact forces, residual, motion, and derivatives along paths
//! through the point.

use super::point::{Direction, Point};
use crate::aft::Want;
use crate::hb::equations::balance::{Balance, ContactResponse, LoadRate, StructureMotion};
use crate::hb::equations::jacobian::{EXACT, Jacobian};
use crate::hb::structure::compliance::Compliance;
use faer::prelude::c64;
use std::sync::Arc;

/// A point with all that is evaluated there.
#[derive(Debug)]
pub struct Iterate<'p> {
    /// The point.
    pub point: Point,
    /// Compliance of the stuck structure at its frequency; iterates of equal frequency share it.
    pub compliance: Arc<Compliance<'p>>,
    /// Contact forces and their derivatives.
    pub contact: ContactResponse,
    /// The residual R (m). Shape: as r.
    pub residual: Vec<f64>,
    /// Motion of the structure.
    pub motion: StructureMotion,
}

/// Tolerance of the linear solve of a Newton step, over the relative residual at its start ("forcing term"). A Newton step
/// leaves about the square of the residual; the error of the linear solve is then no larger.
/// Source: Eisenstat & Walker 1996, SIAM J. Sci. Comput. 17, 16–32.
const FORCING: f64 = 0.1;
/// Largest tolerance of the linear solve of a Newton step.
const LOOSEST: f64 = 1e-3;
/// Round-off of the mean displacements, over the displacement scale of the problem, above which it counts as a residual: a part that only
/// contacts hold may be so far from them that the load on the part is below the last digit of its position.
const HIDDEN: f64 = 1e-10;

impl<'p> Iterate<'p> {
    /// Evaluates the balance equations at `point`.
    #[must_use]
    pub fn new(balance: &Balance<'p>, point: Point) -> Self {
        let compliance = Arc::new(balance.compliance(point.omega));
        Self::with_compliance(balance, point, compliance)
    }

    pub(in crate::hb) fn with_compliance(
        balance: &Balance<'p>,
        point: Point,
        compliance: Arc<Compliance<'p>>,
    ) -> Self {
        let contact = balance.contact(&point.r, Want::ForcesAndTangents);
        let motion = balance.motion(&compliance, point.level, &point.r, &contact.force);
        let residual = balance.residual(&motion, &point.r, &contact.force);
        Self {
            point,
            compliance,
            contact,
            residual,
            motion,
        }
    }

    /// Largest component of the residual over the displacement scale of the problem, which does not depend on the point. Where the round-off
    /// of the mean displacements over this scale is above `HIDDEN`, the larger of both: the static load may disappear in that
    /// round-off. Not a number where the residual is not finite.
    #[must_use]
    pub fn relative_residual(&self, balance: &Balance<'_>) -> f64 {
        let scale = balance.problem.displacement_scale(self.point.level);
        let size = |x: &[f64]| x.iter().map(|x| x.abs()).fold(0.0, f64::max) / scale;
        let hidden = f64::EPSILON * size(&self.point.r[..balance.layout.n_relative()]);
        match self.residual.iter().all(|r| r.is_finite()) {
            true if hidden > HIDDEN => size(&self.residual).max(hidden),
            true => size(&self.residual),
            false => f64::NAN,
        }
    }

    /// The Jacobian at this point, with linear solves as exact as a Newton step from here needs.
    #[must_use]
    pub fn jacobian(&self, balance: &Balance<'p>) -> Jacobian {
        let size = self.relative_residual(balance) / self.point.dynamic_share(balance).min(1.0);
        // a residual that is not a number gives no tolerance
        let tolerance = if size > 0.0 { FORCING * size } else { EXACT };
        self.jacobian_within(balance, tolerance.clamp(EXACT, LOOSEST))
    }

    /// The same with linear solves to the relative residual `tolerance`.
    #[must_use]
    pub fn jacobian_within(&self, balance: &Balance<'p>, tolerance: f64) -> Jacobian {
        Jacobian::new(
            &balance.layout,
            balance.problem,
            &self.compliance,
            &self.contact.active,
            tolerance,
        )
    }

    /// Complex amplitude of the first harmonic of the response that defines resonance (m).
    #[must_use]
    pub fn response(&self, balance: &Balance<'_>) -> c64 {
        self.responses(balance)[balance.problem.resonance_response]
    }

    /// Complex amplitudes of the first harmonics of all responses (m).
    #[must_use]
    pub fn responses(&self, balance: &Balance<'_>) -> Vec<c64> {
        let part = balance.problem.model.part(1);
        part.responses(&self.motion.dynamic[0])
    }

    /// The Newton step at a fixed frequency, −J⁻¹ R (m), and dr/dω (m/(rad/s)) along the branch of solutions, −J⁻¹ ∂R/∂ω, solved
    /// together.
    #[must_use]
    pub fn correction_and_frequency_rate(
        &self,
        balance: &Balance<'_>,
        jacobian: &Jacobian,
    ) -> [Vec<f64>; 2] {
        let slope = balance.frequency_slope(&self.compliance, &self.motion);
        let solved = jacobian.solve_all([&self.residual, &slope]);
        solved.map(|x| negated(&x))
    }

    /// dr/dω (m/(rad/s)) along the branch of solutions: −J⁻¹ ∂R/∂ω.
    #[must_use]
    pub fn frequency_rate(&self, balance: &Balance<'_>, jacobian: &Jacobian) -> Vec<f64> {
        let slope = balance.frequency_slope(&self.compliance, &self.motion);
        negated(&jacobian.solve(&slope))
    }

    /// dr/dlevel (m per unit level) along solutions of a fixed frequency: −J⁻¹ ∂R/∂level.
    #[must_use]
    pub(crate) fn level_rate(&self, balance: &Balance<'_>, jacobian: &Jacobian) -> Vec<f64> {
        negated(&jacobian.solve(&balance.level_slope(&self.compliance)))
    }

    /// Derivative of the first harmonic of the response that defines resonance (m per unit of the path) if the point moves along `direction`,
    /// and the level by `level` per unit of the path.
    #[must_use]
    pub fn response_rate(
        &self,
        balance: &Balance<'_>,
        jacobian: &Jacobian,
        direction: &Direction,
        level: f64,
    ) -> c64 {
        let deviation = jacobian.deviation(&direction.r);
        let rate = LoadRate {
            deviation: &deviation,
            omega: direction.omega,
            level,
        };
        balance.response_rate(&self.compliance, &self.motion, &rate)
    }
}

pub(in crate::hb) fn negated(x: &[f64]) -> Vec<f64> {
    x.iter().map(|x| -x).collect()
}
