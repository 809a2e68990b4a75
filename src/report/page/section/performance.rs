//! Performance curves of the study: frequency, amplitude, Q factor and damping ratio over the ratio of excitation to
//! centrifugal load.

use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, from_to, hertz, significant};
use crate::report::numbers::performance::{FanPlace, Measure, fan};
use crate::report::page::performance_figure::{Performance, keys, ratio_label};
use crate::report::page::view::View;

/// What every page with performance curves says of them.
pub(in crate::report) const HINT: &str =
    "Quantiles at each ratio of the samples with a solution there; each sample is a line, straight over the logarithm of its \
     ratio. Damping ratio: the work that damping and friction dissipate per cycle over 4π times the kinetic energy of the first \
     harmonic; at the linear limits from the half-power width. Q = 1 / (2 · damping ratio), beside published ranges of \
     sources of damping (Gastaldi, Berruti & Gola 2018). Small excitation: contacts stick; large excitation: they slip and open.";

/// Absent with fewer than two levels: there is nothing to draw a curve through.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.n_levels() < 2 {
        return None;
    }
    let runs = [*view.input];
    let performance = Performance {
        runs: &runs,
        unit: view.unit,
        amplitude_unit: view.amplitude_unit(),
    };
    let figures = Measure::ALL.into_iter().flat_map(|measure| {
        let title = |_| format!("{} over excitation", title(measure));
        performance.figures(measure, title, |_| format!("performance-{}", file(measure)))
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

/// Words for `measure` at the start of a title.
pub(in crate::report) fn title(measure: Measure) -> &'static str {
    match measure {
        Measure::Frequency => "Resonance frequency",
        Measure::AmplitudePerExcitation => "Amplitude per excitation",
        Measure::QFactor => "Q factor",
        Measure::DampingRatio => "Damping ratio",
    }
}

/// Name of `measure` in names of files.
pub(in crate::report) fn file(measure: Measure) -> &'static str {
    match measure {
        Measure::Frequency => "frequency",
        Measure::AmplitudePerExcitation => "amplitude",
        Measure::QFactor => "q-factor",
        Measure::DampingRatio => "damping-ratio",
    }
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
            &["damping_ratio_q50", "damping_ratio_q05", "damping_ratio_q95"],
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
