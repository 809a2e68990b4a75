//! Another maximum on the branch through one that was found, which may be higher.
//!
//! A search leads to one maximum of the amplitude. Where contacts open, or the track of a mode is lost, a higher one may lie on the
//! same branch. So the branch is followed from the maximum to both ends of the band, and searched on both sides close to it. A branch that
//! cannot be followed to both ends may be one of several: then the band is swept, too.
//!
//! The branch is followed on the harmonics of the study, whose heights do not tell which maximum is the higher on enough harmonics. So the
//! highest other one gets as many as the alert asks for if it comes near. It is a start for other samples, too, where it may be the higher one.
//!
//! A maximum that was predicted from other samples, whose branches are known, needs this only where the prediction is in doubt, on its
//! resonance alone, or where another maximum of theirs is lost ([`Extent`]).

use super::band::maxima_of_sweeps;
use super::branch_side::BranchSide;
use super::predicted::on_harmonics;
use super::refine::refined_maximum;
use super::search::{BOTH_SIDES, Located, PeakSettings, find_peak, higher, higher_on_both_sides};
use crate::harmonics::HarmonicSet;
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::equations::balance::{Balance, balance_on};
use crate::hb::equations::effort::WorkCount;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::climb;
use crate::hb::newton::{Condition, Iterate, Point};
use crate::hb::route::PeakRoute;
use crate::hb::settings::HbSettings;
use crate::hb::solution::Solution;

/// Share by which another maximum must be higher.
const LEAST_GAIN: f64 = 1e-3;
/// Another maximum comes near that is at least so high beside the one found, on the harmonics of the study.
const COMES_NEAR: f64 = 0.92;
/// Maxima of one branch on other harmonics are one up to this relative distance of frequency.
const SAME: f64 = 5e-3;
/// The branch of one resonance ends where the amplitude is below this share of its maximum.
const FAR: f64 = 0.5;
/// Newton iterations that may be spent on a branch.
const BUDGET: usize = 3000;

/// How far the branch through a maximum is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Extent {
    /// On each side until the amplitude is far below the maximum.
    Resonance,
    /// To both ends of the band.
    Band,
}

/// The highest other maximum on the branch through the maximum `found`, with as many harmonics as the alert asks for, if it is higher or
/// comes near; and the work.
///
/// None where all contacts stick at `found`, whose response is linear. Where the branch cannot be followed to the end of the band, the part
/// that is known counts, and the band is swept, too.
pub fn other_on_branch(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    found: &Solution,
    extent: Extent,
) -> (Option<Solution>, WorkCount) {
    let effort = &problem.effort;
    let before = effort.count();
    let other = match found.contact.stick < 1.0 {
        true => effort.with_own_budget(settings.newton.budget, || {
            competing(problem, settings, peak, found, extent)
        }),
        false => None,
    };
    (other, effort.count().since(before))
}

fn competing(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    found: &Solution,
    extent: Extent,
) -> Option<Solution> {
    let balance = balance_on(problem, settings.harmonics.clone(), settings);
    let start = on_harmonics(&balance, found, peak, settings.newton).ok()?;
    let maxima = maxima_on_branch(&balance, &start, settings, peak, extent);
    let start = Located::from(Iterate::new(&balance, start));
    let omega = start.iterate.point.omega;
    let height = |located: &Located<'_>| located.iterate.response(&balance).norm();
    let own = height(&start);
    let is_known = |other: f64| is_near(other, omega) || is_near(other, found.omega);
    let comes_near = |other: &Located<'_>| {
        let top = height(other);
        let is_higher = top > (1.0 + LEAST_GAIN) * own;
        is_higher || (top >= COMES_NEAR * own && !is_known(other.iterate.point.omega))
    };
    // more harmonics may split the maximum into two, or have led to one that does not belong to it
    let start = (!is_near(omega, found.omega)).then_some(start);
    let near = maxima.into_iter().filter(comes_near);
    let refined = match near.reduce(|best, other| higher(&balance, best, other)) {
        Some(other) => refined_beside(&balance, other, settings, peak, found),
        None => refined_maximum(&balance, start?, settings, peak),
    };
    Some(Solution {
        route: Some(PeakRoute::OnBranch),
        ..refined
    })
}

/// The maximum `other` of `balance` with as many harmonics as the alert asks for. Newton's method onto more of them may lead to the maximum
/// `found`: then they are added one by one at the frequency of `other`, and its maximum is searched along the branch.
fn refined_beside<'p>(
    balance: &Balance<'p>,
    other: Located<'p>,
    settings: &HbSettings,
    peak: PeakSettings,
    found: &Solution,
) -> Solution {
    let start = other.iterate.point.clone();
    let refined = refined_maximum(balance, other, settings, peak);
    let (few, orders) = (balance.harmonics.orders().len(), found.harmonics.orders());
    if !is_near(refined.omega, found.omega) || few >= orders.len() {
        return refined;
    }
    let sets = (few..=orders.len()).filter_map(|n| HarmonicSet::new(orders[..n].to_vec()).ok());
    let rungs: Vec<Balance<'p>> = sets
        .map(|set| balance_on(balance.problem, set, settings))
        .collect();
    let (last, newton) = (&rungs[rungs.len() - 1], settings.newton);
    let climbed = climb(&rungs, start, Condition::FixedFrequency, newton);
    match climbed.and_then(|beside| find_peak(last, beside, peak, newton)) {
        Ok(located) => refined_maximum(last, located, settings, peak),
        Err(_) => refined,
    }
}

/// Whether maxima at these frequencies (rad/s), perhaps on other harmonics, may be one.
fn is_near(omega: f64, other: f64) -> bool {
    (omega / other - 1.0).abs() <= SAME
}

/// The maxima on the branch through `start`, and those of sweeps through the band where these are made.
fn maxima_on_branch<'p>(
    balance: &Balance<'p>,
    start: &Point,
    settings: &HbSettings,
    peak: PeakSettings,
    extent: Extent,
) -> Vec<Located<'p>> {
    let (newton, effort) = (settings.newton, &balance.problem.effort);
    let least = 1.0 + LEAST_GAIN;
    let budget = newton.budget.min(BUDGET);
    let is_wanted = |to: &BranchPoint<'p>, highest: f64| {
        extent == Extent::Band || to.response.norm() >= FAR * highest
    };
    let (sides, beside) = effort.with_own_budget(budget, || {
        let sides = BranchSide::both(balance, start, peak, newton, is_wanted);
        // a step is longer than the distance of two maxima side by side
        let start = Iterate::new(balance, start.clone());
        let n_starts = BOTH_SIDES.len();
        let beside = higher_on_both_sides(balance, &start, least, n_starts, peak, newton);
        (sides, beside)
    });
    let elsewhere = match sides.iter().all(|side| side.is_whole) {
        true => Vec::new(),
        false => effort.with_own_budget(newton.budget, || {
            maxima_of_sweeps(balance, start.level, peak, newton)
        }),
    };
    let maxima = sides.into_iter().flat_map(|side| side.maxima);
    maxima.chain(beside).chain(elsewhere).collect()
}
