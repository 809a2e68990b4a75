//! The maxima that the branch through a solution passes on one side of it.

use super::band::SWEEP_STEP;
use super::search::{Located, PeakSettings, maximum_on};
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::sweep::{SweepDirection, SweepSettings, follow};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Iterate, Point};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use std::ops::ControlFlow;

/// Largest change of the frequency per step, as a share of the band.
const ADVANCE: f64 = 0.1;
/// A step may hide a top that is so many times as high as its ends.
const HIDDEN: f64 = 1.5;

/// A branch on one side of a solution.
pub(super) struct BranchSide<'p> {
    /// The maxima that it passes, but for those far below another.
    pub maxima: Vec<Located<'p>>,
    /// Whether it was followed as far as wanted.
    pub is_whole: bool,
}

impl<'p> BranchSide<'p> {
    /// The branch on both sides of `start`, downward first.
    pub(super) fn both(
        balance: &Balance<'p>,
        start: &Point,
        peak: PeakSettings,
        newton: NewtonSettings,
        is_wanted: impl Fn(&BranchPoint<'p>, f64) -> bool,
    ) -> [Self; 2] {
        let sides = [SweepDirection::Downward, SweepDirection::Upward];
        sides.map(|side| Self::followed(balance, start, side, peak, newton, &is_wanted))
    }

    /// The branch from `start` towards one end of the band, for as long as `is_wanted` says so of the point reached and of the largest
    /// amplitude (m) met before.
    fn followed(
        balance: &Balance<'p>,
        start: &Point,
        direction: SweepDirection,
        peak: PeakSettings,
        newton: NewtonSettings,
        is_wanted: &impl Fn(&BranchPoint<'p>, f64) -> bool,
    ) -> Self {
        let sweep = SweepSettings {
            band: peak.band,
            direction,
            largest_step: SWEEP_STEP,
            largest_advance: ADVANCE,
        };
        let start = Iterate::new(balance, start.clone());
        let mut highest = start.response(balance).norm();
        let mut maxima: Vec<Located<'p>> = Vec::new();
        let end = follow(balance, start, sweep, newton, |from, to| {
            let top = f64::max(from.response.norm(), to.response.norm());
            if HIDDEN * top > highest {
                let segment = BranchSegment::new(&from, to);
                let located = maximum_on(&segment, balance, peak, newton);
                highest = highest.max(top);
                maxima.extend(located);
            }
            match is_wanted(to, highest) {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        });
        Self {
            maxima,
            is_whole: end.status == Status::Converged,
        }
    }
}
