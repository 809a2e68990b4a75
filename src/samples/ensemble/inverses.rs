//! Inverse Jacobians at the peaks of the first samples, as preconditioners for the peaks of later ones.

use crate::hb::equations::free::StaticReference;
use crate::hb::equations::inverse::InverseJacobian;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Anchor, level and mode of a peak.
pub(super) type PeakOfAnchor = (usize, usize, usize);
/// What is made when it is first asked for, by any thread; none where there is no such.
pub(super) type Made<T> = OnceLock<Option<T>>;

/// The inverses of an atlas.
#[derive(Debug, Default)]
pub(super) struct Inverses {
    /// What holds harmonic 0.
    pub(super) reference: Made<StaticReference>,
    cells: Mutex<BTreeMap<PeakOfAnchor, Arc<Made<InverseJacobian>>>>,
}

impl Inverses {
    /// Place of the inverse at this peak.
    pub(super) fn at(&self, peak: PeakOfAnchor) -> Arc<Made<InverseJacobian>> {
        let cells = self.cells.lock();
        let mut cells = cells.unwrap_or_else(PoisonError::into_inner);
        Arc::clone(cells.entry(peak).or_default())
    }
}
