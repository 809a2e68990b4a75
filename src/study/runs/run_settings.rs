//! How a run is carried out.

use std::time::Duration;

use crate::ensemble::backend::BackendSettings;
use crate::ensemble::parts::FLUSH_EVERY;
use crate::ensemble::stop::Stop;

/// How a run is carried out. Nothing of it changes a result.
#[derive(Debug, Clone)]
pub struct RunSettings {
    /// Whether a GPU improves the predicted peaks; what it fails to do the processor does.
    pub backend: BackendSettings,
    /// Ends the run before its last sample.
    pub stop: Stop,
    /// What is solved is on the disk after this time at the latest.
    pub flush_every: Duration,
    /// Solves those samples again that an earlier process left without a solution.
    pub retry_failed: bool,
    /// Takes over samples of another program or instruction set; summary and report name it.
    pub any_program: bool,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self {
            backend: BackendSettings::default(),
            stop: Stop::default(),
            flush_every: FLUSH_EVERY,
            retry_failed: false,
            any_program: false,
        }
    }
}
