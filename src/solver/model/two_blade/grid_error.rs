//! What the contact grid changes: the shift of neck bending by stuck contacts, against its limit on ever finer grids.

use super::{TrackedMode, TwoBladeModel, TwoBladeSettings, build};
use crate::linalg::LinalgError;
use crate::model::ModelError;
use crate::model::interface::InterfaceSettings;

/// Components of the comparison have elements so many times as long (blades) and modes up to so small a part of the cut-off: both
/// grids have the same ones, and only the interface counts.
const COARSER: f64 = 4.0;
/// Order of convergence that the limit is taken with, less than was measured where the shift still changes
/// (`cargo test --release --test verification the_interface_converges -- --nocapture`).
const ORDER: f64 = 1.5;
/// Contact nodes per interface up to which a grid twice as fine is solved: with more it takes long.
const MOST_NODES: usize = 60;
/// Least correlation of a stuck mode with free neck bending.
const SAME_MODE: f64 = 0.5;

/// The shift of a frequency by stuck contacts on a contact grid and on one twice as fine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridError {
    /// Contact nodes per interface, across the gap and along it.
    pub contact_nodes: [usize; 2],
    /// Stuck minus free frequency of neck bending on this grid (Hz).
    pub shift_hz: f64,
    /// The same on the grid twice as fine (Hz).
    pub finer_shift_hz: f64,
}

impl GridError {
    /// The shift to which both lead, with the order 1.5 (Hz).
    #[must_use]
    pub fn limit_hz(&self) -> f64 {
        self.finer_shift_hz + (self.finer_shift_hz - self.shift_hz) / (ORDER.exp2() - 1.0)
    }

    /// Error of the shift over the shift, without sign.
    #[must_use]
    pub fn relative(&self) -> f64 {
        ((self.shift_hz - self.limit_hz()) / self.shift_hz).abs()
    }
}

impl TwoBladeSettings {
    /// The error of the contact grid with the stiffness of `interface`, for the phase of the excitation.
    ///
    /// Blades are coarser than the study's, so that it takes seconds. Absent for a grid of more than 60 nodes, and where a
    /// rig cannot be built so or a stuck mode is no longer neck bending.
    #[must_use]
    pub fn grid_error(&self, interface: &InterfaceSettings) -> Option<GridError> {
        let contact_nodes = self.contact_nodes;
        if contact_nodes[0] * contact_nodes[1] > MOST_NODES {
            return None;
        }
        let shift = |contact_nodes| self.with_grid(contact_nodes).stuck_shift(interface).ok()?;
        Some(GridError {
            contact_nodes,
            shift_hz: shift(contact_nodes)?,
            finer_shift_hz: shift(contact_nodes.map(|n| 2 * n))?,
        })
    }

    /// The rig of the comparison on a contact grid.
    fn with_grid(&self, contact_nodes: [usize; 2]) -> Self {
        Self {
            contact_nodes,
            blade_element_mm: self.blade_element_mm.map(|edge| COARSER * edge),
            blade_cut_off_hz: self.blade_cut_off_hz / COARSER,
            strip_cut_off_hz: self.strip_cut_off_hz / COARSER,
            // one per node of the study's own grid; a static load moves no linear mode
            pressure_weights: None,
            ..self.clone()
        }
    }

    /// Stuck minus free frequency of neck bending (Hz).
    fn stuck_shift(&self, interface: &InterfaceSettings) -> Result<Option<f64>, ModelError> {
        let rig = build(self)?;
        let stuck = rig.stuck_by(interface)?;
        let shift = stuck.frequency - rig.free_neck_bending();
        Ok((stuck.correlation > SAME_MODE && shift > 0.0).then_some(shift))
    }
}

impl TwoBladeModel {
    /// The mode most like neck bending in the phase of the excitation, all contacts stuck with the stiffness of `interface`.
    fn stuck_by(&self, interface: &InterfaceSettings) -> Result<TrackedMode, LinalgError> {
        let pairs = interface.parameters(&self.reduced.contacts);
        let [k_n, k_t] = [
            pairs.iter().map(|pair| pair.k_n).collect::<Vec<_>>(),
            pairs.iter().map(|pair| pair.k_t[0]).collect(),
        ];
        let modes = self.stuck_modes(&k_n, &k_t)?;
        let mode = self.first_blade.x_bending[1];
        Ok(self.most_like(&modes, self.shape(mode, self.settings.excitation_phase)))
    }
}
