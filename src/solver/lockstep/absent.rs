//! In place of the device in a build without the feature `gpu`.

use super::search::LaneSearch;
use super::system::LaneSystem;
use crate::gpu::{Gpu, GpuError, GpuSettings};
use crate::hb::equations::balance::Balance;
use crate::hb::peak::predicted::PeakPrediction;

/// A device for lanes, of which there is none in this build.
#[derive(Debug)]
pub struct LaneDevice {
    /// The device.
    pub gpu: Gpu,
}

impl LaneDevice {
    /// There is none.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`].
    pub fn open(settings: GpuSettings) -> Result<Self, GpuError> {
        Gpu::open(settings).map(|gpu| Self { gpu })
    }

    /// Nobody has a device to ask.
    pub fn improved(
        &self,
        _: &LaneSystem,
        _: &Balance<'_>,
        _: Vec<LaneSearch<'_>>,
    ) -> Vec<Option<PeakPrediction>> {
        match self.gpu {}
    }
}
