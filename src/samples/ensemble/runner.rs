//! Many samples at once.
//!
//! The outcome of sample i is a function of the study and i alone. Samples share read-only data, and the number of a sample
//! decides from which other samples it starts. So neither the number of threads nor the order of solving changes a bit.

use super::atlas::{Anchor, Atlas};
use super::lanes::SAMPLES_OF_BATCH;
use super::outcome::{LevelOutcome, SampleOutcome};
use super::shared::Ensemble;
use super::stop::Stop;
use super::times::SampleTimes;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Number of samples of the first generation, which start from no other sample. Each later generation has half as many samples
/// as all before it.
pub const FIRST_ANCHORS: u64 = 5;
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

/// Samples that are solved already; there may be gaps.
#[derive(Debug, Clone, Default)]
pub struct Known {
    /// Their indices.
    pub indices: BTreeSet<u64>,
    /// The first [`MOST_ANCHORS`] of them as starts for others, by their index.
    pub anchors: BTreeMap<u64, Anchor>,
}

impl Known {
    /// The anchors of the samples before `end`, in their order.
    #[must_use]
    pub fn anchors_before(&self, end: u64) -> Vec<Anchor> {
        self.anchors.range(..end).map(|(_, a)| a.clone()).collect()
    }
}

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
    /// A sample was solved in this time. Called from any thread.
    fn solved(&self, sample: SolvedSample, times: SampleTimes);

    /// Whether no other sample is to begin.
    fn stops(&self) -> bool;
}

/// The run was told to stop before its last sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

/// A watch that keeps all samples.
struct Keeping<'s, F> {
    samples: Mutex<BTreeMap<u64, SampleOutcome>>,
    stop: &'s Stop,
    done: F,
}

impl<F: Fn(SampleTimes) + Sync> Watch for Keeping<'_, F> {
    fn solved(&self, sample: SolvedSample, times: SampleTimes) {
        let kept = self.samples.lock();
        let mut kept = kept.unwrap_or_else(PoisonError::into_inner);
        kept.insert(sample.outcome.index, sample.outcome);
        (self.done)(times);
    }

    fn stops(&self) -> bool {
        self.stop.asked()
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
        // nobody asks it to stop
        let solved = self.solved_until(samples, &Stop::default(), |_| done());
        solved.unwrap_or_default()
    }

    /// The same unless `stop` is asked to; `done` is told the time of each sample.
    ///
    /// # Errors
    /// [`Stopped`] if so.
    pub fn solved_until(
        &self,
        samples: u64,
        stop: &Stop,
        done: impl Fn(SampleTimes) + Sync,
    ) -> Result<Solved, Stopped> {
        let mut known = Known::default();
        let watch = Keeping {
            samples: Mutex::default(),
            stop,
            done,
        };
        self.extend(&mut known, samples, &watch)?;
        let kept = watch.samples.into_inner();
        let kept = kept.unwrap_or_else(PoisonError::into_inner);
        Ok(Solved {
            outcomes: kept.into_values().collect(),
            anchors: known.anchors.into_values().collect(),
        })
    }

    /// Solves at inputs that are no samples of the design, on the processor, started from `anchors`. The results depend on the
    /// inputs and the anchors alone, neither on threads nor on the backend. Shape of a result: `[levels]`.
    pub(super) fn solver_from(
        &self,
        anchors: &[Anchor],
    ) -> impl Fn(&[f64]) -> Vec<LevelOutcome> + Sync {
        let on_processor = Ensemble { gpu: None, ..*self };
        let atlas: Atlas = anchors.iter().cloned().collect();
        move |inputs| on_processor.levels(inputs, &atlas)
    }

    /// Solves those of the samples 0 … `samples` − 1 that are not `known`, and adds them there. `watch` is told of each.
    ///
    /// The samples of the first generation start from no other sample. Each later one starts from the generations before its
    /// own. So the starts of sample i depend on i, but not on the order of solving, the number of samples, or the samples that
    /// were solved already.
    ///
    /// # Errors
    /// [`Stopped`] if `watch` said so; what was solved until then it has been told.
    pub fn extend(
        &self,
        known: &mut Known,
        samples: u64,
        watch: &dyn Watch,
    ) -> Result<(), Stopped> {
        let mut atlas = Atlas::default();
        for generation in generations(samples) {
            let missing = generation.clone().filter(|i| !known.indices.contains(i));
            let missing: Vec<u64> = missing.collect();
            if generation.start < MOST_ANCHORS {
                for batch in self.batches(&missing) {
                    self.improve_predictions(&atlas, batch);
                    let costly_first = self.costly_first(&atlas, batch).into_iter();
                    let new: Option<Vec<(u64, Anchor)>> = (costly_first.par_bridge())
                        .map(|index| Some((index, self.watched(index, &atlas, watch)?)))
                        .collect();
                    atlas.inverses().forget_starts();
                    known.anchors.extend(new.ok_or(Stopped)?);
                }
                let anchors = known.anchors.range(generation);
                atlas.extend(anchors.map(|(_, anchor)| anchor.clone()));
            } else {
                self.solve_with(&atlas, &missing, watch)?;
            }
            known.indices.extend(missing);
        }
        Ok(())
    }

    /// The samples `indices` in the order in which they are begun. One sample may take as long as a hundred others: begun last it would keep
    /// one thread at work while all others wait for the next generation.
    fn costly_first(&self, atlas: &Atlas, indices: &[u64]) -> Vec<u64> {
        let work = |&index: &u64| {
            let place = self.design.place(&self.design.sample(index));
            Reverse(atlas.expected_work(&place))
        };
        let mut ordered = indices.to_vec();
        ordered.sort_by_cached_key(work);
        ordered
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
        let atlas: Atlas = anchors.iter().cloned().collect();
        self.solve_with(&atlas, indices, watch)
    }

    fn solve_with(&self, atlas: &Atlas, indices: &[u64], watch: &dyn Watch) -> Result<(), Stopped> {
        for batch in self.batches(indices) {
            self.improve_predictions(atlas, batch);
            // in their order, so that a part holds neighbours
            let solved = batch.iter().par_bridge();
            let all = solved.all(|&index| self.watched(index, atlas, watch).is_some());
            atlas.inverses().forget_starts();
            all.then_some(()).ok_or(Stopped)?;
        }
        Ok(())
    }

    /// Samples that are solved together: with a device as many as its lanes hold at a time, else all.
    fn batches<'i>(&self, indices: &'i [u64]) -> std::slice::Chunks<'i, u64> {
        indices.chunks(match self.gpu {
            Some(_) => SAMPLES_OF_BATCH,
            None => indices.len().max(1),
        })
    }

    /// Solves sample `index`, unless `watch` stops, and tells it the result. Gives the sample as a start for others.
    fn watched(&self, index: u64, atlas: &Atlas, watch: &dyn Watch) -> Option<Anchor> {
        if watch.stops() {
            return None;
        }
        let (outcome, anchor, times) = self.timed_sample(index, atlas);
        let solved = SolvedSample {
            outcome,
            anchor: (index < MOST_ANCHORS).then(|| anchor.clone()),
        };
        watch.solved(solved, times);
        Some(anchor)
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
