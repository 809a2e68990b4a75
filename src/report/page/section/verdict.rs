//! The first section: what must be known before any number is used, and the numbers that matter most.

use super::decision;
use crate::ensemble::outcome::Maximum;
use crate::hb::Status;
use crate::page::block::{Block, Cell, Section, Table, Verdict};
use crate::page::display::{DASH, count, duration, hertz, percent, stated_percent};
use crate::report::asked::requirement::{Criterion, RequiredQuantity};
use crate::report::assessment::pooling;
use crate::report::numbers::margins::smallest_margin;
use crate::report::numbers::peaks::{above_peak, usable_peak};
use crate::report::numbers::summary::Summary;
use crate::report::page::statistic_cell::{bound_cell, limits};
use crate::report::page::view::View;
use crate::report::verdict::criterion_result::{CriterionResult, LevelResult};
use crate::report::verdict::sentence::{power, reasons, shown, stated_limit, word};
use crate::statistics::Judgement;

pub(super) fn section(view: &View) -> Section {
    let notices = notices(view);
    let calm = "Every sample has a solution at every level, and no error alert was raised.";
    let mut blocks = Vec::new();
    if !view.assessment.criteria.is_empty() {
        blocks.push(Block::Verdicts(
            view.assessment.criteria.iter().map(verdict).collect(),
        ));
        blocks.push(Block::pairs(decision::figures(view)));
        blocks.push(criteria(view));
        blocks.push(Block::Hint(
            "PASS or FAIL: the whole confidence interval lies on that side of the limit, each side with the stated \
             confidence, whatever unknown samples would have given (failed, unstable, bouncing, or with a truncation error \
             above the threshold) and wherever the others lie within their numerical error. UNDECIDED: the limit lies inside, \
             or too few samples bound the side. (indication): the samples are no independent draws, so there is no \
             confidence. Flat inputs as intervals: uniform and log-uniform inputs may say no more than that a value lies \
             somewhere in an interval. Limits, standards and clauses are the user’s."
                .to_owned(),
        ));
    }
    blocks.push(Block::Facts(facts(view.summary)));
    blocks.push(match notices.is_empty() {
        true => Block::Fine(calm.to_owned()),
        false => Block::Notices(notices),
    });
    if view.summary.epistemic.is_none() && view.input.record.has_random_inputs() {
        blocks.push(bounds(view));
    }
    blocks.push(Block::Hint(view.assessment.condition.clone()));
    let stopping = view.assessment.stopping.iter();
    blocks.extend(stopping.map(|s| Block::Hint(s.in_words())));
    Section {
        id: "verdict",
        title: "Verdict".to_owned(),
        blocks,
    }
}

/// A judgement as badge, name and sentence.
fn verdict(result: &CriterionResult) -> Verdict {
    let points = outer_points(result.deciding());
    let (word, class) = badge(result.judgement, points, result.indication);
    Verdict {
        word,
        class,
        name: result.criterion.name.clone(),
        sentence: result.sentence.clone(),
    }
}

fn criteria(view: &View) -> Block {
    let mut table = Table::of(
        "Criteria",
        "criteria",
        &[
            ("Verdict", &["verdict"]),
            ("Criterion", &["criterion"]),
            ("Level", &["level"]),
            ("Required", &["required"]),
            ("Found", &["found", "lower", "upper"]),
            ("Confidence", &["confidence"]),
            (
                "Samples",
                &[
                    "counts",
                    "samples",
                    "broken",
                    "unknown",
                    "numerical_error_lower",
                    "numerical_error_upper",
                ],
            ),
            ("Flat inputs as intervals", &["as_intervals"]),
        ],
    );
    for result in &view.assessment.criteria {
        if let Some(worst) = result.deciding() {
            table.row(criterion_row(view, result, worst));
        }
    }
    table.block()
}

