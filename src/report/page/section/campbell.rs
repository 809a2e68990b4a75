//! Campbell diagram: where engine orders cross the scattered resonance, and how far they stay away.

use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use crate::page::display::{hertz, percent, short};
use crate::page::figure::{Panel, Size};
use crate::report::asked::requirement::{MarginBase, Operation};
use crate::report::numbers::margins::OrderMargin;
use crate::report::numbers::population::Populations;
use crate::report::page::statistic_cell::{
    BOUND_FIELDS, bound_cell, interval_fields, quantile_cell,
};
use crate::report::page::view::View;
use crate::statistics::hull;

/// Probabilities of a scatter bar.
const BAR: [f64; 2] = [0.01, 0.99];

/// Absent without `[operation]`.
pub(super) fn section(view: &View) -> Option<Section> {
    let operation = view.input.record.requirements.operation.as_ref()?;
    let mut keys = vec![
        Key::new(Mark::Line, "line order", "engine order"),
        Key::new(Mark::Band, "speeds", "range of speeds"),
    ];
    if !operation.dwell_rpm.is_empty() {
        keys.push(Key::new(Mark::Line, "rule limit", "speed that is held"));
    }
    let base = match operation.margin_relative_to {
        MarginBase::EngineOrder => "the frequency of the excitation",
        MarginBase::Resonance => "the resonance frequency",
    };
    let hint = format!(
        "Margins are shares of {base}; over the range of speeds the smallest counts, which is 0 where an order crosses \
         the resonance inside. The bound holds for 95 % of the assumed prior with 95 % confidence. The model has the same \
         frequencies at all speeds: centrifugal stiffening enters by the study's model only. Margins are those of the \
         highest maximum of each sample; lower ones, which `peak = \"all\"` searches, have none. {}",
        view.assessment.condition
    );
    let overview = Window::overview(view, operation);
    let mut figures = vec![diagram(
        view,
        operation,
        "Campbell diagram",
        "campbell",
        &overview,
    )];
    figures.extend(Window::close_up(view, operation).map(|window| {
        let title = "Campbell diagram, close-up";
        diagram(view, operation, title, "campbell-close", &window)
    }));
    Some(Section {
        id: "campbell",
        title: "Campbell diagram".to_owned(),
        blocks: vec![
            view.level_legend(keys),
            Block::pairs(figures),
            margins(view),
        ]
        .into_iter()
        .chain(dwell(view, operation))
        .chain([Block::Hint(hint)])
        .collect(),
    })
}

/// Scatter of the resonance frequency of level `i` with its middle (Hz).
fn bar(view: &View, i: usize) -> Option<[f64; 3]> {
    Populations::of(view.input, i, |p| p.frequency_hz).scatter(BAR)
}

/// Frequencies around the scatter of all levels (Hz).
fn close_up(view: &View) -> Option<[f64; 2]> {
    let bars = (0..view.n_levels()).filter_map(|i| bar(view, i));
    let ends = bars.map(|[low, _, high]| [low, high]);
    let [low, high] = ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    let space = (high - low).max(2e-3 * high);
    Some([low - space, high + space])
}

/// Speeds of the close-up: the range of speeds and the crossings of the window (Hz) close to it.
fn speeds_in_sight(operation: &Operation, [low, high]: [f64; 2]) -> [f64; 2] {
    let [slow, fast] = operation.speed_rpm;
    let middle = 0.5 * (low + high);
    let orders = operation.engine_orders.iter();
    let crossings = orders.map(|k| 60.0 * middle / f64::from(*k));
    let close = crossings.filter(|c| (0.85 * slow..=1.15 * fast).contains(c));
    let [slow, fast] = close.fold([slow, fast], |[a, b], c| [a.min(c), b.max(c)]);
    let space = (0.1 * (fast - slow)).max(0.01 * fast);
    [(slow - space).max(0.0), fast + space]
}

/// What a diagram shows: speeds (1/min) and frequencies (Hz).
struct Window {
    speeds: [f64; 2],
    frequencies: [f64; 2],
}

impl Window {
    /// The range of speeds with space, the resonances and the engine orders there.
    fn overview(view: &View, operation: &Operation) -> Self {
        let [slow, fast] = operation.speed_rpm;
        let orders = operation.engine_orders.iter();
        let excited = orders.flat_map(|&k| [slow, fast].map(|speed| excitation_hz(k, speed)));
        let bars = (0..view.n_levels()).filter_map(|i| bar(view, i));
        let resonances = bars.flat_map(|[low, _, high]| [low, high]);
        let [low, high] = hull(excited.chain(resonances)).unwrap_or([0.0, 1.0]);
        let space = (0.12 * (high - low)).max(0.02 * high);
        let aside = (fast - slow).max(0.12 * fast);
        Self {
            speeds: [(slow - aside).max(0.0), fast + aside],
            frequencies: [(low - space).max(0.0), high + space],
        }
    }

    /// The resonances' scatter and the crossings close to the range of speeds; absent without a resonance.
    fn close_up(view: &View, operation: &Operation) -> Option<Self> {
        let frequencies = close_up(view)?;
        Some(Self {
            speeds: speeds_in_sight(operation, frequencies),
            frequencies,
        })
    }
}

/// Frequency (Hz) of an engine order at a speed (1/min).
fn excitation_hz(order: u32, speed_rpm: f64) -> f64 {
    f64::from(order) / 60.0 * speed_rpm
}

