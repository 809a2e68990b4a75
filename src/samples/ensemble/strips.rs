//! Structures of samples whose strip is not the nominal one.

use crate::contact::ContactParameters;
use crate::hb::{LinearModel, Status};
use crate::model::two_blade::TwoBladeModel;

/// What gives a sample a strip of its own thickness.
#[derive(Debug, Clone)]
pub struct Strips {
    /// The nominal rig.
    pub rig: TwoBladeModel,
    /// Nominal constants of all its contact pairs, also of those that a mirror leaves out. Shape: `[n_contacts]`.
    pub contacts: Vec<ContactParameters<f64>>,
    /// Whether samples may be solved on one half of the rig.
    pub mirror: bool,
}

impl Strips {
    /// The structure with a strip of a thickness (mm), in the unknowns of the nominal one.
    ///
    /// # Errors
    /// [`Status::NonFinite`] if numbers fail: the strip cannot be reduced, or its mirror is lost.
    pub fn linear(&self, thickness_mm: f64, nominal: &LinearModel) -> Result<LinearModel, Status> {
        let model = self.rig.with_strip(thickness_mm);
        let model = model.map_err(|_| Status::NonFinite)?;
        let linear = LinearModel::of(&model, &self.contacts, self.mirror);
        let same_unknowns = |linear: &LinearModel| linear.pairs == nominal.pairs;
        let linear = linear.ok().filter(same_unknowns);
        linear.ok_or(Status::NonFinite)
    }
}
