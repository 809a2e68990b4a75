//! All tests beside each other, and the joint distribution of the parameters at a further contact.

use super::parameter::{label, show};
use super::view::{View, short_name};
use crate::identify::found::pooled_result::{Pooled, PooledParameter, Trend, TrendOver};
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use crate::page::display::{capitalised, from_to, percent, with_digits};
use crate::page::figure::{Panel, Size};
use std::f64::consts::TAU;

/// Tests with a line of their own in a figure at most.
const MOST_LINES: usize = 24;
/// Corners of a contour.
const CORNERS: usize = 120;
/// Shares of further contacts inside the contours.
const SHARES: [f64; 2] = [0.5, 0.95];

/// Absent where nothing was found.
pub(super) fn section(view: &View) -> Option<Section> {
    let pooled = view
        .found
        .pooled
        .as_ref()
        .filter(|p| !p.parameters.is_empty())?;
    let confidence = percent(view.confidence());
    let keys = [
        Key::level(
            0,
            format!("a test whose loops are drawn, with its {confidence} intervals"),
        ),
        Key::new(Mark::Line, "whisker plain", "another test"),
        Key::new(
            Mark::Band,
            "range",
            format!("further contact, {confidence}, with its median"),
        ),
        Key::new(
            Mark::Line,
            "line nominal",
            "half of further contacts lie inside",
        ),
        Key::new(Mark::Line, "line wide grey", "95 % of them lie inside"),
    ];
    let count = pooled.parameters.len();
    let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
    let figures = (pooled.parameters.iter().map(|p| forest(view, p)))
        .chain(pairs.map(|pair| contours(view, pooled, pair)));
    let hint = "The file identified.json gives a study this distribution: logarithms of the parameters are jointly normal.";
    let blocks = [
        Some(Block::Legend(keys.into())),
        Some(Block::pairs(figures.collect())),
        Some(Block::Hint(hint.to_owned())),
        trends(pooled),
    ];
    Some(Section {
        id: "joint",
        title: "Tests together, and a further contact".to_owned(),
        blocks: blocks.into_iter().flatten().collect(),
    })
}

/// One parameter, test by test, above the distribution for a further contact.
fn forest(view: &View, pooled: &PooledParameter) -> Figure {
    let parameter = pooled.parameter;
    let having: Vec<_> = (view.estimates())
        .filter_map(|(i, test, estimate)| Some((i, test, estimate.value(parameter)?)))
        .collect();
    // those whose loops are drawn first
    let mut chosen: Vec<_> = having.iter().collect();
    chosen.sort_by_key(|(i, ..)| view.level(*i).is_none());
    chosen.truncate(MOST_LINES);
    chosen.sort_by_key(|(i, ..)| *i);
    let ends = chosen
        .iter()
        .flat_map(|(_, _, found)| [found.lower, found.upper]);
    let x = Axis::around(label(parameter), ends.chain(pooled.further_contact));
    let names = chosen.iter().map(|(_, test, _)| short_name(&test.name));
    let names: Vec<String> = names.chain(["Further contact".to_owned()]).collect();
    let last = -(chosen.len() as f64);
    let title = format!("{} by test", capitalised(parameter.in_words()));
    let mut panel = Panel::new(Size::Rows(names.len()), title, x, Axis::of_names(names));
    let [low, high] = pooled.further_contact;
    panel.band("range", &[(low, last - 0.5, 0.5), (high, last - 0.5, 0.5)]);
    panel.rule("quantile", pooled.median.value);
    for (line, (i, _, found)) in chosen.iter().enumerate() {
        let y = -(line as f64);
        let ends = [found.lower, found.upper];
        match view.level(*i) {
            Some(level) => {
                panel.level_whisker(&format!("l{level}"), y, ends);
                panel.mark(level, (found.value, y));
            }
            None => {
                panel.level_whisker("plain", y, ends);
                panel.pale_dots([(found.value, y)].into_iter());
            }
        }
        panel.readout_level(y, ends, &[show(found.value), from_to(ends, show)]);
    }
    panel.level_whisker("plain", last, [low, high]);
    let caption = match having.len() - chosen.len() {
        0 => String::new(),
        others => format!("{others} more tests are in the table alone. "),
    };
    view.figure(&panel, format!("tests-{}", parameter.name()), caption)
}

