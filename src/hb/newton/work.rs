//! The work that solves take.

/// Work done by solves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WorkCount {
    /// Newton iterations.
    pub iterations: usize,
    /// Linear factorisations.
    pub factorizations: usize,
}

impl WorkCount {
    /// Adds the work of a solve, whether it succeeded or not.
    pub fn tally<T, E>(&mut self, result: Result<(T, WorkCount), (E, WorkCount)>) -> Result<T, E> {
        let (value, work) = match result {
            Ok((value, work)) => (Ok(value), work),
            Err((error, work)) => (Err(error), work),
        };
        *self += work;
        value
    }

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
