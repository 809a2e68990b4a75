//! Many samples at once.
//!
//! The outcome of sample i is a function of the study and i alone: samples share read-only data, and what they start
//! from is decided by their numbers, so the number of threads and the order of solving change no bit.

use super::atlas::{Anchor, Atlas};
use super::outcome::SampleOutcome;
use crate::aft::Backend;
use crate::contact::ContactParameters;
use crate::hb::peak::PeakSettings;
use crate::hb::{HbSettings, LinearModel};
use crate::sampling::Design;
use rayon::prelude::*;

/// What all samples of a study share.
#[derive(Debug, Clone, Copy)]
pub struct Ensemble<'a> {
    /// Linear part of the model.
    pub linear: &'a LinearModel,
    /// Nominal constants of the contact pairs.
    pub contacts: &'a [ContactParameters<f64>],
    /// Random inputs.
    pub design: &'a Design,
    /// Excitation levels, ascending.
    pub levels: &'a [f64],
    /// Solver.
    pub settings: &'a HbSettings,
    /// Where peaks are searched and how exactly.
    pub peak: PeakSettings,
    /// Samples with a forced response curve: 0 … this − 1.
    pub curve_samples: u64,
    /// Who evaluates the contacts.
    pub backend: Backend<'a>,
}

/// Samples solved without help: the first part of the atlas.
const FIRST_ANCHORS: u64 = 8;
/// Samples in the atlas at most.
const MOST_ANCHORS: u64 = 1024;

impl Ensemble<'_> {
    /// Outcomes of the samples 0 … `samples` − 1, in that order; `done` is called after each, from any thread.
    ///
    /// The first samples are solved on their own, each later one starts from samples before the last power of two: what
    /// sample i starts from depends on i, not on the order of solving or the number of samples.
    #[must_use]
    pub fn run(&self, samples: u64, done: impl Fn() + Sync) -> Vec<SampleOutcome> {
        let mut atlas = Atlas::default();
        let mut outcomes = Vec::new();
        let mut first = 0;
        while first < samples {
            let end = match first {
                0 => FIRST_ANCHORS,
                _ if first < MOST_ANCHORS => 2 * first,
                _ => samples,
            };
            let solved: Vec<(SampleOutcome, Option<Anchor>)> = (first..end.min(samples))
                .into_par_iter()
                .map(|index| {
                    let (outcome, anchor) = self.sample(index, &atlas);
                    done();
                    (outcome, (index < MOST_ANCHORS).then_some(anchor))
                })
                .collect();
            let (solved, anchors): (Vec<_>, Vec<_>) = solved.into_iter().unzip();
            outcomes.extend(solved);
            atlas.extend(anchors.into_iter().flatten());
            first = end;
        }
        outcomes
    }
}
