//! The user's criteria, judged: PASS, FAIL or UNDECIDED.

use super::ReportInput;
use super::assessment::values;
use super::epistemic::{nested, outer_groups};
use super::margins::{allowable_amplitude_m, factor, smallest_margin};
use super::requirement::{Criterion, Quantity};
use crate::statistics::{
    Criterion as Rule, Interval, Judgement, Observed, exceedance, judge, quantile_estimate,
};
use serde::Serialize;

/// m → µm.
const UM_PER_M: f64 = 1e6;

/// A criterion and its judgement.
#[derive(Debug, Clone, Serialize)]
pub struct CriterionResult {
    /// As the study file states it.
    pub criterion: Criterion,
    /// The worst of its levels: FAIL before UNDECIDED before PASS.
    pub judgement: Judgement,
    /// One entry per level that it holds for.
    pub levels: Vec<LevelResult>,
}

/// A criterion at one excitation level.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct LevelResult {
    /// Excitation level.
    pub level: f64,
    /// Number that is judged, from the samples with a solution: the quantile that leaves out 1 − share, or the
    /// probability; in the unit of the limit. Absent without samples.
    pub estimate: Option<f64>,
    /// Where it lies: each side holds with the confidence of the criterion, whatever failed samples would have given.
    pub interval: Interval,
    /// Judgement.
    pub judgement: Judgement,
    /// The outer point of the epistemic inputs that decides: the criterion must hold at each. Absent without such inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outer: Option<u64>,
}

/// Judges every criterion of the study.
pub(super) fn judge_all(input: &ReportInput) -> Vec<CriterionResult> {
    let criteria = input.record.requirements.criteria.iter();
    criteria.map(|criterion| result(input, criterion)).collect()
}

fn result(input: &ReportInput, criterion: &Criterion) -> CriterionResult {
    let levels = input.record.levels.iter().enumerate();
    let chosen = levels.filter(|(_, level)| criterion.level.is_none_or(|l| l == **level));
    let levels: Vec<LevelResult> = chosen
        .map(|(i, &level)| level_result(input, criterion, i, level))
        .collect();
    let any = |judgement| levels.iter().any(|l| l.judgement == judgement);
    CriterionResult {
        criterion: criterion.clone(),
        judgement: match (any(Judgement::Fail), any(Judgement::Undecided)) {
            (true, _) => Judgement::Fail,
            (false, true) => Judgement::Undecided,
            (false, false) => Judgement::Pass,
        },
        levels,
    }
}

/// The worst over the outer points, where there are such: their samples are no population together.
fn level_result(input: &ReportInput, criterion: &Criterion, i: usize, level: f64) -> LevelResult {
    if !nested(input.outcomes) {
        return population_result(input, criterion, i, level);
    }
    let of_point = |(outer, members): (Option<u64>, Vec<usize>)| {
        let outcomes: Vec<_> = (members.iter())
            .map(|&m| input.outcomes[m].clone())
            .collect();
        let point = ReportInput {
            outcomes: &outcomes,
            ..*input
        };
        LevelResult {
            outer,
            ..population_result(&point, criterion, i, level)
        }
    };
    let points = outer_groups(input.outcomes).into_iter().map(of_point);
    let severity = |result: &LevelResult| {
        let word = match result.judgement {
            Judgement::Pass => 0,
            Judgement::Undecided => 1,
            Judgement::Fail => 2,
        };
        let sign = if criterion.quantity.at_least() {
            -1.0
        } else {
            1.0
        };
        (word, result.estimate.map_or(f64::INFINITY, |v| sign * v))
    };
    let worse = |a: LevelResult, b: LevelResult| match severity(&b) > severity(&a) {
        true => b,
        false => a,
    };
    let population = || population_result(input, criterion, i, level);
    points.reduce(worse).unwrap_or_else(population)
}

/// Judges the samples of one population.
fn population_result(
    input: &ReportInput,
    criterion: &Criterion,
    i: usize,
    level: f64,
) -> LevelResult {
    let (estimate, interval) = match criterion.quantity {
        Quantity::ProbabilityOfExceedance => probability(input, criterion, i),
        _ => quantile(input, criterion, i),
    };
    let rule = match criterion.quantity.at_least() {
        true => Rule::AtLeast(criterion.limit),
        false => Rule::AtMost(criterion.limit),
    };
    LevelResult {
        level,
        estimate,
        interval,
        judgement: judge(interval, rule),
        outer: None,
    }
}

/// Confidence of the two-sided interval of which each side has the criterion's.
fn two_sided(criterion: &Criterion) -> f64 {
    2.0 * criterion.confidence() - 1.0
}

fn quantile(input: &ReportInput, criterion: &Criterion, i: usize) -> (Option<f64>, Interval) {
    let requirements = &input.record.requirements;
    let values = match (
        criterion.quantity,
        &requirements.operation,
        &requirements.stress,
    ) {
        (Quantity::FrequencyMarginPercent, Some(operation), _) => values(input.outcomes, i, |p| {
            100.0 * smallest_margin(p.frequency_hz, operation)
        }),
        (Quantity::ReserveFactor, _, Some(stress)) => {
            values(input.outcomes, i, |p| factor(p.amplitude_m, stress))
        }
        _ => values(input.outcomes, i, |p| p.amplitude_m * UM_PER_M),
    };
    let probability = match criterion.quantity.at_least() {
        true => 1.0 - criterion.share(),
        false => criterion.share(),
    };
    let observed = Observed::of(values);
    match quantile_estimate(&observed, probability, two_sided(criterion)) {
        Some(quantile) => (Some(quantile.estimate), quantile.interval),
        None => (None, Interval::UNBOUNDED),
    }
}

fn probability(input: &ReportInput, criterion: &Criterion, i: usize) -> (Option<f64>, Interval) {
    let stress = input.record.requirements.stress.as_ref();
    let found = stress.and_then(|stress| {
        let observed = Observed::of(values(input.outcomes, i, |p| p.amplitude_m));
        exceedance(
            &observed,
            allowable_amplitude_m(stress),
            two_sided(criterion),
        )
    });
    match found.map(|exceedance| exceedance.probability) {
        Some(share) => {
            let estimate = share.known.map(|known| known.estimate);
            (estimate, Interval::between(share.lower, share.upper))
        }
        None => (None, Interval::UNBOUNDED),
    }
}
