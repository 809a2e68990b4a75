//! The same samples under other distributions of the inputs: `reweighted.json`.
//!
//! A sample stands for new over old density of its inputs (importance weights); nothing is solved. With epistemic inputs
//! the samples of each outer point are weighted apart.

use super::convention::{CONFIDENCE, PROBABILITIES};
use crate::report::numbers::allowable::amplitude_limits_m;
use crate::report::numbers::outer_points::{chosen, outer_groups};
use crate::report::numbers::peaks::values;
use crate::report::run::stored_run::StoredRun;
use crate::statistics::{
    Exceedance, Observed, QuantileEstimate, WeightedExceedance, WeightedQuantile, Weights,
    exceedance, quantile_estimate, weighted_exceedance, weighted_quantile,
};
use serde::Serialize;

/// Fewest effective samples that a re-weighting may leave: below, the interval of a median is hardly narrower than the
/// range of the samples.
pub const LEAST_EFFECTIVE_SAMPLES: f64 = 20.0;

/// Statistics under the new distributions beside those under the old ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reweighting {
    /// Name of the study.
    pub study: String,
    /// Inputs whose distribution is another one.
    pub inputs: Vec<ReweightedInput>,
    /// Whether the samples are independent draws, as the intervals presume.
    pub independent: bool,
    /// Confidence of every interval.
    pub confidence: f64,
    /// Unit of the excitation levels.
    pub level_unit: String,
    /// Number of samples and of effective samples at every outer point; one entry without epistemic inputs.
    pub weights: Vec<PointWeights>,
    /// One entry per excitation level.
    pub levels: Vec<ReweightedLevel>,
}

/// An input with its distributions in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReweightedInput {
    /// Name.
    pub name: String,
    /// The distribution that the samples were drawn from.
    pub sampled: String,
    /// The one that they stand for now.
    pub reweighted: String,
    /// Largest difference of the distribution functions of the weighted samples and of the draws; absent for a stated distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
}

/// How much the weights leave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PointWeights {
    /// Outer point; absent without epistemic inputs.
    pub outer: Option<u64>,
    /// Number of samples, failed ones included.
    pub samples: usize,
    /// So many samples of the new distribution would say as much about a mean (Kish).
    pub effective_samples: f64,
}

/// Statistics at one excitation level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReweightedLevel {
    /// Excitation level.
    pub level: f64,
    /// One entry per entry of [`Reweighting::weights`].
    pub points: Vec<ReweightedPoint>,
}

/// Statistics of one population.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReweightedPoint {
    /// Outer point; absent without epistemic inputs.
    pub outer: Option<u64>,
    /// Resonance frequency (Hz).
    pub frequency_hz: Vec<ReweightedQuantile>,
    /// Amplitude (m).
    pub amplitude_m: Vec<ReweightedQuantile>,
    /// Probability of exceeding each limit of the amplitude (m) that the study states; empty without.
    pub exceedances: Vec<ReweightedExceedance>,
}

/// A quantile under both distributions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReweightedQuantile {
    /// Under the old one.
    pub sampled: QuantileEstimate,
    /// Under the new one.
    pub reweighted: WeightedQuantile,
}

/// An exceedance probability under both distributions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReweightedExceedance {
    /// Under the old one.
    pub sampled: Exceedance,
    /// Under the new one.
    pub reweighted: WeightedExceedance,
}

impl Reweighting {
    /// Statistics of a run whose samples have the densities `new` and `old` of their inputs.
    ///
    /// Shape of both: `[samples]`; `old` > 0.
    ///
    /// # Errors
    /// The outer point whose weights leave fewer than [`LEAST_EFFECTIVE_SAMPLES`], with their number.
    pub fn of(
        run: &StoredRun,
        inputs: Vec<ReweightedInput>,
        [new, old]: [&[f64]; 2],
    ) -> Result<Self, PointWeights> {
        let mut populations = Vec::new();
        for (outer, members) in outer_groups(&run.outcomes) {
            let weights = Weights::of_densities(&chosen(new, &members), &chosen(old, &members));
            let effective = weights.as_ref().map_or(0.0, Weights::effective_sample_size);
            let found = PointWeights {
                outer,
                samples: members.len(),
                effective_samples: effective,
            };
            match weights.filter(|_| effective >= LEAST_EFFECTIVE_SAMPLES) {
                Some(weights) => populations.push((found, members, weights)),
                None => return Err(found),
            }
        }
        let level = |i: usize| ReweightedLevel {
            level: run.record.levels[i],
            points: (populations.iter())
                .map(|(found, members, weights)| point(run, i, found.outer, members, weights))
                .collect(),
        };
        Ok(Self {
            study: run.record.provenance.study.clone(),
            inputs,
            independent: run.record.design.independent,
            confidence: CONFIDENCE,
            level_unit: run.record.level_unit.clone(),
            levels: (0..run.record.levels.len()).map(level).collect(),
            weights: populations.iter().map(|(found, ..)| *found).collect(),
        })
    }
}

fn point(
    run: &StoredRun,
    i: usize,
    outer: Option<u64>,
    members: &[usize],
    weights: &Weights,
) -> ReweightedPoint {
    let frequency = chosen(&values(&run.outcomes, i, |p| p.frequency_hz), members);
    let amplitude = chosen(&values(&run.outcomes, i, |p| p.amplitude_m), members);
    let observed = Observed::of(amplitude.iter().copied());
    let confidence = run.record.confidence();
    let exceeded = |&limit: &f64| {
        Some(ReweightedExceedance {
            sampled: exceedance(&observed, limit, confidence)?,
            reweighted: weighted_exceedance(&amplitude, weights.values(), limit, confidence)?,
        })
    };
    let limits = amplitude_limits_m(&run.record, i);
    ReweightedPoint {
        outer,
        frequency_hz: quantiles(&frequency, weights, confidence),
        amplitude_m: quantiles(&amplitude, weights, confidence),
        exceedances: limits.iter().filter_map(exceeded).collect(),
    }
}

fn quantiles(values: &[f64], weights: &Weights, confidence: f64) -> Vec<ReweightedQuantile> {
    let observed = Observed::of(values.iter().copied());
    let both = |&p: &f64| {
        Some(ReweightedQuantile {
            sampled: quantile_estimate(&observed, p, confidence)?,
            reweighted: weighted_quantile(values, weights.values(), p, confidence)?,
        })
    };
    PROBABILITIES.iter().filter_map(both).collect()
}
