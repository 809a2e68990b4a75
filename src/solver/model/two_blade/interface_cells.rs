//! The contact grid of one interface and the pressure of a rigid punch on it, for what presses a strip without the model.

use super::TwoBladeSettings;
use super::components::Layout;
use crate::model::ModelError;

/// One cell of the interface of blade 1; x < 0 from the middle of the gap, y from the middle of the strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterfaceCell {
    /// From and to in x and in y (m).
    pub span: [[f64; 2]; 2],
    /// Area (m²): a contact pair's part of the interface.
    pub area: f64,
    /// Mean pressure of a rigid flat punch as wide as the contact, over that of the interface (Johnson 1985, sec. 2.8).
    pub punch: f64,
}

/// Cells of the interface of blade 1, in the order of its contact pairs.
///
/// # Errors
/// [`ModelError`]: a setting breaks a rule, or the points of Gauss' rule are not found.
pub fn interface_cells(settings: &TwoBladeSettings) -> Result<Vec<InterfaceCell>, ModelError> {
    settings.validate()?;
    let layout = Layout::new(settings)?;
    let punch = layout.punch_deviation();
    let cell = |(span, deviation): ([[f64; 2]; 2], f64)| InterfaceCell {
        span,
        area: (span[0][1] - span[0][0]) * (span[1][1] - span[1][0]),
        punch: 1.0 + deviation,
    };
    Ok(layout.spans().into_iter().zip(punch).map(cell).collect())
}
