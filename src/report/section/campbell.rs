//! Campbell diagram: where engine orders cross the scattered resonance, and how far they stay away.

use super::super::axis::Axis;
use super::super::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use super::super::display::{DASH, percent, short};
use super::super::figure::{Panel, Size};
use super::super::margins::OrderMargin;
use super::super::requirement::{MarginBase, Operation};
use super::super::view::{Shown, View};
use super::envelope::limits;
use crate::statistics::{QuantileEstimate, Sorted, quantile};

/// Probabilities of a scatter bar.
const BAR: [f64; 2] = [0.01, 0.99];

/// Absent without `[operation]`.
pub(super) fn section(view: &View) -> Option<Section> {
    let operation = view.input.record.requirements.operation.as_ref()?;
    let keys = [
        Key::new(Mark::Line, "line order", "engine order"),
        Key::new(Mark::Line, "rule quantile", "range of speeds"),
        Key::new(Mark::Line, "rule limit", "speed that is held"),
    ];
    let base = match operation.margin_relative_to {
        MarginBase::EngineOrder => "the frequency of the excitation",
        MarginBase::Resonance => "the resonance frequency",
    };
    let hint = format!(
        "Margins are shares of {base}; over the range of speeds the smallest counts, which is 0 where an order crosses \
         the resonance inside. The bound holds for 95 % of the blades with 95 % confidence. The model has the same \
         frequencies at all speeds: centrifugal stiffening enters by the study's model only. {}",
        view.assessment.condition
    );
    let figures = vec![
        diagram(view, operation, "Campbell diagram", "campbell", None),
        diagram(
            view,
            operation,
            "Campbell diagram, close-up",
            "campbell-close",
            close_up(view),
        ),
    ];
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

/// Quantiles of the resonance frequency of level `i` (Hz).
fn bar(view: &View, i: usize) -> Option<[f64; 2]> {
    let sorted = Sorted::finite(view.values(Shown::Frequency, i));
    let [low, high] = BAR.map(|p| quantile(&sorted, p));
    Some([low?, high?])
}

/// Frequencies around the scatter of all levels (Hz).
fn close_up(view: &View) -> Option<[f64; 2]> {
    let bars = (0..view.n_levels()).filter_map(|i| bar(view, i));
    let [low, high] = bars.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    let room = (high - low).max(2e-3 * high);
    Some([low - room, high + room])
}

/// Engine orders and scatter bars; over all frequencies from 0, or over `window` (Hz).
fn diagram(
    view: &View,
    operation: &Operation,
    title: &str,
    file: &str,
    window: Option<[f64; 2]>,
) -> Figure {
    let [slow, fast] = operation.speed_rpm;
    let [low, high] = window.unwrap_or_else(|| {
        let top = view.all_values(Shown::Frequency).fold(0.0, f64::max);
        [0.0, 1.2 * top.max(1e-6)]
    });
    let speeds = match window {
        // Just the speeds at which an order or the range is in sight.
        Some(_) => {
            let room = (0.15 * (fast - slow)).max(0.01 * fast);
            [(slow - room).max(0.0), fast + room]
        }
        None => [0.0, 1.15 * fast],
    };
    let x = Axis::linear("Speed (1/min)", speeds[0], speeds[1]);
    let y = Axis::linear("Frequency (Hz)", low, high);
    let mut panel = Panel::new(Size::Large, title, x, y);
    for i in 0..view.n_levels() {
        if let Some([lower, upper]) = bar(view, i) {
            let band = [(speeds[0], lower, upper), (speeds[1], lower, upper)];
            panel.band(&format!("l{i}"), &band);
        }
    }
    panel.rule("quantile", slow);
    panel.rule("quantile", fast);
    for speed in &operation.dwell_rpm {
        panel.rule("limit", *speed);
    }
    for &order in &operation.engine_orders {
        draw_order(&mut panel, order, speeds, [low, high]);
    }
    if window.is_some() {
        draw_bars(view, &mut panel, operation, speeds);
    }
    view.note_if_empty(&mut panel);
    let caption = "Bands and bars: 1 % to 99 % of the samples, by level; bars stand where an engine order crosses the median.";
    view.figure(&panel, file, caption)
}

/// The line of an order with its name where it leaves the picture.
fn draw_order(panel: &mut Panel, order: u32, [slow, fast]: [f64; 2], [low, high]: [f64; 2]) {
    let slope = f64::from(order) / 60.0;
    let [enters, leaves] = [slow.max(low / slope), fast.min(high / slope)];
    if enters >= leaves {
        return;
    }
    let ends = [enters, leaves].map(|speed| (speed, slope * speed));
    panel.line("order", ends.into_iter());
    // The name stands a little inside the edge that the line leaves by.
    let speed = enters + 0.93 * (leaves - enters);
    panel.words("end", (speed, slope * speed), &format!("EO {order}"));
}

/// A bar of each level at the speed where an order crosses its median.
fn draw_bars(view: &View, panel: &mut Panel, operation: &Operation, speeds: [f64; 2]) {
    let n = view.n_levels();
    for i in 0..n {
        let sorted = Sorted::finite(view.values(Shown::Frequency, i));
        let (Some(ends), Some(median)) = (bar(view, i), quantile(&sorted, 0.5)) else {
            continue;
        };
        // Side by side, so that levels with the same scatter can be told apart.
        let aside = (i as f64 - 0.5 * (n - 1) as f64) * 0.014 * (speeds[1] - speeds[0]);
        for &order in &operation.engine_orders {
            let speed = 60.0 * median / f64::from(order);
            if (speeds[0]..=speeds[1]).contains(&speed) {
                panel.whisker(&format!("l{i}"), speed + aside, ends);
            }
        }
    }
}

/// Quantile with its interval, by its place among 5, 50, 95 %.
fn cell(quantiles: &[QuantileEstimate], k: usize, show: &dyn Fn(f64) -> String) -> Cell {
    match quantiles.get(k) {
        None => Cell::number(DASH, None).with_raw([None, None]),
        Some(q) => Cell::number(show(q.estimate), Some(q.estimate))
            .with_raw([q.interval.lower.value(), q.interval.upper.value()])
            .with_small(limits(q.interval, show)),
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
                &["crossing_q05_rpm", "lower_rpm", "upper_rpm"],
            ),
            (
                "Crossing, 95 %",
                &["crossing_q95_rpm", "lower_rpm", "upper_rpm"],
            ),
            (
                "Margin, 5 %",
                &["margin_q05", "margin_q05_lower", "margin_q05_upper"],
            ),
            (
                "Margin, 50 %",
                &["margin_q50", "margin_q50_lower", "margin_q50_upper"],
            ),
            ("Lower bound", &["margin_bound"]),
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
            let bound = range_bound.limit.value();
            table.row(vec![
                view.level_cell(i),
                Cell::number(engine_order.to_string(), Some(f64::from(*engine_order))),
                cell(crossing_rpm, 0, &speed),
                cell(crossing_rpm, 2, &speed),
                cell(range, 0, &percent),
                cell(range, 1, &percent),
                Cell::number(bound.map_or_else(|| "open".to_owned(), percent), bound),
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
            (
                "Margin, 5 %",
                &["margin_q05", "margin_q05_lower", "margin_q05_upper"],
            ),
            (
                "Margin, 50 %",
                &["margin_q50", "margin_q50_lower", "margin_q50_upper"],
            ),
        ],
    );
    for (i, level) in view.assessment.levels.iter().enumerate() {
        for margin in &level.margins {
            for dwell in &margin.dwell {
                let order = margin.engine_order;
                table.row(vec![
                    view.level_cell(i),
                    Cell::number(order.to_string(), Some(f64::from(order))),
                    Cell::number(short(dwell.speed_rpm), Some(dwell.speed_rpm)),
                    cell(&dwell.quantiles, 0, &percent),
                    cell(&dwell.quantiles, 1, &percent),
                ]);
            }
        }
    }
    Some(table.block())
}
