//! How much each input moves the results: first and total indices of a pick-freeze design, first-order indices of any other.

use super::box_range::{BoxRange, box_range};
use super::outer_points::{chosen, nested, outer_groups};
use super::peaks::values;
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::report::run::input::ReportInput;
use crate::sampling::DesignKind;
use crate::statistics::{
    Bootstrap, ConditionalMean, GivenData, GivenDataIndex, Interval, SensitivityRefusal,
    SobolIndex, conditional_means, first_order_index, independent_rows, sobol_indices,
};
use schemars::JsonSchema;
use serde::Serialize;

/// Replicates of a resampling interval.
const REPLICATES: u32 = 200;
/// Why samples of another design do not tell how much of the variance a field has.
const NUMBERED: &str =
    "its values only number the draws of a field: design.kind = \"pick-freeze\" tells its share";
/// Groups of a conditional mean.
const GROUPS: usize = 5;

/// How much one input moves the results.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct InputInfluence {
    /// Name of the input.
    pub input: String,
    /// Share of the variance of the resonance frequency.
    pub frequency: IndexResult,
    /// Share of the variance of the amplitude.
    pub amplitude: IndexResult,
    /// Mean resonance frequency (Hz) over groups of samples along the input; empty where samples belong to outer points, and for an input
    /// whose values only number draws.
    pub frequency_means_hz: Vec<ConditionalMean>,
    /// Mean amplitude (m) over the same groups.
    pub amplitude_means_m: Vec<ConditionalMean>,
}

/// An index, or why there is none.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum IndexResult {
    /// First-order index with its interval, from samples of any design.
    Index(GivenDataIndex),
    /// Its range over the outer points, from the samples of each.
    Points(BoxRange),
    /// First and total index with their intervals, from the rows of a pick-freeze design.
    PickFreeze(SobolIndex),
    /// Why there is no index.
    Refused(String),
}

/// One entry per input at level `i`.
pub(in crate::report) fn influences(input: &ReportInput, i: usize) -> Vec<InputInfluence> {
    let results: [Results; 2] = [|p| p.frequency_hz, |p| p.amplitude_m];
    let [frequency, amplitude] = results.map(|value| indices(input, i, value));
    let values = results.map(|value| values(input.outcomes, i, value));
    let inputs = input.record.inputs.iter().enumerate();
    let nested = nested(input.outcomes);
    inputs
        .zip(frequency.into_iter().zip(amplitude))
        .map(|((j, record), (frequency, amplitude))| {
            let (x, open) = (column(input, j), Interval::UNBOUNDED);
            let means = |results: &[f64]| match nested || record.numbers_draws() {
                true => Vec::new(),
                false => conditional_means(&x, results, GROUPS, open, input.record.confidence()),
            };
            InputInfluence {
                input: record.name.clone(),
                frequency,
                amplitude,
                frequency_means_hz: means(&values[0]),
                amplitude_means_m: means(&values[1]),
            }
        })
        .collect()
}

/// A number of a peak.
type Results = fn(&PeakRecord) -> f64;

/// Values of input `j` in the population.
fn column(input: &ReportInput, j: usize) -> Vec<f64> {
    input.outcomes.iter().map(|o| o.inputs[j]).collect()
}

/// One index per input.
fn indices(input: &ReportInput, i: usize, value: Results) -> Vec<IndexResult> {
    let bootstrap = Bootstrap {
        seed: input.record.provenance.seed,
        replicates: REPLICATES,
        confidence: input.record.confidence(),
    };
    if !input.record.design.mixed_inputs.is_empty() {
        return pick_freeze(input, i, value, &bootstrap);
    }
    let nested = nested(input.outcomes);
    if let Some(refusal) = dependent_rows(input).filter(|_| !nested) {
        return vec![IndexResult::Refused(refusal.to_string()); input.record.inputs.len()];
    }
    let results = values(input.outcomes, i, value);
    let replicates = replicates(input);
    let index = |j: usize| {
        if input.record.inputs[j].numbers_draws() {
            return IndexResult::Refused(NUMBERED.to_owned());
        }
        let x = column(input, j);
        let data = GivenData {
            inputs: &x,
            results: &results,
            replicates: replicates.as_deref(),
            seed: input.record.provenance.seed,
            confidence: input.record.confidence(),
        };
        match nested {
            true => by_point(input, &data),
            false => match first_order_index(&data) {
                Ok(index) => IndexResult::Index(index),
                Err(refusal) => IndexResult::Refused(refusal.to_string()),
            },
        }
    };
    (0..input.record.inputs.len()).map(index).collect()
}

/// Why the rows of a file have no index by ranks; none for rows that may be independent, and for any other design.
fn dependent_rows(input: &ReportInput) -> Option<SensitivityRefusal> {
    if input.record.design.kind != DesignKind::File {
        return None;
    }
    let columns = (0..input.record.inputs.len()).map(|j| column(input, j));
    let columns: Vec<_> = columns.collect();
    independent_rows(&columns, input.record.provenance.seed).err()
}

/// Replicate of every sample of a design of quasi-random points, 0 where these are one sequence; absent for any other.
fn replicates(input: &ReportInput) -> Option<Vec<u64>> {
    let quasi_random = input.record.design.kind == DesignKind::Sobol;
    let replicate = |o: &SampleOutcome| o.group.replicate.unwrap_or(0).into();
    quasi_random.then(|| input.outcomes.iter().map(replicate).collect())
}

/// Range of the index of one input over the outer points. An interval has no variance to explain a share of.
fn by_point(input: &ReportInput, data: &GivenData) -> IndexResult {
    let mut found = Vec::new();
    for (outer, members) in outer_groups(input.outcomes) {
        let outer = outer.unwrap_or_default();
        let replicates = data.replicates.map(|all| chosen(all, &members));
        let of_point = GivenData {
            inputs: &chosen(data.inputs, &members),
            results: &chosen(data.results, &members),
            replicates: replicates.as_deref(),
            ..*data
        };
        if of_point.inputs.iter().all(|v| *v == of_point.inputs[0]) {
            let reason = "one value at every outer point: it has no variance there";
            return IndexResult::Refused(reason.to_owned());
        }
        match first_order_index(&of_point) {
            Ok(GivenDataIndex { index, .. }) => found.push((
                outer,
                Interval::between(index.estimate, index.estimate),
                Interval::between(index.lower, index.upper),
            )),
            Err(refusal) => {
                return IndexResult::Refused(format!("outer point {outer}: {refusal}"));
            }
        }
    }
    IndexResult::Points(box_range(&found))
}

/// The same from the rows of a pick-freeze design: A and B are of the population, the others mixed.
fn pick_freeze(
    input: &ReportInput,
    i: usize,
    value: Results,
    bootstrap: &Bootstrap,
) -> Vec<IndexResult> {
    let mixed_inputs = &input.record.design.mixed_inputs;
    let own = input.outcomes.chunks_exact(2);
    let mixed = input.mixed.chunks_exact(mixed_inputs.len());
    let rows: Vec<f64> = own
        .zip(mixed)
        .flat_map(|(own, mixed)| [values(own, i, value), values(mixed, i, value)].concat())
        .collect();
    let found = sobol_indices(&rows, mixed_inputs.len(), bootstrap);
    let index = |j: usize| match (&found, mixed_inputs.iter().position(|&k| k == j)) {
        (_, None) => IndexResult::Refused("the input is fixed".to_owned()),
        (Ok(indices), Some(place)) => IndexResult::PickFreeze(indices[place]),
        (Err(refusal), _) => IndexResult::Refused(refusal.to_string()),
    };
    (0..input.record.inputs.len()).map(index).collect()
}
