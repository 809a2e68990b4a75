//! The part of the band that sweeps from both of its ends do not reach.

use crate::hb::status::Status;

/// The part of the band between the ends of the sweeps from both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Where the sweep from the lower end of the band ended, and why; [`Status::Converged`] if no further frequency was asked
    /// for.
    pub below: Stop,
    /// The same of the sweep from the upper end.
    pub above: Stop,
}

/// The end of a sweep through the band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Last frequency that was reached (rad/s).
    pub omega: f64,
    /// Why it was the last one.
    pub status: Status,
}

impl Gap {
    fn statuses(self) -> [Status; 2] {
        [self.below, self.above].map(|stop| stop.status)
    }

    pub(in crate::hb) fn has_spent_budget(self) -> bool {
        self.statuses().contains(&Status::BudgetSpent)
    }

    /// Whether every frequency asked for was met by a sweep, from one side or from the other.
    #[must_use]
    pub fn is_answered(self) -> bool {
        self.statuses().contains(&Status::Converged)
    }
}
