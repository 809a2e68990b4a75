//! Inverse Jacobians at the peaks of the first samples, as preconditioners for the peaks of later ones.

use crate::hb::equations::free::StaticReference;
use crate::hb::equations::inverse::InverseJacobian;
use crate::hb::peak::predicted::PeakPrediction;
use crate::lockstep::Lanes;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Anchor, level and mode of a peak.
pub(super) type PeakOfAnchor = (usize, usize, usize);
/// Place of a sample in the unit cube to the bit, level and mode.
pub(super) type StartOfSample = (Vec<u64>, usize, usize);
/// What is made when it is first asked for, by any thread; none where there is no such.
pub(super) type Made<T> = OnceLock<Option<T>>;

/// The inverses of an atlas.
#[derive(Debug, Default)]
pub(super) struct Inverses {
    /// What holds harmonic 0.
    pub(super) reference: Made<StaticReference>,
    /// Compiled for the device of the run.
    pub(super) lanes: Lanes,
    /// Predictions that a device has improved, until their samples are solved.
    starts: Mutex<BTreeMap<StartOfSample, PeakPrediction>>,
    cells: Mutex<BTreeMap<PeakOfAnchor, Arc<Made<InverseJacobian>>>>,
}

impl Inverses {
    /// Keeps a better prediction of the peak at `at`.
    pub(super) fn keep_start(&self, at: StartOfSample, start: PeakPrediction) {
        let mut starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        starts.insert(at, start);
    }

    /// Takes it.
    pub(super) fn take_start(&self, at: &StartOfSample) -> Option<PeakPrediction> {
        let mut starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        starts.remove(at)
    }

    /// Forgets those that no sample took: one that is stopped, or that has not the modes of its neighbour.
    pub(super) fn forget_starts(&self) {
        let mut starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        starts.clear();
    }

    /// Place of the inverse at this peak.
    pub(super) fn at(&self, peak: PeakOfAnchor) -> Arc<Made<InverseJacobian>> {
        let cells = self.cells.lock();
        let mut cells = cells.unwrap_or_else(PoisonError::into_inner);
        Arc::clone(cells.entry(peak).or_default())
    }
}
