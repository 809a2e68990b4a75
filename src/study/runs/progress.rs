//! How far a command has come, counted from any thread.

use std::sync::atomic::{AtomicU64, Ordering};

/// How far a command has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Parts done.
    pub done: u64,
    /// All parts.
    pub total: u64,
    /// Newton iterations of the parts that this process has done; 0 where they are not counted.
    pub newton_iterations: u64,
}

/// Counts the parts of a command from any thread; more parts may turn up on the way.
pub(in crate::study) struct Meter<F> {
    done: AtomicU64,
    total: AtomicU64,
    newton_iterations: AtomicU64,
    progress: F,
}

impl<F: Fn(Progress) + Sync> Meter<F> {
    /// Says how far the command has come at its start.
    pub(in crate::study) fn start(done: u64, total: u64, progress: F) -> Self {
        let newton_iterations = 0;
        progress(Progress {
            done,
            total,
            newton_iterations,
        });
        Self {
            done: AtomicU64::new(done),
            total: AtomicU64::new(total),
            newton_iterations: AtomicU64::new(newton_iterations),
            progress,
        }
    }

    /// So many parts more.
    pub(super) fn expect(&self, more: u64) {
        self.total.fetch_add(more, Ordering::Relaxed);
    }

    /// Parts done.
    pub(super) fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// One more part is done, with so many Newton iterations.
    pub(in crate::study) fn one_more(&self, newton_iterations: u64) {
        let add = |sum: &AtomicU64, more| more + sum.fetch_add(more, Ordering::Relaxed);
        (self.progress)(Progress {
            done: add(&self.done, 1),
            total: self.total.load(Ordering::Relaxed),
            newton_iterations: add(&self.newton_iterations, newton_iterations),
        });
    }
}
