//! How far the number of samples leaves the estimates open: over the first 16, 32, 64, … samples, and between replicates.

use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Section, Table};
use crate::page::display::significant;
use crate::page::figure::{Panel, Size};
use crate::report::page::view::View;
use crate::statistics::{Interval, Prefix, QuantileEstimate, ReplicateMean};

/// Absent without prefixes or replicates to compare.
pub(super) fn section(view: &View) -> Option<Section> {
    let of_points = "The first so many samples of all outer points together are no population: how far the samples leave an \
                     estimate open is shown by the confidence limits (small figures) of its range over the outer points.";
    let blocks: Vec<Block> = prefixes(view)
        .into_iter()
        .flatten()
        .chain(view.nested().then(|| Block::Hint(of_points.to_owned())))
        .chain(replicates(view).into_iter().flatten())
        .collect();
    (!blocks.is_empty()).then(|| Section {
        id: "convergence",
        title: "Convergence over the samples".to_owned(),
        blocks,
    })
}

/// Absent with fewer than two prefixes.
fn prefixes(view: &View) -> Option<[Block; 3]> {
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
    Some([
        view.level_legend([]),
        Block::pairs(figures),
        Block::Hint(hint.to_owned()),
    ])
}

/// Columns of the table of replicates after level and outer point.
const OF_REPLICATES: [(&str, &[&str]); 6] = [
    ("Replicates", &["replicates"]),
    (
        "Mean frequency (Hz)",
        &[
            "frequency_mean_hz",
            "frequency_mean_lower_hz",
            "frequency_mean_upper_hz",
        ],
    ),
    (
        "Its 95 % quantile (Hz)",
        &["frequency_q95_lower_hz", "frequency_q95_upper_hz"],
    ),
    (
        "Mean amplitude",
        &[
            "amplitude_mean_m",
            "amplitude_mean_lower_m",
            "amplitude_mean_upper_m",
        ],
    ),
    (
        "Its 95 % quantile",
        &["amplitude_q95_lower_m", "amplitude_q95_upper_m"],
    ),
    ("Failed, not in it", &["failed"]),
];

/// Means over the replicates of a quasi-random design with the error that their scatter shows; absent without replicates.
fn replicates(view: &View) -> Option<[Block; 2]> {
    let means = view.summary.replicate_means();
    let nested = means.first()?.1.is_some();
    let outer = nested.then_some(("Outer point", &["outer"] as &'static [_]));
    let columns = [("Level", &["level"] as &'static [_])]
        .into_iter()
        .chain(outer)
        .chain(OF_REPLICATES)
        .map(|(head, fields)| (head.to_owned(), fields));
    let mut table = Table::new("Means over the replicates", "replicates", columns);
    let hertz = |v: f64| format!("{v:.4}");
    for (i, outer, means) in means {
        let (frequency, amplitude) = (means.frequency_hz, means.amplitude_m);
        let [.., frequency_q95] = means.frequency_quantiles_hz;
        let [.., amplitude_q95] = means.amplitude_quantiles_m;
        let numbers = [
            Cell::whole(frequency.replicates as u64),
            mean_cell(&frequency, hertz),
            interval_cell(frequency_q95.interval, hertz),
            mean_cell(&amplitude, |v| view.amplitude(v)),
            interval_cell(amplitude_q95.interval, |v| view.amplitude(v)),
            Cell::whole(frequency.failed as u64),
        ];
        let outer = outer.map(Cell::whole);
        let head = [view.level_cell(i)].into_iter().chain(outer);
        table.row(head.chain(numbers).collect());
    }
    let hint = "Points of one replicate depend on each other, so their scatter says nothing about the error; that of the \
                replicates does. Small figures and quantiles: 95 % intervals from the scatter of so many replicates. \
                A failed sample may have had any value: a mean of the others has no bounds, and quantiles count it on either side.";
    Some([table.block(), Block::Hint(hint.to_owned())])
}

/// A mean with its interval.
fn mean_cell(mean: &ReplicateMean, show: impl Fn(f64) -> String) -> Cell {
    let Interval { lower, upper } = mean.interval;
    Cell::number(show(mean.mean), Some(mean.mean))
        .with_raw([lower.value(), upper.value()])
        .with_small(mean.interval.in_words(" … ", show))
}

/// An interval alone.
fn interval_cell(interval: Interval, show: impl Fn(f64) -> String) -> Cell {
    let Interval { lower, upper } = interval;
    Cell::number(interval.in_words(" … ", show), lower.value()).with_raw([upper.value()])
}

/// Number of samples, estimate and its interval.
struct RunningPoint {
    n: f64,
    estimate: f64,
    interval: Option<[f64; 2]>,
}

fn scaled(prefixes: &[Prefix<Option<QuantileEstimate>>], scale: f64) -> Vec<RunningPoint> {
    let point = |prefix: &Prefix<Option<QuantileEstimate>>| {
        let quantile = prefix.value?;
        let sides = (
            quantile.interval.lower.value(),
            quantile.interval.upper.value(),
        );
        Some(RunningPoint {
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
    points: &dyn Fn(usize) -> Vec<RunningPoint>,
) -> Figure {
    let levels: Vec<Vec<RunningPoint>> = (0..view.n_levels()).map(points).collect();
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
            panel.mark(i, (point.n * aside, point.estimate));
            let Some([low, high]) = point.interval else {
                continue;
            };
            panel.whisker(&format!("l{i}"), point.n * aside, [low, high]);
            let words = [
                format!("{}, {} samples", view.level_name(i), point.n),
                [point.estimate, low, high].map(significant).join(", "),
            ];
            panel.readout_upright(point.n * aside, [low, high], &words);
        }
    }
    view.note_if_empty(&mut panel);
    view.figure(&panel, format!("convergence-{file}"), "")
}
