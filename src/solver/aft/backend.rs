//! Where contact states are evaluated.

use super::batch::{AftBatch, Want};
use super::evaluate::{AftScratch, evaluate};
use super::forces::AftForces;
use super::plan::AftPlan;

/// What an evaluation is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Accuracy {
    /// To steer an iteration; may be rounded to single precision.
    Draft,
    /// To decide a result: double precision on the processor.
    Full,
}

/// A device that drafts contact forces.
pub trait Drafts: std::fmt::Debug + Sync {
    /// A draft of forces and tangents into `out`; `false`, and `out` as it was, if the device has none to give.
    #[must_use]
    fn draft(&self, plan: &AftPlan<f64>, batch: &AftBatch<f64>, out: &mut AftForces<f64>) -> bool;
}

/// Who evaluates.
#[derive(Debug, Clone, Copy, Default)]
pub enum Backend<'a> {
    /// The processor alone.
    #[default]
    Cpu,
    /// A device for drafts, the processor for the rest.
    Device(&'a dyn Drafts),
}

impl Backend<'_> {
    /// Contact forces, and tangents if wanted, of every state of the batch; says how accurate they are.
    ///
    /// Drafts come with tangents, from the device; forces alone are always evaluated here.
    pub fn evaluate(
        &self,
        plan: &AftPlan<f64>,
        batch: &AftBatch<f64>,
        (want, accuracy): (Want, Accuracy),
        out: &mut AftForces<f64>,
    ) -> Accuracy {
        if let (Self::Device(device), Accuracy::Draft, Want::ForcesAndTangents) =
            (self, accuracy, want)
            && device.draft(plan, batch, out)
        {
            return Accuracy::Draft;
        }
        evaluate(plan, batch, want, &mut AftScratch::default(), out);
        Accuracy::Full
    }
}