fn criterion_row(view: &View, result: &CriterionResult, level: &LevelResult) -> Vec<Cell> {
    let criterion = &result.criterion;
    let (word, class) = badge(
        level.judgement,
        outer_points(Some(level)),
        result.indication,
    );
    let source = [&criterion.standard, &criterion.clause].map(|s| s.as_deref());
    let source: Vec<&str> = source.into_iter().flatten().collect();
    let show = shown(criterion);
    let found = level.estimate.map_or_else(|| DASH.to_owned(), &show);
    let mut levels = view.input.record.levels.iter();
    let place = levels.position(|l| *l == level.level);
    let sides = [level.interval.lower.value(), level.interval.upper.value()];
    let extent = match result.levels.len() {
        1 => String::new(),
        n => format!("decides among {n} levels"),
    };
    let outer =
        (level.outer).map_or_else(String::new, |outer| format!("worst outer point: {outer}"));
    let share = match criterion.quantity {
        RequiredQuantity::ProbabilityOfExceedance => "of the probability".to_owned(),
        _ => format!(
            "for {} of the assumed prior",
            stated_percent(criterion.share())
        ),
    };
    let confidence = match &level.power {
        Some(chance) => Cell::number(
            stated_percent(criterion.confidence()),
            Some(criterion.confidence()),
        )
        .with_small(share)
        .with_small(power(chance)),
        None => Cell::number(DASH, None).with_small("no input is random"),
    };
    vec![
        Cell::text(word).with_badge(class).with_class("text"),
        Cell::text(&criterion.name)
            .with_small(source.join(", "))
            .with_class("text strong"),
        place
            .map_or_else(|| Cell::text(DASH), |i| view.level_cell(i))
            .with_small(extent)
            .with_small(outer)
            .with_class("text brief"),
        Cell::text(requirement(criterion)).with_class("text brief"),
        Cell::number(found, level.estimate)
            .with_raw(sides)
            .with_small(limits(level.interval, &show)),
        confidence.with_class("text prose"),
        trust_cell(view, level, &show),
        as_intervals_cell(result),
    ]
}

/// What is required, in words.
fn requirement(criterion: &Criterion) -> String {
    let limit = stated_limit(criterion);
    match criterion.quantity {
        RequiredQuantity::FrequencyMarginPercent => format!("frequency margin ≥ {limit}"),
        RequiredQuantity::AmplitudeUm => format!("amplitude ≤ {limit}"),
        RequiredQuantity::ReserveFactor => format!("reserve factor ≥ {limit}"),
        RequiredQuantity::ProbabilityOfExceedance => format!("P(reserve factor < 1) ≤ {limit}"),
    }
}

/// The word of a judgement and its class. The word says itself what a PASS rests on: outer points, and samples that are
/// no independent draws.
fn badge(judgement: Judgement, points: Option<usize>, indication: bool) -> (String, &'static str) {
    let class = match judgement {
        Judgement::Pass => "pass",
        Judgement::Fail => "fail",
        Judgement::Undecided => "undecided",
    };
    let word = word(judgement);
    let at = match points.filter(|_| judgement == Judgement::Pass) {
        Some(n) => format!(" at {}", count(n, "point")),
        None => String::new(),
    };
    let end = if indication { " (indication)" } else { "" };
    (format!("{word}{at}{end}"), class)
}

/// Number of outer points that a result is judged at; absent without such.
fn outer_points(level: Option<&LevelResult>) -> Option<usize> {
    Some(level?.over_box.as_ref()?.points.len())
}

/// The judgement with inputs of flat distributions as intervals, its inputs and its basis.
fn as_intervals_cell(result: &CriterionResult) -> Cell {
    match &result.as_intervals {
        None => Cell::text(DASH).with_class("text prose"),
        Some(found) => {
            let (word, class) = badge(found.judgement, None, result.indication);
            Cell::text(word)
                .with_badge(class)
                .with_small(match found.inputs.as_slice() {
                    [one] => format!("{one} as an interval"),
                    several => format!("{} as intervals", several.join(", ")),
                })
                .with_small(found.basis.clone())
                .with_class("text prose")
        }
    }
}

/// Counts of the samples and of curves with several answers, and what their numerical error does to the interval.
fn trust_cell(view: &View, level: &LevelResult, show: &dyn Fn(f64) -> String) -> Cell {
    let counted = &level.counted;
    let error = &level.numerical_error;
    let numbers = [counted.samples, counted.broken, counted.unknown].map(|n| Some(n as f64));
    let unknown = match counted.unknown {
        0 => String::new(),
        n => format!("{n} unknown: {}", reasons(level)),
    };
    let (i, _) = decision::level_of(view, level);
    let answers = view.summary.levels[i].several_answers.in_words();
    let not_in_it = match error.not_estimated.is_empty() {
        true => String::new(),
        false => format!(
            "not estimated: {}",
            error.not_estimated.join(", ").to_lowercase()
        ),
    };
    Cell::text(format!(
        "{} of {} break it",
        counted.broken, counted.samples
    ))
    .with_raw(numbers)
    .with_raw([error.lower, error.upper])
    .with_small(unknown)
    .with_small(answers)
    .with_small(widened([error.lower, error.upper], show))
    .with_small(not_in_it)
    .with_class("text prose")
}

