//! Ranges over the outer points of the epistemic inputs, as tables and as p-boxes.

use super::worst_case;
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use crate::page::display::{hertz, percent, short};
use crate::page::figure::{Panel, Size};
use crate::report::numbers::box_range::QuantileRange;
use crate::report::numbers::epistemic::{EpistemicLevel, EpistemicSummary};
use crate::report::numbers::population::Populations;
use crate::report::page::statistic_cell::{extreme_cell, interval_fields, range_cell};
use crate::report::page::view::{Shown, View};
use crate::statistics::{Observed, Sorted};

/// Values at which a p-box is drawn.
const PLACES: usize = 200;

/// Absent without epistemic inputs.
pub(super) fn section(view: &View) -> Option<Section> {
    let epistemic = view.summary.epistemic.as_ref()?;
    let amplitude = format!("Amplitude ({})", view.unit.symbol);
    let hint = "Each cell: lowest and highest value of the statistic over the outer points and where they are, failed \
                samples at their worst; small figures: from the lowest lower to the highest upper 95 % confidence limit. \
                Nothing is computed between the outer points. “Open” means that some outer point does not bound the side.";
    let design = &view.input.record.design;
    let searched = match design.further_points {
        0 => String::new(),
        n => format!(
            " The last {n} points, from number {} on, are those of the search for the worst case of each number that a \
             criterion judges.",
            design.outer_points
        ),
    };
    let mut blocks = vec![
        Block::Hint(format!("{hint}{searched}")),
        points(epistemic),
        quantiles(
            view,
            "Resonance frequency (Hz)",
            "frequency-ranges",
            |l| &l.frequency_hz,
            &hertz,
        ),
        quantiles(
            view,
            &amplitude,
            "amplitude-ranges",
            |l| &l.amplitude_m,
            &|v| view.length(v),
        ),
        bounds(view, epistemic),
    ];
    blocks.extend(exceedances(view, epistemic));
    blocks.extend(worst_case::blocks(view));
    let keys = [
        Key::new(
            Mark::Band,
            "",
            "between the distribution functions of the outer points",
        ),
        Key::new(Mark::Line, "line order", "each outer point"),
    ];
    blocks.push(Block::Legend(keys.into()));
    for shown in Shown::ALL {
        let figures = (0..view.n_levels()).map(|i| p_box(view, shown, i));
        blocks.push(Block::pairs(figures.collect()));
    }
    Some(Section {
        id: "epistemic",
        title: "Ranges over the epistemic inputs".to_owned(),
        blocks,
    })
}

/// Values of the epistemic inputs at every outer point.
fn points(epistemic: &EpistemicSummary) -> Block {
    let point: (String, &'static [&'static str]) = ("Outer point".to_owned(), &["outer"]);
    let value: &'static [&'static str] = &["value"];
    let samples: (String, &'static [&'static str]) = ("Samples".to_owned(), &["samples"]);
    let inputs = epistemic.inputs.iter().map(|name| (name.clone(), value));
    let columns = [point].into_iter().chain(inputs).chain([samples]);
    let mut table = Table::new("Outer points", "outer-points", columns);
    for point in &epistemic.points {
        let number = |n: f64| Cell::number(short(n), Some(n));
        let values = point.values.iter().map(|v| number(*v));
        let ends = [point.outer as f64, point.samples as f64].map(number);
        let [first, last] = ends;
        table.row([first].into_iter().chain(values).chain([last]).collect());
    }
    table.block()
}

fn quantiles(
    view: &View,
    title: &str,
    file: &str,
    of: fn(&EpistemicLevel) -> &Vec<QuantileRange>,
    show: &dyn Fn(f64) -> String,
) -> Block {
    let mut table = Table::of(
        format!("{title}: ranges of the quantiles"),
        file,
        &[
            ("Level", &["level"]),
            ("5 %", interval_fields!("q05")[1]),
            ("50 %", interval_fields!("q50")[1]),
            ("95 %", interval_fields!("q95")[1]),
        ],
    );
    let levels = view.summary.epistemic.iter().flat_map(|e| &e.levels);
    for (i, level) in levels.enumerate() {
        let cells = of(level).iter().map(|q| range_cell(&q.range, show));
        table.row([view.level_cell(i)].into_iter().chain(cells).collect());
    }
    table.block()
}

