//! Whether a GPU improves the predicted peaks of a run: the choice, and what came of it.

use super::shared::Ensemble;
pub use crate::gpu::GpuReport;
use crate::gpu::GpuSettings;
pub use crate::lockstep::LaneDevice;

/// Why `auto` leaves all studies to the processor (`benches/README.md`, gpu).
const WHY_NOT_AUTO: &str =
    "`auto` takes no GPU as long as none saves time: an H200 beside 16 cores did not";

/// What was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BackendChoice {
    /// The processor.
    #[default]
    Cpu,
    /// The GPU; the processor where it fails.
    Gpu,
    /// Whatever is faster: at present always the processor.
    Auto,
}

impl BackendReport {
    /// Who computed what, such as `CPU, double precision`.
    #[must_use]
    pub fn description(&self) -> String {
        match &self.gpu {
            None => "CPU, double precision".to_owned(),
            Some(_) => {
                "GPU improves predicted peaks in single precision, CPU decides in double precision"
                    .to_owned()
            }
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
        let unused = reason.map(|reason| format!("the processor does all of it: {reason}"));
        let notes = self.gpu.iter().flat_map(|gpu| &gpu.notes);
        unused
            .chain(notes.map(|note| format!("gpu: {note}")))
            .collect()
    }
}

/// Choice and settings of the backend.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BackendSettings {
    /// Who is asked.
    pub choice: BackendChoice,
    /// How the device is used.
    pub gpu: GpuSettings,
}

/// What solved a run.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct BackendReport {
    /// Why the processor did all of it, where a GPU was asked for.
    pub reason: Option<String>,
    /// The device's part.
    pub gpu: Option<GpuReport>,
}

/// The backend of a run, opened.
#[derive(Debug, Default)]
pub struct OpenBackend {
    gpu: Option<LaneDevice>,
    reason: Option<String>,
}

impl OpenBackend {
    /// Opens what was asked for, to solve `ensemble`.
    #[must_use]
    pub fn open(settings: &BackendSettings, ensemble: &Ensemble<'_>) -> Self {
        match Self::gpu_for(settings, ensemble) {
            Ok(gpu) => Self { gpu, reason: None },
            Err(reason) => Self {
                gpu: None,
                reason: Some(reason),
            },
        }
    }

    /// The device that was asked for; else why there is none.
    fn gpu_for(
        settings: &BackendSettings,
        ensemble: &Ensemble<'_>,
    ) -> Result<Option<LaneDevice>, String> {
        match settings.choice {
            BackendChoice::Cpu => return Ok(None),
            BackendChoice::Auto => return Err(WHY_NOT_AUTO.to_owned()),
            BackendChoice::Gpu => {}
        }
        ensemble.has_lanes()?;
        let aft = ensemble.settings.aft;
        let device = LaneDevice::open(GpuSettings {
            law: aft.law,
            events: aft.events,
            ..settings.gpu.clone()
        });
        device.map(Some).map_err(|error| error.to_string())
    }

    /// The device that improves predicted peaks, if any.
    #[must_use]
    pub fn gpu(&self) -> Option<&LaneDevice> {
        self.gpu.as_ref()
    }

    /// What became of it.
    #[must_use]
    pub fn report(&self) -> BackendReport {
        BackendReport {
            reason: self.reason.clone(),
            gpu: self.gpu.as_ref().map(|device| device.gpu.report()),
        }
    }
}
