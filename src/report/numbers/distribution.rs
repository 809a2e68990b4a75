//! What is known of one result of one population: moments and quantiles.

use crate::report::convention::PROBABILITIES;
use crate::statistics::{Moments, Observed, QuantileEstimate, Sorted, moments, quantile_estimate};

/// What is known of one result: from the samples with a solution, and what the others leave open.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Distribution {
    /// Number of samples that count.
    pub valid: usize,
    /// Mean, standard deviation and range; absent without samples. Those of frequency and amplitude over all samples are
    /// absent too where these belong to outer points, and so are their quantiles.
    pub moments: Option<Moments>,
    /// One entry per probability; empty without samples.
    pub quantiles: Vec<QuantileEstimate>,
}

impl Distribution {
    /// Statistics of one population, of which so many samples failed.
    pub(super) fn of(values: impl Iterator<Item = f64>, failed: usize, confidence: f64) -> Self {
        let all = Observed::with_failed(Sorted::finite(values), failed);
        Self::of_observed(&all, confidence)
    }

    /// Statistics of the samples of one population.
    pub(super) fn of_observed(all: &Observed, confidence: f64) -> Self {
        let estimate = |&p: &f64| quantile_estimate(all, p, confidence);
        Self {
            valid: all.valid().values().len(),
            moments: moments(all.valid()),
            quantiles: PROBABILITIES.iter().filter_map(estimate).collect(),
        }
    }
}
