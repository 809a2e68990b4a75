//! `comparison.html`: designs compared on the same samples, as a page of its own.

use super::comparison::{Compared, ComparedQuantity, DesignComparison, Pair, PointRanking};
use super::performance;
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use crate::page::display::{
    DASH, LengthUnit, capitalised, from_to, level_name, percent, with_digits,
};
use crate::page::distribution::{confidence_band, cumulative_steps};
use crate::page::figure::{Panel, Size};
use crate::page::style::figure_style;
use crate::report::convention::CONFIDENCE;
use crate::report::error::ReportError;
use crate::report::numbers::outer_points::{chosen, outer_groups};
use crate::report::numbers::several_answers::SeveralAnswers;
use crate::report::page::document::page;
use crate::report::page::statistic_cell::{limits, share_cell};
use crate::report::run::stored_run::StoredRun;
use crate::statistics::{Sorted, difference};

/// A comparison as the page shows it.
struct ComparisonView<'a> {
    comparison: &'a DesignComparison,
    runs: &'a [StoredRun],
    /// Unit of differences of amplitudes.
    unit: LengthUnit,
    style: String,
}

/// Renders the page.
pub(super) fn render(
    comparison: &DesignComparison,
    runs: &[StoredRun],
) -> Result<String, ReportError> {
    let levels = 0..comparison.levels.len();
    let amplitudes = levels.flat_map(|i| differences(Compared::AmplitudeM, runs, 0, 1, i));
    let largest = amplitudes
        .filter(|v| v.is_finite())
        .map(f64::abs)
        .fold(0.0, f64::max);
    let view = ComparisonView {
        comparison,
        runs,
        unit: LengthUnit::for_largest(largest),
        style: figure_style(comparison.levels.len()),
    };
    let labels: Vec<&str> = comparison
        .designs
        .iter()
        .map(|d| d.label.as_str())
        .collect();
    let title = format!("Designs {} compared", labels.join(", "));
    let sections = [
        Some(designs(&view)),
        Some(rankings(&view)),
        Some(pairs(&view)),
        performance::section(comparison, runs),
        Some(distributions(&view)),
    ];
    let sections: Vec<Section> = sections.into_iter().flatten().collect();
    page(&title, comparison.levels.len(), &sections)
}

/// Differences of run `a` minus run `b` at level `i`, one per sample, NaN where one of the pair is unknown.
fn differences(quantity: Compared, runs: &[StoredRun], a: usize, b: usize, i: usize) -> Vec<f64> {
    let of = |k: usize| quantity.of(&runs[k], i).unwrap_or_default();
    let pairs = of(a).into_iter().zip(of(b));
    pairs.map(|(a, b)| difference(&a, &b)).collect()
}

impl ComparisonView<'_> {
    fn level_cell(&self, i: usize) -> Cell {
        let level = self.comparison.levels[i].level;
        Cell::number(level_name(level, &self.comparison.level_unit), Some(level)).with_chip(i)
    }

    fn label(&self, place: usize) -> &str {
        &self.comparison.designs[place].label
    }

    /// Shown numbers per SI unit, and their unit.
    fn shown(&self, quantity: Compared) -> (f64, &'static str) {
        match quantity {
            Compared::FrequencyHz => (1.0, "Hz"),
            Compared::AmplitudeM => (self.unit.per_metre, self.unit.symbol),
            Compared::FrequencyMargin => (100.0, "%"),
            Compared::ReserveFactor => (1.0, ""),
        }
    }

    fn nested(&self) -> bool {
        let pairs = self.comparison.levels.iter().flat_map(|l| &l.quantities);
        pairs
            .flat_map(|q| &q.pairs)
            .any(|pair| pair.outer.is_some())
    }
}