/// Two parameters of all tests that have both, and contours of their joint distribution at a further contact.
fn contours(view: &View, pooled: &Pooled, [a, b]: [usize; 2]) -> Figure {
    let [first, second] = [a, b].map(|k| &pooled.parameters[k]);
    let correlation = pooled
        .correlation
        .get(a)
        .and_then(|row| row.get(b))
        .copied()
        .unwrap_or(0.0);
    let contours = SHARES.map(|share| contour([first, second], correlation, share));
    let tests: Vec<_> = (view.estimates())
        .filter_map(|(i, test, e)| {
            Some((
                i,
                test,
                [e.value(first.parameter)?, e.value(second.parameter)?],
            ))
        })
        .collect();
    let axis = |k: usize, of: &PooledParameter| {
        let drawn = contours.iter().flatten().map(|p| [p.0, p.1][k]);
        let ends = tests
            .iter()
            .flat_map(|(_, _, found)| [found[k].lower, found[k].upper]);
        Axis::around(label(of.parameter), drawn.chain(ends))
    };
    let (x, y) = (axis(0, first), axis(1, second));
    let mut panel = Panel::new(Size::Large, "Joint distribution", x, y);
    for (class, corners) in ["nominal", "wide grey"].into_iter().zip(contours) {
        panel.line(class, corners.into_iter());
    }
    let others = tests.iter().filter(|(i, ..)| view.level(*i).is_none());
    panel.pale_dots(others.map(|(_, _, [x, y])| (x.value, y.value)));
    for (i, test, [x, y]) in &tests {
        let point = (x.value, y.value);
        if let Some(level) = view.level(*i) {
            panel.whisker(&format!("l{level}"), x.value, [y.lower, y.upper]);
            panel.level_whisker(&format!("l{level}"), y.value, [x.lower, x.upper]);
            panel.mark(level, point);
        }
        panel.readout_mark(
            point,
            &[
                test.name.clone(),
                format!("{}, {}", show(x.value), show(y.value)),
            ],
        );
    }
    let caption = format!(
        "Correlation of the logarithms {}. ",
        with_digits(correlation, 2)
    );
    let file = format!(
        "joint-{}-{}",
        first.parameter.name(),
        second.parameter.name()
    );
    view.figure(&panel, file, caption)
}

/// Corners of the contour of two lognormal parameters that a share of further contacts lies inside.
fn contour(pair: [&PooledParameter; 2], correlation: f64, share: f64) -> Vec<(f64, f64)> {
    let radius = (-2.0 * (1.0 - share).ln()).sqrt();
    let across = (1.0 - correlation * correlation).max(0.0).sqrt();
    let [x, y] = pair.map(|p| {
        move |score: f64| p.median.value * (p.predictive_log_standard_deviation * score).exp()
    });
    let corner = |k: usize| {
        let (sine, cosine) = (TAU * k as f64 / CORNERS as f64).sin_cos();
        let second = correlation * cosine + across * sine;
        (x(radius * cosine), y(radius * second))
    };
    (0..=CORNERS).map(corner).collect()
}

/// Dependence on load and frequency; absent where it could not be looked for.
fn trends(pooled: &Pooled) -> Option<Block> {
    if pooled.trends.is_empty() {
        return None;
    }
    let mut table = Table::of(
        "Dependence on load and frequency: parameter ∝ (load or frequency)^exponent",
        "trends",
        &[
            ("Parameter", &["parameter"]),
            ("On", &["over"]),
            ("Tests", &["tests"]),
            ("Exponent", &["exponent", "lower", "upper"]),
            ("In words", &["words"]),
        ],
    );
    for trend in &pooled.trends {
        table.row(trend_row(trend));
    }
    Some(table.block())
}

fn trend_row(trend: &Trend) -> Vec<Cell> {
    let over = match trend.over {
        TrendOver::NormalForce => "normal force",
        TrendOver::Frequency => "frequency",
    };
    let [low, high] = trend.interval;
    let words = match (low, high) {
        (low, _) if low > 0.0 => "rises",
        (_, high) if high < 0.0 => "falls",
        _ => "no dependence can be told from 0",
    };
    vec![
        Cell::text(trend.parameter.in_words()).with_class("text brief"),
        Cell::text(over).with_class("text"),
        Cell::whole(trend.tests as u64),
        Cell::number(with_digits(trend.exponent, 2), Some(trend.exponent))
            .with_raw([low, high].map(Some))
            .with_small(from_to([low, high], |v| with_digits(v, 2))),
        Cell::text(words).with_class("text brief"),
    ]
}
