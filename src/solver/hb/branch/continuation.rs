//! Pseudo-arclength continuation of the forced response in frequency; passes folds.
//!
//! Source: Seydel, Practical Bifurcation and Stability Analysis, 3rd ed. 2010, ch. 4.

use super::branch_point::{BranchPoint, distance};
use crate::contact::Events;
use crate::hb::equations::balance::Balance;
use crate::hb::equations::effort::Meter;
use crate::hb::newton::{Condition, Direction, Iterate, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use std::ops::ControlFlow;

/// How steps are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    /// First step: relative change of the dynamic displacements.
    pub first: f64,
    /// Largest step.
    pub largest: f64,
    /// Smallest step before giving up.
    pub smallest: f64,
    /// Change of frequency that counts as much as a step of 1 (rad/s).
    pub omega_scale: f64,
    /// Steps before giving up.
    pub max_steps: usize,
    /// Largest distance between a prediction and its solution, over the length of the step. Beyond it a step is repeated with
    /// half its length: it may have jumped to another part of the branch.
    pub closeness: f64,
    /// How the end of a step is predicted.
    pub predictor: Predictor,
}

/// How the end of a step is predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Predictor {
    /// Along the tangent.
    Tangent,
    /// Along the parabola through the step before. Takes fewer iterations if steps are short against the bends of the branch.
    Parabola,
}

impl StepSettings {
    /// Steps for a band of the width `band` (rad/s).
    #[must_use]
    pub(crate) fn for_band(band: f64) -> Self {
        Self {
            first: 0.05,
            largest: 0.4,
            smallest: 1e-6,
            omega_scale: 2.0 * band,
            max_steps: 2000,
            closeness: f64::INFINITY,
            predictor: Predictor::Tangent,
        }
    }
}

/// Newton iterations per step that the step control aims at.
const WANTED_ITERATIONS: f64 = 4.0;

/// Longest step over a fold in frequency. A longer step may have jumped across the resonance instead.
const FOLD_STEP: f64 = 0.1;
/// Steps up to this length do not jump, even if a corner of the branch makes their prediction poor.
const SURE_STEP: f64 = 0.02;
/// Length of the step over a corner of the branch. It is tried after longer steps have failed.
const CORNER: f64 = 1e-4;
/// Lengths of the last steps over a corner, tried where steps have become too small: then the corner is next to the last point.
const LAST_CORNERS: [f64; 3] = [1e-4, 1e-5, 1e-6];
/// Largest distance of a solution from the tangent of a leg of the corner, over the length of the step, at which it lies on that leg.
const LEG: f64 = 0.2;
/// Residual over the length of a step: a short step around a sharp bend of the branch must be solved more exactly.
const STEP_SHARE: f64 = 1e-3;
/// Steps after which a continuation is checked for stalling.
const STALL_STEPS: usize = 200;
/// A continuation has stalled if more than this share of its steps failed, and if its mean step is below this share of the
/// largest step. A stalled continuation fails every other step; of some 750 continuations of the tests the worst 200 steps
/// had 0.25 failures (measured).
const STALL_FAILED: f64 = 0.4;
const STALL_COVERED: f64 = 0.1;

/// Steps since the last check for stalling.
#[derive(Debug, Default)]
struct StepTally {
    steps: usize,
    failed: usize,
    covered: f64,
}

impl StepTally {
    /// Counts a step, `None` if it failed, and says whether the continuation has stalled.
    fn has_stalled(&mut self, step: Option<f64>, largest: f64) -> bool {
        self.steps += 1;
        self.failed += usize::from(step.is_none());
        self.covered += step.unwrap_or(0.0);
        if self.steps < STALL_STEPS {
            return false;
        }
        let steps = STALL_STEPS as f64;
        let now = std::mem::take(self);
        now.failed as f64 > STALL_FAILED * steps && now.covered < STALL_COVERED * steps * largest
    }
}

/// The parabola that continues the step which led to a point.
struct Parabola {
    /// Change of the tangent over the step, per step.
    turn: Direction,
    /// Length of the step in the metric of the point that it led to.
    length: f64,
}

impl Parabola {
    /// The parabola through `to` that continues the step of the length `length` from `from` to `to`.
    fn new(from: &BranchPoint<'_>, to: &BranchPoint<'_>, length: f64) -> Self {
        let length_at_end = from.length_at(to, length);
        let turn = |a: f64, b: f64| length_at_end * b - length * a;
        let (a, b) = (&from.tangent, &to.tangent);
        Self {
            turn: Direction {
                r: a.r.iter().zip(&b.r).map(|(a, b)| turn(*a, *b)).collect(),
                omega: turn(a.omega, b.omega),
            },
            length: length_at_end,
        }
    }

