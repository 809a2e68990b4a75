//! Solutions at given frequencies, as a slow sweep through a band meets them.

use super::forced_response::Response;
use super::gap::{Gap, Stop};
use super::level_problem::LevelProblem;
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::sweep::{SweepDirection, SweepSettings, follow};
use crate::hb::equations::effort::Counted;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::Ladder;
use crate::hb::newton::{Condition, Iterate, Point, polish, solve};
use crate::hb::peak::refine::{RefinementTarget, refined};
use crate::hb::settings::HbSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Band;
use std::ops::ControlFlow;

/// Largest relative change of the displacements per step of a sweep: a step must only stay on the branch.
const SWEEP_STEP: f64 = 0.3;
/// Largest change of the frequency per step, as a share of the band.
const SWEEP_ADVANCE: f64 = 0.1;

/// Frequencies at which the response to a slow sweep through a band is wanted.
#[derive(Debug, Clone, Copy)]
pub struct SlowSweep<'a> {
    /// The band. The sweep begins at one of its ends, whatever the frequencies are.
    pub band: Band,
    /// Direction of the sweep.
    pub direction: SweepDirection,
    /// Frequencies in the band, ascending (rad/s).
    pub omega: &'a [f64],
}

/// Solutions at the frequencies of `sweep`, ascending.
///
/// If several solutions exist at a frequency, the result is the one that a slow sweep meets; it does not depend on the other
/// frequencies of the list. Frequencies outside the band extend it. With an error alert every solution gets more harmonics
/// until the truncation error is not above the threshold. Frequencies beyond the point where the sweep stopped are met by the
/// opposite sweep. Frequencies that neither meets are solved one by one, each from its neighbour.
/// `progress` is given the share of the frequencies that sweeps have met.
#[must_use]
pub fn at_frequencies(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    sweep: SlowSweep<'_>,
    progress: impl Fn(f64),
) -> Response {
    let ladder = Ladder::new(problem, settings);
    let level = LevelProblem::new(problem, &ladder, settings, level);
    let mut answers = Answers::new(sweep);
    let stop = level.answered_by_sweep(sweep.direction, &mut answers, &progress);
    let mut gap = None;
    if let Some(stop) = stop {
        let opposite = sweep.direction.opposite();
        let other = (level.answered_by_sweep(opposite, &mut answers, &progress)).unwrap_or(Stop {
            omega: answers.nearest_to(stop.omega, opposite),
            status: Status::Converged,
        });
        gap = Some(match sweep.direction {
            SweepDirection::Upward => Gap {
                below: stop,
                above: other,
            },
            SweepDirection::Downward => Gap {
                below: other,
                above: stop,
            },
        });
    }
    if gap.is_some_and(|gap| !gap.is_answered() && !gap.has_spent_budget()) {
        level.solve_from_neighbours(sweep.direction, &mut answers);
    }
    // a sweep never meets a frequency that is not a number
    let status = stop.map_or(Status::NonFinite, |stop| stop.status);
    let solutions = (answers.found.into_iter().zip(sweep.omega))
        .map(|(found, &omega)| match found {
            Some(answer) => answer.solution,
            None => level.unsolved(omega, status),
        })
        .collect();
    Response::new(solutions, false, gap)
}

/// Frequencies asked for, and the solutions at those that a sweep has met.
struct Answers<'a> {
    band: Band,
    omega: &'a [f64],
    found: Vec<Option<Answer>>,
}

/// The result at one frequency.
struct Answer {
    solution: Counted<Solution>,
    /// The solution on the harmonics of the settings, if there is one.
    point: Option<Point>,
}

impl<'a> Answers<'a> {
    fn new(sweep: SlowSweep<'a>) -> Self {
        let [low, high] = [sweep.band.low, sweep.band.high];
        Self {
            band: Band {
                low: sweep.omega.iter().fold(low, |a, b| a.min(*b)),
                high: sweep.omega.iter().fold(high, |a, b| a.max(*b)),
            },
            omega: sweep.omega,
            found: sweep.omega.iter().map(|_| None).collect(),
        }
    }

    /// Numbers of the frequencies that a sweep has still to meet, the next one last.
    fn open(&self, direction: SweepDirection) -> Vec<usize> {
        let open = (0..self.omega.len()).filter(|&i| self.found[i].is_none());
        match direction {
            SweepDirection::Upward => open.rev().collect(),
            SweepDirection::Downward => open.collect(),
        }
    }

