//! Forced response: nominal curves, the cloud of peaks, and the band of the curves level by level.

use super::curve_bands::scatter;
use super::response_frame::{
    FREQUENCY, add_linear_curves, amplitude_axis, assessed, largest_linear_amplitude, unstable,
    window,
};
use crate::ensemble::outcome::LevelOutcome;
use crate::hb::Status;
use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark, Section};
use crate::page::display::{hertz, significant};
use crate::page::figure::{Panel, Size};
use crate::page::thinning::thinned;
use crate::report::page::view::{RANGES, Shown, View};
use crate::statistics::{Interval, Limit};

pub(super) fn section(view: &View) -> Section {
    let linear = || {
        [
            Key::new(Mark::Line, "line free", "without contact"),
            Key::new(Mark::Line, "line stuck", "fully stuck"),
        ]
    };
    let nominal = view.input.record.nominal.is_some();
    let ring = nominal.then(|| Key::new(Mark::Ring, "", "nominal peak"));
    let line = nominal.then(|| Key::new(Mark::Line, "line nominal", "nominal"));
    let band_keys: Vec<Key> = match view.nested() {
        false => vec![Key::new(
            Mark::Band,
            "",
            "5 %, 50 % and 95 % at each frequency",
        )],
        true => {
            let [outer, inner] = RANGES;
            vec![
                Key::new(Mark::Band, "outer", outer),
                Key::new(Mark::Band, "", inner),
            ]
        }
    };
    let cross = shows_unstable(view).then(|| Key::new(Mark::Cross, "", "unstable"));
    let scatter = scatter(view);
    let whole =
        (scatter.whole).then(|| Key::new(Mark::Line, "line wide grey", "95 % of whole curves"));
    let mut first: Vec<Figure> = nominal_responses(view).into_iter().collect();
    first.push(cloud(view));
    Section {
        id: "response",
        title: "Forced response".to_owned(),
        blocks: vec![
            view.level_legend(linear().into_iter().chain(ring).chain(cross.clone())),
            Block::pairs(first),
            Block::Heading("Scatter of the response, level by level".to_owned()),
            Block::Legend(
                band_keys
                    .into_iter()
                    .chain(whole)
                    .chain(line)
                    .chain(cross)
                    .chain(linear())
                    .collect(),
            ),
            Block::triples(scatter.figures),
            Block::Hint(scatter.meaning),
        ],
    }
}

/// Response at the nominal inputs, all levels in one panel.
fn nominal_responses(view: &View) -> Option<Figure> {
    let nominal = view.input.record.nominal.as_ref()?;
    let amplitudes = (0..view.n_levels()).filter_map(|i| view.nominal(Shown::AmplitudePerLevel, i));
    let top = amplitudes.fold(largest_linear_amplitude(view), f64::max);
    let (low, high) = window(view);
    let x = Axis::linear(FREQUENCY, low, high);
    let y = amplitude_axis(view, top);
    let mut panel = Panel::new(Size::Large, "Nominal forced response", x, y);
    add_linear_curves(view, &mut panel, |_| Some(1.0));
    let mut labels = Vec::new();
    for (i, record) in nominal.levels.iter().enumerate() {
        let curve = view.curve(record.around.curve(), record.level);
        panel.line(&format!("level l{i}"), curve.into_iter());
        panel.crosses(&format!("l{i}"), unstable(view, i));
        let peak = Shown::ALL.map(|shown| view.nominal(shown, i));
        if let [Some(x), Some(y)] = peak {
            panel.mark(i, (x, y));
            let words = [
                format!("{}: {} Hz", view.level_name(i), hertz(x)),
                format!("{} {}", significant(y), view.amplitude_unit()),
            ];
            panel.readout_mark((x, y), &words);
            labels.push(((x, y), view.level_name(i)));
        }
    }
    panel.labels(&labels);
    Some(view.figure(&panel, "nominal-response", stability_of_curves(view)))
}

fn is_unstable(level: &LevelOutcome) -> bool {
    level.status == Status::Unstable
}

/// Whether a peak or a solution of a nominal curve is unstable.
fn shows_unstable(view: &View) -> bool {
    let mut levels = view.input.outcomes.iter().flat_map(|o| &o.levels);
    let mut curves = (0..view.n_levels()).flat_map(|i| unstable(view, i));
    levels.any(is_unstable) || curves.next().is_some()
}

/// At how many solutions of the nominal curves stability was assessed, in words; empty without any.
fn stability_of_curves(view: &View) -> String {
    let assessed: Vec<bool> = (0..view.n_levels())
        .flat_map(|i| assessed(view, i))
        .map(|(_, unstable)| unstable)
        .collect();
    let n_unstable = assessed.iter().filter(|unstable| **unstable).count();
    match assessed.len() {
        0 => String::new(),
        n => format!(
            "Stability was assessed at {n} solutions along these curves; {n_unstable} of them are unstable. Between them it may change."
        ),
    }
}

/// All peaks: amplitude per force over frequency, coloured by level.
fn cloud(view: &View) -> Figure {
    let [frequency, amplitude] = Shown::ALL;
    let x = Axis::around(view.label(frequency), view.all_values(frequency));
    let y = Axis::around(view.label(amplitude), view.all_values(amplitude)).starting_at_zero();
    let ranges = [x.range(), y.range()];
    let mut panel = Panel::new(Size::Large, "Resonance peaks of all samples", x, y);
    for i in 0..view.n_levels() {
        let points = view.values(frequency, i).zip(view.values(amplitude, i));
        panel.dots(i, thinned(points.collect()).into_iter());
        let unstable = view.peaks(i).filter(|(o, _)| is_unstable(&o.levels[i]));
        let places = unstable.map(|(_, peak)| {
            Shown::ALL.map(|shown| view.value(shown, view.input.record.levels[i], &peak))
        });
        panel.crosses(&format!("l{i}"), places.map(|[x, y]| (x, y)));
    }
    let mut labels = Vec::new();
    for i in 0..view.n_levels() {
        if let Some(corners) = region(view, i, ranges) {
            panel.line(&format!("joint l{i}"), corners.into_iter());
        }
        if let (Some(x), Some(y)) = (view.nominal(frequency, i), view.nominal(amplitude, i)) {
            panel.ring(&format!("l{i}"), (x, y));
            labels.push(((x, y), view.level_name(i)));
        }
    }
    panel.labels(&labels);
    view.note_if_empty(&mut panel);
    let caption = match view.nested() {
        true => "The samples of all outer points: how dense they lie says nothing.",
        false => {
            "Dashed: region that holds 95 % of the assumed prior with 95 % confidence, open where too few samples bound it, \
             conditional on the assumed distributions."
        }
    };
    view.figure(&panel, "peaks", caption)
}

/// Corners of the joint region of level `i`, if there is one; open sides lie outside of the axes.
fn region(view: &View, i: usize, [x_axis, y_axis]: [[f64; 2]; 2]) -> Option<[(f64, f64); 5]> {
    let region = view.assessment.levels[i].joint_region.as_ref()?;
    let scale = view.unit.per_metre / view.input.record.levels[i];
    let sides = |interval: Interval, scale: f64, [low, high]: [f64; 2]| {
        let width = high - low;
        let side = |limit: Limit, open: f64| limit.value().map_or(open, |v| v * scale);
        let lower = side(interval.lower, low - width);
        [lower, side(interval.upper, high + width)]
    };
    let [x0, x1] = sides(region.x, 1.0, x_axis);
    let [y0, y1] = sides(region.y, scale, y_axis);
    Some([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
}