    /// Predicted end of a step of the length `step` from `at`.
    fn predicted(&self, at: &BranchPoint<'_>, step: f64) -> Point {
        let share = step / self.length;
        let straight = at.iterate.point.moved(&at.tangent, step);
        straight.moved(&self.turn, 0.5 * share * share)
    }
}

/// Why a continuation ended.
#[derive(Debug)]
pub struct ContinuationEnd<'p> {
    /// [`Status::Converged`] if the visitor ended it.
    pub status: Status,
    /// The last point.
    pub last: BranchPoint<'p>,
}

/// Follows the branch from `start`. After every step `visit` is given the point before, the new point, and the length of the
/// step in the metric of the point before. It says whether to go on, and how long the next step may be.
///
/// A stalled continuation ends with [`Status::StepTooSmall`], as one whose steps become too small.
pub(crate) fn continue_branch<'p>(
    balance: &Balance<'p>,
    start: BranchPoint<'p>,
    newton: NewtonSettings,
    steps: StepSettings,
    mut visit: impl FnMut(BranchPoint<'p>, &BranchPoint<'p>, f64) -> ControlFlow<(), f64>,
) -> ContinuationEnd<'p> {
    let mut continuation = Continuation::new(balance, start, newton, steps);
    for _ in 0..steps.max_steps {
        let found = match continuation.attempt() {
            Ok(Some(found)) => found,
            Ok(None) => continue,
            Err(status) => return continuation.end(status),
        };
        let (length, iterations) = (found.length, found.iterations);
        let Some(before) = continuation.advance(found) else {
            continue;
        };
        let longest = match visit(before, &continuation.point, length) {
            ControlFlow::Continue(longest) => longest,
            ControlFlow::Break(()) => return continuation.end(Status::Converged),
        };
        if continuation.tally.has_stalled(Some(length), steps.largest) {
            return continuation.end(Status::StepTooSmall);
        }
        let ease = WANTED_ITERATIONS / iterations.max(1) as f64;
        continuation.length = (length * ease.clamp(0.5, 2.0))
            .min(steps.largest)
            .min(longest.max(steps.smallest));
    }
    continuation.end(Status::MaxIterations)
}

/// A continuation while it runs.
struct Continuation<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    steps: StepSettings,
    /// The last point.
    point: BranchPoint<'p>,
    /// Length of the next step.
    length: f64,
    /// Predictor of the next step; the tangent without.
    parabola: Option<Parabola>,
    /// A solution far from its prediction. It is accepted if no shorter step is solved.
    far_solution: Option<StepSolution<'p>>,
    tally: StepTally,
}

/// The solution at the end of a step.
struct StepSolution<'p> {
    iterate: Iterate<'p>,
    /// Length of the step.
    length: f64,
    /// Newton iterations that the step control uses for the length of the next step.
    iterations: usize,
    /// Direction past a corner; `None` if the step followed the tangent.
    turned: Option<Direction>,
}

impl<'b, 'p> Continuation<'b, 'p> {
    fn new(
        balance: &'b Balance<'p>,
        point: BranchPoint<'p>,
        newton: NewtonSettings,
        steps: StepSettings,
    ) -> Self {
        Self {
            balance,
            newton,
            steps,
            point,
            length: steps.first,
            parabola: None,
            far_solution: None,
            tally: StepTally::default(),
        }
    }

    /// Newton's method for a step of this length.
    fn sharp_newton(&self, length: f64) -> NewtonSettings {
        let share = self.point.iterate.point.dynamic_share(self.balance);
        let sharp = STEP_SHARE * length * share;
        NewtonSettings {
            tolerance: self.newton.tolerance.min(sharp),
            ..self.newton
        }
    }

