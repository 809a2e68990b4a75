//! The second verdict: inputs of flat distributions taken as known to an interval only.
//!
//! Uniform and log-uniform distributions mostly say that nobody knows where in an interval a value lies, often one value for
//! all blades. Then "95 % of the assumed prior" is a statement about the prior, and the question is whether the limit holds
//! wherever in the interval the value is. Samples of a prior can show that it does not: if each value kept it, so would
//! their mixture. That it does takes a worst case over the interval, so `kind = "epistemic"`.

use super::criterion_result::IgnoranceResult;
use super::judged::Judged;
use crate::page::display::short;
use crate::report::numbers::outer_points::outer_groups;
use crate::report::run::record::RunRecord;
use crate::sampling::{Distribution, Shape};
use crate::statistics::Judgement;

/// Judges with inputs of flat distributions as intervals, after `judgement` on the prior; absent without such inputs.
pub(super) fn as_intervals(judgement: Judgement, levels: &[Judged]) -> Option<IgnoranceResult> {
    let first = levels.first()?;
    let record = first.input.record;
    let flat: Vec<usize> = (0..record.inputs.len())
        .filter(|&j| is_flat(record, j))
        .collect();
    if flat.is_empty() {
        return None;
    }
    let inputs: Vec<String> = flat
        .iter()
        .map(|&j| record.inputs[j].name.clone())
        .collect();
    let (judgement, basis) = match (judgement, breaking(levels, &flat)) {
        (_, Some(basis)) => (Judgement::Fail, basis),
        (Judgement::Fail, None) => (
            Judgement::Fail,
            "a limit that holds wherever the values are holds for the prior, too, and it does not"
                .to_owned(),
        ),
        _ => (Judgement::Undecided, needed(&inputs)),
    };
    Some(IgnoranceResult {
        inputs,
        judgement,
        basis,
    })
}

fn is_flat(record: &RunRecord, j: usize) -> bool {
    let input = &record.inputs[j];
    let flat = |law: &Distribution| {
        matches!(
            law.shape(),
            Shape::Uniform { .. } | Shape::LogUniform { .. }
        )
    };
    // the values of such an input say nothing of the contacts
    !input.numbers_draws() && input.distribution.as_ref().is_some_and(flat)
}

/// A sample that surely breaks the limit, where nothing but the flat inputs differs between samples: a value at which no
/// blade keeps it.
fn breaking(levels: &[Judged], flat: &[usize]) -> Option<String> {
    let first = levels.first()?;
    let (record, outcomes) = (first.input.record, first.input.outcomes);
    let alike = |j: usize| {
        let groups = outer_groups(outcomes);
        groups.iter().all(|(_, members)| {
            let value = |&m: &usize| outcomes[m].inputs[j];
            members.iter().all(|m| value(m) == value(&members[0]))
        })
    };
    if !(0..record.inputs.len()).all(|j| flat.contains(&j) || alike(j)) {
        return None;
    }
    let broken = levels.iter().find_map(|level| {
        let results = level.results();
        results.iter().position(|result| level.breaks(result))
    })?;
    let sample = &outcomes[broken];
    let values = flat.iter().map(|&j| {
        let name = &record.inputs[j].name;
        format!("{name} = {}", short(sample.inputs[j]))
    });
    let values: Vec<String> = values.collect();
    Some(format!(
        "sample {} breaks the limit: {}",
        sample.index,
        values.join(", ")
    ))
}

fn needed(inputs: &[String]) -> String {
    format!(
        "samples of a prior cannot show that the limit holds everywhere; `kind = \"epistemic\"` for {} judges the worst case",
        inputs.join(" and ")
    )
}
