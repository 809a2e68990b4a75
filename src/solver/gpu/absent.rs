//! In place of the device in a build without the feature `gpu`.

use super::error::GpuError;
use super::report::{AdapterFacts, GpuReport};
use super::settings::GpuSettings;

/// A device, of which there is none in this build.
#[derive(Debug)]
pub enum Gpu {}

impl Gpu {
    /// Refuses.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], always.
    pub fn open(_: GpuSettings) -> Result<Self, GpuError> {
        Err(GpuError::NoAdapter {
            message: "this program was built without GPU support (feature gpu)".to_owned(),
        })
    }

    /// The adapter.
    #[must_use]
    pub fn adapter(&self) -> &AdapterFacts {
        match *self {}
    }

    /// Whether the processor searches the peak of these `inputs` again.
    #[must_use]
    pub fn compares(&self, _: &[f64]) -> bool {
        match *self {}
    }

    /// Records one comparison of both searches: relative differences of frequency and amplitude, and whether they are beyond the limit.
    pub fn compared(&self, _: [f64; 2], _: bool) {
        match *self {}
    }

    /// What the device has done so far.
    #[must_use]
    pub fn report(&self) -> GpuReport {
        match *self {}
    }
}

/// Every adapter that this build can use: none.
#[must_use]
pub fn adapters() -> Vec<AdapterFacts> {
    Vec::new()
}

/// The words of a self-test; there is no adapter to ask for one.
#[must_use]
pub fn examined(_: usize) -> String {
    "not built in".to_owned()
}
