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
    /// `iterate` with the tangent there. The tangent turns less than 90° from `previous`; without `previous` the frequency
    /// increases along it.
    ///
    /// Without `metric` the inner product is scaled to this point.
    #[must_use]
    pub fn new(
        balance: &Balance<'p>,
        iterate: Iterate<'p>,
        omega_scale: f64,
        metric: Option<Metric>,
        previous: Option<&Direction>,
    ) -> Self {
        let n = balance.layout.n_relative();
        let metric = metric.unwrap_or_else(|| Metric::at(balance, &iterate.point, omega_scale));
        let jacobian = iterate.jacobian(balance);
        let mut tangent = Direction {
            r: iterate.frequency_rate(balance, &jacobian),
            omega: 1.0,
        };
        let mut scale = 1.0 / metric.dot(n, &tangent, &tangent).sqrt();
        if previous.is_some_and(|p| metric.dot(n, p, &tangent) < 0.0) {
            scale = -scale;
        }
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
    pub fn phase_rate(&self) -> f64 {
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
    pub fn distances(&self, balance: &Balance<'_>, other: &Point) -> [f64; 2] {
        let base = &self.iterate.point;
        let gone = Direction {
            r: (other.r.iter().zip(&base.r)).map(|(a, b)| a - b).collect(),
            omega: other.omega - base.omega,
        };
        let n = balance.layout.n_relative();
        let along = self.metric.dot(n, &gone, &self.tangent);
        let beside = self.metric.dot(n, &gone, &gone) - along * along;
        [along, beside.max(0.0).sqrt()]
    }

    /// The length `length`, in the metric of this point, as a length in the metric of `other`.
    #[must_use]
    pub fn length_at(&self, balance: &Balance<'_>, other: &Self, length: f64) -> f64 {
        let n = balance.layout.n_relative();
        length / self.metric.dot(n, &other.tangent, &other.tangent).sqrt()
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
    let gone = Direction {
        r: a.r.iter().zip(&b.r).map(|(a, b)| a - b).collect(),
        omega: 0.0,
    };
    metric.dot(balance.layout.n_relative(), &gone, &gone).sqrt()
}