fn designs(view: &ComparisonView) -> Section {
    let comparison = view.comparison;
    let mut table = Table::of(
        "Designs",
        "designs",
        &[
            ("Design", &["design"]),
            ("Study", &["study"]),
            ("Results", &["folder"]),
            ("Distributions that differ", &["priors"]),
        ],
    );
    for design in &comparison.designs {
        let own = design
            .inputs
            .iter()
            .filter(|i| comparison.design_inputs.contains(&i.name));
        let own: Vec<String> = own
            .map(|i| format!("{} ({})", i.name, i.assumption()))
            .collect();
        let own = if own.is_empty() {
            DASH.to_owned()
        } else {
            own.join("; ")
        };
        let text = |text: &str| Cell::text(text).with_class("text wide");
        table.row(vec![
            Cell::text(&design.label),
            text(&design.study),
            text(&design.folder),
            text(&own),
        ]);
    }
    let facts = [
        ("common samples", comparison.samples.to_string()),
        ("seed", comparison.seed.to_string()),
        ("samples by", comparison.sampling.clone()),
    ];
    let facts = facts.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let mut blocks = vec![Block::Facts(facts), table.block()];
    let notices = notices(view);
    if !notices.is_empty() {
        blocks.push(Block::Notices(notices));
    }
    let hint = "Sample i of every design has the same random numbers: a difference of a pair is due to the designs, where \
                it is larger than the numerical errors of both. \
                All probabilities are conditional on the distributions that the studies assume.";
    blocks.push(Block::Hint(hint.to_owned()));
    Section {
        id: "designs",
        title: "Designs".to_owned(),
        blocks,
    }
}

/// What must be known before a number of the page is used.
fn notices(view: &ComparisonView) -> Vec<String> {
    let comparison = view.comparison;
    let mut notices = Vec::new();
    if !comparison.design_inputs.is_empty() {
        notices.push(format!(
            "The distribution of {} differs between the designs and is taken as a part of them: its values are paired at \
             equal probability.",
            comparison.design_inputs.join(", ")
        ));
    }
    let required = |run: &StoredRun| run.record.requirements.clone();
    let first = required(&view.runs[0]);
    let others = || view.runs[1..].iter().map(required);
    if others().any(|other| other.operation != first.operation) {
        notices.push(
            "The designs have different engine orders, speeds or definitions of the margin ([operation]): frequency margins are each \
             to the own ones, and their differences are not due to the resonances alone."
                .to_owned(),
        );
    }
    if others().any(|other| other.stress != first.stress) {
        notices.push(
            "The designs have different stresses or limits of fatigue ([stress]): reserve factors are each to the own ones.".to_owned(),
        );
    }
    if !comparison.independent {
        notices.push(format!(
            "The samples are no independent draws ({}): intervals presume such draws and are indications here.",
            comparison.sampling
        ));
    }
    if view.nested() {
        notices.push(
            "Some inputs are only known to an interval: every outer point is compared apart, and a statement holds over \
             the box only where it holds at each."
                .to_owned(),
        );
    }
    for (i, level) in comparison.levels.iter().enumerate() {
        let pairs = level.quantities.iter().flat_map(|q| &q.pairs);
        let unknown = pairs
            .map(|p| p.comparison.a_better.unknown)
            .max()
            .unwrap_or(0);
        if unknown > 0 {
            notices.push(format!(
                "{}: up to {unknown} pairs are unknown because one of the two has no solution that is to be trusted; every interval allows for \
                 what they could have been.",
                level_name(comparison.levels[i].level, &comparison.level_unit)
            ));
        }
    }
    notices
}

