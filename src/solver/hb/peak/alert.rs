//! Error alert: an estimate of how much the harmonics that were left out would change the amplitude.
//!
//! A solution on H harmonics is solved for again on 2H. The stated error is twice the change of the amplitude: the harmonics
//! beyond 2H change it as much again if the error falls at least as 1/H. If the amplitude on another harmonic set is known,
//! the same law gives the error from it.
//!
//! The error does not always fall: below a resonance of the parts in contact on their contact springs it may stay the same with
//! twice the harmonics. So what twice the harmonics accept is solved for on [`AlertSettings::compared_with`] harmonics, too,
//! if twice is fewer, and the larger of the two errors is stated.
//!
//! One Newton step onto 2H harmonics, as in the Jacobian Alert Algorithm of Gastaldi & Berruti 2017, does not replace the
//! solve. The step misses what a resonance of the strip adds, and its estimate is far too large where the strip lifts off
//! far. The step is the first iteration of the solve. It decides alone only where it asks for many more harmonics.

use crate::harmonics::HarmonicSet;
use crate::hb::equations::balance::{Balance, balance_on};
use crate::hb::equations::effort::WorkCount;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::{Condition, Iterate, Point, newton_step, solve};
use crate::hb::settings::{AlertSettings, HbSettings, NewtonSettings};
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use std::cell::OnceCell;
use std::collections::BTreeSet;

/// Most Newton iterations of a solve on more harmonics; the solves that converge take 4 to 9.
const MOST_ITERATIONS: usize = 10;

/// Undamped steps in a row that may fail to halve the shortest one before.
const PATIENCE: usize = 3;

/// If the error by one Newton step is more than this many thresholds, the step decides without a solve.
const STEP_DECIDES: f64 = 4.0;

/// The error is assumed to fall with this power of the highest harmonic. This serves only to choose the next harmonic set.
const DECAY: f64 = 2.0;

/// A solve on more harmonics ends with a Newton step that changes the dynamic displacements by less than this share of
/// the threshold, and the amplitude by less than the second share: what is left after the step is smaller.
const LAST_STEP: [f64; 2] = [0.25, 0.02];

/// Residual of a solve on more harmonics by damped steps, over the dynamic displacement of the solution and over the threshold. If the
/// amplitude is wrong by a hundred times this residual, that is a tenth of the threshold.
const EXACT_ENOUGH: f64 = 1e-3;

/// Highest harmonic of the next larger set: 1.4 times the highest one, so that twice the harmonics are two sets further.
fn enlarged(highest: usize) -> usize {
    (7 * highest).div_ceil(5)
}

/// Highest harmonics of the sets that a solution may have which starts with the harmonics up to `first`.
fn rungs(alert: AlertSettings, first: usize) -> BTreeSet<usize> {
    let mut highest = first;
    let mut rungs = BTreeSet::from([highest]);
    while highest < alert.highest_harmonic {
        highest = enlarged(highest).min(alert.highest_harmonic);
        rungs.insert(highest);
    }
    rungs
}

/// The highest harmonics in `rungs`, and those of the sets on which solutions on these rungs are compared.
fn sizes(alert: AlertSettings, rungs: &BTreeSet<usize>) -> BTreeSet<usize> {
    let compared = rungs.iter().map(|&rung| 2 * rung);
    let fewest = rungs.first().map(|&first| alert.most_compared(first));
    rungs
        .iter()
        .copied()
        .chain(compared)
        .chain(fewest)
        .collect()
}

/// All sets on which solutions are searched that start on `first`: this one, and larger ones, ascending, where there is an alert.
#[must_use]
pub fn searched_on(first: &HarmonicSet, alert: Option<AlertSettings>) -> Vec<HarmonicSet> {
    let larger = alert.into_iter().flat_map(|alert| {
        let sizes = sizes(alert, &rungs(alert, first.highest()));
        sizes.into_iter().skip(1).map(HarmonicSet::up_to)
    });
    [first.clone()].into_iter().chain(larger).collect()
}

/// A problem on the harmonics of a solution and on larger harmonic sets. Each set is discretised when it is first used.
#[derive(Debug)]
pub struct AlertSets<'s, 'p> {
    problem: &'p Problem<'p>,
    settings: &'s HbSettings,
    alert: AlertSettings,
    /// Highest harmonics of the sets that a solution may have, up to the highest harmonic of the settings.
    rungs: BTreeSet<usize>,
    /// These sets and those on which solutions on them are compared, ascending by the highest harmonic.
    sets: Vec<(HarmonicSet, OnceCell<Balance<'p>>)>,
}

/// Truncation error of a solution, estimated on larger harmonic sets.
#[derive(Debug)]
pub struct TruncationEstimate {
    /// Stated relative error of |ŷ|; infinite if no solution was found on a larger set.
    pub error: f64,
    /// Whether the error is by a solve; else it is by one Newton step onto twice the harmonics.
    pub by_solve: bool,
    /// Index of the set on which the solution was compared: the larger one, if there are two.
    pub set: usize,
    /// The solution on this set, or the point after the Newton step.
    pub point: Point,
    /// |ŷ| of the solution on this set (m); `None` without a solve, or if the solve failed.
    pub amplitude: Option<f64>,
}

impl<'s, 'p> AlertSets<'s, 'p> {
    /// `problem` on `first` and on larger sets; `None` if the settings switch the alert off.
    #[must_use]
    pub fn new(
        problem: &'p Problem<'p>,
        first: &HarmonicSet,
        settings: &'s HbSettings,
    ) -> Option<Self> {
        let alert = settings.alert?;
        let rungs = rungs(alert, first.highest());
        let sets = searched_on(first, Some(alert)).into_iter();
        Some(Self {
            problem,
            settings,
            alert,
            rungs,
            sets: sets.map(|set| (set, OnceCell::new())).collect(),
        })
    }

