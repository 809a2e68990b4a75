//! The results of a set of samples: finite ones in ascending order, the others counted.
//!
//! A result may be known to an enclosure only: what its own numerical error leaves open. The k-th smallest of numbers in
//! enclosures lies between the k-th smallest lower and the k-th smallest upper end, so every limit stays one.

use super::limit::Limit;

/// Finite values in ascending order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sorted(Vec<f64>);

impl Sorted {
    /// Sorts the finite ones of `values`; the caller counts the others as failed.
    #[must_use]
    pub fn finite(values: impl IntoIterator<Item = f64>) -> Self {
        let mut kept: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
        // equal numbers have equal bits
        kept.sort_unstable_by(f64::total_cmp);
        Self(kept)
    }

    /// The values, ascending.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.0
    }

    /// The order statistic x₍ᵣₐₙₖ₎, 1-based; `None` outside 1..=n.
    #[must_use]
    pub fn order_statistic(&self, rank: usize) -> Option<f64> {
        self.0.get(rank.checked_sub(1)?).copied()
    }
}

/// Results of n samples of which some failed: a failed sample has a result that is not known.
///
/// Every statistic of it holds for all results that the failed samples could have had: they lie at −∞ for a lower
/// limit and at +∞ for an upper one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observed {
    valid: Sorted,
    failed: usize,
    /// Ends of the enclosures, each ascending; absent where the results are exact.
    ends: Option<[Vec<f64>; 2]>,
}

/// A result and the ends between which it lies for certain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Enclosed {
    /// Lower end; −∞ where nothing bounds it.
    pub lower: f64,
    /// The result as computed.
    pub value: f64,
    /// Upper end; +∞ where nothing bounds it.
    pub upper: f64,
}

impl Enclosed {
    /// A sample without a result.
    pub const UNKNOWN: Self = Self {
        lower: f64::NAN,
        value: f64::NAN,
        upper: f64::NAN,
    };

    /// A result without an error.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self::within(value, 0.0)
    }

    /// A result that is wrong by `error` at most.
    #[must_use]
    pub fn within(value: f64, error: f64) -> Self {
        Self {
            lower: value - error,
            value,
            upper: value + error,
        }
    }
}

impl Observed {
    /// One value per sample; a value that is not finite is a failed sample.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut total = 0;
        let valid = Sorted::finite(values.into_iter().inspect(|_| total += 1));
        let failed = total - valid.values().len();
        Self::with_failed(valid, failed)
    }

    /// One enclosure per sample; one whose value is not finite is a failed sample. Ends on the wrong side of the value, or
    /// NaN, bound nothing.
    #[must_use]
    pub fn enclosed(results: &[Enclosed]) -> Self {
        let known = || results.iter().filter(|r| r.value.is_finite());
        let ascending = |ends: &dyn Fn(&Enclosed) -> f64| {
            let mut ends: Vec<f64> = known().map(ends).collect();
            ends.sort_unstable_by(f64::total_cmp);
            ends
        };
        let lower = |r: &Enclosed| match r.lower <= r.value {
            true => r.lower,
            false => f64::NEG_INFINITY,
        };
        let upper = |r: &Enclosed| match r.upper >= r.value {
            true => r.upper,
            false => f64::INFINITY,
        };
        Self {
            ends: Some([ascending(&lower), ascending(&upper)]),
            ..Self::of(results.iter().map(|r| r.value))
        }
    }

    /// Finite values beside a number of failed samples.
    #[must_use]
    pub fn with_failed(valid: Sorted, failed: usize) -> Self {
        Self {
            valid,
            failed,
            ends: None,
        }
    }

    /// The results that are known.
    #[must_use]
    pub fn valid(&self) -> &Sorted {
        &self.valid
    }

    /// Number of failed samples.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.failed
    }

    /// Number of samples n, failed ones included.
    #[must_use]
    pub fn total(&self) -> usize {
        self.valid.values().len() + self.failed
    }

    /// Lower ends of the results that are known, ascending: the results themselves where they are exact.
    #[must_use]
    pub fn lower_ends(&self) -> &[f64] {
        (self.ends.as_ref()).map_or_else(|| self.valid.values(), |[lower, _]| lower)
    }

    /// Their upper ends, likewise.
    #[must_use]
    pub fn upper_ends(&self) -> &[f64] {
        (self.ends.as_ref()).map_or_else(|| self.valid.values(), |[_, upper]| upper)
    }

    /// Smallest value that x₍ᵣₐₙₖ₎ of all n samples can have: failed ones at −∞, the others at their lower ends.
    #[must_use]
    pub fn lowest(&self, rank: usize) -> Limit {
        let rank = rank.saturating_sub(self.failed);
        order_statistic(self.lower_ends(), rank).into()
    }

    /// Largest value that x₍ᵣₐₙₖ₎ of all n samples can have: failed ones at +∞, the others at their upper ends.
    #[must_use]
    pub fn highest(&self, rank: usize) -> Limit {
        order_statistic(self.upper_ends(), rank).into()
    }
}

