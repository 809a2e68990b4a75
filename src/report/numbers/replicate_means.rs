//! Means and quantiles over the replicates of a quasi-random design.

use super::peaks::usable_peak;
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::report::convention::{CONFIDENCE, PROBABILITIES};
use crate::statistics::{
    Limit, ReplicateMean, ReplicateQuantile, replicate_mean, replicate_quantile,
};

/// Means over the replicates of a quasi-random design, with the errors that their scatter shows.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ReplicateMeans {
    /// Resonance frequency (Hz). Its interval ends at 0 where the scatter of the replicates would have it go on below.
    pub frequency_hz: ReplicateMean,
    /// Amplitude (m), with an interval that ends at 0 likewise.
    pub amplitude_m: ReplicateMean,
    /// Intervals of the quantiles of the resonance frequency (Hz), one per probability.
    pub frequency_quantiles_hz: [ReplicateQuantile; PROBABILITIES.len()],
    /// The same of the amplitude (m).
    pub amplitude_quantiles_m: [ReplicateQuantile; PROBABILITIES.len()],
}

impl ReplicateMeans {
    /// Means and quantiles at level `i` of the samples of one population; `None` with fewer than two replicates.
    pub(super) fn of<'a>(
        outcomes: impl Iterator<Item = &'a SampleOutcome> + Clone,
        i: usize,
    ) -> Option<Self> {
        let of = |value: fn(&PeakRecord) -> f64| -> Vec<(u64, f64)> {
            let one = |o: &SampleOutcome| {
                let peak = usable_peak(&o.levels[i]);
                Some((
                    o.group.replicate?.into(),
                    peak.map_or(f64::NAN, |p| value(&p)),
                ))
            };
            outcomes.clone().filter_map(one).collect()
        };
        let (frequency, amplitude) = (of(|p| p.frequency_hz), of(|p| p.amplitude_m));
        let mean = |values: &Vec<(u64, f64)>| {
            replicate_mean(values.iter().copied(), CONFIDENCE).map(not_negative)
        };
        let quantiles = |values: &Vec<(u64, f64)>| {
            let at = |p| replicate_quantile(values.iter().copied(), p, CONFIDENCE);
            let [low, middle, high] = PROBABILITIES.map(at);
            Some([low?, middle?, high?])
        };
        Some(Self {
            frequency_hz: mean(&frequency)?,
            amplitude_m: mean(&amplitude)?,
            frequency_quantiles_hz: quantiles(&frequency)?,
            amplitude_quantiles_m: quantiles(&amplitude)?,
        })
    }
}

/// The mean of a positive quantity: no value below 0 is one of it.
fn not_negative(mut mean: ReplicateMean) -> ReplicateMean {
    if let Limit::Value(lower) = &mut mean.interval.lower {
        *lower = lower.max(0.0);
    }
    mean
}
