//! The modes of all maxima of a sample, where a study follows all modes.

use super::outcome::{FollowedModes, ModeOfMaximum};
use super::shared::Ensemble;
use crate::hb::equations::problem::stuck_stiffness;
use crate::hb::peak::attribution::{ModeOfMaximum as Attributed, ModeShapes};
use crate::hb::peak::maxima::Maxima;
use crate::hb::{LinearModel, Problem};
use crate::sampling::design::in_32_bits;

impl Ensemble<'_> {
    /// The modes that maxima of a sample with the structure `linear` may belong to: those with the nominal contacts stuck, so that
    /// they do not depend on the contacts of the sample. Absent where the study does not follow all modes.
    pub(super) fn mode_shapes(&self, linear: &LinearModel) -> Option<ModeShapes> {
        if self.mode_numbers.is_empty() {
            return None;
        }
        ModeShapes::new(linear, &stuck_stiffness(self.contacts)).ok()
    }

    /// The modes of `maxima`.
    pub(super) fn followed_modes(
        &self,
        problem: &Problem<'_>,
        shapes: &ModeShapes,
        maxima: &Maxima,
    ) -> FollowedModes {
        let solutions = match maxima.peak() {
            Some(_) => maxima.distinct(),
            None => Vec::new(),
        };
        let mode = |found: Option<Attributed>| {
            let number = found.and_then(|found| self.mode_numbers.get(found.mode));
            ModeOfMaximum {
                number: number.copied().unwrap_or_default(),
                share: found.map_or(0.0, |found| found.share),
            }
        };
        FollowedModes {
            of_maxima: (shapes.attributed(problem, &solutions).into_iter())
                .map(mode)
                .collect(),
            unfinished: in_32_bits(maxima.unfinished),
        }
    }
}