/// The value of a 1-based rank; `None` outside 1..=n.
fn order_statistic(ascending: &[f64], rank: usize) -> Option<f64> {
    ascending.get(rank.checked_sub(1)?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{exceedance, quantile_estimate};

    /// Every order statistic of 2000 draws from the enclosures lies between the limits, and the limits are reached.
    /// Seen to fail with the ends in the order of the values instead of each sorted.
    #[test]
    fn order_statistics_stay_within_the_ends() {
        let of = |i: u64| ((i as f64) * 0.618_033_988_7).fract();
        let results: Vec<Enclosed> = (0..20)
            .map(|i| Enclosed::within(of(i), 0.3 * of(7 * i + 3)))
            .collect();
        let observed = Observed::enclosed(&results);
        for draw in 0..2000 {
            let at = |(k, r): (usize, &Enclosed)| match draw {
                0 => r.lower,
                1 => r.upper,
                _ => r.lower + of(draw * 31 + k as u64) * (r.upper - r.lower),
            };
            let drawn = Sorted::finite(results.iter().enumerate().map(at));
            for rank in 1..=20 {
                let value = drawn.order_statistic(rank).unwrap();
                let (lowest, highest) = (observed.lowest(rank), observed.highest(rank));
                let [low, high] = [lowest, highest].map(|l| l.value().unwrap());
                assert!(
                    low <= value && value <= high,
                    "rank {rank}: {low} {value} {high}"
                );
                assert!(draw != 0 || low == value);
                assert!(draw != 1 || high == value);
            }
        }
    }

    /// A sample whose enclosure holds the threshold neither exceeds it nor stays below. Seen to fail with the values alone.
    #[test]
    fn an_enclosure_across_the_threshold_is_unknown() {
        let results = [1.0, 1.95, 2.05, 3.0, f64::NAN].map(|v| Enclosed::within(v, 0.1));
        let found = exceedance(&Observed::enclosed(&results), 2.0, 0.95).unwrap();
        let share = found.probability;
        assert_eq!((share.yes, share.no, share.unknown), (1, 1, 3));
    }

    /// An end that bounds nothing opens the side that needs it, and no other. Seen to fail with infinite ends dropped.
    #[test]
    fn open_ends_open_the_limits() {
        let mut results = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|v| Enclosed::within(v, 0.5));
        (results[6].lower, results[6].upper) = (f64::NAN, f64::NAN);
        let observed = Observed::enclosed(&results);
        assert_eq!(observed.highest(7), Limit::Unbounded);
        assert_eq!(observed.highest(6), Limit::Value(6.5));
        assert_eq!(observed.lowest(1), Limit::Unbounded);
        assert_eq!(observed.lowest(2), Limit::Value(0.5));
        let median = quantile_estimate(&observed, 0.5, 0.5).unwrap();
        assert_eq!(median.estimate, 4.0);
        assert_eq!(median.interval.lower, Limit::Value(1.5));
    }
}
