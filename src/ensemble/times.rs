//! Where the time of a sample goes. It is measured, never stored with results, and decides nothing.

use std::ops::AddAssign;
use std::time::Duration;

/// Time of one thread on a sample, by purpose.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleTimes {
    /// Peaks on the harmonics of the study.
    pub peaks: Duration,
    /// Error alert: peaks on larger harmonic sets.
    pub larger_sets: Duration,
    /// Forced response curves.
    pub curves: Duration,
}

impl AddAssign for SampleTimes {
    fn add_assign(&mut self, other: Self) {
        self.peaks += other.peaks;
        self.larger_sets += other.larger_sets;
        self.curves += other.curves;
    }
}