/// Engine orders and scatter bars in a window.
fn diagram(
    view: &View,
    operation: &Operation,
    title: &str,
    file: &str,
    Window {
        speeds,
        frequencies,
    }: &Window,
) -> Figure {
    let x = Axis::linear("Speed (1/min)", speeds[0], speeds[1]);
    let y = Axis::linear("Frequency (Hz)", frequencies[0], frequencies[1]);
    let mut panel = Panel::new(Size::Large, title, x, y);
    let range = operation
        .speed_rpm
        .map(|speed| (speed, frequencies[0], frequencies[1]));
    panel.band("speeds", &range);
    for i in 0..view.n_levels() {
        if let Some([lower, _, upper]) = bar(view, i) {
            let band = [(speeds[0], lower, upper), (speeds[1], lower, upper)];
            panel.band(&format!("l{i}"), &band);
        }
    }
    for speed in &operation.dwell_rpm {
        panel.rule("limit", *speed);
    }
    let mut labels = Vec::new();
    for &order in &operation.engine_orders {
        labels.extend(draw_order(&mut panel, order, *speeds, *frequencies));
    }
    draw_bars(view, &mut panel, operation, *speeds);
    panel.labels(&labels);
    view.note_if_empty(&mut panel);
    let words = view.scatter_in_words("1 %", "99 %");
    let caption = format!(
        "Bands and bars: {words}, by level; bars stand where an engine order crosses their middle."
    );
    view.figure(&panel, file, caption)
}

/// The line of an order; its name and the place of it, if the line crosses the window.
fn draw_order(
    panel: &mut Panel,
    order: u32,
    [slow, fast]: [f64; 2],
    [low, high]: [f64; 2],
) -> Option<((f64, f64), String)> {
    let slope = excitation_hz(order, 1.0);
    let [enters, leaves] = [slow.max(low / slope), fast.min(high / slope)];
    if enters >= leaves {
        return None;
    }
    let ends = [enters, leaves].map(|speed| (speed, slope * speed));
    panel.line("order", ends.into_iter());
    let speed = enters + 0.12 * (leaves - enters);
    Some(((speed, slope * speed), format!("EO {order}")))
}

/// A bar of each level at the speed where an order crosses its middle.
fn draw_bars(view: &View, panel: &mut Panel, operation: &Operation, speeds: [f64; 2]) {
    for i in 0..view.n_levels() {
        let Some([low, middle, high]) = bar(view, i) else {
            continue;
        };
        for &order in &operation.engine_orders {
            let speed = middle / excitation_hz(order, 1.0);
            if !(speeds[0]..=speeds[1]).contains(&speed) {
                continue;
            }
            panel.whisker(&format!("l{i}"), speed, [low, high]);
            panel.mark(i, (speed, middle));
            let words = [
                format!("{}, EO {order} at {speed:.0}/min", view.level_name(i)),
                [low, middle, high].map(hertz).join(", ") + " Hz",
            ];
            panel.readout_upright(speed, [low, high], &words);
        }
    }
}

fn margins(view: &View) -> Block {
    let title = "Crossing speeds (1/min) and margin over the range of speeds";
    let mut table = Table::of(
        title,
        "margins",
        &[
            ("Level", &["level"]),
            ("Order", &["engine_order"]),
            (
                "Crossing, 5 %",
                view.fields(interval_fields!("crossing_q05_rpm")),
            ),
            (
                "Crossing, 95 %",
                view.fields(interval_fields!("crossing_q95_rpm")),
            ),
            ("Margin, 5 %", view.fields(interval_fields!("margin_q05"))),
            ("Margin, 50 %", view.fields(interval_fields!("margin_q50"))),
            ("Lower bound", view.fields(BOUND_FIELDS)),
        ],
    );
    let speed = |v: f64| format!("{v:.0}");
    for (i, level) in view.assessment.levels.iter().enumerate() {
        for margin in &level.margins {
            let OrderMargin {
                engine_order,
                crossing_rpm,
                range,
                range_bound,
                ..
            } = margin;
            table.row(vec![
                view.level_cell_of_margin(i),
                Cell::whole(u64::from(*engine_order)),
                quantile_cell(crossing_rpm, 0, &speed),
                quantile_cell(crossing_rpm, 2, &speed),
                quantile_cell(range, 0, &percent),
                quantile_cell(range, 1, &percent),
                bound_cell(range_bound, &percent),
            ]);
        }
    }
    table.block()
}

/// Margins at the speeds that are held; absent without any.
fn dwell(view: &View, operation: &Operation) -> Option<Block> {
    if operation.dwell_rpm.is_empty() {
        return None;
    }
    let mut table = Table::of(
        "Margin at the speeds that are held",
        "dwell-margins",
        &[
            ("Level", &["level"]),
            ("Order", &["engine_order"]),
            ("Speed (1/min)", &["speed_rpm"]),
            ("Margin, 5 %", view.fields(interval_fields!("margin_q05"))),
            ("Margin, 50 %", view.fields(interval_fields!("margin_q50"))),
        ],
    );
    for (i, level) in view.assessment.levels.iter().enumerate() {
        for margin in &level.margins {
            for dwell in &margin.dwell {
                table.row(vec![
                    view.level_cell_of_margin(i),
                    Cell::whole(u64::from(margin.engine_order)),
                    Cell::number(short(dwell.speed_rpm), Some(dwell.speed_rpm)),
                    quantile_cell(&dwell.quantiles, 0, &percent),
                    quantile_cell(&dwell.quantiles, 1, &percent),
                ]);
            }
        }
    }
    Some(table.block())
}
