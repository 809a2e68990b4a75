//! A judgement in plain words: what was found, what was asked, and what would decide.

use super::criterion_result::{CriterionResult, LevelResult, Power};
use super::over_box::OverBox;
use crate::page::display::{
    beside, capitalised, count, level_name, percent, percent_beside, stated, stated_percent,
};
use crate::report::asked::requirement::{Criterion, RequiredQuantity};
use crate::report::run::input::ReportInput;
use crate::report::run::record::RunRecord;
use crate::sampling::Growth;
use crate::sampling::design_settings::MOST_SAMPLES;
use crate::statistics::{Interval, Judgement, Remedy};

/// How a number that is compared with the limit of the criterion is written: on its side of it.
pub(in crate::report) fn shown(criterion: &Criterion) -> impl Fn(f64) -> String + use<> {
    let (quantity, limit) = (criterion.quantity, criterion.limit);
    move |v| match quantity {
        RequiredQuantity::FrequencyMarginPercent => format!("{} %", beside(v, limit, 3)),
        RequiredQuantity::AmplitudeUm => format!("{} µm", beside(v, limit, 4)),
        RequiredQuantity::ReserveFactor => beside(v, limit, 3),
        RequiredQuantity::ProbabilityOfExceedance => percent_beside(v, limit),
    }
}

/// The limit of the criterion, as the study file states it.
pub(in crate::report) fn stated_limit(criterion: &Criterion) -> String {
    let limit = criterion.limit;
    match criterion.quantity {
        RequiredQuantity::FrequencyMarginPercent => format!("{} %", stated(limit)),
        RequiredQuantity::AmplitudeUm => format!("{} µm", stated(limit)),
        RequiredQuantity::ReserveFactor => stated(limit),
        RequiredQuantity::ProbabilityOfExceedance => stated_percent(limit),
    }
}

/// The judgement of a criterion in one or two sentences.
pub(super) fn sentence(input: &ReportInput, result: &CriterionResult) -> String {
    let (record, criterion) = (input.record, &result.criterion);
    let Some(level) = result.deciding() else {
        return "No level was judged.".to_owned();
    };
    let place = place(record, result, level);
    let limit = stated_limit(criterion);
    let asked = match criterion.quantity.at_least() {
        true => format!("at least {limit} is required"),
        false => format!("at most {limit} is allowed"),
    };
    let show = shown(criterion);
    let found = match level.estimate {
        None => format!("No sample has a solution to be trusted {place} ({asked})."),
        Some(estimate) => {
            let found = found(record, criterion, level, &show(estimate));
            let interval = between(level.interval, &show);
            format!("{found} {place} ({interval}; {asked}).")
        }
    };
    let end = match result.judgement {
        Judgement::Pass => String::new(),
        Judgement::Fail => " The limit is not kept.".to_owned(),
        Judgement::Undecided => undecided(input, result, level),
    };
    let over_box = level.over_box.as_ref();
    let over_box = over_box.map_or_else(String::new, |over| over_box_in_words(record, over));
    format!("{found}{end}{over_box}")
}

/// What would decide at the level that decides, and at the one that takes most, if that is another one.
fn undecided(input: &ReportInput, result: &CriterionResult, level: &LevelResult) -> String {
    let decides = remedy(input, level).map(|remedy| format!(" Undecided: {remedy}."));
    let hardest = result.hardest.as_ref().and_then(|hardest| {
        let place = capitalised(&at(input.record, hardest));
        let outer = hardest
            .outer
            .map_or_else(String::new, |n| format!(" and outer point {n}"));
        Some(format!(" {place}{outer}: {}.", remedy(input, hardest)?))
    });
    decides.into_iter().chain(hardest).collect()
}

/// Where over the box the limit is kept, and how that is known.
fn over_box_in_words(record: &RunRecord, over: &OverBox) -> String {
    let points = count(over.points.len(), "point");
    let seen = match record.design.further_points {
        0 => format!("Shown at {points}, not between them"),
        n => format!(
            "Searched for the worst case: {n} of the {points}; what lies between them is not proved"
        ),
    };
    format!(" Over the box: {}. {seen}.", over.in_words())
}

fn found(record: &RunRecord, criterion: &Criterion, level: &LevelResult, number: &str) -> String {
    if !record.has_random_inputs() {
        let what = match criterion.quantity {
            RequiredQuantity::FrequencyMarginPercent => {
                let what = nearest_order(record, level);
                return format!(
                    "No input is random: the resonance stays {number} away from {what}"
                );
            }
            RequiredQuantity::AmplitudeUm => "amplitude",
            RequiredQuantity::ReserveFactor => "reserve factor",
            RequiredQuantity::ProbabilityOfExceedance => "probability of a reserve factor below 1",
        };
        return format!("No input is random: the {what} is {number}");
    }
    let share = stated_percent(criterion.share());
    match criterion.quantity {
        RequiredQuantity::FrequencyMarginPercent => {
            let what = nearest_order(record, level);
            format!("{share} of the assumed prior stays {number} away from {what}")
        }
        RequiredQuantity::AmplitudeUm => {
            format!("{share} of the assumed prior stays below {number}")
        }
        RequiredQuantity::ReserveFactor => {
            format!("{share} of the assumed prior has a reserve factor of {number} or more")
        }
        RequiredQuantity::ProbabilityOfExceedance => {
            format!("{number} of the assumed prior has a reserve factor below 1")
        }
    }
}

