//! Newton's method for the balance equations, at a fixed frequency or with the frequency as an unknown.
//!
//! The bordered system [J R_ω; c_r c_ω] is solved by block elimination with the two right-hand sides R and R_ω.

use super::damping::{Damping, is_shorter};
use super::iterate::{Iterate, negated};
use super::point::{Direction, Metric, Point};
use crate::hb::equations::balance::Balance;
use crate::hb::equations::jacobian::Jacobian;
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use faer::prelude::c64;
use std::sync::Arc;

/// What closes the system when the frequency is unknown.
#[derive(Debug, Clone, Copy)]
pub enum Condition<'a> {
    /// The frequency is given.
    FixedFrequency,
    /// The response that defines resonance is in phase with this unit phasor (phase resonance).
    PhaseLocked(c64),
    /// The response that defines resonance is `amplitude` times this unit phasor; the excitation level follows. A resonance is
    /// single-valued in its amplitude also where it is not in its level.
    Amplitude {
        /// Unit phasor.
        phasor: c64,
        /// Amplitude (m).
        amplitude: f64,
    },
    /// The step from `base` has the length `step` along `tangent` (pseudo-arclength).
    ArcLength {
        /// Start of the step.
        base: &'a Point,
        /// Unit tangent there.
        tangent: &'a Direction,
        /// Length of the step.
        step: f64,
        /// Inner product.
        metric: Metric,
    },
}

/// Phase error (rad) accepted at a phase resonance; it only starts the search of the maximum.
const PHASE_TOLERANCE: f64 = 1e-6;

/// Largest relative change of the frequency in one iteration.
const MAX_FREQUENCY_STEP: f64 = 0.02;

/// Largest relative change of the level in one iteration.
const MAX_LEVEL_STEP: f64 = 0.5;

/// Iterations within which the smallest residual must halve; a start that does not manage that never converged.
const PATIENCE: usize = 12;

/// Damping of the steps. The factor of a shortened step is about the one that the next step needs.
const DAMPING: Damping = Damping {
    smallest: 1.0 / 64.0,
    recovery: 16.0,
    caution: 2.0,
};

/// Residuals below this need no damping: the condition alone may still be open.
const NEAR: f64 = 1e-2;

/// Solves the balance equations under `condition`, starting at `start`.
///
/// # Errors
/// The status that says why not.
pub fn solve<'p>(
    balance: &Balance<'p>,
    start: Point,
    condition: Condition<'_>,
    settings: NewtonSettings,
) -> Result<Iterate<'p>, Status> {
    let effort = &balance.problem.effort;
    let mut iterations = 0;
    let mut iterate = Iterate::new(balance, start);
    let mut progress = Progress::default();
    let mut damping = 1.0;
    let tolerance = (settings.tolerance).max(balance.problem.round_off(iterate.point.level));
    loop {
        let size = iterate.relative_residual(balance);
        if !size.is_finite() {
            return Err(Status::NonFinite);
        }
        let open = condition
            .values(balance, &iterate)
            .iter()
            .any(|c| c.abs() > condition.tolerance());
        if size <= tolerance && !open {
            return match iterate.contact.steady {
                true => Ok(iterate),
                false => Err(Status::NoSteadyCycle),
            };
        }
        if iterate.point.omega <= 0.0 {
            // a step of a continuation that was too long
            return Err(Status::StepTooSmall);
        }
        if effort.is_spent() {
            return Err(Status::BudgetSpent);
        }
        if iterations == settings.max_iterations || (size > tolerance && progress.stalls(size)) {
            return Err(Status::MaxIterations);
        }
        (iterate, damping) = {
            let jacobian = iterate.jacobian(balance);
            effort.spend(jacobian.factorizations());
            iterations += 1;
            let linear = Linearized::new(balance, &iterate, &jacobian, condition);
            advance(&linear, damping)
        };
    }
}

/// Newton steps at the fixed frequency of a solved iterate for as long as each at least halves the residual: to
/// round-off, whatever the tolerance of the solve was.
#[must_use]
pub(crate) fn polish<'p>(balance: &Balance<'p>, solved: Iterate<'p>) -> Iterate<'p> {
    let mut iterate = solved;
    loop {
        let jacobian = iterate.jacobian(balance);
        let step = newton_step(balance, &iterate, &jacobian, Condition::FixedFrequency);
        balance.problem.effort.spend(jacobian.factorizations());
        let point = iterate.point.moved(&step, 1.0);
        let compliance = Arc::clone(&iterate.compliance);
        let trial = Iterate::with_compliance(balance, point, compliance);
        let (before, after) = (
            iterate.relative_residual(balance),
            trial.relative_residual(balance),
        );
        // A residual of exactly 0 ends it too.
        if after.is_nan() || after >= 0.5 * before {
            return iterate;
        }
        drop(jacobian);
        iterate = trial;
    }
}

