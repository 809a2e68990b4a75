//! Inverse Jacobians at the peaks of the first samples, as preconditioners for the peaks of later ones.

use crate::hb::equations::free::StaticReference;
use crate::hb::equations::inverse::InverseJacobian;
use crate::hb::peak::predicted::PeakPrediction;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Anchor, level and mode of a peak.
pub(super) type PeakOfAnchor = (usize, usize, usize);
/// Place of a sample in the unit cube to the bit, level and mode.
pub(super) type StartOfSample = (Vec<u64>, usize, usize);
/// Computed on first use, by any thread; `None` where it cannot be computed.
pub(super) type Lazy<T> = OnceLock<Option<T>>;

/// The inverses of an atlas.
#[derive(Debug, Default)]
pub(super) struct Inverses {
    /// What holds harmonic 0.
    pub(super) reference: Lazy<StaticReference>,
    /// Predictions that a device has improved, until the samples of their batch are solved.
    starts: Mutex<BTreeMap<StartOfSample, PeakPrediction>>,
    cells: Mutex<BTreeMap<PeakOfAnchor, Arc<Lazy<InverseJacobian>>>>,
}

impl Inverses {
    /// Keeps a better prediction of the peak at `at`.
    pub(super) fn keep_start(&self, at: StartOfSample, start: PeakPrediction) {
        let mut starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        starts.insert(at, start);
    }

    /// The better prediction of the peak at `at`, if there is one. It stays: samples may be equal.
    pub(super) fn start(&self, at: &StartOfSample) -> Option<PeakPrediction> {
        let starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        starts.get(at).cloned()
    }

    /// Forgets them all.
    pub(super) fn forget_starts(&self) {
        let mut starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        starts.clear();
    }

    /// Place of the inverse at this peak.
    pub(super) fn at(&self, peak: PeakOfAnchor) -> Arc<Lazy<InverseJacobian>> {
        let cells = self.cells.lock();
        let mut cells = cells.unwrap_or_else(PoisonError::into_inner);
        Arc::clone(cells.entry(peak).or_default())
    }
}
