//! Forced response at one level: at given frequencies, or as a continuous curve over a band.

use super::alert::{enlarged, pad, time_points, truncation_error};
use super::balance::Balance;
use super::continuation::{BranchPoint, StepSettings, on_if, walk};
use super::ladder::Ladder;
use super::newton::{Condition, Iterate, WorkCount, solve};
use super::problem::Problem;
use super::resonance::Band;
use super::settings::{AlertSettings, HbSettings};
use super::solution::Solution;
use super::status::Status;
use super::sweep::{Sweep, SweepDirection};
use super::track::stuck_point;

/// Largest step of a curve: 2 % of the amplitude, or 4 % of the band.
const CURVE_STEP: f64 = 0.02;
/// Points of a curve before giving up.
const MOST_STEPS: usize = 20_000;
/// Part of the band's lower end down to which an overhanging branch is followed.
const LOWEST: f64 = 0.5;

/// Solutions at the ascending frequencies `omega` (rad/s), in that order.
///
/// Where several solutions exist, the one that a slow sweep in the given direction meets; see [`super::sweep`]. With
/// an error alert every solution gets more harmonics until the truncation error is below the threshold.
#[must_use]
pub fn at_frequencies(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    omega: &[f64],
    direction: SweepDirection,
) -> Vec<Solution> {
    let ladder = Ladder::new(problem, settings);
    let alerts = alert_sets(problem, settings);
    let mut sweep = Sweep::new(&ladder, settings.newton, level, direction);
    let solution = |&omega: &f64| match sweep.next(omega) {
        Ok((iterate, count)) => refined(&alerts, iterate, settings, count),
        Err((status, count)) => {
            let stuck = stuck_point(&alerts[0], omega, level);
            Solution::new(&alerts[0], &Iterate::new(&alerts[0], stuck), status, count)
        }
    };
    match direction {
        SweepDirection::Upward => omega.iter().map(solution).collect(),
        SweepDirection::Downward => {
            let mut solutions: Vec<Solution> = omega.iter().rev().map(solution).collect();
            solutions.reverse();
            solutions
        }
    }
}

/// Solutions along the branch from the lower to the upper end of `band`; overhanging parts are included, also where
/// they leave the band at its lower end.
///
/// All on the harmonics of the settings; the truncation error is estimated, not reduced. If the branch cannot be
/// followed to its end, the last point has the status that says why.
#[must_use]
pub fn over_band(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    band: Band,
) -> Vec<Solution> {
    let balance = Balance::new(problem, settings.harmonics.clone(), settings.aft);
    let next = settings.alert.map(|_| larger(&balance, settings, None));
    let report =
        |iterate: &Iterate<'_>, count| finished(&balance, iterate, next.as_ref(), settings, count);
    let ladder = Ladder::new(problem, settings);
    let mut sweep = Sweep::new(&ladder, settings.newton, level, SweepDirection::Upward);
    let (first, count) = match sweep.next(band.low) {
        Ok(solved) => solved,
        Err((status, count)) => {
            let start = stuck_point(&balance, band.low, level);
            let iterate = Iterate::new(&balance, start);
            return vec![Solution::new(&balance, &iterate, status, count)];
        }
    };
    let mut solutions = vec![report(&first, count)];
    let steps = StepSettings {
        first: CURVE_STEP,
        largest: CURVE_STEP,
        max_steps: MOST_STEPS,
        ..StepSettings::for_band(band.width())
    };
    let (branch, _) = BranchPoint::new(&balance, first, steps.omega_scale, None, None);
    let end = walk(&balance, branch, settings.newton, steps, |_, point, _| {
        solutions.push(report(&point.iterate, WorkCount::default()));
        // An overhanging branch may leave the band at its lower end and come back.
        let omega = point.iterate.point.omega;
        on_if(LOWEST * band.low < omega && omega < band.high)
    });
    if end.status != Status::Converged {
        let last = &end.last.iterate;
        solutions.push(Solution::new(&balance, last, end.status, end.count));
    }
    solutions
}

/// The problem on the first harmonics and, with an alert, on each larger set up to the highest harmonic.
fn alert_sets<'p>(problem: &'p Problem<'p>, settings: &HbSettings) -> Vec<Balance<'p>> {
    let mut rungs = vec![Balance::new(
        problem,
        settings.harmonics.clone(),
        settings.aft,
    )];
    let Some(AlertSettings {
        highest_harmonic, ..
    }) = settings.alert
    else {
        return rungs;
    };
    while let Some(top) = rungs
        .last()
        .filter(|top| top.harmonics.highest() < highest_harmonic)
    {
        rungs.push(larger(top, settings, Some(highest_harmonic)));
    }
    // One more, on which the error of the highest is estimated.
    if let Some(top) = rungs.last() {
        rungs.push(larger(top, settings, None));
    }
    rungs
}

fn larger<'p>(balance: &Balance<'p>, settings: &HbSettings, cap: Option<usize>) -> Balance<'p> {
    let harmonics = enlarged(&balance.harmonics, cap);
    let aft = time_points(settings.aft, &harmonics);
    Balance::new(balance.problem, harmonics, aft)
}

/// Adds harmonics until the truncation error is below the threshold.
fn refined<'p>(
    sets: &[Balance<'p>],
    mut iterate: Iterate<'p>,
    settings: &HbSettings,
    mut count: WorkCount,
) -> Solution {
    for (rung, next) in sets.iter().zip(&sets[1..]) {
        let solution = finished(rung, &iterate, Some(next), settings, count);
        let is_top = next.harmonics.highest() == sets[sets.len() - 1].harmonics.highest();
        if solution.status == Status::Converged || is_top {
            return solution;
        }
        let start = pad(rung, &iterate.point, next);
        match solve(next, start, Condition::FixedFrequency, settings.newton) {
            Ok((better, work)) => {
                count += work;
                iterate = better;
            }
            // The smaller set has a solution whose error is known; the larger one has none.
            Err(_) => return solution,
        }
    }
    finished(&sets[0], &iterate, None, settings, count)
}

/// A solved iterate with its truncation error, estimated on `next`.
fn finished(
    balance: &Balance<'_>,
    iterate: &Iterate<'_>,
    next: Option<&Balance<'_>>,
    settings: &HbSettings,
    count: WorkCount,
) -> Solution {
    let mut solution = Solution::new(balance, iterate, Status::Converged, count);
    if let (Some(alert), Some(next)) = (settings.alert, next) {
        let error = truncation_error(balance, iterate, next, Condition::FixedFrequency);
        solution.truncation_error = Some(error);
        let alarming = error.is_nan() || error > alert.threshold;
        if alarming && solution.status == Status::Converged {
            solution.status = Status::TruncationAboveThreshold;
        }
    }
    solution
}
