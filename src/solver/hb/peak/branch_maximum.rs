//! A higher maximum on the branch through one that was found.
//!
//! A search leads to one maximum of the amplitude. Where contacts open, or the track of a mode is lost, a higher one may lie on the
//! same branch. So the branch is followed from the maximum to both ends of the band, and searched on both sides close to it. A branch that
//! cannot be followed to both ends may be one of several: then the band is swept, too.

use super::band::{SWEEP_STEP, swept_maximum};
use super::predicted::on_harmonics;
use super::refine::refined_maximum;
use super::search::{BOTH_SIDES, Located, PeakSettings, higher, higher_on_both_sides, maximum_on};
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::sweep::{SweepDirection, SweepSettings, follow};
use crate::hb::equations::balance::{Balance, balance_on};
use crate::hb::equations::effort::WorkCount;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::{Iterate, Point};
use crate::hb::route::PeakRoute;
use crate::hb::settings::HbSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use std::ops::ControlFlow;

/// Largest change of the frequency per step, as a share of the band.
const ADVANCE: f64 = 0.1;
/// Share by which the maximum must be higher.
const LEAST_GAIN: f64 = 1e-3;
/// A step may hide a top that is so many times as high as its ends.
const HIDDEN: f64 = 1.5;
/// Newton iterations that may be spent on a branch.
const BUDGET: usize = 3000;

/// The highest maximum on the branch through the maximum `found`, with as many harmonics as the alert asks for, if it is higher; and the
/// work. The branch is that on the harmonics of the study.
///
/// None where all contacts stick at `found`, whose response is linear. Where the branch cannot be followed to the end of the band, the part
/// that is known counts. The branch that begins at that end of the band is searched, too, unless `found` lies on it.
pub fn higher_on_branch(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    found: &Solution,
) -> (Option<Solution>, WorkCount) {
    let effort = &problem.effort;
    let before = effort.count();
    let higher = match found.contact.stick < 1.0 {
        true => effort.with_own_budget(settings.newton.budget, || {
            highest(problem, settings, peak, found)
        }),
        false => None,
    };
    (higher, effort.count().since(before))
}

fn highest(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    found: &Solution,
) -> Option<Solution> {
    let balance = balance_on(problem, settings.harmonics.clone(), settings);
    let newton = settings.newton;
    let start = on_harmonics(&balance, found, peak, newton).ok()?;
    let height = |located: &Located<'_>| located.iterate.response(&balance).norm();
    let least = 1.0 + LEAST_GAIN;
    let budget = newton.budget.min(BUDGET);
    let (sides, beside) = problem.effort.with_own_budget(budget, || {
        let sides = [SweepDirection::Downward, SweepDirection::Upward];
        let sides = sides.map(|side| on_side(&balance, &start, side, settings, peak));
        // a step is longer than the distance of two maxima side by side
        let start = Iterate::new(&balance, start.clone());
        let n_starts = BOTH_SIDES.len();
        let beside = higher_on_both_sides(&balance, &start, least, n_starts, peak, newton);
        (sides, beside)
    });
    let is_whole = sides.iter().all(|side| side.is_whole);
    let is_swept = found.route.is_some_and(PeakRoute::is_of_any_mode);
    let elsewhere = match is_whole || is_swept {
        true => None,
        false => problem.effort.with_own_budget(newton.budget, || {
            let balance = std::slice::from_ref(&balance);
            swept_maximum(balance, found.level, peak, newton).ok()
        }),
    };
    let own = Iterate::new(&balance, start).response(&balance).norm();
    let maxima = sides.into_iter().flat_map(|side| side.highest);
    let best = (maxima.chain(beside).chain(elsewhere))
        .reduce(|best, other| higher(&balance, best, other))
        .filter(|best| height(best) > least * own)?;
    Some(Solution {
        route: Some(PeakRoute::OnBranch),
        ..refined_maximum(&balance, best, settings, peak)
    })
}

/// A branch from a maximum towards one end of the band.
struct Side<'p> {
    /// The highest maximum that it passes.
    highest: Option<Located<'p>>,
    /// Whether it was followed to the end of the band.
    is_whole: bool,
}

/// The branch from `start` towards one end of the band.
fn on_side<'p>(
    balance: &Balance<'p>,
    start: &Point,
    direction: SweepDirection,
    settings: &HbSettings,
    peak: PeakSettings,
) -> Side<'p> {
    let newton = settings.newton;
    let sweep = SweepSettings {
        band: peak.band,
        direction,
        largest_step: SWEEP_STEP,
        largest_advance: ADVANCE,
    };
    let start = Iterate::new(balance, start.clone());
    let mut least = start.response(balance).norm();
    let mut maxima: Vec<Located<'p>> = Vec::new();
    let end = follow(balance, start, sweep, newton, |from, to| {
        let top = f64::max(from.response.norm(), to.response.norm());
        if HIDDEN * top > least {
            let segment = BranchSegment::new(&from, to);
            let located = maximum_on(&segment, balance, peak, newton);
            least = least.max(top);
            maxima.extend(located);
        }
        ControlFlow::Continue(())
    });
    let maxima = maxima.into_iter();
    Side {
        highest: maxima.reduce(|best, other| higher(balance, best, other)),
        is_whole: end.status == Status::Converged,
    }
}
