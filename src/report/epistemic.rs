//! Studies with epistemic inputs: statistics at every outer point, and their ranges over the box.
//!
//! An epistemic input has one value that nobody knows, so its values have no probability: a share of all samples of such
//! a study means nothing. The samples of one outer point are a population; what can be said over the box is the range of
//! its statistics (a p-box: Ferson et al., SAND2002-4015). The box is seen at its outer points alone.

use super::convention::{CONTENT, PROBABILITIES};
use super::input::ReportInput;
use super::margins::allowable_amplitude_m;
use super::peaks::values;
use super::record::RunRecord;
use super::requirement::Quantity;
use super::summary::{
    Distribution, InputCorrelation, ReplicateMeans, correlations, mean_fractions,
};
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::hb::ContactFractions;
use crate::statistics::{
    Interval, Limit, Observed, Proportion, Side, exceedance, proportion, quantile_estimate,
    tolerance_bound,
};
use serde::Serialize;
use std::collections::BTreeMap;

/// Ranges of all statistics over the outer points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EpistemicSummary {
    /// Names of the epistemic inputs.
    pub inputs: Vec<String>,
    /// The outer points, ascending.
    pub points: Vec<OuterPoint>,
    /// One entry per excitation level.
    pub levels: Vec<EpistemicLevel>,
}

/// One point of the box.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OuterPoint {
    /// Its number, as in the column `outer` of the samples.
    pub outer: u64,
    /// Values of the epistemic inputs.
    pub values: Vec<f64>,
    /// Number of samples, failed ones included.
    pub samples: usize,
}

/// Ranges at one excitation level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EpistemicLevel {
    /// Excitation level.
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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// Means over the replicates of a quasi-random design; absent for any other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replicate_means: Option<ReplicateMeans>,
    /// Mean shares of the contact states; absent without a solution.
    pub mean_contact_fractions: Option<ContactFractions>,
    /// How strongly each input orders the results at this point: not at all if it has one value there.
    pub rank_correlations: Vec<InputCorrelation>,
}

/// An end of a range and the outer point that it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extreme {
    /// The end; unbounded if one of the outer points does not bound it.
    pub value: Limit,
    /// The outer point; the first of several.
    pub outer: u64,
}

/// Range of a statistic over the outer points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoxRange {
    /// Lowest, failed samples at their most favourable to it.
    pub lowest: Extreme,
    /// Highest, likewise.
    pub highest: Extreme,
    /// From the lowest lower to the highest upper confidence limit of the outer points.
    pub interval: Interval,
}

/// Range of a quantile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct QuantileRange {
    /// Probability of the quantile.
    pub probability: f64,
    /// Over the outer points.
    #[serde(flatten)]
    pub range: BoxRange,
}

/// Range of an exceedance probability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExceedanceRange {
    /// Limit of the amplitude (m).
    pub threshold_m: f64,
    /// Over the outer points.
    #[serde(flatten)]
    pub range: BoxRange,
}

/// Samples by outer point, ascending: number and places in `outcomes`; one group without number for any other design.
#[must_use]
pub fn outer_groups(outcomes: &[SampleOutcome]) -> Vec<(Option<u64>, Vec<usize>)> {
    let mut groups: BTreeMap<Option<u64>, Vec<usize>> = BTreeMap::new();
    for (i, outcome) in outcomes.iter().enumerate() {
        groups.entry(outcome.group.outer).or_default().push(i);
    }
    groups.into_iter().collect()
}

/// A number of the peaks at level `i` by outer point, failed samples among them; empty without outer points.
pub(super) fn observed_by_point(
    input: &ReportInput,
    i: usize,
    value: impl Fn(&PeakRecord) -> f64,
) -> Vec<(u64, Observed)> {
    let all = values(input.outcomes, i, value);
    let observed = |(outer, members): (Option<u64>, Vec<usize>)| {
        Some((outer?, Observed::of(chosen(&all, &members))))
    };
    let groups = outer_groups(input.outcomes).into_iter();
    groups.filter_map(observed).collect()
}

/// The chosen ones of `values`.
pub(super) fn chosen<T: Copy>(values: &[T], places: &[usize]) -> Vec<T> {
    places.iter().map(|&i| values[i]).collect()
}

/// Limits of the amplitude (m) that the study states for level `i`, ascending: criteria and allowable stress.
#[must_use]
pub fn amplitude_limits_m(record: &RunRecord, i: usize) -> Vec<f64> {
    let requirements = &record.requirements;
    let criteria = requirements.criteria.iter().filter(|criterion| {
        let here = criterion.level.is_none_or(|l| l == record.levels[i]);
        criterion.quantity == Quantity::AmplitudeUm && here
    });
    let stated = criteria.map(|criterion| criterion.limit * 1e-6);
    let stress = requirements.stress.as_ref().map(allowable_amplitude_m);
    let mut limits: Vec<f64> = stated.chain(stress).collect();
    limits.sort_by(f64::total_cmp);
    limits.dedup();
    limits
}

/// Whether the samples belong to outer points, so that shares of all of them are no probabilities.
#[must_use]
pub(super) fn nested(outcomes: &[SampleOutcome]) -> bool {
    outcomes.iter().any(|o| o.group.outer.is_some())
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

/// Inputs with one value at each outer point that is not the same at all: the epistemic ones.
pub(super) fn epistemic_columns<N>(
    outcomes: &[SampleOutcome],
    groups: &[(N, Vec<usize>)],
) -> Vec<usize> {
    let value = |j: usize, i: usize| outcomes[i].inputs[j];
    let alike = |j: usize, members: &[usize]| {
        let first = value(j, members[0]);
        members.iter().all(|&i| value(j, i) == first)
    };
    let differs = |j: usize| {
        let first = value(j, groups[0].1[0]);
        groups
            .iter()
            .any(|(_, members)| value(j, members[0]) != first)
    };
    let n_inputs = outcomes[groups[0].1[0]].inputs.len();
    (0..n_inputs)
        .filter(|&j| groups.iter().all(|(_, members)| alike(j, members)) && differs(j))
        .collect()
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
                    PointStatistics {
                        outer: *outer,
                        failed,
                        failure_rate: proportion(failed, members.len(), confidence),
                        frequency_hz: Distribution::of_observed(frequency, confidence),
                        amplitude_m: Distribution::of_observed(amplitude, confidence),
                        replicate_means: ReplicateMeans::of(samples.clone(), i),
                        mean_contact_fractions: mean_fractions(samples.clone(), i),
                        rank_correlations: correlations(input.record, samples, i),
                    }
                })
                .collect(),
        }
    }
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
    use super::super::convention::CONFIDENCE;
    use super::*;

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
