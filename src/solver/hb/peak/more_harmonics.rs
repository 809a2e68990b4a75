//! The maximum on more harmonics, where Newton's method does not lead to it from the maximum on fewer.
//!
//! The harmonics that are added may meet a resonance of a part in contact. Then the branch on more harmonics has folds and lower maxima
//! close to the maximum that it has on fewer, and Newton's method ends on another leg of a fold, or nowhere. But a solution some way down
//! the resonance is found, and the branch through it leads to the maximum.

use super::branch_side::BranchSide;
use super::search::{Located, PeakSettings, beside, branch_through, find_peak, higher};
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Iterate, solve};
use crate::hb::settings::NewtonSettings;

/// Distances from the maximum on fewer harmonics at which searches start, on each side (relative change of the displacements). More
/// harmonics may have no solution close by.
const DISTANCES: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];
/// The branch is followed up to so many times the distance in frequency between the maximum on fewer harmonics and the one next to it.
const REACH: f64 = 2.0;
/// A band of at most so many frequency tolerances is not searched: every point of it would pass for the maximum.
const NARROW: f64 = 10.0;
/// Newton iterations that may be spent on the branch.
const BUDGET: usize = 600;

/// The highest maximum on the harmonics of `larger` near the maximum `found` on those of `balance`: of those next to it on both sides, and
/// of those on the branch through these.
pub(super) fn highest_on_more<'p>(
    balance: &Balance<'p>,
    found: &Iterate<'p>,
    larger: &Balance<'p>,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Option<Located<'p>> {
    let omega = found.point.omega;
    if peak.band.width() <= NARROW * peak.frequency_tolerance * omega {
        return None;
    }
    let next = highest_on_both_sides(balance, found, larger, peak, newton)?;
    let start = next.iterate.point.clone();
    let reach = REACH * (start.omega - omega).abs();
    let is_near = |to: &BranchPoint<'p>, _| (to.iterate.point.omega - omega).abs() <= reach;
    let budget = newton.budget.min(BUDGET);
    let sides = balance.problem.effort.with_own_budget(budget, || {
        BranchSide::both(larger, &start, peak, newton, is_near)
    });
    let maxima = sides.into_iter().flat_map(|side| side.maxima);
    Some(maxima.fold(next, |best, other| higher(larger, best, other)))
}

/// The highest maximum on `larger` harmonics next to the maximum `found` on those of `balance`. It is searched from both
/// sides: more harmonics may split a maximum into two, with none between them.
pub fn highest_on_both_sides<'p>(
    balance: &Balance<'p>,
    found: &Iterate<'p>,
    larger: &Balance<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Option<Located<'p>> {
    let first = branch_through(balance, &found.point, settings);
    let sides = beside(balance, &first, &DISTANCES, newton);
    let maxima = sides.filter_map(|starts| {
        let mut starts = starts.filter_map(|(_, beside)| {
            let start = beside.point.padded(balance, larger);
            solve(larger, start, Condition::FixedFrequency, newton).ok()
        });
        starts.find_map(|start| find_peak(larger, start, settings, newton).ok())
    });
    maxima.reduce(|best, other| higher(larger, best, other))
}
