//! Failures and error alerts: how many, and where they lie.

use super::several_answers;
use crate::ensemble::outcome::SampleOutcome;
use crate::hb::stability::assessment::MARGIN;
use crate::hb::{ContactFractions, PeakRoute, Status};
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Section, Table};
use crate::page::display::{DASH, from_to, percent, short, significant};
use crate::page::figure::{Panel, Size};
use crate::page::thinning::thinned;
use crate::report::assessment::InputFailures;
use crate::report::numbers::error_budget::stated_truncation_error;
use crate::report::numbers::peaks::usable_peak;
use crate::report::numbers::stability::StabilityCounts;
use crate::report::page::statistic_cell::{percent_cell, range_fields};
use crate::report::page::view::View;
use crate::statistics::{FailurePattern, Proportion, Sorted, histogram, hull};

pub(super) fn section(view: &View) -> Section {
    let mut blocks = vec![statuses(view)];
    let map = failure_map(view);
    if map.is_some() {
        blocks.push(view.level_legend([]));
    }
    let figures: Vec<Figure> = map.into_iter().chain(truncation(view)).collect();
    if !figures.is_empty() {
        blocks.push(Block::pairs(figures));
    }
    blocks.extend(patterns(view));
    blocks.extend([truncation_table(view), contact_table(view), routes(view)]);
    blocks.extend(several_answers::blocks(view));
    blocks.push(work_table(view));
    blocks.extend(stability(view).map(Block::Hint));
    blocks.push(Block::Hint(
        "Work balance: |input − viscous − frictional work| per cycle over the input work; it measures how well the \
         equations are solved, not how many harmonics are needed."
            .to_owned(),
    ));
    blocks.push(Block::Hint(
        "The peak is the highest maximum that grows from the modes of the stuck and the free structure in the band (or \
         from the mode that the study names). Several maxima met: samples with lower ones, too. Isolated branches of \
         solutions are not searched. Several answers: where a curve folds over, a slow sweep upwards and one downwards jump \
         at different frequencies and may meet different largest amplitudes; the peak is sought as the higher one. Known of samples with \
         a curve."
            .to_owned(),
    ));
    Section {
        id: "failures",
        title: "Failures, error alerts, solver".to_owned(),
        blocks,
    }
}

/// How many peaks were assessed for stability, and what was found; absent where none was.
fn stability(view: &View) -> Option<String> {
    let levels = 0..view.n_levels();
    let counts = levels.map(|i| StabilityCounts::of(view.input.outcomes, i));
    let counts = counts.fold(StabilityCounts::default(), StabilityCounts::and);
    Some(format!(
        "Stability: {} of {} peaks were assessed by their Floquet multipliers, {} of them are unstable. The largest \
         modulus of a multiplier is {:.4}; above {} a peak counts as unstable.",
        counts.assessed,
        counts.peaks,
        counts.unstable,
        counts.largest_multiplier?,
        1.0 + MARGIN,
    ))
}

fn statuses(view: &View) -> Block {
    let mut table = counts_by_level(
        view,
        "Samples per status and level",
        "statuses",
        "Status",
        &["status"],
    );
    for status in Status::ALL {
        let counts = view
            .summary
            .levels
            .iter()
            .map(|l| l.statuses[status.name()]);
        add_counts(&mut table, status.name(), status.explanation(), counts);
    }
    let share = match view.nested() {
        false => {
            "share of all samples, with its 95 % confidence interval after Clopper and Pearson"
        }
        true => {
            "lowest and highest share over the outer points; outermost of their 95 % confidence limits after Clopper and \
                 Pearson"
        }
    };
    let name = Cell::text("without a solution")
        .with_small(share)
        .with_class("text strong");
    let rates = (0..view.n_levels()).map(|i| failure_rate(view, i));
    let cells = [name].into_iter().chain(rates).chain([Cell::text("")]);
    table.row(cells.collect());
    table.block()
}