fn rankings(view: &ComparisonView) -> Section {
    let mut table = Table::of(
        "Ranking",
        "ranking",
        &[
            ("Level", &["level"]),
            ("By", &["quantity"]),
            ("Outer point", &["outer"]),
            ("Best first", &["order"]),
            ("Resamples in this order", &["surely", "possibly"]),
            ("First is the best", &["best_surely", "best_possibly"]),
        ],
    );
    for (i, level) in view.comparison.levels.iter().enumerate() {
        for quantity in &level.quantities {
            for ranking in &quantity.rankings {
                table.row(ranking_row(view, i, quantity, ranking));
            }
        }
    }
    let hint = "The order is that of the quantile that 95 % of the assumed prior keeps, on the samples that every design solved. \
                The last two columns draw the common samples anew, 1000 times, and count how often the whole order comes \
                out again, and how often its first design is the best. A range, where quantiles lie within their numerical errors or samples are \
                unknown: the lower end if all of these were decided against it, the upper end if all for it.";
    Section {
        id: "ranking",
        title: "Ranking".to_owned(),
        blocks: vec![table.block(), Block::Hint(hint.to_owned())],
    }
}

fn outer_cell(outer: Option<u64>) -> Cell {
    let value = outer.map(|o| o as f64);
    Cell::number(
        outer.map_or_else(|| DASH.to_owned(), |o| o.to_string()),
        value,
    )
}

fn ranking_row(
    view: &ComparisonView,
    i: usize,
    compared: &ComparedQuantity,
    found: &PointRanking,
) -> Vec<Cell> {
    let quantity = compared.quantity;
    let ranking = &found.ranking;
    let order: Vec<&str> = ranking.order.iter().map(|&k| view.label(k)).collect();
    let best = ranking
        .order
        .first()
        .map_or((0.0, 0.0), |&k| ranking.best[k]);
    let shares = |(surely, possibly): (f64, f64)| {
        Cell::number(from_to([surely, possibly], percent), Some(surely)).with_raw([Some(possibly)])
    };
    let by = format!("{} % quantile, {}", 100.0 * found.quantile, quantity.name());
    vec![
        view.level_cell(i),
        Cell::text(by).with_class("text"),
        outer_cell(found.outer),
        match compared.all_tied(found.outer) {
            true => Cell::text(order.join(" = "))
                .with_small("no order: every pair is equal within its errors"),
            false => Cell::text(order.join(" < ")),
        }
        .with_class("text strong"),
        shares((ranking.surely, ranking.possibly)),
        shares(best),
    ]
}

fn pairs(view: &ComparisonView) -> Section {
    let hint = "Median of the paired differences with its distribution-free 95 % confidence interval; shares of the samples \
                in which one design is better with their Clopper and Pearson interval. Values that differ by no more than their stated \
                numerical errors together, or by a millionth of the value (a margin: of the frequency), are ties and count for neither; a pair of \
                which one failed or is not to be trusted is unknown and widens every interval.";
    let tables = Compared::ALL
        .into_iter()
        .filter_map(|quantity| pair_table(view, quantity));
    Section {
        id: "pairs",
        title: "Paired differences".to_owned(),
        blocks: tables.chain([Block::Hint(hint.to_owned())]).collect(),
    }
}

/// Absent where a design lacks the number.
fn pair_table(view: &ComparisonView, quantity: Compared) -> Option<Block> {
    let (_, unit) = view.shown(quantity);
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" ({unit})")
    };
    let title = format!("{}{unit}", capitalised(quantity.name()));
    let columns: [(String, &'static [&'static str]); 7] = [
        ("Level".to_owned(), &["level"]),
        ("Outer point".to_owned(), &["outer"]),
        ("Pair".to_owned(), &["pair"]),
        (
            "Median difference".to_owned(),
            &["median_difference", "lower", "upper"],
        ),
        (
            format!("First {}", quantity.word()),
            &["first", "first_lower", "first_upper"],
        ),
        (
            format!("Second {}", quantity.word()),
            &["second", "second_lower", "second_upper"],
        ),
        ("Unknown".to_owned(), &["unknown"]),
    ];
    let mut table = Table::new(
        title,
        &format!("pairs-{}", quantity.name().replace(' ', "-")),
        columns,
    );
    for (i, level) in view.comparison.levels.iter().enumerate() {
        let found: &ComparedQuantity = level.quantities.iter().find(|q| q.quantity == quantity)?;
        for pair in &found.pairs {
            table.row(pair_row(view, i, quantity, pair));
        }
    }
    Some(table.block())
}

