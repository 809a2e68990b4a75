//! Error alert: how much would the harmonics left out change the amplitude?
//!
//! The solution is padded with zeros onto two larger harmonic sets and corrected by one Newton step on each. This is the
//! idea of the Jacobian Alert Algorithm of Gastaldi & Berruti 2017, more cautious: the changes of the amplitude do not
//! fall from set to set (the strip's resonances lie on some harmonics and not on others), so that one small change
//! proves nothing. Nor does one step always see what larger sets bring: where what it says is not far from the threshold, a
//! solve on the largest set decides.

use super::balance::Balance;
use super::newton::{Condition, Iterate, Point, WorkCount, newton_step, solve};
use super::problem::Problem;
use super::settings::{AlertSettings, HbSettings};
use super::solution::Solution;
use super::status::Status;
use crate::aft::AftSettings;
use crate::harmonics::HarmonicSet;
use std::cell::OnceCell;

/// Larger sets that the alert looks at.
const LOOKS: usize = 2;

/// The error over the way that the amplitude goes from set to set, and over its change by a solve. `cargo bench --bench
/// peaks -- certified` tells how often that is too little.
const CAUTION: f64 = 2.0;

/// Errors by Newton steps on all sets looked at, over the threshold, that leave open whether the true one is below it.
const OPEN: [f64; 2] = [0.2, 2.0];

/// The next larger set: about 1.6 times the highest harmonic, without gaps.
fn enlarged(highest: usize) -> usize {
    (highest + (highest * 3).div_ceil(5)).max(highest + 2)
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
    /// Smallest first; on the last, beyond the highest harmonic allowed, errors are estimated only.
    sets: Vec<(HarmonicSet, OnceCell<Balance<'p>>)>,
}

/// What a solution would become with more harmonics.
#[derive(Debug)]
pub struct Outlook {
    /// Cautious estimate of the relative error of |ŷ|.
    pub error: f64,
    /// Where one Newton step, or the solve, leads on each larger set, the next one first.
    pub steps: Vec<Point>,
    /// Work of the steps and the solve.
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
        let mut sets = vec![first.clone()];
        let mut highest = first.highest();
        while highest < alert.highest_harmonic {
            highest = enlarged(highest).min(alert.highest_harmonic);
            sets.push(HarmonicSet::up_to(highest));
        }
        sets.push(HarmonicSet::up_to(enlarged(highest)));
        Some(Self {
            problem,
            settings,
            alert,
            sets: sets.into_iter().map(|set| (set, OnceCell::new())).collect(),
        })
    }

    /// The problem on set `i`.
    #[must_use]
    pub fn balance(&self, i: usize) -> &Balance<'p> {
        let (set, balance) = &self.sets[i];
        balance.get_or_init(|| on(self.problem, set.clone(), self.settings))
    }

    /// Sets on which a solution of set `i` may be repeated, largest first: the change to the next one alone is seldom worth
    /// a solve.
    pub fn above(&self, i: usize) -> impl Iterator<Item = usize> {
        let last = (i + LOOKS).min(self.sets.len() - 2);
        (i + 1..=last).rev()
    }

    /// The outlook of `solution` on set `i`, with Newton steps under `condition`.
    #[must_use]
    pub fn outlook(&self, i: usize, solution: &Iterate<'_>, condition: Condition<'_>) -> Outlook {
        let sets = i + 1..self.sets.len().min(i + 1 + LOOKS);
        let looks: Vec<(f64, Point)> = sets
            .map(|to| step_on(self.balance(i), solution, self.balance(to), condition))
            .collect();
        let (mut way, mut last) = (0.0, 0.0);
        for (change, _) in &looks {
            way += (change - last).abs();
            last = *change;
        }
        Outlook {
            error: CAUTION * way,
            count: WorkCount {
                iterations: looks.len(),
                factorizations: looks.len(),
            },
            steps: looks.into_iter().map(|(_, point)| point).collect(),
        }
    }

    /// The `outlook` of `solution` on set `i` with its error by a solve on the largest of its sets, where the steps leave
    /// open what the alert should say.
    #[must_use]
    pub fn decided(
        &self,
        i: usize,
        solution: &Iterate<'_>,
        mut outlook: Outlook,
        condition: Condition<'_>,
    ) -> Outlook {
        let [low, high] = OPEN.map(|share| share * self.alert.threshold);
        let looks = outlook.steps.len();
        // a single look may see nothing by chance
        let low = if looks < LOOKS { 0.0 } else { low };
        let (to, open) = (i + looks, (low..=high).contains(&outlook.error));
        if let Some(step) = outlook.steps.last_mut().filter(|_| open) {
            let larger = self.balance(to);
            let solved = solve(larger, step.clone(), condition, self.settings.newton);
            // without a solution there, the worst of what was open
            outlook.error = high;
            if let Ok(solved) = outlook.count.tally(solved) {
                let amplitude = solution.response(self.balance(i)).norm();
                let change = solved.response(larger).norm() / amplitude - 1.0;
                outlook.error = CAUTION * change.abs();
                *step = solved.point;
            }
        }
        outlook
    }

    /// Whether an estimated error is no alarm.
    #[must_use]
    pub fn is_silent(&self, error: f64) -> bool {
        error <= self.alert.threshold
    }

    /// The solution with its estimated error.
    #[must_use]
    pub fn judged(&self, mut solution: Solution, error: f64) -> Solution {
        if solution.status == Status::Converged && !self.is_silent(error) {
            solution.status = Status::TruncationAboveThreshold;
        }
        solution.truncation_error = Some(error);
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
