//! Which input moves what.

use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Section, Table};
use crate::page::display::{DASH, count, from_to, percent, signed, significant};
use crate::page::figure::{Panel, Size};
use crate::page::thinning::thinned;
use crate::report::numbers::correlation::InputCorrelation;
use crate::report::numbers::sensitivity::{IndexResult, InputInfluence};
use crate::report::numbers::summary::LevelSummary;
use crate::report::page::statistic_cell::{interval_fields, range_cell, range_fields};
use crate::report::page::view::{Shown, View};
use crate::statistics::{ConditionalMean, Index, Influence, Sorted, hull, quantile};

/// Inputs that get a scatter panel, those with the strongest rank correlations.
const MOST_SCATTER_PANELS: usize = 6;

/// Parts of the axis of an input that show their samples under the pointer.
const STRIPS: usize = 12;

/// What a rank correlation is.
const SPEARMAN: &str = "Spearman’s coefficient over the samples with a solution: ±1 where the input alone orders the results, \
                        0 where it does not. A relation that first falls and then rises can hide behind 0.";

/// Absent without inputs.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.input.record.inputs.is_empty() {
        return None;
    }
    let hint = match view.nested() {
        false => SPEARMAN.to_owned(),
        true => format!("{SPEARMAN} Lowest and highest coefficient over the outer points."),
    };
    let scatter = strongest(view)
        .into_iter()
        .flat_map(|j| Shown::ALL.map(|shown| scatter(view, j, shown)));
    let mut blocks = vec![
        view.level_legend([]),
        Block::pairs(Shown::ALL.map(|shown| bars(view, shown)).to_vec()),
        indices(view),
        Block::Hint(explanation(view)),
    ];
    if !view.nested() {
        blocks.extend([
            Block::Heading("Mean of the result along each input".to_owned()),
            Block::pairs(Shown::ALL.map(|shown| means(view, shown)).to_vec()),
        ]);
    }
    blocks.extend([
        Block::Heading("Samples over each input".to_owned()),
        Block::pairs(scatter.collect()),
        correlations(view, Shown::Frequency, |c| c.frequency),
        correlations(view, Shown::AmplitudePerLevel, |c| c.amplitude),
        Block::Hint(hint),
    ]);
    Some(Section {
        id: "influence",
        title: "Influence of the inputs".to_owned(),
        blocks,
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
            "estimated by ranks from the samples at hand, with a 95 % interval. It describes the samples with a solution",
        ),
    };
    let range = match view.nested() {
        false => "",
        true => {
            " Solid bar and first number: the lowest, pale bar and second number: the highest of the outer points, each from \
             its own samples; the interval holds theirs."
        }
    };
    let alone = match view.input.record.design.correlated {
        false => "share of the variance that the input explains alone. ",
        true => {
            "share of the variance that the value of the input explains. Inputs are correlated: what moves along with an input counts \
             as its own, so that shares may sum to more than 1. "
        }
    };
    format!(
        "First-order index: {alone}{kind}It is {source}. “Not distinguishable from 0”: the interval holds 0. That proves no absence of influence: a rank correlation may show one that so few samples leave open here.{range}"
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

fn input_name<'a>(view: &'a View, j: usize) -> &'a str {
    &view.input.record.inputs[j].name
}

fn input_names(view: &View) -> Vec<String> {
    let inputs = 0..view.input.record.inputs.len();
    inputs.map(|j| input_name(view, j).to_owned()).collect()
}

/// What is drawn of an index.
struct Bar {
    /// First-order index, or the lowest one over the outer points.
    solid: f64,
    /// Total index, or the highest first-order one over the outer points.
    pale: Option<f64>,
    interval: [f64; 2],
}

/// `None` without an index.
fn bar(result: &IndexResult) -> Option<Bar> {
    let of = |first: Index, pale: Option<f64>| Bar {
        solid: first.estimate,
        pale,
        interval: [first.lower, first.upper],
    };
    match result {
        IndexResult::Index(found) => Some(of(found.index, None)),
        IndexResult::PickFreeze(found) => Some(of(found.first, Some(found.total.estimate))),
        IndexResult::Points(range) => Some(Bar {
            solid: range.lowest.value.value()?,
            pale: range.highest.value.value(),
            interval: [range.interval.lower.value()?, range.interval.upper.value()?],
        }),
        IndexResult::Refused(_) => None,
    }
}

