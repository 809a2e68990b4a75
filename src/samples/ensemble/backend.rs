//! Who evaluates the contacts of a run: the choice, and what came of it.

use super::Ensemble;
use super::outcome::SampleOutcome;
pub use crate::gpu::GpuReport;
use crate::gpu::{Gpu, GpuSettings};
use crate::hb::HbSettings;
use crate::hb::newton::DRAFT_RESIDUAL;

/// Samples in flight per thread of the processor: two batches of half of them keep the device busy.
const SAMPLES_PER_TURN: usize = 32;
/// Samples in flight at most; each takes a thread and the memory of one solve.
const MOST_IN_FLIGHT: usize = 2048;

/// What was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BackendChoice {
    /// The processor.
    #[default]
    Cpu,
    /// The GPU; the processor where it fails.
    Gpu,
    /// The GPU if there is one that is hardware, else the processor.
    Auto,
}

impl BackendReport {
    /// Who computed what, such as `CPU, double precision`.
    #[must_use]
    pub fn description(&self) -> String {
        match &self.gpu {
            None => "CPU, double precision".to_owned(),
            Some(gpu) => format!(
                "GPU drafts contact forces in {}, CPU decides in double precision",
                gpu.precision.name()
            ),
        }
    }

    /// Name of the accelerator; absent without one.
    #[must_use]
    pub fn adapter(&self) -> Option<String> {
        self.gpu.as_ref().map(|gpu| gpu.adapter.name.clone())
    }

    /// What a reader of messages should know: why a GPU was not used, and what failed. One line each.
    #[must_use]
    pub fn messages(&self) -> Vec<String> {
        let reason = self.reason.iter();
        let unused = reason.map(|reason| format!("the processor evaluates the contacts: {reason}"));
        let notes = self.gpu.iter().flat_map(|gpu| &gpu.notes);
        unused
            .chain(notes.map(|note| format!("gpu: {note}")))
            .collect()
    }
}

/// Choice and settings of the backend.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BackendSettings {
    /// Who evaluates.
    pub choice: BackendChoice,
    /// How the device is used; `turns` is set by the run.
    pub gpu: GpuSettings,
}

/// What evaluated a run.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct BackendReport {
    /// Why the processor did all of it, where a GPU was asked for.
    pub reason: Option<String>,
    /// The device's part.
    pub gpu: Option<GpuReport>,
}

/// The backend of a run, opened.
#[derive(Debug)]
pub struct OpenBackend {
    gpu: Option<Gpu>,
    reason: Option<String>,
    turns: usize,
}

impl OpenBackend {
    /// Opens what was asked for, to solve with `solver`.
    #[must_use]
    pub fn open(settings: &BackendSettings, solver: &HbSettings) -> Self {
        let tolerance = solver.newton.tolerance;
        let turns = rayon::current_num_threads();
        let mut open = Self {
            gpu: None,
            reason: None,
            turns,
        };
        if settings.choice == BackendChoice::Cpu {
            return open;
        }
        if tolerance > DRAFT_RESIDUAL {
            open.reason = Some(format!(
                "solver.tolerance = {tolerance} is too coarse for drafts; the GPU needs at most {DRAFT_RESIDUAL}"
            ));
            return open;
        }
        let gpu = GpuSettings {
            turns,
            law: solver.aft.law,
            events: solver.aft.events,
            ..settings.gpu.clone()
        };
        match Gpu::open(gpu) {
            Ok(gpu) if settings.choice == BackendChoice::Auto && !gpu.adapter().is_hardware() => {
                let name = &gpu.adapter().name;
                open.reason = Some(format!("{name} is software, which `auto` never takes"));
            }
            Ok(gpu) => open.gpu = Some(gpu),
            Err(error) => open.reason = Some(error.to_string()),
        }
        open
    }

    /// The device that drafts contact forces, if any.
    #[must_use]
    pub fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_ref()
    }

    /// Outcomes of the samples 0 … `samples` − 1; `done` is called after each, from any thread.
    ///
    /// # Errors
    /// Those of [`OpenBackend::on_threads`].
    pub fn run(
        &self,
        ensemble: &Ensemble<'_>,
        samples: u64,
        done: impl Fn() + Sync + Send,
    ) -> Result<Vec<SampleOutcome>, rayon::ThreadPoolBuildError> {
        self.on_threads(samples, || ensemble.run(samples, done))
    }

    /// Does the `work`: with a GPU on a thread per sample in flight, `most_in_flight` of them, of which only as many compute as the
    /// pool has threads.
    ///
    /// # Errors
    /// What the operating system says if it does not give the threads.
    pub fn on_threads<T: Send>(
        &self,
        most_in_flight: u64,
        work: impl FnOnce() -> T + Send,
    ) -> Result<T, rayon::ThreadPoolBuildError> {
        if self.gpu.is_none() {
            return Ok(work());
        }
        let most = usize::try_from(most_in_flight)
            .unwrap_or(MOST_IN_FLIGHT)
            .max(1);
        let in_flight = (SAMPLES_PER_TURN * self.turns)
            .min(MOST_IN_FLIGHT)
            .min(most);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(in_flight)
            .build()?;
        Ok(pool.install(work))
    }

    /// What became of it.
    #[must_use]
    pub fn report(&self) -> BackendReport {
        BackendReport {
            reason: self.reason.clone(),
            gpu: self.gpu.as_ref().map(Gpu::report),
        }
    }
}
