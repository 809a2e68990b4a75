//! Which input moves what.

use super::super::axis::Axis;
use super::super::block::{Block, Cell, Figure, Section, Table};
use super::super::display::{DASH, minus_sign};
use super::super::figure::{Panel, Size};
use super::super::summary::{InputCorrelation, LevelSummary};
use super::super::view::{Shown, View, thinned};

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
            Block::pairs(scatter.collect()),
            correlations(view, Shown::Frequency, |c| c.frequency),
            correlations(view, Shown::AmplitudePerLevel, |c| c.amplitude),
            Block::Hint(hint.to_owned()),
        ],
    })
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