fn pair_row(view: &ComparisonView, i: usize, quantity: Compared, pair: &Pair) -> Vec<Cell> {
    let (scale, _) = view.shown(quantity);
    let show = |v: f64| with_digits(v * scale, 3);
    let median = match pair.comparison.median_difference {
        None => Cell::number(DASH, None).with_raw([None, None]),
        Some(median) => Cell::number(show(median.estimate), Some(median.estimate))
            .with_raw([median.interval.lower.value(), median.interval.upper.value()])
            .with_small(limits(median.interval, &show)),
    };
    let unknown = pair.comparison.a_better.unknown;
    let answers = match quantity.is_margin() {
        true => [pair.a, pair.b]
            .map(|k| several_answers(view, k, i))
            .join("; "),
        false => String::new(),
    };
    vec![
        view.level_cell(i),
        outer_cell(pair.outer),
        Cell::text(format!("{} − {}", view.label(pair.a), view.label(pair.b)))
            .with_small(answers)
            .with_class("text"),
        median,
        share_cell(Some(&pair.comparison.a_better)),
        share_cell(Some(&pair.comparison.b_better)),
        Cell::whole(unknown as u64),
    ]
}

/// On how many curves of a design at level `i` there are several answers.
fn several_answers(view: &ComparisonView, design: usize, i: usize) -> String {
    let found = SeveralAnswers::of(&view.runs[design].outcomes, i, CONFIDENCE);
    format!("{}: {}", view.label(design), found.in_words())
}

/// Distribution functions of the differences of every design from the first.
fn distributions(view: &ComparisonView) -> Section {
    let keys = [
        Key::new(Mark::Line, "rule zero", "no difference"),
        Key::new(
            Mark::Band,
            "outer",
            "95 % confidence interval, unknown pairs on either side",
        ),
    ];
    let mut blocks = vec![Block::Legend(keys.into())];
    for quantity in [Compared::FrequencyHz, Compared::AmplitudeM] {
        for b in 1..view.runs.len() {
            let levels = 0..view.comparison.levels.len();
            let figures = levels.map(|i| difference_figure(view, quantity, b, i));
            blocks.push(Block::pairs(figures.collect()));
        }
    }
    Section {
        id: "distributions",
        title: "Distribution of the differences from the first design".to_owned(),
        blocks,
    }
}

fn difference_figure(view: &ComparisonView, quantity: Compared, b: usize, i: usize) -> Figure {
    let (scale, unit) = view.shown(quantity);
    let values: Vec<f64> = differences(quantity, view.runs, 0, b, i)
        .into_iter()
        .map(|v| v * scale)
        .collect();
    let pair = format!("{} − {}", view.label(0), view.label(b));
    let finite = values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = finite.fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    let space = 0.05 * (high - low);
    let label = format!("{}, {pair} ({unit})", capitalised(quantity.name()));
    let x = Axis::linear(label, low - space, high + space);
    let y = Axis::linear("Share of pairs below", 0.0, 1.0);
    let level = view.comparison.levels[i].level;
    let title = format!(
        "{pair} at {}",
        level_name(level, &view.comparison.level_unit)
    );
    let mut panel = Panel::new(Size::Large, title, x, y);
    panel.rule("zero", 0.0);
    for (_, members) in outer_groups(&view.runs[0].outcomes) {
        let here = Sorted::finite(chosen(&values, &members));
        panel.band(
            &format!("outer l{i}"),
            &confidence_band(&here, members.len(), CONFIDENCE),
        );
        panel.steps(&format!("level l{i}"), &cumulative_steps(&here), 0.0);
    }
    if values.iter().all(|v| !v.is_finite()) {
        panel.note("no pair has two solutions");
    }
    let file = format!("difference-{}-{b}-{i}", quantity.name().replace(' ', "-"));
    Figure::new(&panel, &view.style, file, String::new())
}
