//! Search for the worst case between the outer points of the epistemic inputs.
//!
//! For each number that a criterion judges, the box is divided where it could be worst. Every point is a population of its
//! own, of the same random inputs as the others, so that points differ by the epistemic inputs alone. A point that one search
//! has solved is there for all; what is found depends on the study and its samples alone.

use super::progress::{Meter, Progress};
use crate::ensemble::further_points::FurtherPoint;
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::{Ensemble, Solved};
use crate::report::RunRecord;
use crate::report::numbers::outer_groups;
use crate::report::verdict::badness;
use crate::sampling::rectangles::seek_largest;

/// Samples at the points that the search meets beyond the outer points; none for a study without epistemic inputs or
/// criteria.
pub(super) fn worst_cases(
    ensemble: &Ensemble,
    record: &RunRecord,
    solved: &Solved,
    meter: &Meter<impl Fn(Progress) + Sync>,
) -> Vec<SampleOutcome> {
    let Some(outer) = ensemble.design.outer() else {
        return Vec::new();
    };
    let mut known = Known::of(ensemble, solved);
    for criterion in &record.requirements.criteria {
        for level in criterion.levels(&record.levels) {
            seek_largest(outer.intervals.len(), outer.search, |points| {
                let places = known.places(points.iter().map(|t| outer.at(t)).collect(), meter);
                let of = |place: &usize| {
                    let (_, population) = &known.points[*place];
                    badness(record, population, criterion, level).unwrap_or(f64::NAN)
                };
                places.iter().map(of).collect()
            });
        }
    }
    let further = known.points.into_iter().skip(known.given);
    further.flat_map(|(_, population)| population).collect()
}

/// Populations by values of the epistemic inputs: those of the outer points, then further ones.
struct Known<'a> {
    ensemble: &'a Ensemble<'a>,
    solved: &'a Solved,
    given: usize,
    points: Vec<(Vec<f64>, Vec<SampleOutcome>)>,
}

impl<'a> Known<'a> {
    fn of(ensemble: &'a Ensemble<'a>, solved: &'a Solved) -> Self {
        let outer = ensemble.design.outer().into_iter();
        let values = outer.flat_map(|outer| outer.values.clone());
        let groups = outer_groups(&solved.outcomes).into_iter();
        let population = |members: Vec<usize>| -> Vec<SampleOutcome> {
            members
                .iter()
                .map(|&i| solved.outcomes[i].clone())
                .collect()
        };
        let points: Vec<_> = values
            .zip(groups.map(|(_, members)| population(members)))
            .collect();
        Self {
            ensemble,
            solved,
            given: points.len(),
            points,
        }
    }

    /// Places of the given points, of which the new ones are solved.
    fn places(
        &mut self,
        wanted: Vec<Vec<f64>>,
        meter: &Meter<impl Fn(Progress) + Sync>,
    ) -> Vec<usize> {
        let new = |values: &&Vec<f64>| !self.points.iter().any(|(known, _)| known == *values);
        let further: Vec<FurtherPoint> = (wanted.iter().filter(new))
            .zip(self.points.len() as u64..)
            .map(|(values, outer)| FurtherPoint {
                outer,
                values: values.clone(),
            })
            .collect();
        let design = self.ensemble.design;
        let inner = design.samples() / design.outer_points();
        meter.expect(inner * further.len() as u64);
        let mut outcomes = (self.ensemble)
            .at_further_points(&further, &self.solved.anchors, |iterations| {
                meter.one_more(iterations);
            })
            .into_iter();
        for point in further {
            let population = outcomes.by_ref().take(inner as usize).collect();
            self.points.push((point.values, population));
        }
        let place = |values: &Vec<f64>| self.points.iter().position(|(known, _)| known == values);
        wanted.iter().filter_map(place).collect()
    }
}
