//! Linear limits of the rig: no contact and all contacts stuck.

use super::{Phase, TwoBladeModel, frequencies};
use crate::linalg::{LinalgError, symmetric_generalized_eigen};
use crate::model::SparseRow;
use faer::Mat;

/// Modes of the rig with linear contact springs.
#[derive(Debug, Clone)]
pub struct LinearModes {
    /// Natural frequencies, ascending (Hz).
    pub frequencies: Vec<f64>,
    /// Mass-normalised shapes, one per column.
    pub shapes: Mat<f64>,
}

/// A mode found by its shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackedMode {
    /// Index among all modes of the rig.
    pub index: usize,
    /// Frequency (Hz).
    pub frequency: f64,
    /// Correlation with the free mode, (φᵀMφ₀)² for mass-normalised shapes: 1 is identity.
    pub correlation: f64,
}

impl TwoBladeModel {
    /// Frequency of neck bending without strip (Hz): the second blade mode that moves mainly in x.
    #[must_use]
    pub fn free_neck_bending(&self) -> f64 {
        frequencies(&self.first_blade.lambda)[self.first_blade.x_bending[1]]
    }

    /// Modes with springs k_n, k_t (N/m) in all contact pairs, all stuck and closed: K + Σ BᵀkB, without retention.
    ///
    /// Shape: both `[n_contacts]`; k_t holds for both tangential directions.
    ///
    /// # Errors
    /// [`LinalgError`] if the eigenvalue problem fails.
    pub fn stuck_modes(&self, k_n: &[f64], k_t: &[f64]) -> Result<LinearModes, LinalgError> {
        assert!(
            k_n.len() == self.reduced.n_contacts() && k_t.len() == k_n.len(),
            "one stiffness per contact pair"
        );
        let mut stiffness = self.reduced.stiffness.clone();
        for (i, pair) in self.reduced.contacts.iter().enumerate() {
            add_spring(&mut stiffness, &pair.t1, k_t[i]);
            add_spring(&mut stiffness, &pair.t2, k_t[i]);
            add_spring(&mut stiffness, &pair.n, k_n[i]);
        }
        let (lambda, shapes) =
            symmetric_generalized_eigen(stiffness.as_ref(), self.reduced.mass.as_ref())?;
        Ok(LinearModes {
            frequencies: frequencies(&lambda),
            shapes,
        })
    }

    /// Even springs: each pair has a part of the interface stiffness (N/m) in proportion to its area.
    ///
    /// # Errors
    /// [`LinalgError`] if the eigenvalue problem fails.
    pub fn stuck_neck_bending(
        &self,
        interface_k_n: f64,
        interface_k_t: f64,
    ) -> Result<TrackedMode, LinalgError> {
        let [k_n, k_t] = [interface_k_n, interface_k_t].map(|stiffness| {
            let parts = self.area_shares().into_iter();
            parts.map(|part| part * stiffness).collect::<Vec<_>>()
        });
        Ok(self.neck_bending_in(&self.stuck_modes(&k_n, &k_t)?))
    }

    /// Area of every contact pair over that of its interface.
    fn area_shares(&self) -> Vec<f64> {
        let areas = self.reduced.contacts.iter().map(|pair| pair.area);
        // both interfaces have the same area
        let interface = 0.5 * areas.clone().sum::<f64>();
        areas.map(|area| area / interface).collect()
    }

    /// The mode most like in-phase neck bending of the free blades.
    fn neck_bending_in(&self, modes: &LinearModes) -> TrackedMode {
        let mode = self.first_blade.x_bending[1];
        self.most_like(modes, self.shape(mode, Phase::InPhase))
    }

    /// The mode that is most like a mass-normalised shape.
    pub(super) fn most_like(&self, modes: &LinearModes, free: Mat<f64>) -> TrackedMode {
        let projections = (&self.reduced.mass * free).transpose() * &modes.shapes;
        let correlation = |k: usize| projections[(0, k)].powi(2);
        let index = (0..modes.frequencies.len())
            .max_by(|&a, &b| correlation(a).total_cmp(&correlation(b)))
            .unwrap_or(0);
        TrackedMode {
            index,
            frequency: modes.frequencies[index],
            correlation: correlation(index),
        }
    }

    /// Motion of the platforms against each other in the first two in-phase bending modes, as [x, y, z] per mode:
    /// root mean square of (u₁ − u₂)/2 over the contact area, as a fraction of the response point's motion.
    #[must_use]
    pub fn relative_platform_motion(&self) -> [[f64; 3]; 2] {
        let n_blade = self.first_blade.mirror.len();
        let parts = self.area_shares();
        let parts = &parts[..parts.len() / 2];
        self.first_blade.x_bending.map(|mode| {
            let shape = self.shape(mode, Phase::InPhase);
            let response = &self.reduced.responses[0].row;
            let reference: f64 = response.iter().map(|&(dof, w)| w * shape[(dof, 0)]).sum();
            std::array::from_fn(|axis| {
                let square = |(cell, part): (usize, &f64)| {
                    let dof = 3 * cell + axis;
                    part * (0.5 * (shape[(dof, 0)] - shape[(n_blade + dof, 0)])).powi(2)
                };
                let squares: f64 = parts.iter().enumerate().map(square).sum();
                squares.sqrt() / reference.abs()
            })
        })
    }

    /// Mass-normalised shape in which both blades have mode `mode`, in x with equal or with mirrored motion, the strip at rest.
    pub(super) fn shape(&self, mode: usize, phase: Phase) -> Mat<f64> {
        let sign = match phase {
            Phase::InPhase => -1.0,
            Phase::OutOfPhase => 1.0,
        };
        let blade = self.first_blade.shapes.col(mode);
        let n = self.first_blade.mirror.len();
        let mut shape = Mat::zeros(self.reduced.n_dofs(), 1);
        for q in 0..n {
            shape[(q, 0)] = blade[q] / 2f64.sqrt();
            shape[(n + q, 0)] = sign * self.first_blade.mirror[q] * blade[q] / 2f64.sqrt();
        }
        shape
    }
}

/// K += k w wᵀ.
fn add_spring(stiffness: &mut Mat<f64>, row: &SparseRow, k: f64) {
    for &(i, w_i) in row {
        for &(j, w_j) in row {
            stiffness[(i, j)] += k * w_i * w_j;
        }
    }
}
