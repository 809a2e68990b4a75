//! In place of the device in a build without the feature `gpu`.

use super::search::LaneSearch;
use super::system::LaneSystem;
use crate::gpu::Gpu;
use crate::hb::equations::balance::Balance;
use crate::hb::peak::predicted::PeakPrediction;

/// Kernels for lanes, of which there are none in this build.
#[derive(Debug, Default)]
pub struct Lanes;

impl Lanes {
    /// Nobody has a device to ask.
    pub fn improved(
        &self,
        gpu: &Gpu,
        _: (&LaneSystem, &Balance<'_>),
        _: Vec<LaneSearch<'_>>,
    ) -> Vec<Option<PeakPrediction>> {
        match *gpu {}
    }
}
