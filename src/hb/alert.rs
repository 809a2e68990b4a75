//! Error alert: how much would the harmonics left out change the amplitude?
//!
//! The solution is repeated with twice its harmonics, and [`CAUTION`] times the change of the amplitude is the error stated.
//! One Newton step onto them, as in the Jacobian Alert Algorithm of Gastaldi & Berruti 2017, is no substitute: it misses what a
//! resonance of the strip adds and alarms too much where the strip lifts off far. It is the first iteration of that solve,
//! and decides alone where it asks for many more harmonics.

use super::balance::Balance;
use super::newton::{Condition, Iterate, Point, WorkCount, newton_step, solve};
use super::problem::Problem;
use super::settings::{AlertSettings, HbSettings};
use super::solution::Solution;
use super::status::Status;
use crate::aft::AftSettings;
use crate::harmonics::HarmonicSet;
use std::cell::OnceCell;
use std::collections::BTreeSet;

/// The error stated over the change of the amplitude by twice the harmonics: these leave out the ones beyond, whose part is
/// at most as large where the error falls at least as the inverse of the harmonics.
pub const CAUTION: f64 = 2.0;

/// Errors by one Newton step, over the threshold, from which more harmonics are needed whatever a solve would say.
const LOUD: f64 = 4.0;

/// Errors fall at least as this power of the highest harmonic: for the choice of the next set alone.
const DECAY: f64 = 2.0;

/// The next larger set: 1.4 times the highest harmonic, so that twice the harmonics are two sets on, without gaps.
fn enlarged(highest: usize) -> usize {
    (7 * highest).div_ceil(5)
}

/// Time points that keep the sampling error of `harmonics` below the truncation error: at least 12 per period of the
/// highest harmonic, and never fewer than asked for.
#[must_use]
pub fn time_points(aft: AftSettings, harmonics: &HarmonicSet) -> AftSettings {
    let wanted = (12 * harmonics.highest()).next_power_of_two();
    AftSettings {
        n_time: aft.n_time.max(wanted),
        ..aft
    }
}

/// `problem` on the harmonics of the study, or on others with time points to match.
#[must_use]
pub fn on<'p>(
    problem: &'p Problem<'p>,
    harmonics: HarmonicSet,
    settings: &HbSettings,
) -> Balance<'p> {
    let aft = match harmonics == settings.harmonics {
        true => settings.aft,
        false => time_points(settings.aft, &harmonics),
    };
    Balance::new(problem, harmonics, aft)
}

/// The same motion on another harmonic set.
#[must_use]
pub fn pad(from: &Balance<'_>, point: &Point, to: &Balance<'_>) -> Point {
    Point {
        r: from
            .harmonics
            .convert(&point.r, from.layout.n_relative(), &to.harmonics),
        omega: point.omega,
        level: point.level,
    }
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
    /// Work spent.
    pub count: WorkCount,
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
        balance.get_or_init(|| on(self.problem, set.clone(), self.settings))
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

    /// Sets up to twice the harmonics on which a solution of set `i` with this error may be repeated, the one first that
    /// should do, then larger and at last smaller ones.
    #[must_use]
    pub fn above(&self, i: usize, error: f64) -> Vec<usize> {
        let allowed = |j: &usize| self.rungs.contains(&self.highest(*j));
        let sets: Vec<usize> = (i + 1..=self.twice(i)).filter(allowed).collect();
        let growth = libm::pow(error / self.alert.threshold, 1.0 / DECAY);
        let wanted = growth * self.highest(i) as f64;
        let enough = |&j: &usize| self.highest(j) as f64 >= wanted;
        let first = (sets.iter().position(enough)).unwrap_or(sets.len().saturating_sub(1));
        let (smaller, larger) = sets.split_at(first);
        larger.iter().chain(smaller.iter().rev()).copied().collect()
    }

    /// The outlook of `solution` on set `i`, with steps under `condition`: by a solve, unless one Newton step asks for more
    /// harmonics and there are some.
    #[must_use]
    pub fn outlook(&self, i: usize, solution: &Iterate<'_>, condition: Condition<'_>) -> Outlook {
        let look = self.look(i, solution, condition);
        let loud = look.error > LOUD * self.alert.threshold;
        match loud && !self.above(i, look.error).is_empty() {
            true => look,
            false => self.decided(i, solution, look, condition),
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
        let starts = [outlook.point.clone(), pad(from, &solution.point, to)];
        let solved = starts.into_iter().find_map(|start| {
            let solved = solve(to, start, condition, self.settings.newton);
            outlook.count.tally(solved).ok()
        });
        outlook.decided = true;
        outlook.error = f64::INFINITY;
        if let Some(solved) = solved {
            let ratio = solved.response(to).norm() / solution.response(from).norm();
            outlook.error = CAUTION * (ratio - 1.0).abs();
            outlook.point = solved.point;
        }
        outlook
    }

    /// One Newton step from `solution` on set `i` onto twice its harmonics.
    fn look(&self, i: usize, solution: &Iterate<'_>, condition: Condition<'_>) -> Outlook {
        let twice = self.balance(self.twice(i));
        let (change, point) = step_on(self.balance(i), solution, twice, condition);
        let error = CAUTION * change.abs();
        Outlook {
            error: if error.is_nan() { f64::INFINITY } else { error },
            decided: false,
            point,
            count: WorkCount {
                iterations: 1,
                factorizations: 1,
            },
        }
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
    let iterate = Iterate::new(larger, pad(balance, &solution.point, larger));
    let jacobian = iterate.jacobian(larger);
    let step = newton_step(larger, &iterate, &jacobian, condition);
    let rate = iterate.response_rate(larger, &jacobian, &step, 0.0);
    let corrected = (iterate.response(larger) + rate).norm();
    let point = iterate.point.moved(&step, 1.0);
    ((corrected - amplitude) / amplitude, point)
}