fn routes(view: &View) -> Block {
    let mut table = counts_by_level(
        view,
        "How the peaks were found",
        "routes",
        "Route",
        &["route"],
    );
    for route in PeakRoute::ALL {
        let counts = view.summary.levels.iter().map(|l| l.routes[route.name()]);
        add_counts(&mut table, route.name(), route.explanation(), counts);
    }
    table.block()
}

/// A table with one column of counts per level and one of their sums; its first column is headed `of`.
fn counts_by_level(
    view: &View,
    title: &str,
    file: &str,
    of: &str,
    field: &'static [&'static str],
) -> Table {
    let levels = (0..view.n_levels()).map(|i| {
        let fields: &'static [&'static str] = &["samples"];
        (view.level_name(i), fields)
    });
    let columns = [(of.to_owned(), field)]
        .into_iter()
        .chain(levels)
        .chain([("All".to_owned(), &["all"] as &'static [_])]);
    Table::new(title, file, columns)
}

fn add_counts(
    table: &mut Table,
    name: &str,
    explanation: &str,
    counts: impl Iterator<Item = usize>,
) {
    let counts: Vec<usize> = counts.collect();
    let total: usize = counts.iter().sum();
    let name = Cell::text(name)
        .with_small(explanation)
        .with_class("text strong");
    let counts = counts.into_iter().chain([total]);
    let counts = counts.map(|n| Cell::whole(n as u64));
    let cells = [name].into_iter().chain(counts).collect();
    match total {
        0 => table.quiet_row(cells),
        _ => table.row(cells),
    }
}

fn failure_rate(view: &View, i: usize) -> Cell {
    let rates: Vec<Proportion> = match view.points(i) {
        [] => view.summary.levels[i].failure_rate.into_iter().collect(),
        points => points.iter().filter_map(|p| p.failure_rate).collect(),
    };
    let ends = |of: fn(&Proportion) -> f64| hull(rates.iter().map(of));
    let all = (ends(|r| r.estimate), ends(|r| r.lower), ends(|r| r.upper));
    let (Some([lowest, highest]), Some([lower, _]), Some([_, upper])) = all else {
        return Cell::number(DASH, None);
    };
    Cell::number(from_to([lowest, highest], percent), Some(lowest))
        .with_small(format!("{} …", percent(lower)))
        .with_small(percent(upper))
}

/// Inputs whose failure rate is drawn, those that separate failed and solved samples best.
const MOST_FAILURE_PANELS: usize = 4;

/// Places of the inputs, those first that separate failed and solved samples best.
fn separating(view: &View) -> Vec<usize> {
    let distance = |j: &usize| {
        let failures = view.assessment.failures.get(*j);
        failures.map_or(0.0, |f| f.pattern.distance)
    };
    let mut order: Vec<usize> = (0..view.input.record.inputs.len()).collect();
    order.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
    order
}

/// Failure rate along the inputs that separate failed and solved samples best, and the tests of all inputs; empty unless
/// some samples failed and some did not.
fn patterns(view: &View) -> Vec<Block> {
    let failures = &view.assessment.failures;
    if failures.is_empty() {
        return Vec::new();
    }
    let strongest = separating(view).into_iter().take(MOST_FAILURE_PANELS);
    let hint = "A sample counts as failed if it lacks a solution at one level or more. Above: failure rate among fifths of the \
                samples along an input, with 95 % confidence intervals. Shift: how often the input of a failed sample exceeds \
                that of a solved one (Mann and Whitney; 50 % = no shift). Distance: largest one between their distribution \
                functions (Kolmogorov and Smirnov), which sees failures at both ends too. A p-value below 5 % arises by \
                chance for one input in twenty.";
    let of_points = "The samples of the outer points share their random inputs: intervals and p-values, which presume \
                     independent samples, are indications here.";
    let mut blocks = vec![
        Block::pairs(strongest.map(|j| rates(view, j)).collect()),
        separation(failures),
        Block::Hint(hint.to_owned()),
    ];
    blocks.extend(view.nested().then(|| Block::Hint(of_points.to_owned())));
    blocks
}

/// Failure rate of equal shares of the samples along input `j`.
fn rates(view: &View, j: usize) -> Figure {
    let bins = &view.assessment.failures[j].pattern.bins;
    let highest = bins.iter().map(|b| b.rate.upper).fold(0.0, f64::max);
    let y = Axis::linear("Share without a solution", 0.0, 1.06 * highest);
    let title = format!("Failures along {}", view.input.record.inputs[j].name);
    let mut panel = Panel::new(Size::Large, title, view.input_axis(j), y);
    let bars = bins.iter().map(|b| (b.lower, b.upper, b.rate.estimate));
    panel.bars("neutral", bars);
    for bin in bins {
        let middle = 0.5 * (bin.lower + bin.upper);
        panel.whisker("plain", middle, [bin.rate.lower, bin.rate.upper]);
    }
    view.figure(&panel, format!("failures-along-input-{j}"), "")
}

fn separation(failures: &[InputFailures]) -> Block {
    let mut table = Table::of(
        "Inputs of failed against inputs of solved samples",
        "failure-patterns",
        &[
            ("Input", &["input"]),
            ("Shift", &["superiority"]),
            ("p", &["shift_p_value"]),
            ("Distance", &["distance"]),
            ("p", &["distance_p_value"]),
        ],
    );
    for InputFailures { input, pattern } in failures {
        let FailurePattern {
            superiority,
            shift_p_value,
            distance,
            distance_p_value,
            ..
        } = pattern;
        let number = |v: &f64| Cell::number(percent(*v), Some(*v));
        table.row(vec![
            Cell::text(input),
            number(superiority),
            number(shift_p_value),
            number(distance),
            number(distance_p_value),
        ]);
    }
    table.block()
}

/// Where failed samples lie, over the two inputs that separate them best; absent without failures or inputs.
fn failure_map(view: &View) -> Option<Figure> {
    let outcomes = view.input.outcomes;
    let failed = |o: &SampleOutcome| o.levels.iter().any(|l| usable_peak(l).is_none());
    if !outcomes.iter().any(failed) {
        return None;
    }
    let order = separating(view);
    let j = *order.first()?;
    let second = order.get(1).copied();
    let y = match second {
        Some(k) => view.input_axis(k),
        None => Axis::around("Sample", outcomes.iter().map(|o| o.index as f64)),
    };
    let place = |o: &SampleOutcome| (o.inputs[j], second.map_or(o.index as f64, |k| o.inputs[k]));
    let mut panel = Panel::new(Size::Large, "Where samples failed", view.input_axis(j), y);
    let solved = outcomes.iter().filter(|o| !failed(o)).map(place);
    panel.pale_dots(thinned(solved.collect()).into_iter());
    for i in 0..view.n_levels() {
        let lost = outcomes
            .iter()
            .filter(|o| usable_peak(&o.levels[i]).is_none());
        panel.dots(i, lost.map(place));
    }
    let caption = "Marks of a level: samples without a solution there; grey: samples solved at every level. Over the \
                   inputs that separate the two best.";
    Some(view.figure(&panel, "failures", caption))
}

/// Histogram of the truncation errors of all solutions; absent where none was estimated.
fn truncation(view: &View) -> Option<Figure> {
    let levels = 0..view.n_levels();
    let errors = levels
        .flat_map(|i| view.peaks(i))
        .filter_map(|(_, p)| p.truncation_error.get());
    // Errors of 0 have no logarithm; they cannot be a cause for worry.
    let sorted = Sorted::finite(errors.map(f64::log10));
    let bins = histogram(&sorted, 40);
    let highest = bins.iter().map(|b| b.count).max()?;
    let provenance = &view.input.record.provenance;
    let threshold = provenance.truncation_threshold;
    let edges = bins.iter().flat_map(|b| [b.lower, b.upper]);
    let edges = edges.map(|e| 10f64.powf(e)).chain(threshold);
    let x = Axis::around("Stated relative truncation error", edges);
    let y = Axis::linear("Solutions, all levels", 0.0, 1.08 * highest as f64);
    let mut panel = Panel::new(Size::Large, "Harmonics left out", x, y);
    let bar = |b: &crate::statistics::Bin| {
        let [left, right] = [b.lower, b.upper].map(|e| 10f64.powf(e));
        (left, right, b.count as f64)
    };
    panel.bars("neutral", bins.iter().map(bar));
    if let Some(threshold) = threshold {
        panel.rule("limit", threshold);
    }
    let caption = format!(
        "Stated relative error of the amplitude by the harmonics left out: {}; red: threshold, above which harmonics are added.",
        stated_truncation_error(provenance)
    );
    Some(view.figure(&panel, "truncation", caption))
}

fn truncation_table(view: &View) -> Block {
    let mut table = Table::of(
        "Truncation error and harmonics",
        "truncation",
        &[
            ("Level", &["level"]),
            ("Median", &["median"]),
            ("95 %", &["q95"]),
            ("Largest", &["largest"]),
            ("Highest harmonic (solutions)", &["highest_harmonics"]),
        ],
    );
    for (i, level) in view.summary.levels.iter().enumerate() {
        let quantiles = &level.truncation_error.quantiles;
        let error = |k: usize| percent_cell(quantiles.get(k).map(|q| q.estimate));
        let harmonics = level.highest_harmonics.iter();
        let used: Vec<String> = harmonics.map(|(h, n)| format!("{h} ({n})")).collect();
        let used = match used.is_empty() {
            true => DASH.to_owned(),
            false => used.join(", "),
        };
        let largest = level.truncation_error.moments.map(|m| m.maximum);
        table.row(vec![
            view.level_cell(i),
            error(1),
            error(2),
            percent_cell(largest),
            Cell::text(used),
        ]);
    }
    table.block()
}

fn contact_table(view: &View) -> Block {
    let title = match view.nested() {
        false => "Contact states at the peak, mean share of pairs and time",
        true => {
            "Contact states at the peak, mean share of pairs and time: lowest and highest of the outer points"
        }
    };
    let mut table = Table::of(
        title,
        "contact",
        &[
            ("Level", &["level"]),
            ("Stick", view.fields(range_fields!("stick"))),
            ("Slip", view.fields(range_fields!("slip"))),
            ("Separated", view.fields(range_fields!("separated"))),
        ],
    );
    for i in 0..view.n_levels() {
        let means: Vec<ContactFractions> = match view.points(i) {
            [] => (view.summary.levels[i].mean_contact_fractions.into_iter()).collect(),
            points => points
                .iter()
                .filter_map(|p| p.mean_contact_fractions)
                .collect(),
        };
        let range = |of: fn(&ContactFractions) -> f64| match hull(means.iter().map(of)) {
            None => percent_cell(None).with_raw(view.nested().then_some(None)),
            Some([low, high]) => Cell::number(from_to([low, high], percent), Some(low))
                .with_raw(view.nested().then_some(Some(high))),
        };
        table.row(vec![
            view.level_cell(i),
            range(|f| f.stick),
            range(|f| f.slip),
            range(|f| f.separated),
        ]);
    }
    table.block()
}

/// How many curves have several solutions at one frequency.
fn work_table(view: &View) -> Block {
    let mut table = Table::of(
        "Work per sample",
        "work",
        &[
            ("Level", &["level"]),
            ("Newton steps, median", &["newton_median"]),
            ("95 %", &["newton_q95"]),
            ("Factorisations, median", &["factorizations_median"]),
            ("95 %", &["factorizations_q95"]),
            ("Worst work balance", &["work_balance"]),
            ("Several maxima met", &["several_maxima"]),
        ],
    );
    for (i, level) in view.summary.levels.iter().enumerate() {
        let count = |v: Option<f64>| Cell::number(v.map_or_else(|| DASH.to_owned(), short), v);
        let balance = level.worst_work_balance;
        table.row(vec![
            view.level_cell(i),
            count(level.newton_iterations.median),
            count(level.newton_iterations.q95),
            count(level.factorizations.median),
            count(level.factorizations.q95),
            Cell::number(
                balance.map_or_else(|| DASH.to_owned(), significant),
                balance,
            ),
            count(Some(level.several_maxima as f64)),
        ]);
    }
    table.block()
}
