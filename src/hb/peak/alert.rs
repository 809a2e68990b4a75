//! Error alert: how much would the harmonics left out change the amplitude?
//!
//! The solution is repeated with twice its harmonics, and twice the change of the amplitude is the error stated: harmonics
//! beyond change it as much again where the error falls at least as the inverse of the harmonics. Amplitudes on other sets, where
//! they are known, tell it by the same law.
//! One Newton step onto them, as in the Jacobian Alert Algorithm of Gastaldi & Berruti 2017, is no substitute: it misses what a
//! resonance of the strip adds and alarms too much where the strip lifts off far. It is the first iteration of that solve,
//! and decides alone where it asks for many more harmonics.

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

/// Newton iterations onto twice the harmonics; those that lead there take 4 to 9.
const MOST_ITERATIONS: usize = 10;

/// Errors by one Newton step, over the threshold, from which more harmonics are needed whatever a solve would say.
const LOUD: f64 = 4.0;

/// Errors fall at least as this power of the highest harmonic: for the choice of the next set alone.
const DECAY: f64 = 2.0;

/// Residual on twice the harmonics over the dynamic displacement, per threshold: a hundred times what it leaves in the
/// amplitude is far below the threshold still.
const EXACT_ENOUGH: f64 = 1e-4;

/// The next larger set: 1.4 times the highest harmonic, so that twice the harmonics are two sets on, without gaps.
fn enlarged(highest: usize) -> usize {
    (7 * highest).div_ceil(5)
}

/// A problem on the harmonics of a solution and on larger sets, each discretised when it is first asked for.
#[derive(Debug)]
pub struct AlertSets<'s, 'p> {
    problem: &'p Problem<'p>,
    settings: &'s HbSettings,
    alert: AlertSettings,
    /// Highest harmonics of the sets that a solution may have, up to the highest one allowed.
    rungs: BTreeSet<usize>,
    /// These sets and those with twice their harmonics, by the highest harmonic.
    sets: Vec<(HarmonicSet, OnceCell<Balance<'p>>)>,
}

/// What a solution becomes with twice its harmonics.
#[derive(Debug)]
pub struct Outlook {
    /// Stated relative error of |ŷ|; infinite where nothing was found on twice the harmonics.
    pub error: f64,
    /// Whether a solve says so, not one Newton step.
    pub decided: bool,
    /// Where the step or the solve leads on twice the harmonics.
    pub point: Point,
    /// |ŷ| there (m), by a solve.
    pub amplitude: Option<f64>,
}

impl<'s, 'p> AlertSets<'s, 'p> {
    /// `problem` on `first` and on larger sets, unless the settings switch the alert off.
    #[must_use]
    pub fn new(
        problem: &'p Problem<'p>,
        first: &HarmonicSet,
        settings: &'s HbSettings,
    ) -> Option<Self> {
        let alert = settings.alert?;
        let mut highest = first.highest();
        let mut rungs = BTreeSet::from([highest]);
        while highest < alert.highest_harmonic {
            highest = enlarged(highest).min(alert.highest_harmonic);
            rungs.insert(highest);
        }
        let sizes: BTreeSet<usize> = rungs.iter().flat_map(|&rung| [rung, 2 * rung]).collect();
        let larger = sizes.into_iter().skip(1).map(HarmonicSet::up_to);
        let sets = [first.clone()].into_iter().chain(larger);
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

    /// The set with twice the harmonics of set `i`, if that is one that a solution may have.
    #[must_use]
    pub fn twice(&self, i: usize) -> usize {
        let wanted = 2 * self.highest(i);
        self.sets.partition_point(|(set, _)| set.highest() < wanted)
    }

    /// Sets up to twice the harmonics on which a solution of set `i` may be repeated, the smallest first.
    #[must_use]
    pub fn larger(&self, i: usize) -> Vec<usize> {
        let allowed = |j: &usize| self.rungs.contains(&self.highest(*j));
        (i + 1..=self.twice(i)).filter(allowed).collect()
    }

    /// The same, the one first that should do for a solution with this error, then larger and at last smaller ones.
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

    /// The outlook that starts with one Newton `step`: by a solve, unless the step asks for more harmonics and there are some.
    #[must_use]
    pub fn outlook(
        &self,
        i: usize,
        solution: &Iterate<'_>,
        step: Outlook,
        condition: Condition<'_>,
    ) -> Outlook {
        let loud = step.error > LOUD * self.alert.threshold;
        match loud && !self.above(i, step.error).is_empty() {
            true => step,
            false => self.decided(i, solution, step, condition),
        }
    }

    /// The `outlook` of `solution` on set `i` with its error by a solve.
    #[must_use]
    pub fn decided(
        &self,
        i: usize,
        solution: &Iterate<'_>,
        mut outlook: Outlook,
        condition: Condition<'_>,
    ) -> Outlook {
        if outlook.decided {
            return outlook;
        }
        let (from, to) = (self.balance(i), self.balance(self.twice(i)));
        let starts = [outlook.point.clone(), solution.point.padded(from, to)];
        let share = solution.point.dynamic_share(from).min(1.0);
        let enough = EXACT_ENOUGH * self.alert.threshold * share;
        let newton = self.settings.newton;
        let newton = NewtonSettings {
            tolerance: newton.tolerance.max(enough),
            max_iterations: newton.max_iterations.min(MOST_ITERATIONS),
            ..newton
        };
        let mut starts = starts.into_iter();
        let solved = starts.find_map(|start| solve(to, start, condition, newton).ok());
        outlook.decided = true;
        outlook.error = f64::INFINITY;
        if let Some(solved) = solved {
            let amplitude = solved.response(to).norm();
            let change = amplitude / solution.response(from).norm() - 1.0;
            outlook.error = self.error_by(i, self.twice(i), change);
            outlook.amplitude = Some(amplitude);
            outlook.point = solved.point;
        }
        outlook
    }

    /// The outlook of `solution` on set `i` by one Newton step onto twice its harmonics, under `condition`.
    #[must_use]
    pub fn step(&self, i: usize, solution: &Iterate<'_>, condition: Condition<'_>) -> Outlook {
        let twice = self.balance(self.twice(i));
        let (change, point) = step_on(self.balance(i), solution, twice, condition);
        self.problem.effort.add(WorkCount {
            iterations: 1,
            factorizations: 1,
        });
        let error = self.error_by(i, self.twice(i), change);
        Outlook {
            error: if error.is_nan() { f64::INFINITY } else { error },
            decided: false,
            point,
            amplitude: None,
        }
    }

    /// Stated relative error of |ŷ| on set `i` where the one on set `other` differs by `change`: errors fall at least as
    /// the inverse of the harmonics.
    #[must_use]
    pub fn error_by(&self, i: usize, other: usize, change: f64) -> f64 {
        let [here, other] = [i, other].map(|i| self.highest(i) as f64);
        change.abs() * other / (other - here).abs()
    }

    /// Whether an estimated error is no alarm.
    #[must_use]
    pub fn is_silent(&self, error: f64) -> bool {
        error <= self.alert.threshold
    }

    /// The solution with its stated error, if that is known.
    #[must_use]
    pub fn judged(&self, mut solution: Solution, error: f64) -> Solution {
        if solution.status == Status::Converged && !self.is_silent(error) {
            solution.status = Status::TruncationAboveThreshold;
        }
        solution.truncation_error = Some(error).filter(|error| error.is_finite());
        solution
    }
}

/// Relative change of |ŷ| by one Newton step from `solution` on `larger`, under `condition`, and where the step leads.
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
