//! Samples by outer point of the epistemic inputs.
//!
//! Every statistic is one of the samples of one outer point; a study without such inputs is one group without number.

use super::peaks::values;
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::report::run::input::ReportInput;
use crate::statistics::Observed;
use std::collections::BTreeMap;

/// Samples by outer point, ascending: number and places in `outcomes`; one group without number for any other design.
#[must_use]
pub fn outer_groups(outcomes: &[SampleOutcome]) -> Vec<(Option<u64>, Vec<usize>)> {
    let mut groups: BTreeMap<Option<u64>, Vec<usize>> = BTreeMap::new();
    for (i, outcome) in outcomes.iter().enumerate() {
        let outer = outcome.group.outer.map(u64::from);
        groups.entry(outer).or_default().push(i);
    }
    groups.into_iter().collect()
}

/// Whether the samples belong to outer points, so that shares of all of them are no probabilities.
#[must_use]
pub(in crate::report) fn nested(outcomes: &[SampleOutcome]) -> bool {
    outcomes.iter().any(|o| o.group.outer.is_some())
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
pub(in crate::report) fn chosen<T: Copy>(values: &[T], places: &[usize]) -> Vec<T> {
    places.iter().map(|&i| values[i]).collect()
}

/// Inputs with one value at each outer point that is not the same at all: the epistemic ones.
pub(in crate::report) fn epistemic_columns<N>(
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