    /// The last frequency before `end` that a sweep in `direction` has met.
    fn nearest_to(&self, end: f64, direction: SweepDirection) -> f64 {
        let sign = direction.sign();
        (self.omega.iter().copied())
            .filter(|omega| sign * (end - omega) > 0.0)
            .max_by(|a, b| (sign * a).total_cmp(&(sign * b)))
            .unwrap_or(end)
    }
}

impl<'p> LevelProblem<'_, 'p> {
    /// Solves at the open frequencies that a sweep in `direction` meets. The result says where the sweep stopped, if that was
    /// before the last frequency.
    fn answered_by_sweep(
        &self,
        direction: SweepDirection,
        answers: &mut Answers<'_>,
        progress: &impl Fn(f64),
    ) -> Option<Stop> {
        let mut open = answers.open(direction);
        if open.is_empty() {
            return None;
        }
        let sign = direction.sign();
        let sweep = SweepSettings {
            band: answers.band,
            direction,
            largest_step: SWEEP_STEP,
            largest_advance: SWEEP_ADVANCE,
        };
        let first = match self.first(sweep) {
            Ok(first) => first,
            Err(stop) => return Some(stop),
        };
        let mut front = first.point.omega;
        if let Some(i) = open.pop_if(|i| answers.omega[*i] == front) {
            let again = Iterate::new(self.balance(), first.point.clone());
            answers.found[i] = Some(self.with_own_budget(|| self.raised(again)));
        }
        if open.is_empty() {
            return None;
        }
        let newton = self.settings.newton;
        let all = answers.omega.len() as f64;
        let end = follow(self.balance(), first, sweep, newton, |from, to| {
            let segment = BranchSegment::new(&from, to);
            let reached = self.answer(&segment, sign, &mut open, answers);
            front = sign * f64::max(sign * front, sign * reached);
            progress(1.0 - open.len() as f64 / all);
            match open.is_empty() {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        let status = end.status;
        (status != Status::Converged).then_some(Stop {
            omega: front,
            status,
        })
    }

    /// Solves at the `open` frequencies on the step `taken` of a sweep in the direction `sign`; gives the frequency that the step
    /// reaches.
    fn answer(
        &self,
        taken: &BranchSegment<'_, 'p>,
        sign: f64,
        open: &mut Vec<usize>,
        answers: &mut Answers<'_>,
    ) -> f64 {
        let (balance, newton) = (self.balance(), self.settings.newton);
        let tip = match taken.turns_back(sign) {
            true => taken.tip(balance, newton),
            false => None,
        };
        let to = tip.as_ref().unwrap_or(taken.to);
        let segment = BranchSegment::new(taken.from, to);
        let reached = to.iterate.point.omega;
        while let Some(i) = open.pop_if(|i| sign * (answers.omega[*i] - reached) <= 0.0) {
            let omega = answers.omega[i];
            answers.found[i] = Some(self.with_own_budget(|| {
                let located = (segment.crossing(balance, omega, newton))
                    .or_else(|status| segment.solved_from_ends(balance, omega, newton, status));
                match located {
                    Ok(iterate) => self.raised(iterate),
                    Err(status) => Answer {
                        solution: self.unsolved(omega, status),
                        point: None,
                    },
                }
            }));
        }
        reached
    }

    /// Solves at the frequencies that no sweep has met, one after the other in `direction`, each from the solution before. A
    /// ragged branch may have solutions at frequencies between which it cannot be followed.
    fn solve_from_neighbours(&self, direction: SweepDirection, answers: &mut Answers<'_>) {
        let (balance, fixed) = (self.balance(), Condition::FixedFrequency);
        for i in answers.open(direction).into_iter().rev() {
            let before = match direction {
                SweepDirection::Upward => i.checked_sub(1),
                SweepDirection::Downward => Some(i + 1),
            };
            let known = before.and_then(|j| answers.found.get(j)?.as_ref());
            let Some(point) = known.and_then(|answer| answer.point.clone()) else {
                continue;
            };
            let omega = answers.omega[i];
            let start = Point { omega, ..point };
            answers.found[i] = self.with_own_budget(|| {
                let iterate = solve(balance, start, fixed, self.settings.newton).ok()?;
                Some(self.raised(iterate))
            });
        }
    }

    /// The solution solved to round-off, and with as many harmonics as the alert asks for.
    fn raised(&self, iterate: Iterate<'p>) -> Answer {
        let iterate = polish(self.balance(), iterate);
        let point = Some(iterate.point.clone());
        let target = RefinementTarget::Frequency;
        let sets = self.sets.as_ref();
        let newton = self.settings.newton;
        let solution = refined(self.balance(), iterate.into(), sets, target, newton);
        Answer {
            solution: Counted {
                solution,
                work: self.meter.read(),
            },
            point,
        }
    }
}
