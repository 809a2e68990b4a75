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
use std::collections::BTreeMap;
use std::ops::Range;

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

/// A solved sample.
#[derive(Debug, Clone)]
pub struct SolvedSample {
    /// Its outcome.
    pub outcome: SampleOutcome,
    /// Its peaks as starts for others; the first [`MOST_ANCHORS`] samples have such.
    pub anchor: Option<Anchor>,
}

/// Samples that are solved already, by their index; there may be gaps.
pub type Known = BTreeMap<u64, SolvedSample>;

/// Solved samples, and the starts that they give to further ones.
#[derive(Debug, Clone, Default)]
pub struct Solved {
    /// Outcomes of the samples 0, 1, …
    pub outcomes: Vec<SampleOutcome>,
    /// The first [`MOST_ANCHORS`] of them as starts for others, in the same order.
    pub anchors: Vec<Anchor>,
}

/// Who watches a run.
pub trait Watch: Sync {
    /// A sample was solved. Called from any thread.
    fn solved(&self, sample: &SolvedSample);

    /// Whether no other sample is to begin.
    fn stops(&self) -> bool;
}

/// The run was told to stop before its last sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

/// A watch that counts and never stops.
struct Counting<F>(F);

impl<F: Fn() + Sync> Watch for Counting<F> {
    fn solved(&self, _: &SolvedSample) {
        (self.0)();
    }

    fn stops(&self) -> bool {
        false
    }
}

impl Ensemble<'_> {
    /// Outcomes of the samples 0 … `samples` − 1, in that order; `done` is called after each, from any thread.
    #[must_use]
    pub fn run(&self, samples: u64, done: impl Fn() + Sync) -> Vec<SampleOutcome> {
        self.solved(samples, done).outcomes
    }

    /// The same with the starts that they give to further samples.
    #[must_use]
    pub fn solved(&self, samples: u64, done: impl Fn() + Sync) -> Solved {
        let (mut solved, mut known) = (Solved::default(), Known::new());
        // a count never stops a run
        let _ = self.extend(&mut solved, &mut known, samples, &Counting(done));
        solved
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

    /// Goes on from `solved`, the first samples, to the samples 0 … `samples` − 1. Those that are `known` are taken from there.
    ///
    /// The samples of the first generation start from no other sample. Each later one starts from the generations before its
    /// own. So the starts of sample i depend on i, but not on the order of solving, the number of samples, or the samples that
    /// were solved already.
    ///
    /// # Errors
    /// [`Stopped`] if `watch` said so; what was solved until then it has been told.
    pub fn extend(
        &self,
        solved: &mut Solved,
        known: &mut Known,
        samples: u64,
        watch: &dyn Watch,
    ) -> Result<(), Stopped> {
        let mut atlas = Atlas::default();
        for generation in generations(samples) {
            let begun = generation.start.max(solved.outcomes.len() as u64);
            let missing: Vec<u64> = (begun..generation.end)
                .filter(|index| !known.contains_key(index))
                .collect();
            let new: Option<Vec<(u64, SolvedSample)>> = missing
                .into_par_iter()
                // one sample may take as long as a hundred others
                .with_max_len(1)
                .map(|index| Some((index, self.watched(index, &atlas, watch)?)))
                .collect();
            known.extend(new.ok_or(Stopped)?);
            for sample in (begun..generation.end).filter_map(|index| known.remove(&index)) {
                solved.outcomes.push(sample.outcome);
                solved.anchors.extend(sample.anchor);
            }
            let anchors = solved.anchors.iter().take(generation.end as usize);
            atlas.extend(anchors.skip(generation.start as usize).cloned());
        }
        Ok(())
    }

    /// Solves the samples `indices` of one generation from `anchors`, those of the generations before it. Only `watch` is told of
    /// the results.
    ///
    /// # Errors
    /// [`Stopped`] if `watch` said so.
    pub fn solve_from(
        &self,
        anchors: &[Anchor],
        indices: &[u64],
        watch: &dyn Watch,
    ) -> Result<(), Stopped> {
        let mut atlas = Atlas::default();
        atlas.extend(anchors.iter().cloned());
        let solved = indices.par_iter().with_max_len(1);
        let all = solved.all(|index| self.watched(*index, &atlas, watch).is_some());
        all.then_some(()).ok_or(Stopped)
    }

    /// Sample `index`, unless `watch` stops.
    fn watched(&self, index: u64, atlas: &Atlas, watch: &dyn Watch) -> Option<SolvedSample> {
        if watch.stops() {
            return None;
        }
        let (outcome, anchor) = self.sample(index, atlas);
        let anchor = (index < MOST_ANCHORS).then_some(anchor);
        let sample = SolvedSample { outcome, anchor };
        watch.solved(&sample);
        Some(sample)
    }
}

/// The samples 0 … `samples` − 1 by generation.
pub fn generations(samples: u64) -> impl Iterator<Item = Range<u64>> {
    let end = move |first: u64| match first {
        0 => FIRST_ANCHORS,
        _ if first < MOST_ANCHORS => (first + first / 2).min(MOST_ANCHORS),
        _ => samples,
    };
    let generation = move |first: u64| (first < samples).then(|| first..end(first).min(samples));
    std::iter::successors(generation(0), move |before| generation(before.end))
}
