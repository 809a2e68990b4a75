//! Where contact states are evaluated.

use super::batch::{AftBatch, Want};
use super::evaluate::{AftScratch, evaluate};
use super::forces::AftForces;
use super::gpu::{Gpu, Turn};
use super::plan::AftPlan;

/// What an evaluation is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Accuracy {
    /// To steer an iteration; may be rounded to single precision.
    Draft,
    /// To decide a result: double precision on the processor.
    Full,
}

/// Who evaluates.
#[derive(Debug, Clone, Copy, Default)]
pub enum Backend<'a> {
    /// The processor alone.
    #[default]
    Cpu,
    /// A GPU for drafts, the processor for the rest.
    Gpu(&'a Gpu),
}

impl<'a> Backend<'a> {
    /// Contact forces, and tangents if wanted, of every state of the batch; says how accurate they are.
    ///
    /// Drafts come with tangents, on the GPU; forces alone are always evaluated here.
    pub fn evaluate(
        &self,
        plan: &AftPlan<f64>,
        batch: &AftBatch<f64>,
        (want, accuracy): (Want, Accuracy),
        out: &mut AftForces<f64>,
    ) -> Accuracy {
        if let (Self::Gpu(gpu), Accuracy::Draft, Want::ForcesAndTangents) = (self, accuracy, want)
            && gpu.draft(plan, batch, out)
        {
            return Accuracy::Draft;
        }
        evaluate(plan, batch, want, &mut AftScratch::default(), out);
        Accuracy::Full
    }

    /// A sample begins on this thread; hold the result until it ends.
    #[must_use]
    pub fn turn(&self) -> Option<Turn<'a>> {
        match self {
            Self::Cpu => None,
            Self::Gpu(gpu) => Some(gpu.turn()),
        }
    }
}
