//! Ranges of statistics over the outer points, and the point that each end comes from.

use crate::report::convention::{CONTENT, PROBABILITIES};
use crate::statistics::{
    Interval, Limit, Observed, Side, exceedance, quantile_estimate, tolerance_bound,
};
use schemars::JsonSchema;
use serde::Serialize;

/// An end of a range and the outer point that it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Extreme {
    /// The end; unbounded if one of the outer points does not bound it.
    pub value: Limit,
    /// The outer point; the first of several.
    pub outer: u64,
}

/// Range of a statistic over the outer points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct BoxRange {
    /// Lowest, failed samples at their most favourable to it.
    pub lowest: Extreme,
    /// Highest, likewise.
    pub highest: Extreme,
    /// From the lowest lower to the highest upper confidence limit of the outer points.
    pub interval: Interval,
}

/// Range of a quantile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct QuantileRange {
    /// Probability of the quantile.
    pub probability: f64,
    /// Over the outer points.
    #[serde(flatten)]
    pub range: BoxRange,
}

/// Range of an exceedance probability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ExceedanceRange {
    /// Limit of the amplitude (m).
    pub threshold_m: f64,
    /// Over the outer points.
    #[serde(flatten)]
    pub range: BoxRange,
}

/// The farthest of the limits of the outer points on one side, an unbounded one before any other.
fn extreme(limits: impl Iterator<Item = (u64, Limit)>, side: Side) -> Extreme {
    let open = Extreme {
        value: Limit::Unbounded,
        outer: 0,
    };
    let reach = |limit: Limit| match side {
        Side::Lower => -limit.value().unwrap_or(f64::NEG_INFINITY),
        Side::Upper => limit.value().unwrap_or(f64::INFINITY),
    };
    limits
        .map(|(outer, value)| Extreme { value, outer })
        .reduce(|best, next| match reach(next.value) > reach(best.value) {
            true => next,
            false => best,
        })
        .unwrap_or(open)
}

/// Range of intervals over the outer points: of the statistic with failed samples at either end, and of its confidence
/// interval.
pub(super) fn box_range(points: &[(u64, Interval, Interval)]) -> BoxRange {
    let side = |of: fn(&(u64, Interval, Interval)) -> Limit, side: Side| {
        extreme(points.iter().map(|point| (point.0, of(point))), side)
    };
    BoxRange {
        lowest: side(|p| p.1.lower, Side::Lower),
        highest: side(|p| p.1.upper, Side::Upper),
        interval: Interval {
            lower: side(|p| p.2.lower, Side::Lower).value,
            upper: side(|p| p.2.upper, Side::Upper).value,
        },
    }
}

pub(super) fn quantile_ranges(points: &[(u64, Observed)], confidence: f64) -> Vec<QuantileRange> {
    let range = |&probability: &f64| {
        let at = |(outer, observed): &(u64, Observed)| match quantile_estimate(
            observed,
            probability,
            confidence,
        ) {
            Some(q) => (*outer, q.failure_bounds, q.interval),
            None => (*outer, Interval::UNBOUNDED, Interval::UNBOUNDED),
        };
        QuantileRange {
            probability,
            range: box_range(&points.iter().map(at).collect::<Vec<_>>()),
        }
    };
    PROBABILITIES.iter().map(range).collect()
}

/// The outermost tolerance bound: whichever outer point is true, its own bound lies inside, with its confidence.
pub(super) fn outermost_bound(points: &[(u64, Observed)], side: Side, confidence: f64) -> Extreme {
    let limit = |(outer, observed): &(u64, Observed)| {
        let bound = tolerance_bound(observed, side, CONTENT, confidence);
        (*outer, bound.limit)
    };
    extreme(points.iter().map(limit), side)
}

pub(super) fn exceedance_range(
    points: &[(u64, Observed)],
    threshold_m: f64,
    confidence: f64,
) -> Option<ExceedanceRange> {
    let at = |(outer, observed): &(u64, Observed)| {
        let share = exceedance(observed, threshold_m, confidence)?.probability;
        let of_all = |count: usize| count as f64 / share.total() as f64;
        let estimate = Interval::between(of_all(share.yes), of_all(share.yes + share.unknown));
        Some((
            *outer,
            estimate,
            Interval::between(share.lower, share.upper),
        ))
    };
    let points: Vec<_> = points.iter().map(at).collect::<Option<_>>()?;
    Some(ExceedanceRange {
        threshold_m,
        range: box_range(&points),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::convention::CONFIDENCE;

    fn of(values: &[f64]) -> Observed {
        Observed::of(values.iter().copied())
    }

    /// Medians 2 and 5 at two points: the range is theirs, and each end names its point. Seen to fail with the sides
    /// exchanged in `extreme`.
    #[test]
    fn a_range_holds_every_point_and_names_its_ends() {
        let points = [(3, of(&[1.0, 2.0, 3.0])), (7, of(&[4.0, 5.0, 6.0]))];
        let median = quantile_ranges(&points, CONFIDENCE)[1].range;
        assert_eq!(
            (median.lowest.value, median.lowest.outer),
            (Limit::Value(2.0), 3)
        );
        assert_eq!(
            (median.highest.value, median.highest.outer),
            (Limit::Value(5.0), 7)
        );
        let above = exceedance_range(&points, 2.5, CONFIDENCE).unwrap().range;
        assert_eq!(above.lowest.value, Limit::Value(1.0 / 3.0));
        assert_eq!(
            (above.highest.value, above.highest.outer),
            (Limit::Value(1.0), 7)
        );
        assert!(above.interval.contains(1.0 / 3.0) && above.interval.contains(1.0));
    }

    /// A failed sample widens the range to both sides; a point without a solution opens it. Seen to fail with the
    /// estimate in place of its failure bounds.
    #[test]
    fn failures_widen_the_range() {
        let nan = f64::NAN;
        let points = [(0, of(&[1.0, 2.0, 3.0, 4.0, nan])), (1, of(&[2.5; 5]))];
        let median = quantile_ranges(&points, CONFIDENCE)[1].range;
        assert_eq!(median.lowest.value, Limit::Value(2.0));
        assert_eq!(
            (median.highest.value, median.highest.outer),
            (Limit::Value(3.0), 0)
        );
        let above = exceedance_range(&points, 3.5, CONFIDENCE).unwrap().range;
        assert_eq!(above.highest.value, Limit::Value(0.4));
        let lost = [(0, of(&[1.0])), (1, of(&[nan, nan]))];
        let median = quantile_ranges(&lost, CONFIDENCE)[1].range;
        assert_eq!(
            (median.lowest.value, median.lowest.outer),
            (Limit::Unbounded, 1)
        );
        assert_eq!(
            exceedance_range(&lost, 3.5, CONFIDENCE)
                .unwrap()
                .range
                .highest
                .value,
            Limit::Value(1.0)
        );
    }
}
