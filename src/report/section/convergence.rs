//! What more samples changed: estimates over the first 16, 32, 64, … samples.

use super::super::axis::Axis;
use super::super::block::{Block, Figure, Section};
use super::super::figure::{Panel, Size};
use super::super::view::View;
use crate::statistics::{Prefix, QuantileEstimate};

/// Absent without two prefixes to compare.
pub(super) fn section(view: &View) -> Option<Section> {
    let first = view.assessment.levels.first()?;
    if first.amplitude_q95_m.len() < 2 {
        return None;
    }
    let amplitude = format!("95 % quantile of the amplitude ({})", view.amplitude_unit());
    let scale = |i: usize| view.unit.per_metre / view.input.record.levels[i];
    let figures = vec![
        figure(
            view,
            "Median of the frequency",
            "Frequency (Hz)",
            "frequency",
            &|i| scaled(&view.assessment.levels[i].frequency_q50_hz, 1.0),
        ),
        figure(
            view,
            "95 % quantile of the amplitude",
            &amplitude,
            "amplitude",
            &|i| scaled(&view.assessment.levels[i].amplitude_q95_m, scale(i)),
        ),
    ];
    let hint = "Each point uses the first so many samples, failed ones included; bars are 95 % confidence intervals, \
                left out where a side is open. A bar that the later points leave is a reason to doubt the samples.";
    Some(Section {
        id: "convergence",
        title: "Convergence over the samples".to_owned(),
        blocks: vec![
            view.level_legend([]),
            Block::pairs(figures),
            Block::Hint(hint.to_owned()),
        ],
    })
}

/// Number of samples, estimate and its interval.
struct Point {
    n: f64,
    estimate: f64,
    interval: Option<[f64; 2]>,
}

fn scaled(prefixes: &[Prefix<Option<QuantileEstimate>>], scale: f64) -> Vec<Point> {
    let point = |prefix: &Prefix<Option<QuantileEstimate>>| {
        let quantile = prefix.value?;
        let sides = (
            quantile.interval.lower.value(),
            quantile.interval.upper.value(),
        );
        Some(Point {
            n: prefix.n as f64,
            estimate: quantile.estimate * scale,
            interval: match sides {
                (Some(lower), Some(upper)) => Some([lower * scale, upper * scale]),
                _ => None,
            },
        })
    };
    prefixes.iter().filter_map(point).collect()
}

fn figure(
    view: &View,
    title: &str,
    label: &str,
    file: &str,
    points: &dyn Fn(usize) -> Vec<Point>,
) -> Figure {
    let levels: Vec<Vec<Point>> = (0..view.n_levels()).map(points).collect();
    let all = || levels.iter().flatten();
    let ends = all().filter_map(|p| p.interval).flatten();
    let y = Axis::around(label, ends.chain(all().map(|p| p.estimate)));
    let [low, high] = [f64::min, f64::max].map(|f| all().map(|p| p.n).reduce(f).unwrap_or(1.0));
    let x = Axis::log("Samples", 0.85 * low, 1.18 * high.max(2.0 * low));
    let mut panel = Panel::new(Size::Large, title, x, y);
    for (i, points) in levels.iter().enumerate() {
        // A little apart, so that the bars of the levels do not hide each other.
        let aside = 1.0 + 0.025 * (i as f64 - 0.5 * (levels.len() - 1) as f64);
        let line = points.iter().map(|p| (p.n * aside, p.estimate));
        panel.line(&format!("level l{i}"), line);
        for point in points {
            if let Some(interval) = point.interval {
                panel.whisker(&format!("l{i}"), point.n * aside, interval);
            }
        }
    }
    view.note_if_empty(&mut panel);
    view.figure(&panel, format!("convergence-{file}"), "")
}
