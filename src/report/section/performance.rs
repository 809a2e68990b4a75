//! Performance curves: frequency and amplitude over the excitation, with fans.

use super::super::axis::Axis;
use super::super::block::{Block, Figure, Key, Mark, Section};
use super::super::figure::{Panel, Size};
use super::super::record::LinearRecord;
use super::super::view::{Shown, View};
use crate::statistics::{Sorted, quantile};

/// Probabilities of the fan, outside in, and its middle.
const FAN: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// Absent with fewer than two levels: there is nothing to draw a curve through.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.n_levels() < 2 {
        return None;
    }
    let keys = [
        Key::new(Mark::Band, "outer", "5 % to 95 % of the samples, median"),
        Key::new(Mark::Band, "", "25 % to 75 %"),
        Key::new(Mark::Line, "line free", "without contact"),
        Key::new(Mark::Line, "line stuck", "fully stuck"),
    ];
    let nominal = view.input.record.nominal.is_some();
    let ring = nominal.then(|| Key::new(Mark::Ring, "", "nominal"));
    let figures = Shown::ALL.map(|shown| fan(view, shown)).to_vec();
    Some(Section {
        id: "performance",
        title: "Performance over the excitation".to_owned(),
        blocks: vec![
            Block::Legend(keys.into_iter().chain(ring).collect()),
            Block::pairs(figures),
            Block::Hint(
                "Quantiles of the samples with a solution at each level, joined by straight lines. Small excitation: \
                 contacts stick; large excitation: they slip and open."
                    .to_owned(),
            ),
        ],
    })
}

fn fan(view: &View, shown: Shown) -> Figure {
    let record = view.input.record;
    let limits = match shown {
        Shown::Frequency => [record.free.frequency_hz, record.stuck.frequency_hz],
        Shown::AmplitudePerLevel => {
            let top = |linear: &LinearRecord| view.largest(&linear.curve, 1.0);
            [&record.free, &record.stuck].map(|linear| top(linear).unwrap_or(f64::NAN))
        }
    };
    let fans: Vec<(f64, Vec<f64>)> = (0..view.n_levels())
        .filter_map(|i| {
            let sorted = Sorted::finite(view.values(shown, i));
            let quantiles: Option<Vec<f64>> = FAN.iter().map(|&p| quantile(&sorted, p)).collect();
            Some((record.levels[i], quantiles?))
        })
        .collect();
    let nominal =
        (0..view.n_levels()).filter_map(|i| Some((record.levels[i], view.nominal(shown, i)?)));
    let nominal: Vec<(f64, f64)> = nominal.collect();
    let values = fans.iter().flat_map(|(_, q)| q.iter().copied());
    let x = Axis::around(
        format!("Excitation ({})", record.level_unit),
        record.levels.iter().copied(),
    );
    let y = Axis::around(
        view.label(shown),
        values.chain(limits).chain(nominal.iter().map(|p| p.1)),
    );
    let title = match shown {
        Shown::Frequency => "Resonance frequency over excitation",
        Shown::AmplitudePerLevel => "Amplitude per excitation over excitation",
    };
    let mut panel = Panel::new(Size::Large, title, x, y);
    let band = |low: usize, high: usize| -> Vec<_> {
        fans.iter().map(|(x, q)| (*x, q[low], q[high])).collect()
    };
    panel.level_rule("free", limits[0]);
    panel.level_rule("stuck", limits[1]);
    panel.band("range outer", &band(0, 4));
    panel.band("range", &band(1, 3));
    panel.line("nominal", fans.iter().map(|(x, q)| (*x, q[2])));
    for (i, point) in nominal.into_iter().enumerate() {
        panel.ring(&format!("l{i}"), point);
    }
    view.note_if_empty(&mut panel);
    view.figure(&panel, format!("performance-{}", shown.word()), "")
}