    /// The problem on set `i`.
    #[must_use]
    pub fn balance(&self, i: usize) -> &Balance<'p> {
        let (set, balance) = &self.sets[i];
        balance.get_or_init(|| balance_on(self.problem, set.clone(), self.settings))
    }

    fn highest(&self, i: usize) -> usize {
        self.sets[i].0.highest()
    }

    /// Index of the set with twice the harmonics of set `i`, which is one that a solution may have.
    #[must_use]
    pub fn twice(&self, i: usize) -> usize {
        self.with_at_least(2 * self.highest(i))
    }

    /// Index of the smallest set with at least so many harmonics.
    fn with_at_least(&self, harmonics: usize) -> usize {
        self.sets
            .partition_point(|(set, _)| set.highest() < harmonics)
    }

    /// Whether a solution may be accepted after it was compared with the one on set `i` alone.
    #[must_use]
    pub fn is_enough(&self, i: usize) -> bool {
        self.highest(i) >= self.alert.compared_with
    }

    /// Sets that may come after set `i`, up to twice its harmonics, the smallest first.
    #[must_use]
    pub fn larger(&self, i: usize) -> Vec<usize> {
        let allowed = |j: &usize| self.rungs.contains(&self.highest(*j));
        (i + 1..=self.twice(i)).filter(allowed).collect()
    }

    /// The same sets in the order in which they are tried for a solution with this error. First comes the set that should be
    /// large enough, then the larger ones, at last the smaller ones.
    #[must_use]
    pub fn above(&self, i: usize, error: f64) -> Vec<usize> {
        let sets = self.larger(i);
        let growth = libm::pow(error / self.alert.threshold, 1.0 / DECAY);
        let wanted = growth * self.highest(i) as f64;
        let enough = |&j: &usize| self.highest(j) as f64 >= wanted;
        let first = (sets.iter().position(enough)).unwrap_or(sets.len().saturating_sub(1));
        let (smaller, larger) = sets.split_at(first);
        larger.iter().chain(smaller.iter().rev()).copied().collect()
    }

    /// Estimate by one Newton step from `solution` on set `i` onto twice its harmonics, under `condition`.
    #[must_use]
    pub(crate) fn estimate_by_step(
        &self,
        i: usize,
        solution: &Iterate<'_>,
        condition: Condition<'_>,
    ) -> TruncationEstimate {
        let twice = self.twice(i);
        let (change, point) = step_on(self.balance(i), solution, self.balance(twice), condition);
        self.problem.effort.add(WorkCount {
            iterations: 1,
            factorizations: 1,
        });
        let error = self.error_by(i, twice, change);
        TruncationEstimate {
            error: if error.is_nan() { f64::INFINITY } else { error },
            by_solve: false,
            set: twice,
            point,
            amplitude: None,
        }
    }

    /// Estimate of the error of `solution` on set `i`, given the one `by_step`. That one is kept if it clearly asks for more
    /// harmonics and there are larger sets. Otherwise the estimate is by a solve.
    #[must_use]
    pub fn estimate(
        &self,
        i: usize,
        solution: &Iterate<'_>,
        by_step: TruncationEstimate,
        condition: Condition<'_>,
    ) -> TruncationEstimate {
        let is_clear = by_step.error > STEP_DECIDES * self.alert.threshold;
        match is_clear && !self.above(i, by_step.error).is_empty() {
            true => by_step,
            false => self.estimate_by_solve(i, solution, by_step, condition),
        }
    }

    /// Estimate of the error of `solution` on set `i` by a solve on twice its harmonics and, if these would accept it but are
    /// too few to do so, by a second one on as many as the settings ask for.
    #[must_use]
    pub(crate) fn estimate_by_solve(
        &self,
        i: usize,
        solution: &Iterate<'_>,
        known: TruncationEstimate,
        condition: Condition<'_>,
    ) -> TruncationEstimate {
        if known.by_solve {
            return known;
        }
        let on_twice = self.solved_on(self.twice(i), i, solution, known, condition);
        if self.is_enough(on_twice.set) || !self.is_accepted(on_twice.error) {
            return on_twice;
        }
        let (enough, error) = (self.with_at_least(self.alert.compared_with), on_twice.error);
        let on_enough = self.solved_on(enough, i, solution, on_twice, condition);
        TruncationEstimate {
            error: on_enough.error.max(error),
            ..on_enough
        }
    }

