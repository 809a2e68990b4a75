//! Where the time of a sample goes, and its work. The time is measured, never stored with results, and decides nothing.

use std::ops::AddAssign;
use std::time::Duration;

/// Time of one thread on a sample, by purpose, and its work.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleTimes {
    /// Peaks on the harmonics of the study.
    pub peaks: Duration,
    /// Error alert: peaks on larger harmonic sets.
    pub larger_sets: Duration,
    /// Forced response curves, and the stability of the peaks.
    pub curves: Duration,
    /// Newton iterations for all of these.
    pub newton_iterations: u64,
}

impl AddAssign for SampleTimes {
    fn add_assign(&mut self, other: Self) {
        self.peaks += other.peaks;
        self.larger_sets += other.larger_sets;
        self.curves += other.curves;
        self.newton_iterations += other.newton_iterations;
    }
}
