//! What a surrogate says beyond the samples, and what it is worth.

use super::influence::index_cell;
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, count, percent, signed, significant};
use crate::report::numbers::surrogate::{
    ExceedanceBoth, LevelSurrogates, Surrogate, SurrogateResult,
};
use crate::report::page::statistic_cell::{percent_range, share_cell};
use crate::report::page::view::{Shown, View};

/// Absent where the study wants none.
pub(super) fn section(view: &View) -> Option<Section> {
    view.input.record.surrogate?;
    let mut blocks = vec![
        Block::Hint(
            "A polynomial chaos expansion stands for the solver in this section, and nowhere else on this page. Every sample \
             is predicted by an expansion that it did not shape (held out); these errors say what the surrogate is worth, \
             correct its numbers, and give their 95 % intervals."
                .to_owned(),
        ),
        worth(view),
        indices(view),
    ];
    if let Some(table) = exceedances(view) {
        blocks.push(table);
        blocks.push(Block::Hint(
            "Surrogate: share of 100000 points above the limit, corrected by the samples that it puts on the wrong side, with \
             its 95 % interval. Samples: share of the solved ones with its 95 % interval, failed ones on either side. The \
             surrogate narrows the interval only where it is right at almost every sample."
                .to_owned(),
        ));
    }
    Some(Section {
        id: "surrogate",
        title: "Surrogate".to_owned(),
        blocks,
    })
}

/// Number of a level, its surrogates.
fn levels<'a>(view: &'a View) -> impl Iterator<Item = (usize, &'a LevelSurrogates)> {
    let levels = view.assessment.levels.iter().enumerate();
    levels.filter_map(|(i, level)| Some((i, level.surrogates.as_ref()?)))
}

fn of(level: &LevelSurrogates, shown: Shown) -> &SurrogateResult {
    match shown {
        Shown::Frequency => &level.frequency,
        Shown::AmplitudePerLevel => &level.amplitude,
    }
}

fn worth(view: &View) -> Block {
    let mut table = Table::of(
        "Surrogate: what it is worth",
        "surrogate",
        &[
            ("Level", &["level"]),
            ("Result", &["result"]),
            ("Variance predicted", &["q2"]),
            ("Error where held out", &["held_out_rms_error"]),
            ("Largest there", &["held_out_largest_error"]),
            ("Samples", &["fitted", "failed"]),
            ("Terms", &["terms", "degree"]),
        ],
    );
    for (i, level) in levels(view) {
        for shown in Shown::ALL {
            let head = [
                view.level_cell(i),
                Cell::text(shown.word()).with_class("text"),
            ];
            let cells = match of(level, shown) {
                SurrogateResult::Refused(reason) => refused(reason),
                SurrogateResult::Surrogate(surrogate) => worth_cells(view, shown, surrogate),
            };
            table.row(head.into_iter().chain(cells).collect());
        }
    }
    table.block()
}

fn refused(reason: &str) -> Vec<Cell> {
    let none = || Cell::number(DASH, None);
    vec![
        none().with_small(format!("not available: {reason}")),
        none(),
        none(),
        none().with_raw([None]),
        none().with_raw([None]),
    ]
}

/// Errors in Hz or in the unit of the page; in full and in SI in the download.
fn worth_cells(view: &View, shown: Shown, surrogate: &Surrogate) -> Vec<Cell> {
    let error = |v: f64| {
        let text = match shown {
            Shown::Frequency => format!("{} Hz", significant(v)),
            Shown::AmplitudePerLevel => view.amplitude(v),
        };
        Cell::number(text, Some(v))
    };
    let held = &surrogate.held_out;
    vec![
        Cell::number(signed(&format!("{:.4}", held.q2)), Some(held.q2)),
        error(held.rms),
        error(held.largest),
        Cell::whole(surrogate.fitted as u64)
            .with_raw([Some(surrogate.failed as f64)])
            .with_small(format!("{} failed", surrogate.failed)),
        Cell::whole(surrogate.terms as u64)
            .with_raw([Some(surrogate.degree as f64)])
            .with_small(format!("degree {}", surrogate.degree)),
    ]
}

fn indices(view: &View) -> Block {
    let mut table = Table::of(
        "Surrogate: Sobol’ indices",
        "surrogate-indices",
        &[
            ("Level", &["level"]),
            ("Result", &["result"]),
            ("Input", &["input"]),
            (
                "First-order index",
                &["first", "first_lower", "first_upper"],
            ),
            ("Total index", &["total", "total_lower", "total_upper"]),
        ],
    );
    for (i, level) in levels(view) {
        for shown in Shown::ALL {
            let found = of(level, shown).surrogate();
            for index in found.iter().flat_map(|s| &s.indices) {
                table.row(vec![
                    view.level_cell(i),
                    Cell::text(shown.word()).with_class("text"),
                    Cell::text(&index.input).with_class("text"),
                    index_cell(index.first),
                    index_cell(index.total),
                ]);
            }
        }
    }
    table.block()
}

/// Absent without a limit of the amplitude.
fn exceedances(view: &View) -> Option<Block> {
    let mut table = Table::of(
        "Surrogate: probability that the amplitude exceeds a limit",
        "surrogate-exceedance",
        &[
            ("Level", &["level"]),
            ("Limit", &["limit_m"]),
            (
                "Surrogate",
                &[
                    "surrogate",
                    "surrogate_lower",
                    "surrogate_upper",
                    "surrogate_alone",
                    "missed",
                    "false_alarms",
                ],
            ),
            ("Samples", &["samples", "samples_lower", "samples_upper"]),
        ],
    );
    let mut empty = true;
    for (i, level) in levels(view) {
        for both in level
            .amplitude
            .surrogate()
            .iter()
            .flat_map(|s| &s.exceedances)
        {
            empty = false;
            table.row(exceedance_row(view, i, both));
        }
    }
    (!empty).then(|| table.block())
}

fn exceedance_row(view: &View, i: usize, both: &ExceedanceBoth) -> Vec<Cell> {
    let found = &both.surrogate;
    let share = found.probability;
    let samples = both.samples.map(|s| s.probability);
    vec![
        view.level_cell(i),
        view.limit_cell(found.threshold),
        Cell::number(percent(share.estimate), Some(share.estimate))
            .with_raw(
                [
                    share.lower,
                    share.upper,
                    found.surrogate_alone,
                    found.missed as f64,
                    found.false_alarms as f64,
                ]
                .map(Some),
            )
            .with_small(percent_range(share.lower, share.upper))
            .with_small(format!(
                "wrong at {}",
                count(found.missed + found.false_alarms, "sample")
            )),
        share_cell(samples.as_ref()),
    ]
}
