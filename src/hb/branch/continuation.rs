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
    /// Distance between a prediction and its solution, over the length of the step, above which a step is repeated with
    /// half its length: it may have jumped to another part of the branch.
    pub closeness: f64,
    /// Where a step is predicted to lead.
    pub predictor: Predictor,
}

/// How a step continues a branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Predictor {
    /// Along the tangent.
    Tangent,
    /// Along the parabola through the step before: fewer iterations where steps are short against the bends of the branch.
    Parabola,
}

impl StepSettings {
    /// Steps for a band of the width `band` (rad/s).
    #[must_use]
    pub fn for_band(band: f64) -> Self {
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

/// Longest step over a fold of the frequency: a longer one may have jumped across the resonance instead.
const FOLD_STEP: f64 = 0.1;
/// Steps so short that they do not jump, whatever a corner makes of their prediction.
const SURE_STEP: f64 = 0.02;
/// Length of the step over a corner of the branch, tried where longer ones failed, and distance from the tangents of both
/// legs, over it, up to which a solution lies on a leg.
const CORNER: f64 = 1e-4;
const LEG: f64 = 0.2;
/// Residual over the length of a step: what a short step around a sharp bend of the branch must not lose in it.
const STEP_SHARE: f64 = 1e-3;
/// Steps after which the pace of a walk is judged.
const PACE_STEPS: usize = 200;
/// Share of failed steps, and mean step over the largest one, of a walk on the spot: both must be met. A walk without
/// hope fails every other step; of some 750 walks of the tests the worst 200 steps had 0.25 failures (measured).
const PACE_FAILED: f64 = 0.4;
const PACE_COVERED: f64 = 0.1;

/// How the steps since the last judgement went.
#[derive(Debug, Default)]
struct Pace {
    steps: usize,
    failed: usize,
    covered: f64,
}

impl Pace {
    /// Counts a step, `None` if it failed, and says whether the walk is on the spot.
    fn is_hopeless(&mut self, step: Option<f64>, largest: f64) -> bool {
        self.steps += 1;
        self.failed += usize::from(step.is_none());
        self.covered += step.unwrap_or(0.0);
        if self.steps < PACE_STEPS {
            return false;
        }
        let steps = PACE_STEPS as f64;
        let now = std::mem::take(self);
        now.failed as f64 > PACE_FAILED * steps && now.covered < PACE_COVERED * steps * largest
    }
}

/// The step that led to a point, as its parabola continues it.
struct Behind {
    /// Change of the tangent over the step, per step.
    turn: Direction,
    /// Length as the point that it led to measures it.
    length: f64,
}

impl Behind {
    /// The step of the length `length` from `from` to `to`.
    fn new(
        balance: &Balance<'_>,
        from: &BranchPoint<'_>,
        to: &BranchPoint<'_>,
        length: f64,
    ) -> Self {
        let stretch = from.length_at(balance, to, length);
        let turn = |a: f64, b: f64| stretch * b - length * a;
        let (a, b) = (&from.tangent, &to.tangent);
        Self {
            turn: Direction {
                r: a.r.iter().zip(&b.r).map(|(a, b)| turn(*a, *b)).collect(),
                omega: turn(a.omega, b.omega),
            },
            length: stretch,
        }
    }

    /// Where a step of the length `step` from `at` leads.
    fn predicted(&self, at: &BranchPoint<'_>, step: f64) -> Point {
        let share = step / self.length;
        let straight = at.iterate.point.moved(&at.tangent, step);
        straight.moved(&self.turn, 0.5 * share * share)
    }
}

/// Why a walk along a branch ended.
#[derive(Debug)]
pub struct WalkEnd<'p> {
    /// `Converged` if the visitor ended it.
    pub status: Status,
    /// Where it ended.
    pub last: BranchPoint<'p>,
}

/// Walks along the branch from `start`; `visit` is given every point left behind, the new one and the length
/// of the step between them as the point left behind measures it, and says whether to go on and how long the next step may be. A walk on the spot ends as one whose steps become too small.
pub fn walk<'p>(
    balance: &Balance<'p>,
    start: BranchPoint<'p>,
    newton: NewtonSettings,
    steps: StepSettings,
    mut visit: impl FnMut(BranchPoint<'p>, &BranchPoint<'p>, f64) -> ControlFlow<(), f64>,
) -> WalkEnd<'p> {
    let mut walk = Walk::new(balance, start, newton, steps);
    for _ in 0..steps.max_steps {
        let landing = match walk.attempt() {
            Ok(Some(landing)) => landing,
            Ok(None) => continue,
            Err(status) => return walk.end(status),
        };
        let (length, iterations) = (landing.length, landing.iterations);
        let Some(before) = walk.advance(landing) else {
            continue;
        };
        let longest = match visit(before, &walk.point, length) {
            ControlFlow::Continue(longest) => longest,
            ControlFlow::Break(()) => return walk.end(Status::Converged),
        };
        if walk.pace.is_hopeless(Some(length), steps.largest) {
            return walk.end(Status::StepTooSmall);
        }
        let ease = WANTED_ITERATIONS / iterations.max(1) as f64;
        walk.length = (length * ease.clamp(0.5, 2.0))
            .min(steps.largest)
            .min(longest.max(steps.smallest));
    }
    walk.end(Status::MaxIterations)
}

