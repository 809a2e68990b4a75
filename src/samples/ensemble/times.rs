//! Where the time of a sample goes, and its work. The time is measured, never stored with results, and decides nothing.

use super::outcome::{LevelOutcome, newton_iterations};
use crate::hb::equations::effort::Effort;
use std::ops::AddAssign;
use std::time::{Duration, Instant};

/// Time of one thread on a sample, by purpose, and its work.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleTimes {
    /// Peaks on the harmonics of the study.
    pub peaks: Duration,
    /// Error alert: peaks on larger harmonic sets.
    pub larger_sets: Duration,
    /// Stability of the peaks.
    pub stability: Duration,
    /// Forced response curves.
    pub curves: Duration,
    /// Newton iterations for all of these.
    pub newton_iterations: u64,
}

impl SampleTimes {
    /// Those of a sample that began at `begun` and ends now, with these `levels`. Its peaks took `to_peaks`, of which the larger harmonic
    /// sets took what `effort` had counted then; stability was assessed after them.
    pub(super) fn until_now(
        begun: Instant,
        to_peaks: Duration,
        effort: &Effort,
        levels: &[LevelOutcome],
    ) -> Self {
        let stability = effort.stability_time();
        Self {
            peaks: to_peaks.saturating_sub(effort.alert_time()),
            larger_sets: effort.alert_time(),
            stability,
            curves: (begun.elapsed() - to_peaks).saturating_sub(stability),
            newton_iterations: newton_iterations(levels),
        }
    }
}

impl AddAssign for SampleTimes {
    fn add_assign(&mut self, other: Self) {
        self.peaks += other.peaks;
        self.larger_sets += other.larger_sets;
        self.stability += other.stability;
        self.curves += other.curves;
        self.newton_iterations += other.newton_iterations;
    }
}
