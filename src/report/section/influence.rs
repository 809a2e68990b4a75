//! Which input moves what.

use super::super::axis::Axis;
use super::super::block::{Block, Cell, Figure, Section, Table};
use super::super::display::{DASH, minus_sign};
use super::super::figure::{Panel, Size};
use super::super::sensitivity::{IndexResult, InputInfluence};
use super::super::summary::{InputCorrelation, LevelSummary};
use super::super::view::{Shown, View, thinned};
use crate::statistics::{ConditionalMean, Index, Influence};

/// Inputs that get a scatter panel, those with the strongest rank correlations.
const MAX_INPUTS: usize = 6;

/// Absent without inputs.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.input.record.inputs.is_empty() {
        return None;
    }
    let hint = "Spearman’s coefficient over the samples with a solution: ±1 where the input alone orders the results, \
                0 where it does not. A relation that first falls and then rises can hide behind 0.";
    let scatter = strongest(view)
        .into_iter()
        .flat_map(|j| Shown::ALL.map(|shown| scatter(view, j, shown)));
    Some(Section {
        id: "influence",
        title: "Influence of the inputs".to_owned(),
        blocks: vec![
            view.level_legend([]),
            Block::pairs(Shown::ALL.map(|shown| bars(view, shown)).to_vec()),
            indices(view),
            Block::Hint(explanation(view)),
            Block::Heading("Mean of the result along each input".to_owned()),
            Block::pairs(Shown::ALL.map(|shown| means(view, shown)).to_vec()),
            Block::Heading("Samples over each input".to_owned()),
            Block::pairs(scatter.collect()),
            correlations(view, Shown::Frequency, |c| c.frequency),
            correlations(view, Shown::AmplitudePerLevel, |c| c.amplitude),
            Block::Hint(hint.to_owned()),
        ],
    })
}

/// Whether the indices are those of a pick-freeze design, with totals.
fn with_totals(view: &View) -> bool {
    !view.input.record.design.mixed_inputs.is_empty()
}

/// What an index is and where it comes from.
fn explanation(view: &View) -> String {
    let (kind, source) = match with_totals(view) {
        true => (
            "Total index (pale bar): that and its interactions with the other inputs. ",
            "estimated from the rows of the pick-freeze design, with 95 % intervals by resampling the rows. A single \
             sample without a solution refuses the indices of its level: without its row they would be biased",
        ),
        false => (
            "",
            "estimated by ranks from the samples at hand, with a 95 % interval from tenths of the samples. It describes \
             the samples with a solution",
        ),
    };
    format!(
        "First-order index: share of the variance that the input explains alone. {kind}Independent inputs are presumed; \
         {source}. “Not distinguishable from 0”: these samples show no influence."
    )
}

/// Index of the result that a panel shows.
fn index(influence: &InputInfluence, shown: Shown) -> &IndexResult {
    match shown {
        Shown::Frequency => &influence.frequency,
        Shown::AmplitudePerLevel => &influence.amplitude,
    }
}

/// Line of level `i` of `n` beside input `j`: input names stand at −j.
fn line(j: usize, i: usize, n: usize) -> f64 {
    let spread = 0.7 * (i as f64 + 0.5) / n as f64 - 0.35;
    -(j as f64) - spread
}

fn input_names(view: &View) -> Vec<String> {
    let inputs = view.input.record.inputs.iter();
    inputs.map(|input| input.name.clone()).collect()
}

/// Indices, one bar per input and level; totals behind the first-order ones.
fn bars(view: &View, shown: Shown) -> Figure {
    let n = view.n_levels();
    let x = Axis::linear("Share of the variance", -0.1, 1.1);
    let names = input_names(view);
    let size = Size::Rows(names.len() * n.div_ceil(2).max(1));
    let title = match with_totals(view) {
        true => format!("First-order and total index, {}", shown.word()),
        false => format!("First-order index, {}", shown.word()),
    };
    let mut panel = Panel::new(size, title, x, Axis::of_names(names));
    panel.rule("zero", 0.0);
    let mut empty = true;
    for (i, level) in view.assessment.levels.iter().enumerate() {
        for (j, influence) in level.influences.iter().enumerate() {
            let (first, total) = match index(influence, shown) {
                IndexResult::Index(found) => (found.index, None),
                IndexResult::PickFreeze(found) => (found.first, Some(found.total)),
                IndexResult::Refused(_) => continue,
            };
            empty = false;
            let (y, height) = (line(j, i, n), 0.6 / n as f64);
            let ends = |index: Index| [0.0, index.estimate.max(0.0)];
            if let Some(total) = total {
                panel.level_bar(&format!("total l{i}"), y, ends(total), height);
            }
            panel.level_bar(&format!("l{i}"), y, ends(first), 0.6 * height);
            panel.level_whisker("plain", y, [first.lower, first.upper]);
        }
    }
    if empty {
        panel.note("no index: the table says why");
    }
    view.figure(&panel, format!("index-{}", shown.word()), "")
}

