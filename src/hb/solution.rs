//! What one nonlinear solve returns.

use super::status::Status;
use crate::harmonics::HarmonicSet;

/// Shares of (pair, time) in each contact state; they add up to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct ContactFractions {
    /// Sticking.
    pub stick: f64,
    /// Slipping in at least one direction.
    pub slip: f64,
    /// Separated.
    pub separated: f64,
}

/// Work per cycle (J).
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct CycleWork {
    /// Done by the excitation.
    pub input: f64,
    /// Dissipated by the damping matrix.
    pub viscous: f64,
    /// Dissipated by the contacts.
    pub friction: f64,
}

/// One periodic solution of the balance equations, or the last iterate of a failed solve.
#[derive(Debug, Clone)]
pub struct Solution {
    /// How the solve ended.
    pub status: Status,
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Excitation level.
    pub level: f64,
    /// Harmonics of the solution.
    pub harmonics: HarmonicSet,
    /// Relative contact displacements (m). Shape: `[n_coefficients][3 · n_contacts]`, components t1, t2, n.
    pub relative: Vec<f64>,
    /// Response coordinates (m). Shape: `[n_coefficients][n_responses]`.
    pub responses: Vec<f64>,
    /// Largest residual component over the displacement scale.
    pub residual: f64,
    /// Contact states.
    pub contact: ContactFractions,
    /// Energy balance.
    pub work: CycleWork,
    /// Estimated relative change of the amplitude by the harmonics left out.
    pub truncation_error: Option<f64>,
    /// Newton iterations.
    pub newton_iterations: usize,
    /// Linear factorisations.
    pub factorizations: usize,
}

impl Solution {
    /// Amplitude |q̂₁| of the first harmonic of response `i` (m).
    #[must_use]
    pub fn amplitude(&self, i: usize) -> f64 {
        let n = self.responses.len() / self.harmonics.n_coefficients();
        self.responses[n + i].hypot(self.responses[2 * n + i])
    }
}
