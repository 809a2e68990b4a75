//! How the search for the peak at one level ended, and that for the maximum of one mode.

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

/// Result of the search for the maximum of one mode.
#[derive(Debug)]
pub struct ModeSearch {
    /// The maximum, or why there is none.
    pub peak: LevelPeak,
    /// Other maxima that the search has found.
    pub others: Vec<Solution>,
    /// Whether the maximum is known to be that of the mode. A sweep through the band leads to the highest maximum, whatever its mode.
    pub is_own: bool,
    /// Whether it was predicted from other samples with quite another amplitude: another maximum of its branch may be the one that they have.
    pub is_doubtful: bool,
}

impl From<LevelPeak> for ModeSearch {
    /// A search that has found no other maximum.
    fn from(peak: LevelPeak) -> Self {
        Self {
            peak,
            others: Vec::new(),
            is_own: true,
            is_doubtful: false,
        }
    }
}