/// Indices, one bar per input and level; totals, or the highest of the outer points, behind the first-order ones.
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
            let Some(Bar {
                solid,
                pale,
                interval,
            }) = bar(index(influence, shown))
            else {
                continue;
            };
            empty = false;
            let (y, height) = (line(j, i, n), 0.6 / n as f64);
            let ends = |index: f64| [0.0, index.max(0.0)];
            if let Some(pale) = pale {
                panel.level_bar(&format!("total l{i}"), y, ends(pale), height);
            }
            panel.level_bar(&format!("l{i}"), y, ends(solid), 0.6 * height);
            panel.level_whisker("plain", y, interval);
            panel.mark(i, (-0.05, y));
            let [low, high] = interval.map(percent);
            let words = [
                format!("{}, {}", input_name(view, j), view.level_name(i)),
                format!("{} ({low} … {high})", percent(solid)),
            ];
            panel.readout_level(y, [-0.1, 1.1], &words);
        }
    }
    if empty {
        panel.note("no index: the table says why");
    }
    view.figure(&panel, format!("index-{}", shown.word()), "")
}

/// Indices with their intervals, or the reason why there is none.
fn indices(view: &View) -> Block {
    let totals = with_totals(view);
    let mut columns = vec![("Level", &["level"] as &'static [_]), ("Input", &["input"])];
    let fields = |of| view.fields(of);
    columns.push(("Frequency", fields(interval_fields!("frequency_index"))));
    columns.extend(totals.then(|| {
        (
            "Frequency, total",
            fields(interval_fields!("frequency_total")),
        )
    }));
    columns.push(("Amplitude", fields(interval_fields!("amplitude_index"))));
    columns.extend(totals.then(|| {
        (
            "Amplitude, total",
            fields(interval_fields!("amplitude_total")),
        )
    }));
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
                cells.extend(index_cells(view, index(influence, shown)));
            }
            table.row(cells);
        }
    }
    table.block()
}

/// One cell, or two with totals.
fn index_cells(view: &View, result: &IndexResult) -> Vec<Cell> {
    match result {
        IndexResult::Index(found) => vec![index_cell(found.index)],
        IndexResult::Points(range) => vec![range_cell(range, &|v| signed(&format!("{v:.2}")))],
        IndexResult::PickFreeze(found) => [found.first, found.total].map(index_cell).into(),
        IndexResult::Refused(reason) => {
            let fields = view.fields(interval_fields!("index")).len();
            let none = Cell::number(DASH, None)
                .with_raw(vec![None; fields - 1])
                .with_small(reason);
            vec![none; 1 + usize::from(with_totals(view))]
        }
    }
}

/// An index with its interval and the verdict on it.
pub(super) fn index_cell(index: Index) -> Cell {
    let number = |v: f64| signed(&format!("{v:.2}"));
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
    /// Confidence intervals of both, where they are estimates from samples.
    pub intervals: Option<[[f64; 2]; 2]>,
}

impl Leg {
    /// Whether the two results differ by more than the uncertainty of their estimates.
    fn is_distinguishable(&self) -> bool {
        self.intervals
            .is_none_or(|[low, high]| low[1] < high[0] || high[1] < low[0])
    }
}

/// A bar per input and level from the result at the low to that at the high value of the input (dot), none where the two
/// cannot be told apart; thin lines for the intervals of estimates.
pub(super) fn legs(
    view: &View,
    shown: Shown,
    names: &[String],
    title: String,
    legs: &[Leg],
) -> Panel {
    let n = view.n_levels();
    let ends = legs.iter().flat_map(|leg| [leg.low, leg.high]);
    let intervals = legs.iter().filter_map(|leg| leg.intervals).flatten();
    let x = Axis::around(view.label(shown), ends.chain(intervals.flatten()));
    let size = Size::Rows(names.len() * n.div_ceil(2).max(1));
    let mut panel = Panel::new(size, title, x, Axis::of_names(names.to_vec()));
    for leg in legs {
        let (left, right) = (leg.low.min(leg.high), leg.low.max(leg.high));
        let y = line(leg.row, leg.level, n);
        let class = format!("total l{}", leg.level);
        if leg.is_distinguishable() {
            panel.level_bar(&class, y, [left, right], 0.5 / n as f64);
        }
        for interval in leg.intervals.into_iter().flatten() {
            panel.level_whisker("plain", y, interval);
        }
        panel.mark(leg.level, (leg.high, y));
        let words = [
            format!("{}, {}", names[leg.row], view.level_name(leg.level)),
            format!("{} → {}", significant(leg.low), significant(leg.high)),
        ];
        panel.readout_level(y, [left, right], &words);
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
            let interval = |k: &ConditionalMean| {
                let mean = k.moments?.mean;
                Some([mean.lower.value()? * scale, mean.upper.value()? * scale])
            };
            let [Some(first), Some(last)] = [means.first(), means.last()] else {
                continue;
            };
            if let (Some(low), Some(high)) = (mean(first), mean(last)) {
                found.push(Leg {
                    level: i,
                    row,
                    low,
                    high,
                    intervals: interval(first).zip(interval(last)).map(<[_; 2]>::from),
                });
            }
        }
    }
    let title = format!("Mean {}, low to high input", shown.word());
    let panel = legs(view, shown, &input_names(view), title, &found);
    let caption = "From the fifth of the samples with the lowest values of the input to the fifth with the highest (dot), \
                   each the mean over all other inputs. Thin lines: 95 % confidence intervals of the means; no bar where \
                   the two overlap: there the samples show no change.";
    view.figure(&panel, format!("means-{}", shown.word()), caption)
}