/// The full Newton step of the (bordered) system at a fixed level.
#[must_use]
pub fn newton_step(
    balance: &Balance<'_>,
    iterate: &Iterate<'_>,
    jacobian: &Jacobian,
    condition: Condition<'_>,
) -> Direction {
    let linear = Linearized::new(balance, iterate, jacobian, condition);
    linear.step().direction
}

/// A Newton step with the change of the level.
struct NewtonStep {
    direction: Direction,
    level: f64,
}

impl NewtonStep {
    fn add(&mut self, factor: f64, other: &Self) {
        for (a, b) in self.direction.r.iter_mut().zip(&other.direction.r) {
            *a += factor * b;
        }
        self.direction.omega += factor * other.direction.omega;
        self.level += factor * other.level;
    }
}

/// The balance equations and their condition, linearised at one iterate.
struct Linearized<'a, 'p> {
    balance: &'a Balance<'p>,
    iterate: &'a Iterate<'p>,
    jacobian: &'a Jacobian,
    condition: Condition<'a>,
    /// −J⁻¹ R: the step at a fixed frequency.
    correction: Vec<f64>,
    /// Solutions of the linearised balance per change of the frequency and of the level, each with the rates of the
    /// condition, where the condition sets them free.
    free: Vec<(NewtonStep, [f64; 2])>,
}

impl<'a, 'p> Linearized<'a, 'p> {
    fn new(
        balance: &'a Balance<'p>,
        iterate: &'a Iterate<'p>,
        jacobian: &'a Jacobian,
        condition: Condition<'a>,
    ) -> Self {
        let (correction, by_omega) = match condition {
            Condition::FixedFrequency => (negated(&jacobian.solve(&iterate.residual)), None),
            Condition::Amplitude { .. }
            | Condition::PhaseLocked(_)
            | Condition::ArcLength { .. } => {
                let [correction, rate] = iterate.correction_and_frequency_rate(balance, jacobian);
                (correction, Some(rate))
            }
        };
        let by_omega = by_omega.map(|r| NewtonStep {
            direction: Direction { r, omega: 1.0 },
            level: 0.0,
        });
        let by_level = || NewtonStep {
            direction: Direction {
                r: iterate.level_rate(balance, jacobian),
                omega: 0.0,
            },
            level: 1.0,
        };
        let level_is_free = matches!(condition, Condition::Amplitude { .. });
        let free = by_omega.into_iter().chain(level_is_free.then(by_level));
        let mut linear = Self {
            balance,
            iterate,
            jacobian,
            condition,
            correction,
            free: Vec::new(),
        };
        linear.free = free
            .map(|step| {
                let rates = linear.rates(&step);
                (step, rates)
            })
            .collect();
        linear
    }

    fn rates(&self, step: &NewtonStep) -> [f64; 2] {
        let (direction, level) = (&step.direction, step.level);
        (self.condition).rates(self.balance, self.iterate, self.jacobian, direction, level)
    }

    /// The Newton step.
    fn step(&self) -> NewtonStep {
        let values = self.condition.values(self.balance, self.iterate);
        self.closed(self.correction.clone(), values)
    }

    /// The step that would follow at `trial` with the same Jacobian.
    fn following(&self, trial: &Iterate<'_>) -> NewtonStep {
        let correction = negated(&self.jacobian.solve(&trial.residual));
        self.closed(correction, self.condition.values(self.balance, trial))
    }