/// `engine order 6`. Samples that are crossed all have the margin 0, of whichever order.
fn nearest_order(record: &RunRecord, level: &LevelResult) -> String {
    let Some(order) = level.engine_order else {
        return "every engine order".to_owned();
    };
    let operation = record.requirements.operation.as_ref();
    let several = operation.is_some_and(|operation| operation.engine_orders.len() > 1);
    match several && level.estimate == Some(0.0) {
        true => format!("engine order {order}, the one crossed most often,"),
        false => format!("engine order {order}"),
    }
}

/// `at 5 N, the worst of 2 levels`.
fn place(record: &RunRecord, result: &CriterionResult, level: &LevelResult) -> String {
    let mut text = at(record, level);
    if result.levels.len() > 1 {
        text.push_str(&format!(", the worst of {} levels", result.levels.len()));
    }
    if let Some(outer) = level.outer {
        text.push_str(&format!(" and at outer point {outer}, the worst"));
    }
    text
}

/// `at 5 N`.
fn at(record: &RunRecord, level: &LevelResult) -> String {
    format!("at {}", level_name(level.level, &record.level_unit))
}

fn between(interval: Interval, show: &impl Fn(f64) -> String) -> String {
    match (interval.lower.value(), interval.upper.value()) {
        (Some(lower), Some(upper)) => format!("{} to {}", show(lower), show(upper)),
        (Some(lower), None) => format!("{} or more", show(lower)),
        (None, Some(upper)) => format!("{} or less", show(upper)),
        (None, None) => "the samples bound it on no side".to_owned(),
    }
}

/// What would decide, with its number; absent where a level is decided.
pub(super) fn remedy(input: &ReportInput, level: &LevelResult) -> Option<String> {
    let counted = &level.counted;
    Some(match level.remedy? {
        Remedy::Samples(n) => {
            let few = counted.broken + counted.unknown == 0;
            let needed = match few {
                true => format!("{n} samples needed"),
                false => format!("about {n} samples needed"),
            };
            format!("{needed}{}", more_samples(input, n))
        }
        Remedy::FewerUnknownOrSamples(n) => format!(
            "{}: the others alone would decide, and with as many unknown ones it takes about {n} samples{}",
            unknown(level),
            more_samples(input, n)
        ),
        Remedy::FewerUnknown if !input.record.has_random_inputs() => format!(
            "{}, and further samples would be the same, since no input is random",
            unknown(level)
        ),
        Remedy::FewerUnknown => format!(
            "{}, and no number of samples decides as long as so large a share is",
            unknown(level)
        ),
        Remedy::AtLeast(n) => format!(
            "the share that keeps the limit lies too close to the one that must for a number of samples to be named; at the best \
             that {} samples allow, about {n} decide{}",
            counted.samples,
            more_samples(input, n)
        ),
        Remedy::TooClose => {
            "the share that keeps the limit is too close to the one that must: more than a million samples needed"
                .to_owned()
        }
    })
}

/// Where and how the samples come from: a command only where the program does not refuse it.
fn more_samples(input: &ReportInput, n: usize) -> String {
    let (record, folder) = (input.record, input.folder);
    let outer = record.design.outer_points;
    let each = match outer {
        1 => "",
        _ => " at each outer point",
    };
    let grown = match &record.stopping {
        Some(stopping) if stopping.met => {
            return format!(
                "{each}: the rule of `samples` was met, `run` the study with `samples = {n}`"
            );
        }
        Some(stopping) => stopping.growth(n as u64),
        None => record.design.growth.total(n as u64),
    };
    let total = grown.and_then(|total| total.checked_mul(outer));
    match (total, record.design.growth) {
        (Some(total), _) if total > MOST_SAMPLES => {
            format!("{each}: {total} in all, and a study has at most {MOST_SAMPLES}")
        }
        (Some(total), _) => format!("{each}: `microslip extend {folder} --samples {total}`"),
        (None, Growth::UpTo(rows)) => {
            format!("{each}: the file of samples has {rows} rows, add as many and `run` it anew")
        }
        (None, _) => format!("{each}: this design cannot be extended, `run` one of so many"),
    }
}

/// `3 of 70 samples are unknown (3 failed)`.
fn unknown(level: &LevelResult) -> String {
    let counted = &level.counted;
    let verb = if counted.unknown == 1 { "is" } else { "are" };
    format!(
        "{} of {} samples {verb} unknown ({})",
        counted.unknown,
        counted.samples,
        reasons(level)
    )
}

/// Why samples are unknown: `3 failed, 12 not to be trusted`.
pub(in crate::report) fn reasons(level: &LevelResult) -> String {
    let because = &level.unknown_because;
    let parts = [
        (because.failed, "failed"),
        (because.untrusted, "not to be trusted"),
        (
            because.within_error,
            "with the limit inside their numerical error",
        ),
    ];
    let parts = parts.into_iter().filter(|(count, _)| *count > 0);
    let parts: Vec<String> = parts.map(|(count, why)| format!("{count} {why}")).collect();
    parts.join(", ")
}

/// How often a study of this size passes: a PASS of a study that hardly ever gives one says more than its absence would.
pub(in crate::report) fn power(power: &Power) -> String {
    let kept = beside(100.0 * power.kept, 100.0, 3);
    let more = match power.samples_for_90_percent {
        Some(n) => format!(", {n} samples in 90 %"),
        None => String::new(),
    };
    format!(
        "if {kept} % kept the limit, so many samples would pass in {} of all studies{more}",
        percent(power.probability)
    )
}

/// The word of a judgement.
pub(in crate::report) fn word(judgement: Judgement) -> &'static str {
    match judgement {
        Judgement::Pass => "PASS",
        Judgement::Fail => "FAIL",
        Judgement::Undecided => "UNDECIDED",
    }
}
