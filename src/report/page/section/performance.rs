//! Performance curves: frequency and amplitude over the excitation, with fans.

use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark, Section};
use crate::page::figure::{Panel, Size};
use crate::report::numbers::population::Populations;
use crate::report::page::view::{RANGES, Shown, View};
use crate::report::run::record::LinearRecord;

/// The fan at one level.
struct Fan {
    /// Excitation level.
    level: f64,
    /// From the 5 % to the 95 % quantile.
    outer: [f64; 2],
    /// From the 25 % to the 75 % quantile; over outer points from the lowest to the highest median.
    inner: [f64; 2],
    /// Absent over outer points.
    median: Option<f64>,
}

impl Fan {
    /// `None` without a solution.
    fn of(view: &View, shown: Shown, i: usize) -> Option<Self> {
        let level = view.input.record.levels[i];
        let values = Populations::of(view.input, i, |p| view.value(shown, level, p));
        let medians = values.hull(0.5)?;
        let from_to = |[low, high]: [f64; 2]| Some([values.hull(low)?[0], values.hull(high)?[1]]);
        let nested = view.nested();
        Some(Self {
            level,
            outer: from_to([0.05, 0.95])?,
            inner: if nested {
                medians
            } else {
                from_to([0.25, 0.75])?
            },
            median: (!nested).then_some(medians[0]),
        })
    }
}

/// Absent with fewer than two levels: there is nothing to draw a curve through.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.n_levels() < 2 {
        return None;
    }
    let [outer, inner] = match view.nested() {
        false => ["5 % to 95 % of the samples, median", "25 % to 75 %"],
        true => RANGES,
    };
    let keys = [
        Key::new(Mark::Band, "outer", outer),
        Key::new(Mark::Band, "", inner),
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
    let fans: Vec<Fan> = (0..view.n_levels())
        .filter_map(|i| Fan::of(view, shown, i))
        .collect();
    let nominal =
        (0..view.n_levels()).filter_map(|i| Some((record.levels[i], view.nominal(shown, i)?)));
    let nominal: Vec<(f64, f64)> = nominal.collect();
    let values = fans.iter().flat_map(|fan| fan.outer);
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
    let band = |of: fn(&Fan) -> [f64; 2]| -> Vec<_> {
        let edges = |fan: &Fan| (fan.level, of(fan)[0], of(fan)[1]);
        fans.iter().map(edges).collect()
    };
    panel.level_rule("free", limits[0]);
    panel.level_rule("stuck", limits[1]);
    panel.band("range outer", &band(|fan| fan.outer));
    panel.band("range", &band(|fan| fan.inner));
    let medians = fans.iter().filter_map(|fan| Some((fan.level, fan.median?)));
    panel.line("nominal", medians);
    for (i, point) in nominal.into_iter().enumerate() {
        panel.ring(&format!("l{i}"), point);
    }
    view.note_if_empty(&mut panel);
    view.figure(&panel, format!("performance-{}", shown.word()), "")
}
