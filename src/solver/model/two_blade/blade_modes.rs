//! Modes of one blade without strip, as a force on its airfoil excites them and its platform shows them.

use super::components::Layout;
use super::{Blade, TwoBladeSettings};
use crate::fe::Rectangle;
use crate::model::ModelError;

/// Modes of blade 1, mass-normalised, all that its reduced model has: their sum at rest is its static answer.
#[derive(Debug, Clone, PartialEq)]
pub struct BladeModes {
    /// Natural angular frequencies (rad/s), ascending.
    pub omega: Vec<f64>,
    /// Work of the unit force of the excitation on each shape (1/√kg).
    pub excited: Vec<f64>,
    /// Displacement of the platform in x per modal coordinate, mean over the contact with the strip (1/√kg).
    pub platform: Vec<f64>,
}

/// Modes of blade 1 of the rig; the strip is not made.
///
/// # Errors
/// [`ModelError`]: a setting breaks a rule, or the mesh or an eigenvalue problem fails.
pub fn blade_modes(settings: &TwoBladeSettings) -> Result<BladeModes, ModelError> {
    settings.validate()?;
    let layout = Layout::new(settings)?;
    let contact = layout.contact_cells();
    let patches: Vec<Rectangle> = contact.iter().map(|cell| cell.patch).collect();
    let (blade, _) = Blade::new(settings, &layout, &patches)?;
    let nodes = &blade.component.nodes;
    let direction = settings.excitation_direction;
    let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
    let area: f64 = contact.iter().map(|cell| cell.area).sum();
    let excited = |mode: usize| {
        let at = nodes[contact.len()];
        let work = |axis: usize| direction[axis] / norm * blade.shapes[(at + axis, mode)];
        (0..3).map(work).sum::<f64>()
    };
    let platform = |mode: usize| {
        let cells = contact.iter().zip(nodes);
        let mean = cells.map(|(cell, &x)| cell.area / area * blade.shapes[(x, mode)]);
        mean.sum::<f64>()
    };
    let modes = 0..blade.lambda.len();
    Ok(BladeModes {
        omega: blade.lambda.iter().map(|l| l.max(0.0).sqrt()).collect(),
        excited: modes.clone().map(excited).collect(),
        platform: modes.map(platform).collect(),
    })
}
