//! How the search for the peak at one level ended.

use crate::hb::equations::effort::WorkCount;
use crate::hb::equations::problem::Problem;
use crate::hb::settings::HbSettings;
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
    pub fn found(solution: Solution, count: WorkCount) -> Self {
        Self {
            level: solution.level,
            status: solution.status,
            count,
            solution: Some(solution),
        }
    }

    /// No peak, and why.
    #[must_use]
    pub fn failed(level: f64, status: Status, count: WorkCount) -> Self {
        Self {
            level,
            status,
            solution: None,
            count,
        }
    }

    /// The same with the stability of the solution, where `settings` ask for it, and with the status that follows.
    #[must_use]
    pub fn with_stability(mut self, problem: &Problem<'_>, settings: &HbSettings) -> Self {
        self.solution = (self.solution).map(|solution| solution.with_stability(problem, settings));
        if let Some(solution) = &self.solution {
            self.status = solution.status;
        }
        self
    }
}
