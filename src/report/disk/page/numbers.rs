//! The numbers of each engine order at each level.

use super::{DiskView, excitation_hz};
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, hertz, percent, significant};
use crate::report::disk::summary::{OrderLevel, OrderSummary};

pub(super) fn section(view: &DiskView) -> Section {
    let unit = view.unit.symbol;
    let amplitude = format!("Amplitude ({unit})");
    let mut table = Table::of(
        "By engine order and level",
        "disk",
        &[
            ("Order", &["engine_order"]),
            ("Nodal diameter", &["nodal_diameter"]),
            ("Level", &["level"]),
            ("Samples", &["samples"]),
            ("Failed", &["failed"]),
            (
                "Frequency (Hz)",
                &["frequency_q01_hz", "frequency_q50_hz", "frequency_q99_hz"],
            ),
            (
                &amplitude,
                &["amplitude_q01_m", "amplitude_q50_m", "amplitude_q99_m"],
            ),
            ("Crossing (1/min)", &["crossing_rpm"]),
            ("Margin, lower bound", &["margin_bound"]),
        ],
    );
    for (order, i, level) in view.bars() {
        table.row(number_row(view, order, i, level));
    }
    let hint = "Frequency and amplitude: 1 %, 50 % and 99 % of the samples. The lower bound of the margin over the range of speeds \
                holds for 95 % of the assumed prior with 95 % confidence.";
    Section {
        id: "numbers",
        title: "Numbers".to_owned(),
        blocks: vec![table.block(), Block::Hint(hint.to_owned())],
    }
}

fn number_row(view: &DiskView, order: &OrderSummary, i: usize, level: &OrderLevel) -> Vec<Cell> {
    let bar = |bar: &Option<[f64; 3]>, show: &dyn Fn(f64) -> String| match bar {
        None => Cell::number(DASH, None).with_raw([None, None]),
        Some([low, middle, high]) => {
            let words = [low, middle, high].map(|value| show(*value)).join(", ");
            Cell::number(words, Some(*low)).with_raw([Some(*middle), Some(*high)])
        }
    };
    let slope = excitation_hz(f64::from(order.engine_order), 1.0);
    let crossing = level.frequency_hz.map(|[_, middle, _]| middle / slope);
    let speed = crossing.map_or(DASH.to_owned(), |v| format!("{v:.0}"));
    let bound = level
        .margin
        .as_ref()
        .and_then(|margin| margin.range_bound.value());
    let margin = Cell::number(bound.map_or(DASH.to_owned(), percent), bound)
        .with_small(level.several_answers.in_words());
    vec![
        Cell::whole(u64::from(order.engine_order)),
        Cell::whole(order.nodal_diameter as u64),
        Cell::number(view.level_name(i), Some(level.level)).with_chip(i),
        Cell::whole(order.samples as u64),
        Cell::whole(level.failed as u64),
        bar(&level.frequency_hz, &hertz),
        bar(&level.amplitude_m, &|a| {
            significant(a * view.unit.per_metre)
        }),
        Cell::number(speed, crossing),
        margin,
    ]
}
