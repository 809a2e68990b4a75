//! Newton iterations that one search for a peak, or one curve, may take.
//!
//! Each attempt of a search is bounded on its own, but a search has many: without a common bound one sample can take
//! minutes. The budget lies with the problem, so that every solve of a search spends from it, whoever asks for it.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Newton iterations left to the search that runs on a problem: one at a time.
#[derive(Debug)]
pub struct Budget {
    left: AtomicUsize,
}

impl Default for Budget {
    /// Without a bound.
    fn default() -> Self {
        Self {
            left: AtomicUsize::new(usize::MAX),
        }
    }
}

impl Budget {
    /// Begins a search of at most `iterations` Newton iterations.
    pub fn grant(&self, iterations: usize) {
        self.left.store(iterations, Ordering::Relaxed);
    }

    /// Runs a search within one that has a budget, on `iterations` of its own.
    pub fn apart<T>(&self, iterations: usize, search: impl FnOnce() -> T) -> T {
        let left = self.left.swap(iterations, Ordering::Relaxed);
        let found = search();
        self.left.store(left, Ordering::Relaxed);
        found
    }

    /// Takes one iteration, or nothing where none is left.
    pub(in crate::hb) fn spend(&self) {
        let left = self.left.load(Ordering::Relaxed);
        self.left.store(left.saturating_sub(1), Ordering::Relaxed);
    }

    /// Whether the search must end with [`crate::hb::Status::BudgetSpent`].
    #[must_use]
    pub fn is_spent(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }
}
