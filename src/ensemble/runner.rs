//! Many samples at once.
//!
//! The outcome of sample i is a function of the study and i alone. Samples share read-only data, and the number of a sample
//! decides from which other samples it starts. So neither the number of threads nor the order of solving changes a bit.

use super::atlas::{Anchor, Atlas};
use super::outcome::{LevelOutcome, SampleOutcome};
use super::strips::Strips;
use crate::contact::ContactParameters;
use crate::gpu::Gpu;
use crate::hb::peak::maxima::PeakChoice;
use crate::hb::peak::search::PeakSettings;
use crate::hb::{HbSettings, LinearModel};
use crate::sampling::{Design, Input};
use rayon::prelude::*;

/// What all samples of a study share.
#[derive(Debug, Clone, Copy)]
pub struct Ensemble<'a> {
    /// Nominal linear part of the model.
    pub linear: &'a LinearModel,
    /// Makes the strip of a sample, if the thickness of the strip is an input.
    pub strips: Option<&'a Strips>,
    /// Nominal constants of the contact pairs.
    pub contacts: &'a [ContactParameters<f64>],
    /// Interface of each contact pair: 0 = left, 1 = right. Shape as `contacts`; read for inputs of one side only.
    pub interfaces: &'a [usize],
    /// Inputs that are static loads, in the order of [`crate::hb::structure::linear::ModalPart::loads`].
    pub loads: &'a [Input],
    /// Random inputs.
    pub design: &'a Design,
    /// Excitation levels, ascending.
    pub levels: &'a [f64],
    /// Solver.
    pub settings: &'a HbSettings,
    /// Where peaks are searched and how exactly.
    pub peak: PeakSettings,
    /// Which of the maxima is the peak.
    pub choice: PeakChoice,
    /// Samples with a forced response curve: 0 … this − 1.
    pub curve_samples: u64,
    /// A device that drafts contact forces, if any. The processor computes everything that decides a result.
    pub gpu: Option<&'a Gpu>,
    /// How the peaks of a sample are computed.
    pub solver: SampleSolver,
}

/// How the peaks of a sample are computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SampleSolver {
    /// The balance equations.
    #[default]
    HarmonicBalance,
    /// A function with known answers.
    #[cfg(feature = "test-functions")]
    Function(super::test_function::TestFunction),
}

/// Number of samples of the first generation, which start from no other sample. Each later generation has half as many samples
/// as all before it.
pub(super) const FIRST_ANCHORS: u64 = 5;
/// Most samples in the atlas.
pub const MOST_ANCHORS: u64 = 1024;

/// Solved samples, and the starts that they give to further ones.
#[derive(Debug, Clone, Default)]
pub struct Solved {
    /// Outcomes of the samples 0, 1, …
    pub outcomes: Vec<SampleOutcome>,
    /// The first [`MOST_ANCHORS`] of them as starts for others, in the same order.
    pub anchors: Vec<Anchor>,
}

impl Ensemble<'_> {
    /// Outcomes of the samples 0 … `samples` − 1, in that order; `done` is called after each, from any thread.
    #[must_use]
    pub fn run(&self, samples: u64, done: impl Fn() + Sync) -> Vec<SampleOutcome> {
        self.extend(Solved::default(), samples, done).outcomes
    }

    /// Solves at inputs that are no samples of the design, on the processor, started from `anchors`. The results depend on the
    /// inputs and the anchors alone, neither on threads nor on the backend. Shape of a result: `[levels]`.
    pub(super) fn solver_from(
        &self,
        anchors: &[Anchor],
    ) -> impl Fn(&[f64]) -> Vec<LevelOutcome> + Sync {
        let on_processor = Ensemble { gpu: None, ..*self };
        let mut atlas = Atlas::default();
        atlas.extend(anchors.iter().cloned());
        move |inputs| on_processor.levels(inputs, &atlas)
    }

    /// The samples 0 … `samples` − 1, of which the first ones are `solved` already; `done` is called after each of the others.
    ///
    /// The samples of the first generation start from no other sample. Each later one starts from the generations before its
    /// own. So the starts of sample i depend on i, but not on the order of solving, the number of samples, or the samples that
    /// were solved already.
    #[must_use]
    pub fn extend(&self, solved: Solved, samples: u64, done: impl Fn() + Sync) -> Solved {
        let mut solved = solved;
        let mut atlas = Atlas::default();
        let mut first = 0;
        while first < samples {
            let end = match first {
                0 => FIRST_ANCHORS,
                _ if first < MOST_ANCHORS => (first + first / 2).min(MOST_ANCHORS),
                _ => samples,
            };
            let end = end.min(samples);
            let missing = solved.outcomes.len()..end as usize;
            let new: Vec<(SampleOutcome, Option<Anchor>)> = missing
                .into_par_iter()
                // one sample may take as long as a hundred others
                .with_max_len(1)
                .map(|index| {
                    let index = index as u64;
                    let (outcome, anchor) = self.sample(index, &atlas);
                    done();
                    (outcome, (index < MOST_ANCHORS).then_some(anchor))
                })
                .collect();
            let (outcomes, anchors): (Vec<_>, Vec<_>) = new.into_iter().unzip();
            solved.outcomes.extend(outcomes);
            solved.anchors.extend(anchors.into_iter().flatten());
            let generation = solved.anchors.iter().take(end as usize);
            atlas.extend(generation.skip(first as usize).cloned());
            first = end;
        }
        solved
    }
}
