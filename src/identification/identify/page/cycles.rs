//! What each single loop gives, over the number of the cycle.

use super::parameter::label;
use super::view::{View, short_name};
use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::result::{LoopResult, LoopValue, TestResult};
use crate::identify::found::uncertain::Uncertain;
use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark, Section};
use crate::page::display::percent;
use crate::page::figure::{Panel, Size};
use crate::special::normal_quantile;

/// Cycles with an interval that a panel can show; more are thinned evenly.
const MOST_CYCLES: usize = 60;

/// What a panel shows of one cycle.
struct Point {
    /// Its number, from 1.
    cycle: f64,
    value: f64,
    /// Interval of the value by noise; the value twice where it has none.
    ends: [f64; 2],
}

/// Absent where no test has a loop.
pub(super) fn section(view: &View) -> Option<Section> {
    let drawn = view.drawn().filter(|(_, test)| !test.loops.is_empty());
    let rows: Vec<Block> = drawn
        .map(|(level, test)| Block::triples(figures(view, level, test)))
        .collect();
    if rows.is_empty() {
        return None;
    }
    let confidence = percent(view.confidence());
    let keys = [
        Key::level(
            0,
            format!("one cycle, with its {confidence} interval by noise"),
        ),
        Key::new(
            Mark::Band,
            "range",
            format!("mean of the steady loops, with its {confidence} interval"),
        ),
        Key::new(Mark::Band, "speeds", "run-in, left out"),
    ];
    let hint = "A value that still drifts after the shaded cycles says that the contact had not run in. Stiffness that differs \
                between the reversals at the greatest and at the least displacement says that the contact, or the rig, is not \
                the same in both directions.";
    let hint = format!("{hint} {}", view.not_drawn());
    let legend = Block::Legend(keys.into());
    let hint = Block::Hint(hint.trim_end().to_owned());
    Some(Section {
        id: "cycles",
        title: "Values of single cycles".to_owned(),
        blocks: [legend].into_iter().chain(rows).chain([hint]).collect(),
    })
}

/// Friction coefficient, and stiffness after both reversals on equal axes.
fn figures(view: &View, level: usize, test: &TestResult) -> Vec<Figure> {
    let [friction, tangential] = [
        ContactParameter::FrictionCoefficient,
        ContactParameter::TangentialStiffnessNPerUm,
    ];
    let coefficients = points(view, test, |found| found.friction_coefficient);
    let sides = [0, 1].map(|side| {
        points(view, test, |found| {
            found.tangential_stiffness_n_per_um[side]
        })
    });
    let estimate = test.estimate.as_ref();
    let coefficient = estimate.and_then(|e| e.friction).map(|f| f.coefficient);
    let stiffness = |side: usize| estimate.and_then(|e| e.tangential.sides_n_per_um[side]);
    let name = short_name(&test.name);
    let both: Vec<&Point> = sides.iter().flatten().collect();
    let figure = |file: &str, points: &[Point], mut panel: Panel| {
        draw(&mut panel, level, points);
        let caption = missing(test.loops.len(), points.len());
        view.figure(&panel, format!("cycles-{file}-{level}"), caption)
    };
    let plateaus = frame(
        test,
        label(friction),
        format!("{name}: plateaus"),
        coefficient,
        &coefficients.iter().collect::<Vec<_>>(),
    );
    let side = |side: usize, words: &str| {
        let title = format!("{name}: after {words}");
        let panel = frame(test, label(tangential), title, stiffness(side), &both);
        figure(words, &sides[side], panel)
    };
    vec![
        figure("friction", &coefficients, plateaus),
        side(0, "greatest"),
        side(1, "least"),
    ]
}

/// Cycles that have a value.
fn points(
    view: &View,
    test: &TestResult,
    of: impl Fn(&LoopResult) -> Option<LoopValue>,
) -> Vec<Point> {
    let factor = normal_quantile(0.5 * (1.0 + view.confidence()));
    let point = |found: &LoopResult| {
        let LoopValue {
            value,
            standard_error,
        } = of(found)?;
        let half = standard_error.map_or(0.0, |error| factor * error);
        Some(Point {
            cycle: found.cycle as f64 + 1.0,
            value,
            ends: [value - half, value + half],
        })
    };
    test.loops.iter().filter_map(point).collect()
}

/// An empty panel with the run-in and the value of the mean loop, `whole`; its axes hold what is `shown`.
fn frame(
    test: &TestResult,
    label: String,
    title: String,
    whole: Option<Uncertain>,
    shown: &[&Point],
) -> Panel {
    let limits = whole.into_iter().flat_map(|w| [w.lower, w.upper]);
    let last = test.loops.len() as f64 + 1.0;
    let x = Axis::linear("Cycle", 0.0, last);
    let values = shown.iter().flat_map(|p| p.ends);
    let y = Axis::around(label, values.chain(limits));
    let [bottom, top] = y.range();
    let mut panel = Panel::new(Size::Small, title, x, y);
    let run_in = match test.cycles.map_or(0, |c| c.run_in) {
        0 => 0.0,
        cycles => cycles as f64 + 0.5,
    };
    panel.band("speeds", &[0.0, run_in].map(|cycle| (cycle, bottom, top)));
    if let Some(whole) = whole {
        let span = [run_in, last];
        panel.band(
            "range",
            &span.map(|cycle| (cycle, whole.lower, whole.upper)),
        );
        panel.line(
            "nominal",
            span.map(|cycle| (cycle, whole.value)).into_iter(),
        );
    }
    panel
}

fn draw(panel: &mut Panel, level: usize, points: &[Point]) {
    let shown = || points.iter().step_by(stride(points.len()));
    for point in shown() {
        let ends = point.ends.map(|end| (point.cycle, end));
        panel.line(&format!("quartile l{level}"), ends.into_iter());
    }
    panel.dots(level, shown().map(|point| (point.cycle, point.value)));
    if points.is_empty() {
        panel.note("no cycle has a value");
    }
}

/// What the panel does not show, in words.
fn missing(cycles: usize, values: usize) -> String {
    let lost = match cycles - values {
        0 => String::new(),
        lost => format!("{lost} of {cycles} cycles have no value. "),
    };
    match stride(values) {
        1 => lost,
        stride => format!("{lost}One of {stride} values is drawn. "),
    }
}

fn stride(values: usize) -> usize {
    values.div_ceil(MOST_CYCLES).max(1)
}
