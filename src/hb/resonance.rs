//! Resonance of the fully stuck structure: the linear start of every nonlinear one.

use super::compliance::Compliance;
use super::linear::{LinearModel, Structure};
use super::problem::Problem;
use crate::linalg::{LinalgError, symmetric_generalized_eigen};
use faer::prelude::*;

/// A resonance of the stuck structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckResonance {
    /// Undamped natural frequency (rad/s).
    pub omega: f64,
    /// Half bandwidth, damping constant of the mode (rad/s).
    pub half_bandwidth: f64,
    /// First harmonic of response 0 per unit level (m).
    pub response: c64,
}

/// Frequency band of the search (rad/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lower edge.
    pub low: f64,
    /// Upper edge.
    pub high: f64,
}

impl Band {
    /// Width (rad/s).
    #[must_use]
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// Whether `omega` lies inside.
    #[must_use]
    pub fn contains(self, omega: f64) -> bool {
        (self.low..=self.high).contains(&omega)
    }
}

/// Natural frequencies (rad/s, ascending) and modes (columns, mass-normalised) of the stuck structure.
///
/// # Errors
/// [`LinalgError`] if the eigensolver fails.
pub fn stuck_modes(problem: &Problem<'_>) -> Result<(Vec<f64>, Mat<f64>), LinalgError> {
    let stiffness = problem.model.stiffness_with_springs(&problem.stuck_stiffness);
    let mass = match &problem.model.structure {
        Structure::Modal { .. } => Mat::identity(stiffness.nrows(), stiffness.ncols()),
        Structure::Physical { mass, .. } => mass.clone(),
    };
    let (lambda, modes) = symmetric_generalized_eigen(stiffness.as_ref(), mass.as_ref())?;
    Ok((lambda.iter().map(|l| l.max(0.0).sqrt()).collect(), modes))
}

/// The resonance of the stuck structure inside `band` with the largest modal amplitude of response 0.
///
/// # Errors
/// [`LinalgError`] if the eigensolver fails. `Ok(None)` if no natural frequency lies in the band.
pub fn stuck_resonance(
    problem: &Problem<'_>,
    band: Band,
) -> Result<Option<StuckResonance>, LinalgError> {
    let model = problem.model;
    let (omega, modes) = stuck_modes(problem)?;
    let strongest = (0..omega.len())
        .filter(|&j| band.contains(omega[j]))
        .map(|j| {
            let mode: Vec<c64> = modes.col(j).iter().map(|x| c64::new(*x, 0.0)).collect();
            let force: c64 = mode.iter().zip(&model.force).map(|(x, f)| x.re * f).sum();
            let half_bandwidth = 0.5 * damping_of(model, &mode);
            let residue = (force * model.responses(&mode)[0]).norm();
            let amplitude = residue / (2.0 * omega[j] * half_bandwidth.max(1e-12 * omega[j]));
            (j, half_bandwidth, amplitude)
        })
        .max_by(|a, b| a.2.total_cmp(&b.2));
    Ok(strongest.map(|(j, half_bandwidth, _)| StuckResonance {
        omega: omega[j],
        half_bandwidth,
        response: stuck_response(problem, omega[j]),
    }))
}

/// First harmonic of response 0 of the stuck structure at `omega` per unit level (m).
#[must_use]
pub fn stuck_response(problem: &Problem<'_>, omega: f64) -> c64 {
    response_with_springs(problem.model, &problem.stuck_stiffness, omega)
}

/// First harmonic of response 0 of the structure with all contacts open at `omega` per unit level (m).
#[must_use]
pub fn free_response(problem: &Problem<'_>, omega: f64) -> c64 {
    let open = vec![0.0; problem.stuck_stiffness.len()];
    response_with_springs(problem.model, &open, omega)
}

fn response_with_springs(model: &LinearModel, k: &[f64], omega: f64) -> c64 {
    let at = Compliance::new(model, k, &[0, 1], omega);
    model.responses(&at.harmonics[0].solve(&model.force))[0]
}

fn damping_of(model: &LinearModel, mode: &[c64]) -> f64 {
    model.damp(mode).iter().zip(mode).map(|(c, x)| (c * x.conj()).re).sum()
}
