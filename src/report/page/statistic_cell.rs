//! Cells of statistics: quantiles, bounds, shares and their ranges over the outer points, and the fields that each has in a
//! download.

use crate::page::block::Cell;
use crate::page::display::{DASH, percent};
use crate::report::numbers::box_range::{BoxRange, Extreme};
use crate::report::numbers::population::{Bound, Quantiles};
use crate::statistics::{Interval, Limit, Share, ToleranceBound, wilks_sample_size};

/// Fields of a statistic with its interval in a download: of all samples, and as a range over the outer points.
macro_rules! interval_fields {
    ($name:literal) => {
        [
            &[$name, concat!($name, "_lower"), concat!($name, "_upper")]
                as &'static [&'static str],
            &[
                concat!($name, "_lowest"),
                concat!($name, "_highest"),
                concat!($name, "_lower"),
                concat!($name, "_upper"),
                concat!($name, "_lowest_at"),
                concat!($name, "_highest_at"),
            ],
        ]
    };
}
pub(super) use interval_fields;

/// Fields of a number in a download: of all samples, and its range over the outer points.
macro_rules! range_fields {
    ($name:literal) => {
        [
            &[$name] as &'static [&'static str],
            &[concat!($name, "_lowest"), concat!($name, "_highest")],
        ]
    };
}
pub(super) use range_fields;

/// Fields of a bound in a download: of all samples, and over the outer points.
pub(super) const BOUND_FIELDS: [&[&str]; 2] = [
    &["bound", "order", "achieved_confidence"],
    &["bound", "outer"],
];

/// `a … b`, where a side may be open.
pub(in crate::report) fn limits(interval: Interval, show: &dyn Fn(f64) -> String) -> String {
    interval.in_words(" … ", show)
}

/// `1 % … 2 %`.
pub(super) fn percent_range(lower: f64, upper: f64) -> String {
    format!("{} … {}", percent(lower), percent(upper))
}

/// A share; a dash where there is none.
pub(super) fn percent_cell(value: Option<f64>) -> Cell {
    Cell::number(value.map_or_else(|| DASH.to_owned(), percent), value)
}

/// A share of the samples, and what it can be at least and at most.
pub(in crate::report) fn share_cell(share: Option<&Share>) -> Cell {
    let Some(share) = share else {
        return Cell::number(DASH, None).with_raw([None, None]);
    };
    let known = share.known.map(|known| known.estimate);
    let [lower, upper] = [share.lower, share.upper];
    Cell::number(known.map_or_else(|| DASH.to_owned(), percent), known)
        .with_raw([lower, upper].map(Some))
        .with_small(percent_range(lower, upper))
}

/// A quantile by its place among 5, 50, 95 %, or its range over the outer points.
pub(super) fn quantile_cell(quantiles: &Quantiles, k: usize, show: &dyn Fn(f64) -> String) -> Cell {
    match quantiles {
        Quantiles::One(all) => match all.get(k) {
            None => Cell::number(DASH, None).with_raw([None, None]),
            Some(q) => Cell::number(show(q.estimate), Some(q.estimate))
                .with_raw([q.interval.lower.value(), q.interval.upper.value()])
                .with_small(limits(q.interval, show)),
        },
        Quantiles::Points(ranges) => match ranges.get(k) {
            None => Cell::number(DASH, None).with_raw([None; 5]),
            Some(quantile) => range_cell(&quantile.range, show),
        },
    }
}

/// A bound, and the value of the samples or the outer point that it comes from.
pub(super) fn bound_cell(bound: &Bound, show: &dyn Fn(f64) -> String) -> Cell {
    match bound {
        Bound::One(bound) => tolerance_cell(bound, show),
        Bound::Points(extreme) => extreme_cell(extreme, show),
    }
}

fn tolerance_cell(bound: &ToleranceBound, show: &dyn Fn(f64) -> String) -> Cell {
    let value = bound.limit.value();
    let basis = match (bound.order, value) {
        (0, _) => match wilks_sample_size(bound.content, bound.confidence, 1) {
            Some(n) => format!("too few samples: {n} needed"),
            None => "too few samples".to_owned(),
        },
        (_, None) => "failed samples may lie beyond".to_owned(),
        // The place in the order and the confidence reached stand in the download.
        _ => String::new(),
    };
    Cell::number(bound.limit.in_words(show), value)
        .with_raw([Some(bound.order as f64), Some(bound.achieved_confidence)])
        .with_small(basis)
}

/// `a … b`, where they are, and the hull of the confidence intervals.
pub(super) fn range_cell(range: &BoxRange, show: &dyn Fn(f64) -> String) -> Cell {
    let (lowest, highest) = (range.lowest, range.highest);
    let ends = Interval {
        lower: lowest.value,
        upper: highest.value,
    };
    let interval = [range.interval.lower, range.interval.upper].map(Limit::value);
    Cell::number(limits(ends, show), lowest.value.value())
        .with_raw([highest.value.value(), interval[0], interval[1]])
        .with_raw([lowest.outer, highest.outer].map(|outer| Some(outer as f64)))
        .with_small(places(lowest.outer, highest.outer))
        .with_small(limits(range.interval, show))
}

/// The outer points of both ends of a range.
fn places(lowest: u64, highest: u64) -> String {
    match lowest == highest {
        true => format!("at point {lowest}"),
        false => format!("at points {lowest} and {highest}"),
    }
}

/// The outermost value and the outer point that it comes from.
pub(super) fn extreme_cell(extreme: &Extreme, show: &dyn Fn(f64) -> String) -> Cell {
    let value = extreme.value.value();
    let basis = match value {
        Some(_) => format!("at point {}", extreme.outer),
        None => "too few samples, or too many failed".to_owned(),
    };
    Cell::number(extreme.value.in_words(show), value)
        .with_raw([Some(extreme.outer as f64)])
        .with_small(basis)
}

#[cfg(test)]
mod tests {
    use super::places;

    /// Seen to fail with "at points 0 and 0".
    #[test]
    fn one_point_is_named_once() {
        let found = [places(0, 0), places(0, 2)];
        assert_eq!(found, ["at point 0", "at points 0 and 2"]);
    }
}