/// Correlations of input `j` at level `i`: one of all samples, or one of each outer point.
fn correlations_of<'a>(view: &'a View, i: usize, j: usize) -> Vec<&'a InputCorrelation> {
    let of_level = |level: &'a LevelSummary| vec![&level.rank_correlations[j]];
    match view.points(i) {
        [] => of_level(&view.summary.levels[i]),
        points => points.iter().map(|p| &p.rank_correlations[j]).collect(),
    }
}

/// The inputs in their order; where they are many those known to an interval, and those with the strongest rank correlations.
fn strongest(view: &View) -> Vec<usize> {
    let epistemic = view.summary.epistemic.as_ref();
    let strength = |j: usize| {
        let name = &view.input.record.inputs[j].name;
        if epistemic.is_some_and(|e| e.inputs.contains(name)) {
            return f64::INFINITY;
        }
        let found = (0..view.n_levels()).flat_map(|i| correlations_of(view, i, j));
        found
            .flat_map(|c| [c.frequency, c.amplitude])
            .flatten()
            .fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    let inputs = view.input.record.inputs.iter().enumerate();
    let has_order = inputs.filter(|(_, input)| !input.numbers_draws());
    let mut order: Vec<usize> = has_order.map(|(j, _)| j).collect();
    if order.len() > MOST_SCATTER_PANELS {
        order.sort_by(|&a, &b| strength(b).total_cmp(&strength(a)));
        order.truncate(MOST_SCATTER_PANELS);
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
    let x = view.input_axis(j);
    let strips = x.parts(STRIPS);
    let mut panel = Panel::new(Size::Large, title, x, y);
    let mut of_levels: Vec<Vec<(f64, f64)>> = Vec::new();
    for i in 0..view.n_levels() {
        let inputs = view.peaks(i).map(|(o, _)| o.inputs[j]);
        let points: Vec<_> = inputs.zip(view.values(shown, i)).collect();
        panel.dots(i, thinned(points.clone()).into_iter());
        of_levels.push(points);
    }
    for [from, to] in strips {
        let mut words = vec![format!(
            "{name} {} to {}",
            significant(from),
            significant(to)
        )];
        for (i, points) in of_levels.iter().enumerate() {
            let inside = points.iter().filter(|(x, _)| (from..to).contains(x));
            let values = Sorted::finite(inside.map(|point| point.1));
            if let Some(median) = quantile(&values, 0.5) {
                let (level, n) = (view.level_name(i), values.values().len());
                words.push(format!(
                    "{level}: {}, median {}",
                    count(n, "sample"),
                    shown.in_words(median)
                ));
            }
        }
        panel.readout_between([from, to], &words);
    }
    view.note_if_empty(&mut panel);
    view.figure(&panel, format!("{}-over-input-{j}", shown.word()), "")
}

/// Rows input, columns level; each cell with its strength for the shade behind it.
fn correlations(view: &View, shown: Shown, value: fn(&InputCorrelation) -> Option<f64>) -> Block {
    let fields = view.fields(range_fields!("rank_correlation"));
    let levels = (0..view.n_levels()).map(|i| (view.level_name(i), fields));
    let columns = [("Input".to_owned(), &["input"] as &'static [_])]
        .into_iter()
        .chain(levels);
    let title = format!("Rank correlation with the input: {}", shown.word());
    let file = format!("rank-correlation-{}", shown.word());
    let mut table = Table::new(title, &file, columns);
    for (j, input) in view.input.record.inputs.iter().enumerate() {
        let cell = |i: usize| {
            let found = correlations_of(view, i, j).into_iter().map(value);
            let found: Option<Vec<f64>> = found.collect();
            correlation_cell(found.and_then(hull), view.nested())
        };
        let name = Cell::text(&input.name);
        let cells = (0..view.n_levels()).map(cell);
        table.row([name].into_iter().chain(cells).collect());
    }
    table.block()
}

/// Lowest and highest coefficient, shaded by what both have in common.
fn correlation_cell(ends: Option<[f64; 2]>, nested: bool) -> Cell {
    let show = |rho: f64| signed(&format!("{rho:+.2}"));
    let text = ends.map_or_else(|| DASH.to_owned(), |ends| from_to(ends, show));
    let [low, high] = ends.unwrap_or_default();
    let strength = match low * high > 0.0 {
        true => low.abs().min(high.abs()),
        false => 0.0,
    };
    let class = match low < 0.0 {
        true => "shade negative",
        false => "shade positive",
    };
    Cell::number(text, ends.map(|e| e[0]))
        .with_raw(nested.then_some(ends.map(|e| e[1])))
        .with_shade(class, strength * 60.0)
}
