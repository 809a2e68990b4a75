//! Where over the box of the epistemic inputs a criterion is kept and where not.
//!
//! The box is known at its outer points and at those that the search for the worst case has met: a PASS is shown there and
//! not between them.

use crate::page::display::{count, from_to, short};
use crate::statistics::{Judgement, hull};
use schemars::JsonSchema;
use serde::Serialize;

/// Judgements at the outer points.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OverBox {
    /// Names of the epistemic inputs.
    pub inputs: Vec<String>,
    /// One entry per outer point, ascending in its number.
    pub points: Vec<PointJudgement>,
}

/// The judgement at one outer point.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PointJudgement {
    /// Number of the outer point; absent for none.
    pub outer: Option<u64>,
    /// Values of the epistemic inputs.
    pub values: Vec<f64>,
    /// Number that is judged there; absent without samples.
    pub estimate: Option<f64>,
    /// Judgement there.
    pub judgement: Judgement,
}

impl OverBox {
    /// `fails at 2 points (mu 0.1 … 0.3); passes at 3 points (mu 0.5 … 0.8)`: by stretches of points where there is one input, by
    /// the range of each input where there are more and no other point lies within.
    #[must_use]
    pub fn in_words(&self) -> String {
        let judgements = [Judgement::Fail, Judgement::Undecided, Judgement::Pass];
        let parts = judgements
            .iter()
            .filter_map(|&judgement| self.part(judgement));
        parts.collect::<Vec<_>>().join("; ")
    }

    fn part(&self, judgement: Judgement) -> Option<String> {
        let verb = match judgement {
            Judgement::Fail => "fails",
            Judgement::Undecided => "is undecided",
            Judgement::Pass => "passes",
        };
        let points = self
            .points
            .iter()
            .filter(|p| p.judgement == judgement)
            .count();
        if points == 0 {
            return None;
        }
        let count = count(points, "point");
        let places = match self.inputs.as_slice() {
            [input] => Some(self.stretches(judgement, input)),
            _ => self.ranges(judgement),
        };
        Some(match places {
            Some(places) => format!("{verb} at {count} ({places})"),
            None => format!("{verb} at {count}"),
        })
    }

    /// Stretches of neighbouring points with one judgement, along the only input.
    fn stretches(&self, judgement: Judgement, input: &str) -> String {
        let mut points: Vec<&PointJudgement> = self.points.iter().collect();
        points.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
        let stretches = points.chunk_by(|a, b| a.judgement == b.judgement);
        let of = stretches.filter(|stretch| stretch[0].judgement == judgement);
        let ends = of.filter_map(|s| Some([s.first()?.values[0], s.last()?.values[0]]));
        let words: Vec<String> = ends.map(|ends| from_to(ends, short)).collect();
        format!("{input} {}", words.join(", "))
    }

    /// The range of every input over the points with one judgement; absent if a point with another judgement lies inside the ranges.
    fn ranges(&self, judgement: Judgement) -> Option<String> {
        let (of, others): (Vec<_>, Vec<_>) =
            (self.points.iter()).partition(|p| p.judgement == judgement);
        let ends: Option<Vec<[f64; 2]>> = (0..self.inputs.len())
            .map(|k| hull(of.iter().map(|p| p.values[k])))
            .collect();
        let ends = ends?;
        let inside = |point: &&PointJudgement| {
            let mut ranges = point.values.iter().zip(&ends);
            ranges.all(|(value, [low, high])| (low..=high).contains(&value))
        };
        if others.iter().any(inside) {
            return None;
        }
        let inputs = self.inputs.iter().zip(ends);
        let words = inputs.map(|(input, ends)| format!("{input} {}", from_to(ends, short)));
        Some(words.collect::<Vec<_>>().join(", "))
    }
}
