//! Performance curves of the study: frequency, amplitude, Q factor and damping ratio over the ratio of excitation to
//! centrifugal load.

use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, from_to, hertz, significant};
use crate::report::numbers::performance::{FanPlace, Measure, fan};
use crate::report::page::performance_figure::{HINT, Performance, file, keys, ratio_label, title};
use crate::report::page::view::View;

/// Absent with fewer than two levels: there is nothing to draw a curve through.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.n_levels() < 2 {
        return None;
    }
    let runs = [*view.input];
    let performance = Performance {
        runs: &runs,
        unit: view.unit,
    };
    let figures = Measure::ALL.into_iter().flat_map(|measure| {
        let name = |_| format!("{} over excitation", title(measure));
        performance.figures(measure, name, |_| format!("performance-{}", file(measure)))
    });
    let figures = figures.collect();
    let legend = keys(view.nested(), view.input.record.nominal.is_some());
    Some(Section {
        id: "performance",
        title: "Performance over the excitation".to_owned(),
        blocks: vec![
            Block::Legend(legend),
            Block::pairs(figures),
            table(view, &performance),
            Block::Hint(HINT.to_owned()),
        ],
    })
}

/// The fans in numbers.
fn table(view: &View, performance: &Performance) -> Block {
    let columns: [(String, &'static [&'static str]); 5] = [
        (ratio_label(view.input.record), &["excitation"]),
        (
            performance.label(Measure::Frequency),
            &["frequency_hz_q50", "frequency_hz_q05", "frequency_hz_q95"],
        ),
        (
            performance.label(Measure::AmplitudePerExcitation),
            &["amplitude_m_q50", "amplitude_m_q05", "amplitude_m_q95"],
        ),
        (
            performance.label(Measure::QFactor),
            &["q_factor_q50", "q_factor_q05", "q_factor_q95"],
        ),
        (
            performance.label(Measure::DampingRatio),
            &[
                "damping_ratio_q50",
                "damping_ratio_q05",
                "damping_ratio_q95",
            ],
        ),
    ];
    let mut table = Table::new("Performance", "performance", columns);
    let fans = Measure::ALL.map(|measure| (measure, fan(view.input, measure)));
    for place in &fans[0].1 {
        let mut row = vec![Cell::number(significant(place.ratio), Some(place.ratio))];
        row.extend(fans.iter().map(|(measure, fan)| {
            let here = fan.iter().find(|other| other.ratio == place.ratio);
            cell(view, *measure, here)
        }));
        table.row(row);
    }
    table.block()
}

/// Median and range of a fan at one ratio.
fn cell(view: &View, measure: Measure, place: Option<&FanPlace>) -> Cell {
    let Some(place) = place else {
        return Cell::number(DASH, None).with_raw([None, None]);
    };
    let show = |value: f64| match measure {
        Measure::Frequency => hertz(value),
        Measure::AmplitudePerExcitation => significant(value * view.unit.per_metre),
        Measure::QFactor => significant(value),
        Measure::DampingRatio => significant(100.0 * value),
    };
    let text = place.median.map_or_else(|| DASH.to_owned(), show);
    Cell::number(text, place.median)
        .with_raw(place.outer.map(Some))
        .with_small(from_to(place.outer, show))
}
