//! A disk whose blades differ from sample to sample.

use crate::hb::ProblemError;
use crate::hb::structure::mistuned::{MistunedRing, highest_combined};
use crate::model::disk::Disk;

/// A disk whose blades differ from sample to sample.
#[derive(Debug, Clone)]
pub struct MistunedDisk {
    pub(super) disk: Disk,
    pub(super) engine_order: usize,
    pub(super) ring: MistunedRing,
}

impl MistunedDisk {
    /// All sectors of a disk under an engine order; `highest` is the upper end of the band (rad/s).
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub fn new(disk: Disk, engine_order: usize, highest: f64) -> Result<Self, ProblemError> {
        let highest = highest_combined(&disk, highest);
        Ok(Self {
            ring: MistunedRing::new(&disk, engine_order, highest)?,
            disk,
            engine_order,
        })
    }
}
