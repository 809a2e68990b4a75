//! A point on a branch of the forced response, with the tangent of the branch.

use crate::hb::equations::balance::Balance;
use crate::hb::equations::effort::WorkCount;
use crate::hb::newton::{Condition, Direction, Iterate, Metric, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use faer::prelude::c64;

/// A solution with the tangent of its branch.
#[derive(Debug)]
pub struct BranchPoint<'p> {
    /// The solution.
    pub iterate: Iterate<'p>,
    /// Unit tangent in `metric`.
    pub tangent: Direction,
    /// Inner product in which lengths along the branch are measured, scaled to this point.
    pub metric: Metric,
    /// First harmonic ŷ of the response that defines resonance (m).
    pub response: c64,
    /// dŷ/ds along the tangent.
    pub response_rate: c64,
}

impl<'p> BranchPoint<'p> {
    /// `iterate` with the tangent along which the frequency increases. The inner product is scaled to this point and to `omega_scale`
    /// (rad/s).
    #[must_use]
    pub fn new(balance: &Balance<'p>, iterate: Iterate<'p>, omega_scale: f64) -> Self {
        let metric = Metric::at(balance, &iterate.point, omega_scale);
        Self::in_metric(balance, iterate, metric)
    }

    /// The same with an inner product that is given.
    #[must_use]
    pub(crate) fn in_metric(balance: &Balance<'p>, iterate: Iterate<'p>, metric: Metric) -> Self {
        let jacobian = iterate.jacobian(balance);
        let mut tangent = Direction {
            r: iterate.frequency_rate(balance, &jacobian),
            omega: 1.0,
        };
        let scale = 1.0 / metric.length(&tangent);
        tangent.r.iter_mut().for_each(|r| *r *= scale);
        tangent.omega *= scale;
        let response_rate = iterate.response_rate(balance, &jacobian, &tangent, 0.0);
        balance.problem.effort.add(WorkCount {
            iterations: 0,
            factorizations: jacobian.factorizations(),
        });
        drop(jacobian);
        let response = iterate.response(balance);
        Self {
            iterate,
            tangent,
            metric,
            response,
            response_rate,
        }
    }

    /// d ln|ŷ| / ds.
    #[must_use]
    pub fn growth(&self) -> f64 {
        (self.response.conj() * self.response_rate).re / self.response.norm_sqr()
    }

    /// d arg ŷ / ds.
    #[must_use]
    pub(crate) fn phase_rate(&self) -> f64 {
        (self.response.conj() * self.response_rate).im / self.response.norm_sqr()
    }

    /// The solution at the (signed) distance `step` along the tangent.
    ///
    /// # Errors
    /// The status of the failed correction.
    pub fn step(
        &self,
        balance: &Balance<'p>,
        step: f64,
        newton: NewtonSettings,
    ) -> Result<Iterate<'p>, Status> {
        let predicted = self.iterate.point.moved(&self.tangent, step);
        self.step_to(balance, predicted, step, newton)
    }

    /// The same; Newton's method starts at `predicted`.
    pub(in crate::hb) fn step_to(
        &self,
        balance: &Balance<'p>,
        predicted: Point,
        step: f64,
        newton: NewtonSettings,
    ) -> Result<Iterate<'p>, Status> {
        let base = &self.iterate.point;
        let condition = Condition::ArcLength {
            base,
            tangent: &self.tangent,
            step,
            metric: self.metric,
        };
        solve(balance, predicted, condition, newton)
    }

    /// Distance of another point from this one: along the tangent, and normal to it.
    #[must_use]
    pub fn distances(&self, other: &Point) -> [f64; 2] {
        let base = &self.iterate.point;
        let gone = Direction::between(base, other);
        let along = self.metric.dot(&gone, &self.tangent);
        let beside = self.metric.dot(&gone, &gone) - along * along;
        [along, beside.max(0.0).sqrt()]
    }

    /// The length `length`, in the metric of this point, as a length in the metric of `other`.
    #[must_use]
    pub(crate) fn length_at(&self, other: &Self, length: f64) -> f64 {
        length / self.metric.length(&other.tangent)
    }

    /// The same point with the tangent less than 90° from `previous`.
    #[must_use]
    pub(crate) fn following(self, previous: &Direction) -> Self {
        match self.metric.dot(previous, &self.tangent) < 0.0 {
            true => self.reversed(),
            false => self,
        }
    }

    /// The same point with the tangent towards higher frequencies if `sign` is positive, else towards lower ones.
    #[must_use]
    pub fn towards(self, sign: f64) -> Self {
        match self.tangent.omega * sign < 0.0 {
            true => self.reversed(),
            false => self,
        }
    }

    /// The same point with the tangent in the opposite direction.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.tangent.r.iter_mut().for_each(|r| *r = -*r);
        self.tangent.omega = -self.tangent.omega;
        self.response_rate = -self.response_rate;
        self
    }
}

/// Distance of two points relative to the dynamic displacements at `a`.
pub(in crate::hb) fn distance(balance: &Balance<'_>, a: &Point, b: &Point) -> f64 {
    let metric = Metric::at(balance, a, 1.0);
    metric.length(&Direction {
        omega: 0.0,
        ..Direction::between(b, a)
    })
}
