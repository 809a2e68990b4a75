//! What each single loop gives, over the number of the cycle.

use super::parameter::{label, of_test};
use super::view::{View, short_name};
use crate::identify::identified::ContactParameter;
use crate::identify::result::{LoopResult, LoopValue, TestResult};
use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark, Section};
use crate::page::display::percent;
use crate::page::figure::{Panel, Size};
use crate::special::normal_quantile;

/// Cycles with an interval that a panel can show; more are thinned evenly.
const MOST_CYCLES: usize = 80;

/// Values of one cycle: its number from 1, the value and its interval.
type Point = (f64, f64, [f64; 2]);

/// Absent where no test has a loop.
pub(super) fn section(view: &View) -> Option<Section> {
    let drawn = view.drawn().filter(|(_, test)| !test.loops.is_empty());
    let figures: Vec<Figure> = drawn
        .flat_map(|(level, test)| [friction(view, level, test), stiffness(view, level, test)])
        .collect();
    if figures.is_empty() {
        return None;
    }
    let confidence = percent(view.confidence());
    let keys = [
        Key::level(
            0,
            format!(
                "value of one cycle, with its {confidence} interval by noise; of stiffness, after the greatest displacement"
            ),
        ),
        Key::new(Mark::Cross, "", "stiffness after the least displacement"),
        Key::new(
            Mark::Band,
            "range",
            format!("test as a whole, with its {confidence} interval"),
        ),
        Key::new(Mark::Band, "speeds", "run-in, left out"),
    ];
    let hint = "A value that still drifts after the shaded cycles says that the contact had not run in. Stiffness that differs \
                between the two reversals says that the contact, or the rig, is not the same in both directions.";
    Some(Section {
        id: "cycles",
        title: "Values of single cycles".to_owned(),
        blocks: vec![
            Block::Legend(keys.into()),
            Block::pairs(figures),
            Block::Hint(format!("{hint} {}", view.not_drawn()).trim_end().to_owned()),
        ],
    })
}

fn friction(view: &View, level: usize, test: &TestResult) -> Figure {
    let parameter = ContactParameter::FrictionCoefficient;
    let points = points(view, test, |found| found.friction_coefficient);
    let (mut panel, missing) = panel(view, test, parameter, &[&points]);
    draw(&mut panel, level, &points);
    if points.is_empty() {
        panel.note("no cycle has a plateau");
    }
    view.figure(&panel, format!("friction-cycles-{level}"), missing)
}

fn stiffness(view: &View, level: usize, test: &TestResult) -> Figure {
    let parameter = ContactParameter::TangentialStiffnessNPerUm;
    let [greatest, least] = [0, 1].map(|side| {
        points(view, test, |found| {
            found.tangential_stiffness_n_per_um[side]
        })
    });
    let (mut panel, missing) = panel(view, test, parameter, &[&greatest, &least]);
    draw(&mut panel, level, &greatest);
    // beside those of the other reversal
    let beside = least
        .iter()
        .map(|&(cycle, value, ends)| (cycle + 0.3, value, ends));
    for (cycle, _, ends) in beside.clone() {
        panel.whisker("plain", cycle, ends);
    }
    panel.crosses(
        &format!("l{level}"),
        beside.map(|(cycle, value, _)| (cycle, value)),
    );
    if greatest.is_empty() && least.is_empty() {
        panel.note("no cycle has a stick branch");
    }
    view.figure(&panel, format!("stiffness-cycles-{level}"), missing)
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
        let half = factor * standard_error;
        Some((
            found.cycle as f64 + 1.0,
            value,
            [value - half, value + half],
        ))
    };
    test.loops.iter().filter_map(point).collect()
}

/// An empty panel with run-in and the value of the test, and a sentence on what is not drawn.
fn panel(
    view: &View,
    test: &TestResult,
    parameter: ContactParameter,
    sides: &[&[Point]],
) -> (Panel, String) {
    let whole = test.estimate.as_ref().and_then(|e| of_test(parameter, e));
    let ends = whole.map(|w| [w.lower, w.upper]);
    let cycles = test.loops.len();
    let x = Axis::linear("Cycle", 0.0, cycles as f64 + 1.0);
    let shown = sides
        .iter()
        .copied()
        .flatten()
        .flat_map(|(_, value, ends)| [*value, ends[0], ends[1]]);
    let y = Axis::around(label(parameter), shown.chain(ends.into_iter().flatten()));
    let across = y.range();
    let mut panel = Panel::new(Size::Large, short_name(&test.name), x, y);
    let run_in = test.cycles.map_or(0, |c| c.run_in) as f64;
    if run_in > 0.0 {
        panel.band(
            "speeds",
            &[0.0, run_in + 0.5].map(|cycle| (cycle, across[0], across[1])),
        );
    }
    if let (Some(whole), Some([low, high])) = (whole, ends) {
        let span = [run_in + 0.5, cycles as f64 + 1.0];
        panel.band("range", &span.map(|cycle| (cycle, low, high)));
        panel.line(
            "nominal",
            span.map(|cycle| (cycle, whole.value)).into_iter(),
        );
    }
    (panel, missing(cycles, sides))
}

fn missing(cycles: usize, sides: &[&[Point]]) -> String {
    let least = sides.iter().map(|side| side.len()).min().unwrap_or(0);
    let lost = match cycles - least {
        0 => String::new(),
        lost => format!("{lost} of {cycles} cycles have no value. "),
    };
    match stride(least) {
        1 => lost,
        stride => format!("{lost}One of {stride} values is drawn. "),
    }
}

fn stride(values: usize) -> usize {
    values.div_ceil(MOST_CYCLES).max(1)
}

fn draw(panel: &mut Panel, level: usize, points: &[Point]) {
    let shown = points.iter().step_by(stride(points.len()));
    for &(cycle, _, ends) in shown.clone() {
        panel.whisker(&format!("l{level}"), cycle, ends);
    }
    panel.dots(level, shown.map(|&(cycle, value, _)| (cycle, value)));
}
