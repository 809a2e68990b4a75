//! Damping of Newton steps by natural monotonicity.
//!
//! A step is shortened until the step that would follow with the same Jacobian is shorter than the step itself. The residual
//! is no measure far from the solution: stiff contacts can make it ten times larger on the best path to the solution.
//!
//! Source: Deuflhard 2004, Newton Methods for Nonlinear Problems, section 3.3.

/// How damping factors are chosen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Damping {
    /// Smallest factor; a step with it is always taken.
    pub(super) smallest: f64,
    /// First factor of the next step over that of this step, if this step was not shortened.
    pub(super) recovery: f64,
    /// The same if this step was shortened.
    pub(super) caution: f64,
}

impl Damping {
    /// The first accepted trial of a step times a factor, and the factor that the next step tries first. The first factor
    /// tried is `first`, the others are halves of the one before.
    pub(super) fn damped<T>(
        self,
        first: f64,
        trial: impl Fn(f64) -> T,
        is_accepted: impl Fn(&T, f64) -> bool,
    ) -> (T, f64) {
        let (mut factor, mut growth) = (first, self.recovery);
        loop {
            let tried = trial(factor);
            if factor <= self.smallest || is_accepted(&tried, factor) {
                return (tried, (growth * factor).min(1.0));
            }
            (factor, growth) = (0.5 * factor, self.caution);
        }
    }
}

/// Whether the length of the step that would follow is enough below that of the step which was taken times `factor`.
pub(super) fn is_shorter(following: f64, step: f64, factor: f64) -> bool {
    following <= (1.0 - 0.25 * factor) * step
}