/// By how much the numerical error moves the lower and the upper limit of an interval; a side without a number is open.
fn widened(sides: [Option<f64>; 2], show: &dyn Fn(f64) -> String) -> String {
    match sides.map(|side| side.map(show)) {
        [Some(lower), Some(upper)] => {
            format!("numerical error widens by {lower} below, {upper} above")
        }
        [None, Some(upper)] => format!("numerical error widens by {upper} above; below open"),
        [Some(lower), None] => format!("numerical error widens by {lower} below; above open"),
        [None, None] => "open on both sides, with or without numerical error".to_owned(),
    }
}

/// Bounds that hold for 95 % of the assumed prior with 95 % confidence.
fn bounds(view: &View) -> Block {
    let title = "Bounds: each holds for 95 % of the assumed prior with 95 % confidence";
    let mut table = Table::of(
        title,
        "bounds",
        &[
            ("Level", &["level"]),
            (
                "Frequency above",
                &["frequency_lower_hz", "order", "confidence"],
            ),
            (
                "Frequency below",
                &["frequency_upper_hz", "order", "confidence"],
            ),
            (
                "Amplitude below",
                &["amplitude_upper_m", "order", "confidence"],
            ),
        ],
    );
    let frequency = |v: f64| format!("{} Hz", hertz(v));
    for (i, level) in view.assessment.levels.iter().enumerate() {
        let [lower, upper] = &level.frequency_bounds_hz;
        table.row(vec![
            view.level_cell(i),
            bound_cell(lower, &frequency),
            bound_cell(upper, &frequency),
            bound_cell(&level.amplitude_bound_m, &|v| view.amplitude(v)),
        ]);
    }
    table.block()
}