    /// Tries a step; `None` if it is to be repeated with a shorter length.
    ///
    /// # Errors
    /// Why the continuation ends.
    fn attempt(&mut self) -> Result<Option<StepSolution<'p>>, Status> {
        let (balance, length) = (self.balance, self.length);
        let predicted = match &self.parabola {
            Some(parabola) => parabola.predicted(&self.point, length),
            None => self.point.iterate.point.moved(&self.point.tangent, length),
        };
        let newton = self.sharp_newton(length);
        let meter = Meter::new(&balance.problem.effort);
        let solved = (self.point).step_to(balance, predicted.clone(), length, newton);
        let iterate = match solved {
            Ok(iterate) => iterate,
            Err(status) => return self.after_failure(status),
        };
        let apart = distance(balance, &iterate.point, &predicted);
        let found = StepSolution {
            iterate,
            length,
            iterations: meter.read().iterations,
            turned: None,
        };
        if length > SURE_STEP && apart > self.steps.closeness * length {
            self.far_solution = Some(found);
            self.length *= 0.5;
            return Ok(None);
        }
        Ok(Some(found))
    }

    /// Continues after a step that was not solved; the result is that of [`Self::attempt`].
    fn after_failure(&mut self, status: Status) -> Result<Option<StepSolution<'p>>, Status> {
        let is_spent = status == Status::BudgetSpent;
        self.length *= 0.5;
        if (0.5 * CORNER..CORNER).contains(&self.length)
            && !is_spent
            && let Some(turned) = self.turned(CORNER)
        {
            return Ok(Some(turned));
        }
        let has_stalled = self.tally.has_stalled(None, self.steps.largest);
        if !(is_spent || has_stalled || self.length < self.steps.smallest) {
            return Ok(None);
        }
        let mut corners = LAST_CORNERS.iter().filter(|_| !is_spent);
        if let Some(turned) = corners.find_map(|&corner| self.turned(corner)) {
            return Ok(Some(turned));
        }
        match self.far_solution.take_if(|_| !is_spent) {
            // the next step is to be a short one
            Some(far) => Ok(Some(StepSolution {
                iterations: self.newton.max_iterations,
                ..far
            })),
            None => Err(of_failed_step(status)),
        }
    }

    /// The step of the length `corner` past a corner of the branch, if there is one.
    fn turned(&self, corner: f64) -> Option<StepSolution<'p>> {
        // without located events the branch is ragged, and that would be taken for corners
        if self.balance.events() != Events::Located {
            return None;
        }
        let newton = self.sharp_newton(corner);
        let (iterate, direction) = past_corner(self.balance, &self.point, corner, newton)?;
        Some(StepSolution {
            iterate,
            length: corner,
            iterations: WANTED_ITERATIONS as usize,
            turned: Some(direction),
        })
    }

    /// Accepts a step and gives the point before. A long step over a fold is not accepted: it is repeated with half its
    /// length.
    fn advance(&mut self, found: StepSolution<'p>) -> Option<BranchPoint<'p>> {
        let (balance, length) = (self.balance, found.length);
        let forward = found.turned.as_ref().unwrap_or(&self.point.tangent);
        let scale = self.steps.omega_scale;
        let next = BranchPoint::new(balance, found.iterate, scale).following(forward);
        let folds = next.tangent.omega * self.point.tangent.omega < 0.0;
        if folds && length > FOLD_STEP {
            self.length = 0.5 * length;
            return None;
        }
        self.far_solution = None;
        let before = std::mem::replace(&mut self.point, next);
        self.parabola = match self.steps.predictor {
            // no parabola continues the branch around a corner
            Predictor::Parabola if found.turned.is_none() => {
                Some(Parabola::new(&before, &self.point, length))
            }
            Predictor::Parabola | Predictor::Tangent => None,
        };
        Some(before)
    }

    fn end(self, status: Status) -> ContinuationEnd<'p> {
        ContinuationEnd {
            status,
            last: self.point,
        }
    }
}

/// A solution past a corner of the branch at `at`, at the distance `corner`, and the direction that leads to it.
///
/// If a contact begins or ceases to slip the branch may turn by more than 90°. Then no step along the tangent has a solution.
/// The tangent of the other leg is that of the equations a little further on, where the contact has its new state.
fn past_corner<'p>(
    balance: &Balance<'p>,
    at: &BranchPoint<'p>,
    corner: f64,
    newton: NewtonSettings,
) -> Option<(Iterate<'p>, Direction)> {
    let base = &at.iterate.point;
    let beyond = Iterate::new(balance, base.moved(&at.tangent, corner));
    let beyond = BranchPoint::in_metric(balance, beyond, at.metric);
    let back = base.moved(&at.tangent, -corner);
    [1.0, -1.0].into_iter().find_map(|sign| {
        let tangent = beyond.tangent.scaled(sign);
        let predicted = base.moved(&tangent, corner);
        let condition = Condition::ArcLength {
            base,
            tangent: &tangent,
            step: corner,
            metric: at.metric,
        };
        let found = solve(balance, predicted.clone(), condition, newton).ok()?;
        let is_leg = distance(balance, &found.point, &predicted) <= LEG * corner
            && distance(balance, &found.point, &back) > LEG * corner;
        is_leg.then_some((found, tangent))
    })
}

/// The status of a continuation whose last step failed with `status`.
fn of_failed_step(status: Status) -> Status {
    match status {
        Status::NonFinite | Status::BudgetSpent | Status::NoSteadyCycle => status,
        _ => Status::StepTooSmall,
    }
}

/// Continues with steps of any length, or ends the continuation.
pub(crate) fn on_if(go_on: bool) -> ControlFlow<(), f64> {
    match go_on {
        true => ControlFlow::Continue(f64::INFINITY),
        false => ControlFlow::Break(()),
    }
}
