//! Where the time of a process goes that carries out a run.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::ensemble::times::SampleTimes;

/// A stage of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunStage {
    /// The model is built.
    Model,
    /// Samples are solved.
    Samples,
    /// One input at a time.
    OneAtATime,
    /// Search for worst cases of the epistemic inputs.
    WorstCases,
    /// Samples on few harmonics.
    ControlVariate,
    /// Tables are written from the parts.
    Tables,
    /// Statistics and report.
    Report,
}

impl RunStage {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Samples => "samples",
            Self::OneAtATime => "one input at a time",
            Self::WorstCases => "search for worst cases",
            Self::ControlVariate => "control variate",
            Self::Tables => "tables",
            Self::Report => "report",
        }
    }
}

/// Where the time of one process went. It is not stored with the results, which are the same for any time.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    /// Wall time of each stage, in their order; a stage that was not needed is absent.
    pub stages: Vec<(RunStage, Duration)>,
    /// Time of the samples, the sum over the threads.
    pub samples: SampleTimes,
}

/// Measures stages, from any thread.
#[derive(Debug, Default)]
pub(super) struct Profiler(Mutex<Profile>);

impl Profiler {
    /// Does the `work` of a stage.
    pub(super) fn stage<T>(&self, stage: RunStage, work: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let result = work();
        let time = begun.elapsed();
        self.with(
            |profile| match profile.stages.iter_mut().find(|(known, _)| *known == stage) {
                Some((_, sum)) => *sum += time,
                None => profile.stages.push((stage, time)),
            },
        );
        result
    }

    /// A sample took so long.
    pub(super) fn add(&self, times: SampleTimes) {
        self.with(|profile| profile.samples += times);
    }

    /// What was measured so far.
    pub(super) fn read(&self) -> Profile {
        self.with(|profile| profile.clone())
    }

    fn with<T>(&self, of: impl FnOnce(&mut Profile) -> T) -> T {
        // a thread that panicked has spoiled no time
        of(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