/// A walk under way.
struct Walk<'b, 'p> {
    balance: &'b Balance<'p>,
    newton: NewtonSettings,
    steps: StepSettings,
    /// Where it is, and the length of the next step.
    point: BranchPoint<'p>,
    length: f64,
    /// The step that led there, where the next one continues it.
    behind: Option<Behind>,
    /// A solution far from its prediction: taken after all where no shorter step is solved.
    aside: Option<Landing<'p>>,
    pace: Pace,
}

/// Where a step leads.
struct Landing<'p> {
    iterate: Iterate<'p>,
    /// Length of the step.
    length: f64,
    /// Newton iterations, as those of the next step.
    iterations: usize,
    /// Direction past a corner; along the tangent without.
    turned: Option<Direction>,
}

impl<'b, 'p> Walk<'b, 'p> {
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
            behind: None,
            aside: None,
            pace: Pace::default(),
        }
    }

    /// Newton's method for a step of today's length.
    fn sharp_newton(&self) -> NewtonSettings {
        let share = self.point.iterate.point.dynamic_share(self.balance);
        let sharp = STEP_SHARE * self.length * share;
        NewtonSettings {
            tolerance: self.newton.tolerance.min(sharp),
            ..self.newton
        }
    }

    /// Tries a step; none if it is to be repeated with a shorter length.
    ///
    /// # Errors
    /// Why the walk ends.
    fn attempt(&mut self) -> Result<Option<Landing<'p>>, Status> {
        let (balance, length) = (self.balance, self.length);
        let predicted = match &self.behind {
            Some(behind) => behind.predicted(&self.point, length),
            None => self.point.iterate.point.moved(&self.point.tangent, length),
        };
        let newton = self.sharp_newton();
        let meter = Meter::new(&balance.problem.effort);
        let solved = (self.point).step_to(balance, predicted.clone(), length, newton);
        let iterate = match solved {
            Ok(iterate) => iterate,
            Err(status) => return self.after_failure(status),
        };
        let apart = distance(balance, &iterate.point, &predicted);
        let landing = Landing {
            iterate,
            length,
            iterations: meter.read().iterations,
            turned: None,
        };
        if length > SURE_STEP && apart > self.steps.closeness * length {
            self.aside = Some(landing);
            self.length *= 0.5;
            return Ok(None);
        }
        Ok(Some(landing))
    }

    /// What is left where a step was not solved, as [`Self::attempt`] gives it.
    fn after_failure(&mut self, status: Status) -> Result<Option<Landing<'p>>, Status> {
        let is_spent = status == Status::BudgetSpent;
        self.length *= 0.5;
        // elsewhere what the time points make ragged would pass for corners
        let has_corners = self.balance.events() == Events::Located;
        let may_turn = (0.5 * CORNER..CORNER).contains(&self.length) && has_corners;
        if may_turn && !is_spent {
            let newton = self.sharp_newton();
            let turned = past_corner(self.balance, &self.point, newton);
            if let Some((iterate, direction)) = turned {
                return Ok(Some(Landing {
                    iterate,
                    length: CORNER,
                    iterations: WANTED_ITERATIONS as usize,
                    turned: Some(direction),
                }));
            }
        }
        let is_hopeless = self.pace.is_hopeless(None, self.steps.largest);
        if !(is_spent || is_hopeless || self.length < self.steps.smallest) {
            return Ok(None);
        }
        match self.aside.take_if(|_| !is_spent) {
            // the next step is to be a short one
            Some(far) => Ok(Some(Landing {
                iterations: self.newton.max_iterations,
                ..far
            })),
            None => Err(of_failed_step(status)),
        }
    }

    /// Goes to where a step has led and gives the point before, unless the step is to be repeated with half its length: a
    /// long one over a fold.
    fn advance(&mut self, landing: Landing<'p>) -> Option<BranchPoint<'p>> {
        let (balance, length) = (self.balance, landing.length);
        let forward = landing.turned.as_ref().unwrap_or(&self.point.tangent);
        let scale = self.steps.omega_scale;
        let next = BranchPoint::new(balance, landing.iterate, scale, None, Some(forward));
        let folds = next.tangent.omega * self.point.tangent.omega < 0.0;
        if folds && length > FOLD_STEP {
            self.length = 0.5 * length;
            return None;
        }
        self.aside = None;
        let before = std::mem::replace(&mut self.point, next);
        self.behind = match self.steps.predictor {
            // no parabola leads around a corner
            Predictor::Parabola if landing.turned.is_none() => {
                Some(Behind::new(balance, &before, &self.point, length))
            }
            Predictor::Parabola | Predictor::Tangent => None,
        };
        Some(before)
    }

    fn end(self, status: Status) -> WalkEnd<'p> {
        WalkEnd {
            status,
            last: self.point,
        }
    }
}

