//! A result by population: all samples of a study, or those of each outer point of its epistemic inputs.
//!
//! Samples of different outer points are no population together, so a statistic is then its range over the points.

use super::box_range::{
    ExceedanceRange, Extreme, QuantileRange, exceedance_range, outermost_bound, quantile_ranges,
};
use super::outer_points::observed_by_point;
use super::peaks::values;
use crate::ensemble::outcome::PeakRecord;
use crate::report::convention::{CONTENT, PROBABILITIES};
use crate::report::run::input::ReportInput;
use crate::statistics::{
    Exceedance, Observed, QuantileEstimate, Side, ToleranceBound, exceedance, hull, quantile,
    quantile_estimate, tolerance_bound,
};
use schemars::JsonSchema;
use serde::Serialize;

/// Values of a result, failed samples among them, and the confidence that its intervals and bounds have.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Populations {
    members: Members,
    confidence: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Members {
    /// Of all samples.
    One(Observed),
    /// Of each outer point, with its number.
    Points(Vec<(u64, Observed)>),
}

/// 5, 50 and 95 % quantiles; empty without samples.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Quantiles {
    /// Of all samples.
    One(Vec<QuantileEstimate>),
    /// Their ranges over the outer points.
    Points(Vec<QuantileRange>),
}

/// A tolerance bound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Bound {
    /// Of all samples.
    One(ToleranceBound),
    /// The outermost of the outer points.
    Points(Extreme),
}

/// Probability of exceeding a limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Exceeded {
    /// Of all samples.
    One(Exceedance),
    /// Its range over the outer points.
    Points(ExceedanceRange),
}

impl Bound {
    /// The bound; `None` where it is open.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::One(bound) => bound.limit.value(),
            Self::Points(extreme) => extreme.value.value(),
        }
    }
}

impl Populations {
    /// A number of the peaks at level `i`.
    pub(in crate::report) fn of(
        input: &ReportInput,
        i: usize,
        value: impl Fn(&PeakRecord) -> f64,
    ) -> Self {
        let points = observed_by_point(input, i, &value);
        Self {
            members: match points.is_empty() {
                true => Members::One(Observed::of(values(input.outcomes, i, value))),
                false => Members::Points(points),
            },
            confidence: input.record.confidence(),
        }
    }

    /// Each population.
    pub(in crate::report) fn each(&self) -> Vec<&Observed> {
        match &self.members {
            Members::One(all) => vec![all],
            Members::Points(points) => points.iter().map(|(_, observed)| observed).collect(),
        }
    }

    pub(super) fn quantiles(&self) -> Quantiles {
        let estimate = |all: &Observed, p: &f64| quantile_estimate(all, *p, self.confidence);
        match &self.members {
            Members::One(all) => {
                let all = PROBABILITIES.iter().filter_map(|p| estimate(all, p));
                Quantiles::One(all.collect())
            }
            Members::Points(points) => Quantiles::Points(quantile_ranges(points, self.confidence)),
        }
    }

    pub(in crate::report) fn bound(&self, side: Side) -> Bound {
        match &self.members {
            Members::One(all) => Bound::One(tolerance_bound(all, side, CONTENT, self.confidence)),
            Members::Points(points) => {
                Bound::Points(outermost_bound(points, side, self.confidence))
            }
        }
    }

    /// `None` without samples.
    pub(super) fn exceedance(&self, limit: f64) -> Option<Exceeded> {
        match &self.members {
            Members::One(all) => exceedance(all, limit, self.confidence).map(Exceeded::One),
            Members::Points(points) => {
                exceedance_range(points, limit, self.confidence).map(Exceeded::Points)
            }
        }
    }

    /// Lowest and highest quantile of the populations, from the samples with a solution; `None` without such.
    pub(in crate::report) fn hull(&self, probability: f64) -> Option<[f64; 2]> {
        let each = self.each();
        hull(each.iter().filter_map(|o| quantile(o.valid(), probability)))
    }

    /// Lowest `low` quantile, middle of the medians and highest `high` quantile of the populations; `None` without a
    /// solution.
    pub(in crate::report) fn scatter(&self, [low, high]: [f64; 2]) -> Option<[f64; 3]> {
        let [least, most] = self.hull(0.5)?;
        Some([
            self.hull(low)?[0],
            0.5 * (least + most),
            self.hull(high)?[1],
        ])
    }
}