fn bounds(view: &View, epistemic: &EpistemicSummary) -> Block {
    let title = "Bounds: each holds for 95 % of the assumed prior with 95 % confidence, whichever outer point is true";
    let mut table = Table::of(
        title,
        "bounds",
        &[
            ("Level", &["level"]),
            ("Frequency above", &["frequency_lower_hz", "outer"]),
            ("Frequency below", &["frequency_upper_hz", "outer"]),
            ("Amplitude below", &["amplitude_upper_m", "outer"]),
        ],
    );
    let frequency = |v: f64| format!("{} Hz", hertz(v));
    for (i, level) in epistemic.levels.iter().enumerate() {
        let [lower, upper] = &level.frequency_bounds_hz;
        table.row(vec![
            view.level_cell(i),
            extreme_cell(lower, &frequency),
            extreme_cell(upper, &frequency),
            extreme_cell(&level.amplitude_bound_m, &|v| view.amplitude(v)),
        ]);
    }
    table.block()
}

/// Absent without limits of the amplitude.
fn exceedances(view: &View, epistemic: &EpistemicSummary) -> Option<Block> {
    let mut table = Table::of(
        "Probability that the amplitude exceeds a limit: range over the outer points",
        "exceedance-ranges",
        &[
            ("Level", &["level"]),
            ("Limit", &["limit_m"]),
            (
                "Probability",
                &[
                    "lowest",
                    "highest",
                    "lower",
                    "upper",
                    "lowest_at",
                    "highest_at",
                ],
            ),
        ],
    );
    let mut any = false;
    for (i, level) in epistemic.levels.iter().enumerate() {
        for exceedance in &level.exceedances {
            any = true;
            table.row(vec![
                view.level_cell(i),
                view.limit_cell(exceedance.threshold_m),
                range_cell(&exceedance.range, &percent),
            ]);
        }
    }
    any.then(|| table.block())
}

/// Distribution functions of the outer points and the band that they leave, failed samples on either side.
fn p_box(view: &View, shown: Shown, i: usize) -> Figure {
    let level = view.input.record.levels[i];
    let populations = Populations::of(view.input, i, |p| view.value(shown, level, p));
    let points = populations.each();
    let all = Sorted::finite(view.values(shown, i));
    let x = Axis::around(view.label(shown), all.values().iter().copied());
    let y = Axis::linear("Share of samples below", 0.0, 1.0);
    let mut panel = Panel::new(Size::Large, view.level_name(i), x, y);
    panel.band(&format!("l{i}"), &between(&points, all.values()));
    for point in &points {
        let corners = crate::statistics::empirical_cdf(point.valid());
        panel.steps(&format!("quartile l{i}"), &corners, 0.0);
    }
    if all.values().is_empty() {
        panel.note("no sample has a solution");
    }
    view.figure(&panel, format!("p-box-{}-{i}", shown.word()), "")
}

/// The steps (value, lowest share, highest share) that hold the distribution functions of all points, drawn at some of the
/// ascending `values`: the lowest share at the start of a step, the highest at its end, failed samples on either side.
fn between(points: &[&Observed], values: &[f64]) -> Vec<(f64, f64, f64)> {
    let below = |point: &Observed, x: f64, failed: usize| {
        let known = point.valid().values().partition_point(|v| *v <= x);
        (known + failed) as f64 / point.total().max(1) as f64
    };
    let least = |x: f64| points.iter().map(|p| below(p, x, 0)).fold(1.0, f64::min);
    let most = |x: f64| {
        let shares = points.iter().map(|p| below(p, x, p.failed()));
        shares.fold(0.0, f64::max)
    };
    let stride = values.len().div_ceil(PLACES).max(1);
    let mut band = Vec::new();
    for start in (0..values.len()).step_by(stride) {
        let end = (start + stride).min(values.len());
        let [low, high] = [least(values[start]), most(values[end - 1])];
        band.push((values[start], low, high));
        band.push((values[end.min(values.len() - 1)], low, high));
    }
    band
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No distribution function leaves the band, at its steps and between them. Seen to fail with straight lines between the
    /// values.
    #[test]
    fn the_band_holds_every_distribution_function() {
        let drawn = |shift: f64| (0..300).map(move |i| (f64::from(i) * 0.37).sin() + shift);
        let [a, b] = [0.0, 0.5].map(|shift| Observed::of(drawn(shift)));
        let points = [&a, &b];
        let all = Sorted::finite(drawn(0.0).chain(drawn(0.5)));
        let band = between(&points, all.values());
        for point in points {
            for (i, x) in all.values().iter().enumerate() {
                let next = all.values().get(i + 1).copied().unwrap_or(*x);
                let middle = 0.5 * (x + next);
                let step = band.chunks(2).rfind(|s| s[0].0 <= middle).unwrap();
                assert_eq!((step[0].1, step[0].2), (step[1].1, step[1].2));
                let known = point.valid().values().partition_point(|v| *v <= middle);
                let share = known as f64 / 300.0;
                assert!(step[0].1 <= share && share <= step[0].2, "{x}: {share}");
            }
        }
        let ends: Vec<f64> = band.iter().map(|s| s.0).collect();
        assert!(ends.windows(2).all(|w| w[0] <= w[1]));
    }
}