fn facts(summary: &Summary) -> Vec<(String, String)> {
    let solves = summary.samples * summary.levels.len();
    let failed: usize = summary.levels.iter().map(|l| l.failed).sum();
    let in_band = |frequency_hz: Option<f64>| match frequency_hz {
        Some(frequency_hz) => format!("{} Hz", hertz(frequency_hz)),
        None => "none in the band".to_owned(),
    };
    [
        ("samples", summary.samples.to_string()),
        ("solutions", format!("{} of {solves}", solves - failed)),
        ("free resonance", in_band(summary.free_frequency_hz)),
        ("fully stuck", in_band(summary.stuck_frequency_hz)),
        ("wall time, last command", duration(summary.wall_time_s)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

/// What must be known before any number of the report is used.
fn notices(view: &View) -> Vec<String> {
    let summary = view.summary;
    let mut notices: Vec<String> = view
        .input
        .changed
        .iter()
        .map(|name| format!("{name} is not the file that the run wrote: its content has changed."))
        .collect();
    let design = &view.input.record.design;
    if !design.independent {
        notices.push(format!(
            "The samples are no independent draws ({}): confidence intervals, bounds and verdicts presume such draws and \
             are indications here.",
            design.description
        ));
    }
    notices.extend(view.summary.epistemic.as_ref().map(pooling));
    notices.extend(mixed_notice(view));
    for status in Status::ALL.into_iter().filter(|&s| s != Status::Converged) {
        notices.extend(status_notice(view, status));
    }
    notices.extend(untrusted_notice(summary));
    notices.extend((0..summary.levels.len()).filter_map(|i| lower_maxima_notice(view, i)));
    notices.extend((0..summary.levels.len()).filter_map(|i| higher_curves_notice(view, i)));
    for (i, level) in summary.levels.iter().enumerate() {
        if level.frequency_hz.valid == 0 {
            let name = view.level_name(i);
            notices.push(format!("No sample has a solution at {name}."));
        }
    }
    notices
}

/// In how many samples a lower maximum lies on an engine order at level `i`, of which no frequency margin says anything; absent for none.
fn lower_maxima_notice(view: &View, i: usize) -> Option<String> {
    let operation = view.input.record.requirements.operation.as_ref()?;
    let shares: Vec<f64> = (view.input.outcomes.iter())
        .filter_map(|sample| {
            let level = &sample.levels[i];
            let highest = usable_peak(level)?.amplitude_m;
            let crossed = |of: &&Maximum| smallest_margin(of.frequency_hz, operation) == 0.0;
            let crossed = level.around.others().iter().filter(crossed);
            crossed.map(|of| of.amplitude_m / highest).reduce(f64::max)
        })
        .collect();
    let largest = shares.iter().copied().reduce(f64::max)?;
    Some(format!(
        "Frequency margins are those of the highest maximum of each sample. At {} a lower one, of up to {} of its amplitude, lies on an \
         engine order in {} of {} samples.",
        view.level_name(i),
        percent(largest),
        shares.len(),
        view.input.outcomes.len(),
    ))
}

/// In how many samples a sweep through the band meets more than the peak at level `i`: at an end of the band, as a rule; absent for none, and where
/// the peak is that of one mode.
fn higher_curves_notice(view: &View, i: usize) -> Option<String> {
    let levels = view.input.outcomes.iter().map(|sample| &sample.levels[i]);
    let swept =
        levels.filter(|level| usable_peak(level).is_some() && level.around.sweeps().is_some());
    let curves = swept.clone().count();
    let above = swept.filter_map(|level| {
        let top = above_peak(view.input.record, level)?;
        Some((top.amplitude_m / usable_peak(level)?.amplitude_m, top))
    });
    let above: Vec<(f64, Maximum)> = above.collect();
    let (ratio, top) = above
        .iter()
        .copied()
        .reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    Some(format!(
        "The peak is the highest maximum of the amplitude in the band. At {} {} of {} go above it elsewhere, by up to {} at {} Hz: at an \
         end of the band, which is to be wider then, or on a part of the branch whose maximum was not found. Verdicts take these samples up to there.",
        view.level_name(i),
        above.len(),
        count(curves, "curve"),
        percent(ratio - 1.0),
        hertz(top.frequency_hz),
    ))
}

/// How many samples serve the sensitivity indices alone, and how many of them have no solution; absent without such.
fn mixed_notice(view: &View) -> Option<String> {
    let levels = view.summary.levels.iter();
    let mixed: Vec<_> = levels.filter_map(|l| l.mixed.as_ref()).collect();
    let samples = mixed.first()?.samples;
    let failed: usize = mixed.iter().map(|m| m.failed).sum();
    let solves = samples * mixed.len();
    Some(format!(
        "{samples} further samples share inputs with these and serve the sensitivity indices alone; {failed} of their \
         {solves} solves have no solution. No other number of this page counts them."
    ))
}

/// How many solutions the verdicts do not trust and every other number counts; absent without such.
fn untrusted_notice(summary: &Summary) -> Option<String> {
    let untrusted = Status::ALL.into_iter();
    let untrusted = untrusted.filter(|status| status.has_solution() && !status.is_trusted());
    let count: usize = untrusted
        .flat_map(|status| {
            summary
                .levels
                .iter()
                .map(move |l| l.statuses[status.name()])
        })
        .sum();
    let solves = summary.samples * summary.levels.len();
    (count > 0).then(|| {
        format!(
            "{count} of {solves} solves have a solution that is not to be trusted. Verdicts count it as unknown; every other \
             number of this page (quantiles, bounds, bands, indices) counts it with the value that it has."
        )
    })
}

/// How many solves ended so, and where most of them; absent if none did.
fn status_notice(view: &View, status: Status) -> Option<String> {
    let summary = view.summary;
    let solves = summary.samples * summary.levels.len();
    let levels = summary.levels.iter();
    let counts: Vec<usize> = levels.map(|l| l.statuses[status.name()]).collect();
    let total: usize = counts.iter().sum();
    let numbered = counts.iter().enumerate();
    let (worst, count) = numbered.max_by_key(|(i, count)| (**count, usize::MAX - i))?;
    (total > 0).then(|| {
        let share = percent(total as f64 / solves as f64);
        format!(
            "{total} of {solves} solves ({share}) ended as {}: {}; most at {} ({count}).",
            status.name(),
            status.explanation(),
            view.level_name(worst),
        )
    })
}
