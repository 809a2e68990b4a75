//! The results of a set of samples: finite ones in ascending order, the others counted.

use super::limit::Limit;

/// Finite values in ascending order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sorted(Vec<f64>);

impl Sorted {
    /// Sorts the finite ones of `values`; the caller counts the others as failed.
    #[must_use]
    pub fn finite(values: impl IntoIterator<Item = f64>) -> Self {
        let mut kept: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
        kept.sort_by(f64::total_cmp);
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
}

impl Observed {
    /// One value per sample; a value that is not finite is a failed sample.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut total = 0;
        let valid = Sorted::finite(values.into_iter().inspect(|_| total += 1));
        let failed = total - valid.values().len();
        Self { valid, failed }
    }

    /// Finite values beside a number of failed samples.
    #[must_use]
    pub fn with_failed(valid: Sorted, failed: usize) -> Self {
        Self { valid, failed }
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

    /// Smallest value that x₍ᵣₐₙₖ₎ of all n samples can have: failed ones at −∞.
    #[must_use]
    pub fn lowest(&self, rank: usize) -> Limit {
        let rank = rank.saturating_sub(self.failed);
        self.valid.order_statistic(rank).into()
    }

    /// Largest value that x₍ᵣₐₙₖ₎ of all n samples can have: failed ones at +∞.
    #[must_use]
    pub fn highest(&self, rank: usize) -> Limit {
        self.valid.order_statistic(rank).into()
    }
}
