//! Samples at further points of the box of the epistemic inputs: the same random inputs as at its outer points.

use super::atlas::Anchor;
use super::outcome::{SampleOutcome, newton_iterations};
use super::shared::Ensemble;
use crate::sampling::design::in_32_bits;
use rayon::prelude::*;

/// A point of the box beside the outer points of the design.
#[derive(Debug, Clone, PartialEq)]
pub struct FurtherPoint {
    /// Its number, after those of the outer points.
    pub outer: u64,
    /// Values of the epistemic inputs.
    pub values: Vec<f64>,
}

impl Ensemble<'_> {
    /// Every inner sample at each of `points`, started from all `anchors`: they depend neither on threads nor on the backend.
    /// `done` is called after each with its Newton iterations, from any thread.
    ///
    /// Sample numbers follow those of the design's samples, point after point.
    #[must_use]
    pub fn at_further_points(
        &self,
        points: &[FurtherPoint],
        anchors: &[Anchor],
        done: impl Fn(u64) + Sync,
    ) -> Vec<SampleOutcome> {
        let solved = self.solver_from(anchors);
        let design = self.design;
        let inner = design.samples() / design.outer_points();
        let sample = |(point, i): (&FurtherPoint, u64)| {
            let inputs = design.at_point(i, &point.values);
            let levels = solved(&inputs);
            done(newton_iterations(&levels));
            let mut group = design.group(i * design.outer_points());
            group.outer = Some(in_32_bits(point.outer));
            SampleOutcome {
                index: point.outer * inner + i,
                group,
                inputs: inputs.into(),
                levels: levels.into(),
            }
        };
        let all: Vec<(&FurtherPoint, u64)> = (points.iter())
            .flat_map(|point| (0..inner).map(move |i| (point, i)))
            .collect();
        all.into_par_iter().map(sample).collect()
    }
}
