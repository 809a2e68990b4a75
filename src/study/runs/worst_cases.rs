//! Search for the worst case between the outer points of the epistemic inputs.
//!
//! For each number that a criterion judges, the box is divided where it could be worst. Every point is a population of its
//! own, of the same random inputs as the others, so that points differ by the epistemic inputs alone. A point that one search
//! has solved is there for all; what is found depends on the study and its samples alone.
//!
//! The size of a frequency margin says nothing of what lies between a point below an engine order and one above it: a resonance that
//! changes continuously crosses the order there. Such a crossing is sought by halving.

use super::progress::{Meter, Progress};
use crate::ensemble::further_points::FurtherPoint;
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::{Ensemble, Solved};
use crate::report::RunRecord;
use crate::report::asked::requirement::{Criterion, RequiredQuantity};
use crate::report::numbers::outer_groups;
use crate::report::verdict::{badness, side_of_order};
use crate::sampling::outer::OuterPoints;
use crate::sampling::rectangles::seek_largest;

/// Halvings of the distance of two points between which the resonance crosses an engine order. If it jumps across, because another mode
/// becomes the highest, they end at the jump.
const MOST_HALVINGS: usize = 12;

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
            known.seek_crossings(outer, record, criterion, level, meter);
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

    /// Solves points between one below an engine order and one above it, until the resonance crosses the order at one of them, or they
    /// are as close as [`MOST_HALVINGS`] brings them. Nothing is sought for a criterion that is broken at a known point.
    fn seek_crossings(
        &mut self,
        outer: &OuterPoints,
        record: &RunRecord,
        criterion: &Criterion,
        level: usize,
        meter: &Meter<impl Fn(Progress) + Sync>,
    ) {
        let operation = match (criterion.quantity, &record.requirements.operation) {
            (RequiredQuantity::FrequencyMarginPercent, Some(operation)) => operation,
            _ => return,
        };
        for &order in &operation.engine_orders {
            for _ in 0..MOST_HALVINGS {
                let is_broken = self.points.iter().any(|(_, population)| {
                    badness(record, population, criterion, level)
                        .is_some_and(|worst| -worst < criterion.limit)
                });
                let side = |population: &[SampleOutcome]| {
                    side_of_order(operation, population, order, level)
                };
                let Some(between) = self.between_sides(outer, side).filter(|_| !is_broken) else {
                    break;
                };
                self.places(vec![between], meter);
            }
        }
    }

    /// The point midway between the two closest points on different sides of zero; none if a point lies on it, or if all lie on one side.
    fn between_sides(
        &self,
        outer: &OuterPoints,
        side: impl Fn(&[SampleOutcome]) -> Option<f64>,
    ) -> Option<Vec<f64>> {
        let sides: Vec<(Vec<f64>, f64)> = (self.points.iter())
            .filter_map(|(values, population)| Some((outer.unit(values), side(population)?)))
            .collect();
        if sides.iter().any(|(_, side)| *side == 0.0) {
            return None;
        }
        let of = |sign: f64| sides.iter().filter(move |(_, side)| sign * side > 0.0);
        let pairs = of(-1.0).flat_map(|(below, _)| of(1.0).map(move |(above, _)| (below, above)));
        let distance = |(one, other): &(&Vec<f64>, &Vec<f64>)| {
            let squares = one.iter().zip(*other).map(|(a, b)| (a - b) * (a - b));
            squares.sum::<f64>()
        };
        let (below, above) = pairs.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let middle: Vec<f64> = below
            .iter()
            .zip(above)
            .map(|(a, b)| 0.5 * (a + b))
            .collect();
        Some(outer.at(&middle))
    }
}