/// Columns of the download, in the order of the cells.
const FREQUENCY_FIRST: &[&str] = &[
    "frequency_index",
    "frequency_index_lower",
    "frequency_index_upper",
];
const FREQUENCY_TOTAL: &[&str] = &[
    "frequency_total",
    "frequency_total_lower",
    "frequency_total_upper",
];
const AMPLITUDE_FIRST: &[&str] = &[
    "amplitude_index",
    "amplitude_index_lower",
    "amplitude_index_upper",
];
const AMPLITUDE_TOTAL: &[&str] = &[
    "amplitude_total",
    "amplitude_total_lower",
    "amplitude_total_upper",
];

/// Indices with their intervals, or the reason why there is none.
fn indices(view: &View) -> Block {
    let totals = with_totals(view);
    let mut columns = vec![("Level", &["level"] as &'static [_]), ("Input", &["input"])];
    columns.push(("Frequency", FREQUENCY_FIRST));
    columns.extend(totals.then_some(("Frequency, total", FREQUENCY_TOTAL)));
    columns.push(("Amplitude", AMPLITUDE_FIRST));
    columns.extend(totals.then_some(("Amplitude, total", AMPLITUDE_TOTAL)));
    let title = match totals {
        true => "First-order and total indices",
        false => "First-order indices",
    };
    let mut table = Table::of(title, "indices", &columns);
    for (i, level) in view.assessment.levels.iter().enumerate() {
        for influence in &level.influences {
            let mut cells = vec![
                view.level_cell(i),
                Cell::text(&influence.input).with_class("text"),
            ];
            for shown in Shown::ALL {
                cells.extend(index_cells(index(influence, shown), totals));
            }
            table.row(cells);
        }
    }
    table.block()
}

/// One cell, or two with totals.
fn index_cells(result: &IndexResult, totals: bool) -> Vec<Cell> {
    match result {
        IndexResult::Index(found) => vec![index_cell(found.index)],
        IndexResult::PickFreeze(found) => [found.first, found.total].map(index_cell).into(),
        IndexResult::Refused(reason) => {
            let none = Cell::number(DASH, None)
                .with_raw([None, None])
                .with_small(reason);
            vec![none; 1 + usize::from(totals)]
        }
    }
}

fn index_cell(index: Index) -> Cell {
    let number = |v: f64| minus_sign(&format!("{v:.2}"));
    let cell = Cell::number(number(index.estimate), Some(index.estimate))
        .with_raw([Some(index.lower), Some(index.upper)])
        .with_small(format!("{} … {}", number(index.lower), number(index.upper)));
    match index.influence {
        Influence::Distinct => cell,
        Influence::NotDistinguishable => cell.with_small(index.influence.to_string()),
    }
}

/// How far a result goes along an input, at one level.
pub(super) struct Leg {
    pub level: usize,
    /// Number of the input's line in the panel.
    pub row: usize,
    /// Results at the input's low and high value.
    pub low: f64,
    pub high: f64,
}

/// A bar per input and level from the result at the low to that at the high value of the input (dot).
pub(super) fn legs(
    view: &View,
    shown: Shown,
    names: &[String],
    title: String,
    legs: &[Leg],
) -> Panel {
    let n = view.n_levels();
    let ends = legs.iter().flat_map(|leg| [leg.low, leg.high]);
    let x = Axis::around(view.label(shown), ends);
    let size = Size::Rows(names.len() * n.div_ceil(2).max(1));
    let mut panel = Panel::new(size, title, x, Axis::of_names(names.to_vec()));
    for leg in legs {
        let (left, right) = (leg.low.min(leg.high), leg.low.max(leg.high));
        let y = line(leg.row, leg.level, n);
        let class = format!("l{}", leg.level);
        panel.level_bar(&format!("total {class}"), y, [left, right], 0.5 / n as f64);
        panel.dots(&class, [(leg.high, y)].into_iter());
    }
    view.note_if_empty(&mut panel);
    panel
}

/// Means of the samples with the lowest and the highest values of each input.
fn means(view: &View, shown: Shown) -> Figure {
    let mut found = Vec::new();
    for (i, level) in view.assessment.levels.iter().enumerate() {
        let scale = view.unit.per_metre / level.level;
        for (row, influence) in level.influences.iter().enumerate() {
            let (means, scale) = match shown {
                Shown::Frequency => (&influence.frequency_means_hz, 1.0),
                Shown::AmplitudePerLevel => (&influence.amplitude_means_m, scale),
            };
            let mean = |k: &ConditionalMean| Some(k.moments?.valid_only.mean * scale);
            let ends = [means.first(), means.last()].map(|k| k.and_then(mean));
            if let [Some(low), Some(high)] = ends {
                found.push(Leg {
                    level: i,
                    row,
                    low,
                    high,
                });
            }
        }
    }
    let title = format!("Mean {}, low to high input", shown.word());
    let panel = legs(view, shown, &input_names(view), title, &found);
    let caption = "From the fifth of the samples with the lowest values of the input to the fifth with the highest (dot), \
                   each the mean over all other inputs.";
    view.figure(&panel, format!("means-{}", shown.word()), caption)
}

/// The inputs in their order, or those with the strongest rank correlations where they are many.
fn strongest(view: &View) -> Vec<usize> {
    let strength = |j: usize| {
        let levels = view.summary.levels.iter();
        let of_input = levels.filter_map(|l| l.rank_correlations.get(j));
        of_input
            .flat_map(|c| [c.frequency, c.amplitude])
            .flatten()
            .fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    let mut order: Vec<usize> = (0..view.input.record.inputs.len()).collect();
    if order.len() > MAX_INPUTS {
        order.sort_by(|&a, &b| strength(b).total_cmp(&strength(a)));
        order.truncate(MAX_INPUTS);
    }
    order
}

fn scatter(view: &View, j: usize, shown: Shown) -> Figure {
    let name = &view.input.record.inputs[j].name;
    let y = Axis::around(view.label(shown), view.all_values(shown));
    let title = match shown {
        Shown::Frequency => format!("Frequency over {name}"),
        Shown::AmplitudePerLevel => format!("Amplitude over {name}"),
    };
    let mut panel = Panel::new(Size::Large, title, view.input_axis(j), y);
    for i in 0..view.n_levels() {
        let inputs = view.peaks(i).map(|(o, _)| o.inputs[j]);
        let points = inputs.zip(view.values(shown, i)).collect();
        panel.dots(&format!("l{i}"), thinned(points).into_iter());
    }
    view.note_if_empty(&mut panel);
    view.figure(&panel, format!("{}-over-input-{j}", shown.word()), "")
}

/// Rows input, columns level; each cell with its strength for the shade behind it.
fn correlations(view: &View, shown: Shown, value: fn(&InputCorrelation) -> Option<f64>) -> Block {
    let fields: [&'static [&'static str]; 2] = [&["input"], &["rank_correlation"]];
    let levels = (0..view.n_levels()).map(|i| (view.level_name(i), fields[1]));
    let columns = [("Input".to_owned(), fields[0])].into_iter().chain(levels);
    let title = format!("Rank correlation with the input: {}", shown.word());
    let file = format!("rank-correlation-{}", shown.word());
    let mut table = Table::new(title, &file, columns);
    for (j, input) in view.input.record.inputs.iter().enumerate() {
        let cell = |level: &LevelSummary| {
            let rho = level.rank_correlations.get(j).and_then(value);
            let text = rho.map_or_else(|| DASH.to_owned(), |r| minus_sign(&format!("{r:+.2}")));
            let class = match rho < Some(0.0) {
                true => "shade negative",
                false => "shade positive",
            };
            Cell::number(text, rho).with_shade(class, rho.map_or(0.0, |r| r.abs() * 60.0))
        };
        let name = Cell::text(&input.name);
        let cells = view.summary.levels.iter().map(cell);
        table.row([name].into_iter().chain(cells).collect());
    }
    table.block()
}
