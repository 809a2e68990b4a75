//! A point in the space of unknowns with everything evaluated there: forces, residual, motion, and what follows from them.

use super::point::{Direction, Point};
use crate::aft::{Accuracy, Want};
use crate::hb::equations::balance::{Balance, ContactResponse, LoadRate, Motion};
use crate::hb::equations::jacobian::{EXACT, Jacobian};
use crate::hb::structure::compliance::Compliance;
use faer::prelude::c64;
use std::sync::Arc;

/// A point with everything evaluated there.
#[derive(Debug)]
pub struct Iterate<'p> {
    /// The point.
    pub point: Point,
    /// Compliances at its frequency, shared by the iterates of one frequency.
    pub compliance: Arc<Compliance<'p>>,
    /// Contact forces and tangents.
    pub contact: ContactResponse,
    /// R.
    pub residual: Vec<f64>,
    /// Motion of the structure.
    pub motion: Motion,
}

/// Residual over the motion below which contact forces decide a result: a draft in single precision leaves a few 1e-6
/// there, so that no draft is ever taken for a solution by a tolerance that is finer.
pub const DRAFT_RESIDUAL: f64 = 1e-4;

/// Tolerance of linear solves over the residual that Newton's method starts from ("forcing term"). What the step leaves,
/// about the square of the residual, is then not raised.
/// Source: Eisenstat & Walker 1996, SIAM J. Sci. Comput. 17, 16–32.
const FORCING: f64 = 0.1;
/// Largest such tolerance.
const LOOSEST: f64 = 1e-3;

impl<'p> Iterate<'p> {
    /// Evaluates everything at `point`.
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
        Self::evaluated(balance, point, compliance, Accuracy::Full)
    }

    /// Evaluates everything at `point`, to steer an iteration: where the residual is large the contact forces are a draft,
    /// if the balance's backend gives one.
    #[must_use]
    pub fn draft(balance: &Balance<'p>, point: Point) -> Self {
        let compliance = Arc::new(balance.compliance(point.omega));
        let iterate = Self::evaluated(balance, point, compliance, Accuracy::Draft);
        if iterate.contact.accuracy == Accuracy::Full || iterate.is_far(balance) {
            return iterate;
        }
        Self::evaluated(balance, iterate.point, iterate.compliance, Accuracy::Full)
    }

    /// Whether the residual is large against the motion, of which the forces of the stuck structure may cancel much.
    fn is_far(&self, balance: &Balance<'_>) -> bool {
        let stuck = balance.stuck_size(&self.compliance, self.point.level);
        let floor = stuck.max(balance.problem.displacement_scale(self.point.level));
        let motion = self.point.r.iter().fold(floor, |m, r| m.max(r.abs()));
        self.residual
            .iter()
            .any(|r| r.abs() > DRAFT_RESIDUAL * motion)
            && self.residual.iter().all(|r| r.is_finite())
    }

    fn evaluated(
        balance: &Balance<'p>,
        point: Point,
        compliance: Arc<Compliance<'p>>,
        accuracy: Accuracy,
    ) -> Self {
        let contact = balance.contact(&point.r, Want::ForcesAndTangents, accuracy);
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

    /// Largest residual component over the fixed displacement scale.
    #[must_use]
    pub fn relative_residual(&self, balance: &Balance<'_>) -> f64 {
        let scale = balance.problem.displacement_scale(self.point.level);
        let largest = self.residual.iter().map(|r| r.abs()).fold(0.0, f64::max);
        if self.residual.iter().all(|r| r.is_finite()) {
            largest / scale
        } else {
            f64::NAN
        }
    }

    /// The Jacobian here. Its solves are as exact as a step from here can use, and exact where the residual is round-off.
    #[must_use]
    pub fn jacobian<'a>(&'a self, balance: &'a Balance<'p>) -> Jacobian<'a> {
        let size = self.relative_residual(balance) / self.point.dynamic_share(balance).min(1.0);
        // a residual that is no number asks for nothing
        let tolerance = if size > 0.0 { FORCING * size } else { EXACT };
        self.jacobian_within(balance, tolerance.clamp(EXACT, LOOSEST))
    }

    /// The same with solves that leave `tolerance` of the forces.
    #[must_use]
    pub fn jacobian_within<'a>(&'a self, balance: &'a Balance<'p>, tolerance: f64) -> Jacobian<'a> {
        Jacobian::new(
            &balance.layout,
            balance.problem,
            &self.compliance,
            &self.contact.active,
            tolerance,
        )
    }

    /// First harmonic of response 0.
    #[must_use]
    pub fn response(&self, balance: &Balance<'_>) -> c64 {
        balance
            .problem
            .model
            .part(1)
            .responses(&self.motion.dynamic[0])[0]
    }

    /// dr/dω along the solution branch: −J⁻¹ R_ω.
    #[must_use]
    pub fn frequency_rate(&self, balance: &Balance<'_>, jacobian: &Jacobian<'_>) -> Vec<f64> {
        let slope = balance.frequency_slope(&self.compliance, &self.motion);
        negated(&jacobian.solve(&slope))
    }

    /// dr/dlevel at a fixed frequency: −J⁻¹ R_level.
    #[must_use]
    pub fn level_rate(&self, balance: &Balance<'_>, jacobian: &Jacobian<'_>) -> Vec<f64> {
        negated(&jacobian.solve(&balance.level_slope(&self.compliance)))
    }

    /// Rate of response 0 when the point moves along `direction` (and the level along `level`).
    #[must_use]
    pub fn response_rate(
        &self,
        balance: &Balance<'_>,
        jacobian: &Jacobian<'_>,
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
