//! A process at work on a run.

use super::profile::{Profiler, RunStage};
use super::progress::{Meter, Progress};
use super::resume::{Resumed, refuse_other_results};
use super::run_record::provenance;
use super::run_settings::RunSettings;
use crate::Error;
use crate::ensemble::backend::OpenBackend;
use crate::ensemble::memory::{available_bytes, samples_at_once};
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::parts::{PartFolder, PartHead, PartWriter, RunIdentity};
use crate::ensemble::runner::{Stopped, Watch};
use crate::ensemble::times::SampleTimes;
use crate::ensemble::{Ensemble, Known};
use crate::study::output::OutputFolder;
use crate::study::prepared::PreparedStudy;
use crate::study::settings::read::Study;

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
    pub meter: &'a Meter<F>,
    pub profiler: Profiler,
    /// What a user should know, one line each.
    pub notes: Vec<String>,
}

/// Builds the model, opens the backend, and does the `work`, of which `meter` counts the samples. As many samples are solved at once as
/// there are threads, or fewer where the memory is not enough.
///
/// # Errors
/// Whatever building the model refuses; [`Error::Unfit`] if sample 0 is not what it was, or no sample fits into the memory;
/// [`Error::Threads`] if the system gives no more threads; those of `work`.
pub(super) fn at_work<T: Send, F: Fn(Progress) + Sync>(
    begun: Begun<'_>,
    meter: Meter<F>,
    work: impl FnOnce(&Session<'_, F>) -> Result<T, Error> + Send,
) -> Result<T, Error> {
    let profiler = Profiler::default();
    let prepared = profiler.stage(RunStage::Model, || begun.study.prepared())?;
    let at_once = samples_that_fit(&prepared)?;
    let threads = rayon::current_num_threads();
    if at_once >= threads {
        return on_this_pool(begun, &prepared, profiler, Vec::new(), &meter, work);
    }
    let note = format!(
        "{at_once} of {threads} threads solve: a sample takes up to {:.0} MB of memory, of which there is not enough for more",
        prepared.solve_memory()[1] / 1e6
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(at_once).build();
    let pool = pool.map_err(|error| Error::Threads(error.to_string()))?;
    pool.install(|| on_this_pool(begun, &prepared, profiler, vec![note], &meter, work))
}

/// Number of samples that the memory has room for at once.
fn samples_that_fit(prepared: &PreparedStudy<'_>) -> Result<usize, Error> {
    let Some(available) = available_bytes() else {
        return Ok(usize::MAX);
    };
    samples_at_once(prepared.solve_memory(), available)
        .map_err(|message| Error::unfit(&prepared.study.path, message))
}

/// The same on the threads of this pool.
fn on_this_pool<T, F: Fn(Progress) + Sync>(
    begun: Begun<'_>,
    prepared: &PreparedStudy<'_>,
    profiler: Profiler,
    notes: Vec<String>,
    meter: &Meter<F>,
    work: impl FnOnce(&Session<'_, F>) -> Result<T, Error>,
) -> Result<T, Error> {
    let Begun {
        study,
        folder,
        settings,
        identity,
        first,
    } = begun;
    let backend = OpenBackend::open(&settings.backend, &prepared.ensemble(None));
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
            provenance: provenance(prepared),
            input_names: inputs.map(|(input, _)| input.name().to_owned()).collect(),
        },
        parts: PartFolder::of(folder.path()),
        prepared,
        settings,
        meter,
        profiler,
        notes,
    })
}

/// A part, a claim or a result could not be written.
pub(super) fn unwritten(error: impl Into<Error>) -> Error {
    Error::Unwritten(Box::new(error.into()))
}

/// How often samples are solved whose parts have gone.
const ATTEMPTS: usize = 3;

impl<F: Fn(Progress) + Sync> Session<'_, F> {
    /// Does the `work`, whose results are written as parts.
    pub(super) fn written(
        &self,
        work: impl FnOnce(&dyn Watch) -> Result<(), Stopped> + Send,
    ) -> Result<(), Error> {
        let (stop, every) = (&self.settings.stop, self.settings.flush_every);
        let ended = std::thread::scope(|scope| {
            let done = |times: SampleTimes| {
                self.profiler.add(times);
                self.meter.one_more(times.newton_iterations);
            };
            let (writer, collector) =
                PartWriter::start(scope, &self.parts, &self.head, stop, every, done);
            let ended = self.profiler.stage(RunStage::Samples, || work(&collector));
            drop(collector);
            writer.finish().map_err(unwritten)?;
            Ok::<_, Error>(ended)
        })?;
        ended.map_err(|Stopped| self.stopped())
    }

    /// Does the `work` until none of its samples is `missing` in parts or results: somebody may have deleted or damaged some.
    ///
    /// # Errors
    /// Those of [`Session::written`], and [`Error::Results`] if parts go again and again.
    pub(super) fn kept(
        &self,
        resumed: &mut Resumed,
        missing: impl Fn(&Known) -> u64,
        work: impl Fn(&mut Known, &dyn Watch) -> Result<(), Stopped> + Sync,
    ) -> Result<(), Error> {
        for _ in 0..ATTEMPTS {
            self.written(|watch| work(&mut resumed.known, watch))?;
            resumed.look_again(&self.parts, &self.head.identity, self.settings)?;
            match missing(&resumed.known) {
                0 => return Ok(()),
                lost => {
                    resumed.say_missing(lost);
                    self.meter.expect(lost);
                }
            }
        }
        let message = "parts are deleted or damaged while the run writes them: find out by whom, then `run` again".to_owned();
        Err(Error::results(self.parts.path(), message))
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
