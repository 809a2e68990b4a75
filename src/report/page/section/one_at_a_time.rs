//! One input at a time: how far the results go when an input alone goes from its low to its high value.

use super::influence::{Leg, legs};
use crate::ensemble::one_at_a_time::{ENDS, OneAtATime};
use crate::ensemble::outcome::LevelOutcome;
use crate::page::block::{Block, Cell, Figure, Section, Table};
use crate::page::display::{minus_sign, short};
use crate::report::numbers::peaks::usable_peak;
use crate::report::page::view::{Shown, View};

/// Absent where the study does not ask for it.
pub(super) fn section(view: &View) -> Option<Section> {
    let results = view.input.record.one_at_a_time.as_ref()?;
    let [low, high] = ENDS.map(|p| short(100.0 * p));
    Some(Section {
        id: "one-at-a-time",
        title: "One input at a time".to_owned(),
        blocks: vec![
            view.level_legend([]),
            Block::pairs(
                Shown::ALL
                    .map(|shown| figure(view, results, shown))
                    .to_vec(),
            ),
            table(view, results),
            Block::Hint(format!(
                "Each random input alone from its {low} % to its {high} % value (dot), all others at their medians. \
                 Interactions between inputs do not show, and a result that turns between the ends is missed."
            )),
        ],
    })
}

fn figure(view: &View, results: &OneAtATime, shown: Shown) -> Figure {
    let record = view.input.record;
    let value = |outcome: &LevelOutcome, i: usize| {
        Some(view.value(shown, record.levels[i], &usable_peak(outcome)?))
    };
    let mut found = Vec::new();
    for i in 0..view.n_levels() {
        for (row, swing) in results.swings.iter().enumerate() {
            let [low, high] = [0, 1].map(|end| value(&swing.ends[end][i], i));
            if let (Some(low), Some(high)) = (low, high) {
                found.push(Leg {
                    level: i,
                    row,
                    low,
                    high,
                    intervals: None,
                });
            }
        }
    }
    let names = results
        .swings
        .iter()
        .map(|s| record.inputs[s.input].name.clone());
    let title = format!("Resonance {}, one input alone", shown.word());
    let panel = legs(view, shown, &names.collect::<Vec<_>>(), title, &found);
    view.figure(&panel, format!("one-at-a-time-{}", shown.word()), "")
}

/// The numbers, with the status where there is none.
fn table(view: &View, results: &OneAtATime) -> Block {
    let columns: [(&str, &[&str]); 7] = [
        ("Level", &["level"]),
        ("Input", &["input"]),
        ("Value", &["value"]),
        ("Frequency (Hz)", &["frequency_hz"]),
        ("Change (Hz)", &["frequency_change_hz"]),
        ("Amplitude (µm)", &["amplitude_m"]),
        ("Change (%)", &["amplitude_change"]),
    ];
    let mut table = Table::of("One input at a time", "one-at-a-time", &columns);
    for i in 0..view.n_levels() {
        let median = &results.median[i];
        let mut row = |name: &str, value: Option<f64>, outcome: &LevelOutcome| {
            let (peak, middle) = (usable_peak(outcome), usable_peak(median));
            let pair = peak.zip(middle);
            let number = |v: Option<f64>, scale: f64, digits: usize| match v {
                Some(v) => Cell::number(minus_sign(&format!("{:.digits$}", v * scale)), Some(v)),
                None => Cell::number(outcome.status.name(), None),
            };
            table.row(vec![
                view.level_cell(i),
                Cell::text(name).with_class("text"),
                Cell::number(value.map_or_else(String::new, short), value),
                number(peak.map(|p| p.frequency_hz), 1.0, 3),
                number(pair.map(|(p, m)| p.frequency_hz - m.frequency_hz), 1.0, 3),
                number(peak.map(|p| p.amplitude_m), 1e6, 3),
                number(
                    pair.map(|(p, m)| p.amplitude_m / m.amplitude_m - 1.0),
                    1e2,
                    1,
                ),
            ]);
        };
        row("all at their medians", None, median);
        for swing in &results.swings {
            let name = &view.input.record.inputs[swing.input].name;
            for (value, end) in swing.values.into_iter().zip(&swing.ends) {
                row(name, Some(value), &end[i]);
            }
        }
    }
    table.block()
}