/// A solution past a corner of the branch at `at`, and the direction that leads to it. Where a contact begins or ceases to
/// slip the branch may turn by more than 90°: then no step along the tangent has a solution. The tangent of the other leg
/// is that of the equations a little further on, where the contact has its new state.
fn past_corner<'p>(
    balance: &Balance<'p>,
    at: &BranchPoint<'p>,
    newton: NewtonSettings,
) -> Option<(Iterate<'p>, Direction)> {
    let base = &at.iterate.point;
    let beyond = Iterate::new(balance, base.moved(&at.tangent, CORNER));
    let beyond = BranchPoint::new(balance, beyond, 1.0, Some(at.metric), None);
    let back = base.moved(&at.tangent, -CORNER);
    [1.0, -1.0].into_iter().find_map(|sign| {
        let tangent = beyond.tangent.scaled(sign);
        let predicted = base.moved(&tangent, CORNER);
        let condition = Condition::ArcLength {
            base,
            tangent: &tangent,
            step: CORNER,
            metric: at.metric,
        };
        let found = solve(balance, predicted.clone(), condition, newton).ok()?;
        let is_leg = distance(balance, &found.point, &predicted) <= LEG * CORNER
            && distance(balance, &found.point, &back) > LEG * CORNER;
        is_leg.then_some((found, tangent))
    })
}

/// The status of a walk whose last step failed with `status`.
fn of_failed_step(status: Status) -> Status {
    match status {
        Status::NonFinite | Status::BudgetSpent | Status::NoSteadyCycle => status,
        _ => Status::StepTooSmall,
    }
}

/// On with steps of any length, or the end of the walk.
pub fn on_if(go_on: bool) -> ControlFlow<(), f64> {
    match go_on {
        true => ControlFlow::Continue(f64::INFINITY),
        false => ControlFlow::Break(()),
    }
}
