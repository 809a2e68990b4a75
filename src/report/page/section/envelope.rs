//! Quantiles of frequency and amplitude, level by level, as tables.

use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, hertz, with_digits};
use crate::report::convention::PROBABILITIES;
use crate::report::numbers::distribution::Distribution;
use crate::report::numbers::summary::LevelSummary;
use crate::report::page::statistic_cell::limits;
use crate::report::page::view::View;
use crate::statistics::QuantileEstimate;

/// A quantity of the tables and how it is shown.
struct Quantity<'a> {
    title: String,
    file: &'static str,
    distribution: fn(&LevelSummary) -> &Distribution,
    nominal: fn(&LevelSummary) -> Option<f64>,
    /// Shown number per SI unit.
    unit: f64,
    show: &'a dyn Fn(f64) -> String,
}

/// Absent with epistemic inputs: their section has the tables and figures by outer point.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.summary.epistemic.is_some() {
        return None;
    }
    let scale = view.unit.per_metre;
    let length = |v: f64| view.length(v);
    let quantities = [
        Quantity {
            title: "Resonance frequency (Hz)".to_owned(),
            file: "frequency",
            distribution: |l| &l.frequency_hz,
            nominal: |l| Some(l.nominal?.frequency_hz),
            unit: 1.0,
            show: &hertz,
        },
        Quantity {
            title: format!("Amplitude per nominal level ({})", view.amplitude_unit()),
            file: "amplitude-per-level",
            distribution: |l| &l.amplitude_per_unit_level_m,
            nominal: |l| Some(l.nominal?.amplitude_m / l.level),
            unit: scale,
            show: &length,
        },
        Quantity {
            title: format!("Amplitude ({})", view.unit.symbol),
            file: "amplitude",
            distribution: |l| &l.amplitude_m,
            nominal: |l| Some(l.nominal?.amplitude_m),
            unit: scale,
            show: &length,
        },
    ];
    let hint = "Quantiles are order statistics of the samples with a solution. Small figures: 95 % confidence interval \
                from the binomial, free of any assumption on the distribution; “open” means that the samples do not \
                bound that side. Where samples failed, the second small line is the range of the quantile over all \
                values they could have had. “Per nominal level” divides by the level of the study, not by the excitation of each \
                sample. Downloads are in SI units.";
    let tables = quantities.iter().map(|q| table(view, q));
    Some(Section {
        id: "envelopes",
        title: "Envelopes of the resonance".to_owned(),
        blocks: [Block::Hint(hint.to_owned())]
            .into_iter()
            .chain(tables)
            .collect(),
    })
}

fn table(view: &View, quantity: &Quantity) -> Block {
    let mut table = Table::of(
        &quantity.title,
        quantity.file,
        &[
            ("Level", &["level"]),
            ("Nominal", &["nominal"]),
            ("5 %", &["q05", "q05_lower", "q05_upper"]),
            ("50 %", &["q50", "q50_lower", "q50_upper"]),
            ("95 %", &["q95", "q95_lower", "q95_upper"]),
            ("Mean ± s.d.", &["mean", "standard_deviation"]),
        ],
    );
    for (i, level) in view.summary.levels.iter().enumerate() {
        let nominal = (quantity.nominal)(level);
        let text = nominal.map_or_else(|| DASH.to_owned(), quantity.show);
        let mut cells = vec![view.level_cell(i), Cell::number(text, nominal)];
        let distribution = (quantity.distribution)(level);
        cells.extend(quantile_cells(distribution, level.failed, quantity.show));
        cells.push(mean(distribution, quantity));
        table.row(cells);
    }
    table.block()
}

pub(super) fn quantile_cells(
    distribution: &Distribution,
    failed: usize,
    show: &dyn Fn(f64) -> String,
) -> Vec<Cell> {
    let cell = |q: &QuantileEstimate| {
        let interval = q.interval;
        Cell::number(show(q.estimate), Some(q.estimate))
            .with_raw([interval.lower.value(), interval.upper.value()])
            .with_small(limits(interval, show))
            .with_warning((failed > 0).then(|| limits(q.failure_bounds, show)))
    };
    let mut cells: Vec<Cell> = distribution.quantiles.iter().map(cell).collect();
    let absent = || Cell::number(DASH, None).with_raw([None, None]);
    cells.resize_with(PROBABILITIES.len(), absent);
    cells
}

/// Mean ± standard deviation, the latter with three digits.
fn mean(distribution: &Distribution, quantity: &Quantity) -> Cell {
    let Some(moments) = distribution.moments else {
        return Cell::number(DASH, None).with_raw([None]);
    };
    let mut text = (quantity.show)(moments.mean);
    if let Some(deviation) = moments.standard_deviation {
        text.push_str(&format!(" ± {}", with_digits(deviation * quantity.unit, 3)));
    }
    Cell::number(text, Some(moments.mean)).with_raw([moments.standard_deviation])
}
