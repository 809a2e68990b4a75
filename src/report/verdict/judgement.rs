//! The user's criteria, judged: PASS, FAIL or UNDECIDED, over all their levels and outer points.
//!
//! What a judgement is (`criterion_result`), how one population is judged (`judged`) and how it is put into words (`sentence`)
//! stand below.

use super::criterion_result::{CriterionResult, LevelResult};
use super::ignorance::as_intervals;
use super::judged::Judged;
use super::numerical_error::NumericalErrors;
use super::over_box::{OverBox, PointJudgement};
use super::sentence::sentence;
use crate::report::asked::requirement::Criterion;
use crate::report::numbers::error_budget::ErrorLine;
use crate::report::numbers::outer_points::{chosen, epistemic_columns, nested, outer_groups};
use crate::report::run::input::ReportInput;
use crate::statistics::Judgement;

/// Judges every criterion of the study.
pub(in crate::report) fn judge_all(
    input: &ReportInput,
    budget: &[ErrorLine],
) -> Vec<CriterionResult> {
    let errors = NumericalErrors::of(input, budget);
    let criteria = input.record.requirements.criteria.iter();
    criteria
        .map(|criterion| result(input, criterion, &errors))
        .collect()
}

fn result(input: &ReportInput, criterion: &Criterion, errors: &NumericalErrors) -> CriterionResult {
    let levels = criterion.levels(&input.record.levels);
    let populations = levels.len() * outer_groups(input.outcomes).len();
    let judged = |&level: &usize| Judged {
        populations,
        ..Judged::new(*input, criterion, errors, level)
    };
    let judged: Vec<Judged> = levels.iter().map(judged).collect();
    let points: Vec<Vec<LevelResult>> = judged.iter().map(results_of_points).collect();
    let levels = judged.iter().zip(&points);
    let levels: Vec<LevelResult> = levels.map(|(of, points)| worst_point(of, points)).collect();
    let any = |judgement| levels.iter().any(|l| l.judgement == judgement);
    let judgement = match (any(Judgement::Fail), any(Judgement::Undecided)) {
        (true, _) => Judgement::Fail,
        (false, true) => Judgement::Undecided,
        (false, false) => Judgement::Pass,
    };
    let mut result = CriterionResult {
        criterion: criterion.clone(),
        judgement,
        indication: !input.record.design.independent && input.record.has_random_inputs(),
        sentence: String::new(),
        as_intervals: as_intervals(judgement, &judged),
        levels,
        hardest: None,
    };
    result.hardest = hardest(&result, points);
    result.sentence = sentence(input, &result);
    result
}

/// Of all levels and outer points the one whose remedy is the hardest, if it is harder than that of the level that decides: what the
/// sentence says of that one alone would not be enough.
fn hardest(result: &CriterionResult, points: Vec<Vec<LevelResult>>) -> Option<LevelResult> {
    let hardness = |level: &LevelResult| level.remedy.map(|remedy| remedy.hardness());
    let enough = hardness(result.deciding()?)?;
    let harder = points.into_iter().flatten();
    let harder = harder.filter(|point| hardness(point) > Some(enough));
    harder.max_by_key(hardness)
}

/// The results of the outer points, whose samples are no population together; of all samples where there are no such points.
fn results_of_points(judged: &Judged) -> Vec<LevelResult> {
    if !nested(judged.input.outcomes) {
        return vec![judged.population()];
    }
    let of_point = |(outer, members): (Option<u64>, Vec<usize>)| {
        let outcomes: Vec<_> = (members.iter())
            .map(|&m| judged.input.outcomes[m].clone())
            .collect();
        let input = ReportInput {
            outcomes: &outcomes,
            ..judged.input
        };
        LevelResult {
            outer,
            ..Judged { input, ..*judged }.population()
        }
    };
    let groups = outer_groups(judged.input.outcomes);
    groups.into_iter().map(of_point).collect()
}

/// The worst of the results of a level.
fn worst_point(judged: &Judged, points: &[LevelResult]) -> LevelResult {
    let severity = |result: &LevelResult| {
        let word = match result.judgement {
            Judgement::Pass => 0,
            Judgement::Undecided => 1,
            Judgement::Fail => 2,
        };
        (word, result.cost(judged.criterion))
    };
    let worse = |a, b| match severity(b) > severity(a) {
        true => b,
        false => a,
    };
    let worst = points.iter().reduce(worse).cloned();
    LevelResult {
        over_box: nested(judged.input.outcomes).then(|| over_box(&judged.input, points)),
        ..worst.unwrap_or_else(|| judged.population())
    }
}

/// The judgements over the box, from the results of the outer points in the order of their numbers.
fn over_box(input: &ReportInput, results: &[LevelResult]) -> OverBox {
    let groups = outer_groups(input.outcomes);
    let columns = epistemic_columns(input.outcomes, &groups);
    let point = |((outer, members), result): (&(Option<u64>, Vec<usize>), &LevelResult)| {
        let first = &input.outcomes[members[0]];
        PointJudgement {
            outer: *outer,
            values: chosen(&first.inputs, &columns),
            estimate: result.estimate,
            judgement: result.judgement,
        }
    };
    let names = columns.iter().map(|&j| input.record.inputs[j].name.clone());
    OverBox {
        inputs: names.collect(),
        points: groups.iter().zip(results).map(point).collect(),
    }
}
