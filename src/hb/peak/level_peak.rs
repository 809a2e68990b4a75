//! How the search for the peak at one level ended.

use crate::hb::newton::WorkCount;
use crate::hb::solution::Solution;
use crate::hb::status::Status;

/// Peak at one level.
#[derive(Debug)]
pub struct LevelPeak {
    /// Excitation level.
    pub level: f64,
    /// How it ended.
    pub status: Status,
    /// The solution at the peak, if any.
    pub solution: Option<Solution>,
    /// Work spent on this level.
    pub count: WorkCount,
}

impl LevelPeak {
    /// A located peak.
    #[must_use]
    pub fn found(solution: Solution) -> Self {
        Self {
            level: solution.level,
            status: solution.status,
            count: solution.work_count,
            solution: Some(solution),
        }
    }

    pub(in crate::hb) fn failed(level: f64, status: Status, count: WorkCount) -> Self {
        Self {
            level,
            status,
            solution: None,
            count,
        }
    }
}
