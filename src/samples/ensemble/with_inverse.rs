//! Peaks that are found with the inverse Jacobian of an anchor.
//!
//! Which inverse a sample takes is decided by its inputs and by the first anchors, which all processes of a run share. So
//! neither the number of threads nor the order of solving changes a bit.

use super::atlas::{Atlas, AtlasPrediction, NearAnchor, Place};
use super::inverses::Lazy;
use super::shared::Ensemble;
use crate::hb::equations::free::StaticReference;
use crate::hb::equations::inverse::InverseJacobian;
use crate::hb::peak::anchored::AnchorInverse;
use std::sync::Arc;

/// Samples in the atlas from which on inverses pay: before, there are too few samples left for what they cost.
const LEAST_ANCHORS: usize = 244;
/// The inverses of this many first anchors may be used.
const ANCHORS_WITH_INVERSE: usize = 15;
/// Most unknowns: the memory and the time of an inverse grow with their square and cube.
pub(super) const MOST_UNKNOWNS: usize = 800;
/// Most memory of all inverses (bytes); fewer anchors have one where they would take more.
const MOST_BYTES: usize = 128 << 20;

impl Ensemble<'_> {
    /// Whether samples that start from `atlas` take inverses.
    pub(super) fn takes_inverses(&self, atlas: &Atlas) -> bool {
        // a strip of another thickness is another structure
        atlas.len() >= LEAST_ANCHORS && self.strips.is_none()
    }

    /// What `search` finds with the inverse of an anchor near `at`; none without inverse.
    pub(super) fn with_inverse<T>(
        &self,
        atlas: &Atlas,
        at: &Place<'_>,
        prediction: &AtlasPrediction,
        search: impl FnOnce(AnchorInverse<'_>) -> Option<T>,
    ) -> Option<T> {
        let reference = self.reference_of(atlas)?;
        let inverse = self.inverse_near(atlas, at, prediction)?;
        let inverse = inverse.get()?.as_ref()?;
        search(AnchorInverse { reference, inverse })
    }

    /// What holds harmonic 0 of all samples that start from `atlas`.
    pub(super) fn reference_of<'t>(&self, atlas: &'t Atlas) -> Option<&'t StaticReference> {
        let reference = &atlas.inverses().reference;
        reference.get_or_init(|| self.reference()).as_ref()
    }

    /// The inverse that is taken for the peak `prediction` at `at`; none where inverses do not pay.
    pub(super) fn inverse_near(
        &self,
        atlas: &Atlas,
        at: &Place<'_>,
        prediction: &AtlasPrediction,
    ) -> Option<Arc<Lazy<InverseJacobian>>> {
        let unknowns = prediction.peak.point.r.len();
        let bytes = unknowns * unknowns * size_of::<f32>() * self.levels.len();
        let first = ANCHORS_WITH_INVERSE.min(MOST_BYTES / bytes.max(1));
        if !self.takes_inverses(atlas) || unknowns > MOST_UNKNOWNS || first == 0 {
            return None;
        }
        let (number, anchor) = atlas.nearest_of_first(first, at, &prediction.harmonics)?;
        let reference = self.reference_of(atlas)?;
        let cell = atlas.inverses().at((number, at.level, at.mode));
        cell.get_or_init(|| self.inverse(reference, at.level, &anchor));
        Some(cell)
    }

    /// The nominal structure at rest.
    fn reference(&self) -> Option<StaticReference> {
        let applied = self.applied(&[]).ok()?;
        let problem = applied.problem(self.settings.anchor).ok()?;
        Some(StaticReference::new(&problem))
    }

    /// The inverse Jacobian at the peak of `anchor` at level number `level`.
    fn inverse(
        &self,
        reference: &StaticReference,
        level: usize,
        anchor: &NearAnchor<'_>,
    ) -> Option<InverseJacobian> {
        let inputs = self.design.values_at(anchor.place);
        let known = anchor.peak.as_prediction();
        self.search_at(&inputs, level, known, |balance, peak| {
            AnchorInverse::inverse_at(reference, balance, &peak.point)
        })
    }
}
