//! What further samples on few harmonics add to the samples: means and probabilities by control variate.

use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, count, percent, signed, significant};
use crate::report::numbers::control_variate::{ControlledAndPlain, LevelControlVariate};
use crate::report::page::statistic_cell::{limits, percent_range, share_cell};
use crate::report::page::view::{Shown, View};
use crate::statistics::{ControlledMean, Interval};

/// Absent where the study wants none.
pub(super) fn section(view: &View) -> Option<Section> {
    let (_, first) = levels(view).next()?;
    let all = first.further + view.input.outcomes.len();
    let mut blocks = vec![
        Block::Hint(format!(
            "{all} samples, among them the {} of this study, are also solved on harmonics up to {} alone. That is cheap and \
             wrong, but nearly proportional to the full solution: the many samples say where its mean lies, and the samples of \
             the study what has to be corrected (control variate). The numbers of this section stand here and nowhere else \
             on this page.",
            view.input.outcomes.len(),
            first.highest_harmonic,
        )),
        means(view),
    ];
    blocks.extend(exceedances(view));
    blocks.push(Block::Hint(
        "Small figures: 95 % confidence intervals. Samples: those of the study alone. Variance ratio: square of the ratio of \
         the two widths; with 0.1 the samples alone would need ten times as many for an interval of the same width. A ratio near \
         or above 1 says that the control variate is worth nothing here. A failed sample of the study may lie anywhere above 0, \
         which opens the upper limit of a mean. A control without solution counts as the mean of the \
         others in a mean, and on neither side of a limit in a probability."
            .to_owned(),
    ));
    Some(Section {
        id: "control-variate",
        title: "Control variate".to_owned(),
        blocks,
    })
}

/// Number of a level, its control variate.
fn levels<'a>(view: &'a View) -> impl Iterator<Item = (usize, &'a LevelControlVariate)> {
    let levels = view.assessment.levels.iter().enumerate();
    levels.filter_map(|(i, level)| Some((i, level.control_variate.as_ref()?)))
}

fn means(view: &View) -> Block {
    let mut table = Table::of(
        "Means by control variate",
        "control-variate-means",
        &[
            ("Level", &["level"]),
            ("Result", &["result"]),
            ("Control variate", &["mean", "mean_lower", "mean_upper"]),
            (
                "Samples",
                &["mean_alone", "mean_alone_lower", "mean_alone_upper"],
            ),
            ("Correlation", &["correlation"]),
            ("Variance ratio", &["variance_ratio"]),
        ],
    );
    for (i, level) in levels(view) {
        for shown in Shown::ALL {
            let found = match shown {
                Shown::Frequency => level.frequency_hz,
                Shown::AmplitudePerLevel => level.amplitude_m,
            };
            let head = [
                view.level_cell(i).with_small(without_solution(level)),
                Cell::text(shown.word()).with_class("text"),
            ];
            let cells = mean_cells(view, shown, found.as_ref());
            table.row(head.into_iter().chain(cells).collect());
        }
    }
    table.block()
}

/// How many controls have failed, in words; empty if none has.
fn without_solution(level: &LevelControlVariate) -> String {
    match level.failed {
        0 => String::new(),
        n => format!("{n} of the control without solution"),
    }
}

/// Means in Hz or in the unit of the page; in SI in the download.
fn mean_cells(view: &View, shown: Shown, found: Option<&ControlledMean>) -> [Cell; 4] {
    let none = || Cell::number(DASH, None);
    let Some(found) = found else {
        return [
            none()
                .with_raw([None; 2])
                .with_small("fewer than 20 samples have a solution".to_owned()),
            none().with_raw([None; 2]),
            none(),
            none(),
        ];
    };
    let show = |v: f64| match shown {
        Shown::Frequency => format!("{v:.2} Hz"),
        Shown::AmplitudePerLevel => view.amplitude(v),
    };
    let cell = |mean: f64, interval: Interval| {
        Cell::number(show(mean), Some(mean))
            .with_raw([interval.lower.value(), interval.upper.value()])
            .with_small(limits(interval, &show))
    };
    [
        cell(found.mean, found.interval),
        cell(found.mean_alone, found.interval_alone),
        Cell::number(
            signed(&format!("{:.3}", found.correlation)),
            Some(found.correlation),
        ),
        ratio_cell(found.variance_ratio),
    ]
}

fn ratio_cell(ratio: Option<f64>) -> Cell {
    Cell::number(ratio.map_or_else(|| DASH.to_owned(), significant), ratio)
}

/// Absent without a limit of the amplitude.
fn exceedances(view: &View) -> Option<Block> {
    let mut table = Table::of(
        "Probability that the amplitude exceeds a limit, by control variate",
        "control-variate-exceedance",
        &[
            ("Level", &["level"]),
            ("Limit", &["limit_m"]),
            (
                "Control variate",
                &[
                    "probability",
                    "probability_lower",
                    "probability_upper",
                    "control_alone",
                    "missed",
                    "false_alarms",
                ],
            ),
            ("Samples", &["samples", "samples_lower", "samples_upper"]),
            ("Variance ratio", &["variance_ratio"]),
        ],
    );
    let mut empty = true;
    for (i, level) in levels(view) {
        for both in &level.exceedances {
            empty = false;
            table.row(exceedance_row(view, i, both));
        }
    }
    (!empty).then(|| table.block())
}

fn exceedance_row(view: &View, i: usize, both: &ControlledAndPlain) -> Vec<Cell> {
    let found = &both.controlled;
    let share = found.probability;
    let wrong = found.missed + found.false_alarms;
    let raw = [
        share.lower,
        share.upper,
        found.control_alone,
        found.missed as f64,
        found.false_alarms as f64,
    ];
    vec![
        view.level_cell(i),
        view.limit_cell(found.threshold),
        Cell::number(percent(share.estimate), Some(share.estimate))
            .with_raw(raw.map(Some))
            .with_small(percent_range(share.lower, share.upper))
            .with_small(format!(
                "the control is wrong at {}",
                count(wrong, "sample")
            )),
        share_cell(both.samples.as_ref().map(|s| s.probability).as_ref()),
        ratio_cell(Some(found.variance_ratio)),
    ]
}