    /// The step with this `correction` at a fixed frequency that makes the `values` of the condition vanish, too.
    fn closed(&self, correction: Vec<f64>, values: [f64; 2]) -> NewtonStep {
        let [c1, c2] = values;
        let mut step = NewtonStep {
            direction: Direction {
                r: correction,
                omega: 0.0,
            },
            level: 0.0,
        };
        let [t1, t2] = self.rates(&step);
        let point = &self.iterate.point;
        let limit = MAX_FREQUENCY_STEP * point.omega;
        match &self.free[..] {
            [(by_omega, [a1, _])] => {
                step.add((-(c1 + t1) / a1).clamp(-limit, limit), by_omega);
            }
            [(by_omega, [a1, a2]), (by_level, [b1, b2])] => {
                let determinant = a1 * b2 - a2 * b1;
                let (e1, e2) = (-(c1 + t1), -(c2 + t2));
                let omega = (e1 * b2 - e2 * b1) / determinant;
                let level = (a1 * e2 - a2 * e1) / determinant;
                // the level must stay positive
                let largest = MAX_LEVEL_STEP * point.level;
                step.add(omega.clamp(-limit, limit), by_omega);
                step.add(level.clamp(-largest, largest), by_level);
            }
            _ => {}
        }
        step
    }
}

/// The smallest residuals of the running and the previous window of iterations.
struct Progress {
    iterations: usize,
    best: f64,
    best_before: f64,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            iterations: 0,
            best: f64::INFINITY,
            best_before: f64::INFINITY,
        }
    }
}

impl Progress {
    /// Whether the residual has not halved within the last window.
    fn stalls(&mut self, size: f64) -> bool {
        if self.iterations == 0 {
            self.best_before = size;
        }
        self.best = self.best.min(size);
        self.iterations += 1;
        if !self.iterations.is_multiple_of(PATIENCE) {
            return false;
        }
        let stalled = self.best > 0.5 * self.best_before;
        self.best_before = self.best;
        stalled
    }
}

/// Takes the Newton step times `first` or less, damped by natural monotonicity (`damping`); also returns the factor that the
/// next step tries first.
fn advance<'p>(linear: &Linearized<'_, 'p>, first: f64) -> (Iterate<'p>, f64) {
    let (balance, from) = (linear.balance, linear.iterate);
    let step = linear.step();
    let moving = step.direction.omega != 0.0;
    let metric = Metric::at(balance, &from.point, from.point.omega);
    let length = |step: &NewtonStep| metric.length(&step.direction);
    let trial = |factor: f64| {
        let mut point = from.point.moved(&step.direction, factor);
        point.level += factor * step.level;
        if moving {
            Iterate::new(balance, point)
        } else {
            Iterate::with_compliance(balance, point, Arc::clone(&from.compliance))
        }
    };
    DAMPING.damped(first, trial, |trial, factor| {
        let shorter = || {
            let following = linear.following(trial);
            is_shorter(length(&following), length(&step), factor)
        };
        trial.relative_residual(balance) <= NEAR || shorter()
    })
}

impl Condition<'_> {
    fn tolerance(self) -> f64 {
        match self {
            Self::FixedFrequency => f64::INFINITY,
            Self::PhaseLocked(_) | Self::Amplitude { .. } => PHASE_TOLERANCE,
            Self::ArcLength { step, .. } => 1e-6 * step.abs(),
        }
    }

    /// What must vanish; the second entry is used by [`Condition::Amplitude`] alone.
    fn values(self, balance: &Balance<'_>, iterate: &Iterate) -> [f64; 2] {
        match self {
            Self::FixedFrequency => [0.0; 2],
            Self::PhaseLocked(phasor) => {
                let y = iterate.response(balance);
                [(y * phasor.conj()).im / y.norm(), 0.0]
            }
            Self::Amplitude { phasor, amplitude } => {
                let y = iterate.response(balance) * phasor.conj() / amplitude;
                [y.im, y.re - 1.0]
            }
            Self::ArcLength {
                base,
                tangent,
                step,
                metric,
            } => {
                let gone = Direction::between(base, &iterate.point);
                [metric.dot(&gone, tangent) - step, 0.0]
            }
        }
    }

    fn rates(
        self,
        balance: &Balance<'_>,
        iterate: &Iterate<'_>,
        jacobian: &Jacobian,
        direction: &Direction,
        level: f64,
    ) -> [f64; 2] {
        let response_rate = || iterate.response_rate(balance, jacobian, direction, level);
        match self {
            Self::FixedFrequency => [0.0; 2],
            Self::PhaseLocked(phasor) => {
                let rate = response_rate() * phasor.conj();
                [rate.im / iterate.response(balance).norm(), 0.0]
            }
            Self::Amplitude { phasor, amplitude } => {
                let rate = response_rate() * phasor.conj() / amplitude;
                [rate.im, rate.re]
            }
            Self::ArcLength {
                tangent, metric, ..
            } => [metric.dot(direction, tangent), 0.0],
        }
    }
}