    /// Estimate of the error of `solution` on set `i` by a solve on the set `other`. The solve starts at the point of the
    /// estimate `known`; if that fails, at the solution itself.
    fn solved_on(
        &self,
        other: usize,
        i: usize,
        solution: &Iterate<'_>,
        known: TruncationEstimate,
        condition: Condition<'_>,
    ) -> TruncationEstimate {
        let (from, to) = (self.balance(i), self.balance(other));
        let start = known.point.padded(self.balance(known.set), to);
        let newton = self.newton_on_larger(solution.point.dynamic_share(from).min(1.0));
        let solved = self.undamped(to, start.clone(), condition).or_else(|| {
            let mut starts = [start.clone(), solution.point.padded(from, to)].into_iter();
            let solved = starts.find_map(|start| solve(to, start, condition, newton).ok())?;
            Some((solved.response(to).norm(), solved.point))
        });
        let amplitude = solved.as_ref().map(|(amplitude, _)| *amplitude);
        let change = |amplitude: f64| amplitude / solution.response(from).norm() - 1.0;
        TruncationEstimate {
            error: amplitude.map_or(f64::INFINITY, |a| self.error_by(i, other, change(a))),
            by_solve: true,
            set: other,
            point: solved.map_or(start, |(_, point)| point),
            amplitude,
        }
    }

    /// |ŷ| (m) and point of the solution of `balance` next to `start` by undamped Newton steps; `None` if [`PATIENCE`] of them
    /// in a row have not halved the shortest step before.
    fn undamped(
        &self,
        balance: &Balance<'_>,
        start: Point,
        condition: Condition<'_>,
    ) -> Option<(f64, Point)> {
        let effort = &self.problem.effort;
        let [displacement, amplitude] = LAST_STEP.map(|share| share * self.alert.threshold);
        let (mut point, mut shortest, mut worse) = (start, f64::INFINITY, 0);
        for _ in 0..MOST_ITERATIONS {
            if effort.is_spent() {
                return None;
            }
            let iterate = Iterate::new(balance, point);
            let jacobian = iterate.jacobian(balance);
            effort.spend(jacobian.factorizations());
            let step = newton_step(balance, &iterate, &jacobian, condition);
            let length = iterate.point.relative_step(balance, &step);
            worse = if length <= 0.5 * shortest {
                0
            } else {
                worse + 1
            };
            if length.is_nan() || worse == PATIENCE {
                return None;
            }
            shortest = shortest.min(length);
            let response = iterate.response(balance);
            let stepped = response + iterate.response_rate(balance, &jacobian, &step, 0.0);
            let is_last = length <= displacement
                && (stepped.norm() / response.norm() - 1.0).abs() <= amplitude;
            point = iterate.point.moved(&step, 1.0);
            if is_last && iterate.contact.steady {
                return Some((stepped.norm(), point));
            }
        }
        None
    }

    /// Newton's method for a solve on more harmonics than those of a solution whose dynamic displacement is `share` of the scale of
    /// the residual.
    fn newton_on_larger(&self, share: f64) -> NewtonSettings {
        let enough = EXACT_ENOUGH * self.alert.threshold * share;
        let newton = self.settings.newton;
        NewtonSettings {
            tolerance: newton.tolerance.max(enough),
            max_iterations: newton.max_iterations.min(MOST_ITERATIONS),
            ..newton
        }
    }

    /// Stated relative error of |ŷ| on set `i` if |ŷ| on set `other` differs by the relative `change`. The error is assumed to
    /// fall at least as the inverse of the highest harmonic.
    #[must_use]
    pub fn error_by(&self, i: usize, other: usize, change: f64) -> f64 {
        let [here, other] = [i, other].map(|i| self.highest(i) as f64);
        change.abs() * other / (other - here).abs()
    }

    /// Whether an estimated error is not above the threshold.
    #[must_use]
    pub(crate) fn is_accepted(&self, error: f64) -> bool {
        self.alert.accepts(error)
    }

    /// The solution with its stated truncation error, if that is known, and with the status that follows from the error.
    #[must_use]
    pub(crate) fn with_error(&self, mut solution: Solution, error: f64) -> Solution {
        if solution.status == Status::Converged && !self.is_accepted(error) {
            solution.status = Status::TruncationAboveThreshold;
        }
        solution.truncation_error = Some(error).filter(|error| error.is_finite());
        solution
    }
}

/// One Newton step from `solution` on `larger` harmonics, under `condition`: relative change of |ŷ|, and the point after the
/// step.
#[must_use]
pub fn step_on(
    balance: &Balance<'_>,
    solution: &Iterate<'_>,
    larger: &Balance<'_>,
    condition: Condition<'_>,
) -> (f64, Point) {
    let amplitude = solution.response(balance).norm();
    let iterate = Iterate::new(larger, solution.point.padded(balance, larger));
    let jacobian = iterate.jacobian(larger);
    let step = newton_step(larger, &iterate, &jacobian, condition);
    let rate = iterate.response_rate(larger, &jacobian, &step, 0.0);
    let corrected = (iterate.response(larger) + rate).norm();
    let point = iterate.point.moved(&step, 1.0);
    ((corrected - amplitude) / amplitude, point)
}
