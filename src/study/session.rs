//! A process at work on a run.

use super::output::OutputFolder;
use super::prepared::PreparedStudy;
use super::profile::{Profiler, Stage};
use super::progress::{Meter, Progress};
use super::read::Study;
use super::resume::{Resumed, refuse_other_results};
use super::run_record::provenance;
use super::run_settings::RunSettings;
use crate::Error;
use crate::ensemble::Ensemble;
use crate::ensemble::backend::OpenBackend;
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::parts::{PartFolder, PartHead, PartWriter, RunIdentity};
use crate::ensemble::runner::{Stopped, Watch};
use crate::ensemble::times::SampleTimes;

/// What a process knows before it begins.
pub(super) struct Begun<'a> {
    study: &'a Study,
    folder: &'a OutputFolder,
    settings: &'a RunSettings,
    identity: RunIdentity,
    /// Sample 0, if it is solved already.
    first: Option<SampleOutcome>,
}

impl<'a> Begun<'a> {
    /// A process that takes over samples.
    pub(super) fn with(
        resumed: &Resumed,
        study: &'a Study,
        folder: &'a OutputFolder,
        settings: &'a RunSettings,
        identity: RunIdentity,
    ) -> Self {
        Self {
            study,
            folder,
            settings,
            identity,
            first: resumed.first.clone(),
        }
    }
}

/// A process at work on a run: it solves, and what it has solved is written as parts.
pub(super) struct Session<'a, F> {
    pub prepared: &'a PreparedStudy<'a>,
    pub folder: &'a OutputFolder,
    pub ensemble: &'a Ensemble<'a>,
    pub backend: &'a OpenBackend,
    pub head: PartHead,
    pub parts: PartFolder,
    pub settings: &'a RunSettings,
    pub meter: Meter<F>,
    pub profiler: Profiler,
}

/// Builds the model, opens the backend, and does the `work`, of which `meter` counts the samples.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Command`] if sample 0 is not what it was; those of `work`.
pub(super) fn at_work<T, F: Fn(Progress) + Sync>(
    begun: Begun<'_>,
    meter: Meter<F>,
    work: impl FnOnce(&Session<'_, F>) -> Result<T, Error>,
) -> Result<T, Error> {
    let Begun {
        study,
        folder,
        settings,
        identity,
        first,
    } = begun;
    let backend = OpenBackend::open(&settings.backend, &study.solver);
    let profiler = Profiler::default();
    let prepared = profiler.stage(Stage::Model, || study.prepared())?;
    let ensemble = prepared.ensemble(backend.gpu());
    if let Some(first) = first.filter(|_| !settings.any_program) {
        refuse_other_results(study, &ensemble, &first)?;
    }
    let inputs = study.design.inputs().iter();
    work(&Session {
        folder,
        ensemble: &ensemble,
        backend: &backend,
        head: PartHead {
            identity,
            provenance: provenance(study, prepared.folded()),
            input_names: inputs.map(|(input, _)| input.name().to_owned()).collect(),
        },
        parts: PartFolder::of(folder.path()),
        prepared: &prepared,
        settings,
        meter,
        profiler,
    })
}

impl<F: Fn(Progress) + Sync> Session<'_, F> {
    /// Does the `work` of so many samples, whose results are written as parts.
    pub(super) fn written(
        &self,
        samples: u64,
        work: impl FnOnce(&dyn Watch) -> Result<(), Stopped> + Send,
    ) -> Result<(), Error> {
        let control = (&self.settings.stop, self.settings.flush_every);
        let ended = std::thread::scope(|scope| {
            let done = |times: SampleTimes| {
                self.profiler.add(times);
                self.meter.one_more(times.newton_iterations);
            };
            let (writer, collector) =
                PartWriter::start(scope, &self.parts, &self.head, control, done);
            let ended = self.profiler.stage(Stage::Samples, || {
                self.backend.on_threads(samples, || work(&collector))
            });
            drop(collector);
            writer.finish()?;
            ended.map_err(|error| Error::Threads(error.to_string()))
        })?;
        ended.map_err(|Stopped| self.stopped())
    }

    /// The run was stopped.
    pub(super) fn stopped(&self) -> Error {
        Error::Stopped {
            folder: self.folder.path().to_owned(),
            done: self.meter.done(),
            samples: self.ensemble.design.samples(),
        }
    }
}
