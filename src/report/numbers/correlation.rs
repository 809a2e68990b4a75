//! How strongly each input orders the results of one population.

use super::peaks::usable_peak;
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::report::run::record::RunRecord;
use crate::statistics::rank_correlation;

/// Spearman's rank correlation of one input with the results; absent where either does not vary, where the values of the input only
/// number draws, and over samples that belong to outer points.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct InputCorrelation {
    /// Name of the input.
    pub input: String,
    /// With the resonance frequency.
    pub frequency: Option<f64>,
    /// With the amplitude.
    pub amplitude: Option<f64>,
}

/// Correlations at level `i` over the samples of one population.
pub(super) fn correlations<'a>(
    record: &RunRecord,
    outcomes: impl Iterator<Item = &'a SampleOutcome> + Clone,
    i: usize,
) -> Vec<InputCorrelation> {
    let with = |j: usize, value: fn(&PeakRecord) -> f64| {
        let pair =
            |o: &SampleOutcome| Some((*o.inputs.get(j)?, value(&usable_peak(&o.levels[i])?)));
        if record.inputs[j].numbers_draws() {
            return None;
        }
        rank_correlation(&outcomes.clone().filter_map(pair).collect::<Vec<_>>())
    };
    let names = record.inputs.iter().enumerate();
    names
        .map(|(j, input)| InputCorrelation {
            input: input.name.clone(),
            frequency: with(j, |p| p.frequency_hz),
            amplitude: with(j, |p| p.amplitude_m),
        })
        .collect()
}
