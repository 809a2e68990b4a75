//! Newton iterations and factorisations on one problem, and the largest number of iterations that a search may take.
//!
//! The problem holds both, so that every solve is counted, wherever it is called from. A solve has a bound of its own
//! (`max_iterations`). But a search makes many solves: without a common bound one sample could take minutes.

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

/// Work done by solves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WorkCount {
    /// Newton iterations.
    pub iterations: usize,
    /// Linear factorisations.
    pub factorizations: usize,
}

impl WorkCount {
    /// The work since it was `before`.
    #[must_use]
    pub fn since(self, before: Self) -> Self {
        Self {
            iterations: self.iterations - before.iterations,
            factorizations: self.factorizations - before.factorizations,
        }
    }
}

impl std::ops::AddAssign for WorkCount {
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.factorizations += other.factorizations;
    }
}

/// A solution with the work that it took.
#[derive(Debug)]
pub(in crate::hb) struct Counted<T> {
    pub(in crate::hb) solution: T,
    pub(in crate::hb) work: WorkCount,
}

/// Work done on a problem, the time of its error alert and of its stability, and Newton iterations left to the search that runs: one at a time.
#[derive(Debug)]
pub struct Effort {
    left: AtomicUsize,
    iterations: AtomicUsize,
    factorizations: AtomicUsize,
    alert_nanoseconds: AtomicU64,
    stability_nanoseconds: AtomicU64,
}

impl Default for Effort {
    /// No work yet, and no bound.
    fn default() -> Self {
        Self {
            left: AtomicUsize::new(usize::MAX),
            iterations: AtomicUsize::new(0),
            factorizations: AtomicUsize::new(0),
            alert_nanoseconds: AtomicU64::new(0),
            stability_nanoseconds: AtomicU64::new(0),
        }
    }
}

impl Effort {
    /// Begins a search of at most `iterations` Newton iterations.
    pub fn grant(&self, iterations: usize) {
        self.left.store(iterations, Ordering::Relaxed);
    }

    /// Runs a search within another search: `search` may take `iterations`, which are not taken from those of the other.
    pub(crate) fn with_own_budget<T>(&self, iterations: usize, search: impl FnOnce() -> T) -> T {
        let left = self.left.swap(iterations, Ordering::Relaxed);
        let found = search();
        self.left.store(left, Ordering::Relaxed);
        found
    }

    /// Whether the search must end with [`crate::hb::Status::BudgetSpent`].
    #[must_use]
    pub(crate) fn is_spent(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }

    /// All work so far; [`WorkCount::since`] gives that of a part.
    #[must_use]
    pub fn count(&self) -> WorkCount {
        WorkCount {
            iterations: self.iterations.load(Ordering::Relaxed),
            factorizations: self.factorizations.load(Ordering::Relaxed),
        }
    }

    /// Time that the error alert has taken, larger harmonic sets included. Nothing is decided by it.
    #[must_use]
    pub fn alert_time(&self) -> Duration {
        Duration::from_nanos(self.alert_nanoseconds.load(Ordering::Relaxed))
    }

    pub(in crate::hb) fn add_alert_time(&self, time: Duration) {
        add_time(&self.alert_nanoseconds, time);
    }

    /// Time that assessments of stability have taken. Nothing is decided by it.
    #[must_use]
    pub fn stability_time(&self) -> Duration {
        Duration::from_nanos(self.stability_nanoseconds.load(Ordering::Relaxed))
    }

    pub(in crate::hb) fn add_stability_time(&self, time: Duration) {
        add_time(&self.stability_nanoseconds, time);
    }

    /// Counts a Newton iteration with its factorisations, and takes it from what is left.
    pub(in crate::hb) fn spend(&self, factorizations: usize) {
        let left = self.left.load(Ordering::Relaxed);
        self.left.store(left.saturating_sub(1), Ordering::Relaxed);
        self.add(WorkCount {
            iterations: 1,
            factorizations,
        });
    }

    /// Counts work without reducing what is left to the search that runs.
    pub fn add(&self, work: WorkCount) {
        self.iterations
            .fetch_add(work.iterations, Ordering::Relaxed);
        self.factorizations
            .fetch_add(work.factorizations, Ordering::Relaxed);
    }
}

fn add_time(nanoseconds: &AtomicU64, time: Duration) {
    let more = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
    nanoseconds.fetch_add(more, Ordering::Relaxed);
}

/// A meter of the work on a problem: each reading gives the work since the one before.
#[derive(Debug)]
pub(in crate::hb) struct Meter<'e> {
    effort: &'e Effort,
    read: Cell<WorkCount>,
}

impl<'e> Meter<'e> {
    pub(in crate::hb) fn new(effort: &'e Effort) -> Self {
        Self {
            effort,
            read: Cell::new(effort.count()),
        }
    }

    /// The work since the last reading, or since the start.
    pub(in crate::hb) fn read(&self) -> WorkCount {
        let now = self.effort.count();
        now.since(self.read.replace(now))
    }
}
