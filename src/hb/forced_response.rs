//! Forced response at one level: at given frequencies, or as a continuous curve over a band.

use super::alert::AlertSets;
use super::balance::Balance;
use super::continuation::{BranchPoint, StepSettings, on_if, walk};
use super::ladder::Ladder;
use super::newton::{Condition, Iterate, WorkCount};
use super::problem::Problem;
use super::refine::{Kept, refined};
use super::resonance::Band;
use super::settings::HbSettings;
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
    let balance = ladder.full();
    let sets = AlertSets::new(problem, &settings.harmonics, settings);
    let kept = (Kept::Frequency, settings.newton);
    let mut sweep = Sweep::new(&ladder, settings.newton, level, direction);
    let solution = |&omega: &f64| match sweep.next(omega) {
        Ok((iterate, count)) => refined(balance, iterate.into(), sets.as_ref(), kept, count),
        Err((status, count)) => {
            let stuck = stuck_point(balance, omega, level);
            Solution::new(balance, &Iterate::new(balance, stuck), status, count)
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
    let sets = AlertSets::new(problem, &settings.harmonics, settings);
    let report = |iterate: &Iterate<'_>, count| {
        let solution = Solution::new(&balance, iterate, Status::Converged, count);
        let Some(sets) = &sets else {
            return solution;
        };
        let fixed = Condition::FixedFrequency;
        let outlook = sets.outlook(0, iterate, fixed);
        let outlook = sets.decided(0, iterate, outlook, fixed);
        sets.judged(solution, outlook.error)
    };
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
