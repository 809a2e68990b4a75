//! Resonance of the structure with linear springs at the contacts: stuck, the start of every nonlinear one; open, its
//! limit at large excitation.

use super::compliance::Compliance;
use super::linear::{LinearModel, Part};
use crate::linalg::{LinalgError, symmetric_generalized_eigen};
use faer::prelude::*;

/// Damping ratios below this count as this much when modes are ranked.
const UNDAMPED: f64 = 1e-12;

/// A resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearResonance {
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

/// The resonance of the structure with linear springs `k` (N/m, shape `[3·n_contacts]`) between the contacts whose
/// modal amplitude of response 0 is largest inside `band`.
///
/// # Errors
/// [`LinalgError`] if the eigensolver fails. `Ok(None)` if no natural frequency lies in the band.
pub fn linear_resonance(
    model: &LinearModel,
    k: &[f64],
    band: Band,
) -> Result<Option<LinearResonance>, LinalgError> {
    let part = model.part(1);
    let stiffness = part.stiffness_with_springs(k);
    let unit = Mat::identity(stiffness.nrows(), stiffness.ncols());
    let (lambda, modes) = symmetric_generalized_eigen(stiffness.as_ref(), unit.as_ref())?;
    let omega: Vec<f64> = lambda.iter().map(|l| l.max(0.0).sqrt()).collect();
    let strongest = (0..omega.len())
        .filter(|&j| band.contains(omega[j]))
        .map(|j| {
            let mode: Vec<c64> = modes.col(j).iter().map(|x| c64::new(*x, 0.0)).collect();
            let force: c64 = mode.iter().zip(&part.force).map(|(x, f)| x.re * f).sum();
            let half_bandwidth = 0.5 * damping_of(part, &mode);
            let residue = (force * part.responses(&mode)[0]).norm();
            let amplitude = residue / (2.0 * omega[j] * half_bandwidth.max(UNDAMPED * omega[j]));
            (j, half_bandwidth, amplitude)
        })
        .max_by(|a, b| a.2.total_cmp(&b.2));
    Ok(strongest.map(|(j, half_bandwidth, _)| LinearResonance {
        omega: omega[j],
        half_bandwidth,
        response: linear_response(model, k, omega[j]),
    }))
}

/// First harmonic of response 0 at `omega` per unit level (m) with linear springs `k` between the contacts.
#[must_use]
pub fn linear_response(model: &LinearModel, k: &[f64], omega: f64) -> c64 {
    let at = Compliance::new(model, k, &[0, 1], omega);
    let first = &at.harmonics[0];
    first.part.responses(&first.solve(&first.part.force))[0]
}

fn damping_of(part: &Part, mode: &[c64]) -> f64 {
    (part.structure.damp(mode).iter().zip(mode))
        .map(|(c, x)| (c * x.conj()).re)
        .sum()
}
