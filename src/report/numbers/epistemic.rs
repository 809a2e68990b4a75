//! Studies with epistemic inputs: statistics at every outer point, and their ranges over the box.
//!
//! An epistemic input has one value that nobody knows, so its values have no probability: a share of all samples of such
//! a study means nothing. The samples of one outer point are a population; what can be said over the box is the range of
//! its statistics (a p-box: Ferson et al., SAND2002-4015). The box is seen at its outer points alone.

use super::allowable::amplitude_limits_m;
use super::box_range::{
    ExceedanceRange, Extreme, QuantileRange, exceedance_range, outermost_bound, quantile_ranges,
};
use super::correlation::{InputCorrelation, correlations};
use super::distribution::Distribution;
use super::outer_points::{chosen, epistemic_columns, observed_by_point, outer_groups};
use super::peaks::{mean_fractions, usable_peak};
use super::replicate_means::ReplicateMeans;
use crate::hb::ContactFractions;
use crate::report::run::input::ReportInput;
use crate::statistics::{Proportion, Side, proportion};
use schemars::JsonSchema;
use serde::Serialize;

/// Ranges of all statistics over the outer points.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EpistemicSummary {
    /// Names of the epistemic inputs.
    pub inputs: Vec<String>,
    /// The outer points, ascending.
    pub points: Vec<OuterPoint>,
    /// One entry per excitation level.
    pub levels: Vec<EpistemicLevel>,
}

/// One point of the box.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OuterPoint {
    /// Its number, as in the column `outer` of the samples.
    pub outer: u64,
    /// Values of the epistemic inputs.
    pub values: Vec<f64>,
    /// Number of samples, failed ones included.
    pub samples: usize,
}

/// Ranges at one excitation level.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EpistemicLevel {
    /// Excitation level (N on each blade for the built-in model, else a factor).
    pub level: f64,
    /// Quantiles of the resonance frequency (Hz).
    pub frequency_hz: Vec<QuantileRange>,
    /// Quantiles of the amplitude (m).
    pub amplitude_m: Vec<QuantileRange>,
    /// Lower and upper tolerance bound of the resonance frequency (Hz): the outermost of the outer points.
    pub frequency_bounds_hz: [Extreme; 2],
    /// Upper tolerance bound of the amplitude (m): the highest of the outer points.
    pub amplitude_bound_m: Extreme,
    /// Probability of exceeding each limit of the amplitude that the study states; empty without.
    pub exceedances: Vec<ExceedanceRange>,
    /// Statistics at each outer point.
    pub points: Vec<PointStatistics>,
}

/// Statistics of the samples of one outer point.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PointStatistics {
    /// Number of the outer point.
    pub outer: u64,
    /// Samples without a solution.
    pub failed: usize,
    /// Their share, with confidence limits; absent without samples.
    pub failure_rate: Option<Proportion>,
    /// Resonance frequency (Hz).
    pub frequency_hz: Distribution,
    /// Amplitude (m).
    pub amplitude_m: Distribution,
    /// Equivalent damping ratio of the resonance; `valid` counts the peaks that have one.
    pub damping_ratio: Distribution,
    /// Means over the replicates of a quasi-random design; absent for any other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replicate_means: Option<ReplicateMeans>,
    /// Mean shares of the contact states; absent without a solution.
    pub mean_contact_fractions: Option<ContactFractions>,
    /// How strongly each input orders the results at this point: not at all if it has one value there.
    pub rank_correlations: Vec<InputCorrelation>,
}

impl EpistemicSummary {
    /// Statistics of a study by outer point; `None` for a study without.
    #[must_use]
    pub fn of(input: &ReportInput) -> Option<Self> {
        let groups: Vec<(u64, Vec<usize>)> = outer_groups(input.outcomes)
            .into_iter()
            .filter_map(|(outer, members)| Some((outer?, members)))
            .collect();
        if groups.is_empty() {
            return None;
        }
        let columns = epistemic_columns(input.outcomes, &groups);
        let name = |&j: &usize| input.record.inputs[j].name.clone();
        let point = |(outer, members): &(u64, Vec<usize>)| {
            let first = &input.outcomes[members[0]];
            OuterPoint {
                outer: *outer,
                values: chosen(&first.inputs, &columns),
                samples: members.len(),
            }
        };
        Some(Self {
            inputs: columns.iter().map(name).collect(),
            points: groups.iter().map(point).collect(),
            levels: (0..input.record.levels.len())
                .map(|i| EpistemicLevel::of(input, &groups, i))
                .collect(),
        })
    }
}

impl EpistemicLevel {
    fn of(input: &ReportInput, groups: &[(u64, Vec<usize>)], i: usize) -> Self {
        let frequency = observed_by_point(input, i, |p| p.frequency_hz);
        let amplitude = observed_by_point(input, i, |p| p.amplitude_m);
        let limits = amplitude_limits_m(input.record, i);
        let confidence = input.record.confidence();
        Self {
            level: input.record.levels[i],
            frequency_hz: quantile_ranges(&frequency, confidence),
            amplitude_m: quantile_ranges(&amplitude, confidence),
            frequency_bounds_hz: [Side::Lower, Side::Upper]
                .map(|side| outermost_bound(&frequency, side, confidence)),
            amplitude_bound_m: outermost_bound(&amplitude, Side::Upper, confidence),
            exceedances: limits
                .into_iter()
                .filter_map(|limit| exceedance_range(&amplitude, limit, confidence))
                .collect(),
            points: (groups.iter().zip(frequency.iter().zip(&amplitude)))
                .map(|((outer, members), ((_, frequency), (_, amplitude)))| {
                    let samples = members.iter().map(|&m| &input.outcomes[m]);
                    let failed = frequency.failed();
                    let ratios = (samples.clone())
                        .filter_map(|sample| usable_peak(&sample.levels[i])?.damping_ratio.get());
                    PointStatistics {
                        outer: *outer,
                        failed,
                        failure_rate: proportion(failed, members.len(), confidence),
                        frequency_hz: Distribution::of_observed(frequency, confidence),
                        amplitude_m: Distribution::of_observed(amplitude, confidence),
                        damping_ratio: Distribution::of(ratios, failed, confidence),
                        replicate_means: ReplicateMeans::of(samples.clone(), i),
                        mean_contact_fractions: mean_fractions(samples.clone(), i),
                        rank_correlations: correlations(input.record, samples, i),
                    }
                })
                .collect(),
        }
    }
}
