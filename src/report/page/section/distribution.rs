//! Distribution functions and histograms.

use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark, Section};
use crate::page::display::{count, percent};
use crate::page::distribution::{confidence_band, cumulative_steps};
use crate::page::figure::{Panel, Size};
use crate::report::convention::PROBABILITIES;
use crate::report::page::view::{Shown, View};
use crate::statistics::{Sorted, histogram, hull, quantile};

/// Parts of the axis of a distribution function that show their values under the pointer.
const STRIPS: usize = 40;

/// Absent with epistemic inputs: their section has the tables and figures by outer point.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.summary.epistemic.is_some() {
        return None;
    }
    let nominal = view.input.record.nominal.is_some();
    let keys = [Key::new(Mark::Line, "rule quantile", "5 %, 50 %, 95 %")]
        .into_iter()
        .chain(nominal.then(|| Key::new(Mark::Line, "rule nominal", "nominal")));
    let histograms = Shown::ALL.map(|shown| {
        let levels = 0..view.n_levels();
        Block::triples(levels.map(|i| level_histogram(view, shown, i)).collect())
    });
    Some(Section {
        id: "distributions",
        title: "Distributions".to_owned(),
        blocks: [
            view.level_legend([]),
            Block::pairs(Shown::ALL.map(|shown| cdf(view, shown)).to_vec()),
            Block::Heading("Histograms".to_owned()),
            Block::Legend(keys.collect()),
        ]
        .into_iter()
        .chain(histograms)
        .collect(),
    })
}

fn level_histogram(view: &View, shown: Shown, i: usize) -> Figure {
    let sorted = Sorted::finite(view.values(shown, i));
    let bins = histogram(&sorted, 30);
    let nominal = view.nominal(shown, i);
    let edges = bins.iter().flat_map(|b| [b.lower, b.upper]);
    let highest = bins.iter().map(|b| b.count).max().unwrap_or(1);
    let x = match hull(edges.chain(nominal)) {
        Some([low, high]) => {
            let space = 0.04 * (high - low);
            Axis::linear(view.label(shown), low - space, high + space)
        }
        None => Axis::linear(view.label(shown), 0.0, 1.0),
    };
    let y = Axis::linear("Samples", 0.0, 1.08 * highest as f64);
    let mut panel = Panel::new(Size::Small, view.level_name(i), x, y);
    let bars = bins.iter().map(|b| (b.lower, b.upper, b.count as f64));
    panel.bars(&format!("l{i}"), bars);
    for bin in &bins {
        let [from, to] = [bin.lower, bin.upper].map(|value| shown.in_words(value));
        let words = [format!("{from} to {to}"), count(bin.count, "sample")];
        panel.readout_between([bin.lower, bin.upper], &words);
    }
    let quantiles = PROBABILITIES.into_iter();
    for value in quantiles.filter_map(|p| quantile(&sorted, p)) {
        panel.rule("quantile", value);
    }
    if let Some(nominal) = nominal {
        panel.rule("nominal", nominal);
    }
    if bins.is_empty() {
        panel.note("no sample has a solution");
    }
    view.figure(&panel, format!("histogram-{}-{i}", shown.word()), "")
}

/// Empirical distribution functions, all levels in one panel.
fn cdf(view: &View, shown: Shown) -> Figure {
    let x = Axis::around(view.label(shown), view.all_values(shown));
    let y = Axis::linear("Share of samples below", 0.0, 1.0);
    let title = match shown {
        Shown::Frequency => "Distribution of the resonance frequency",
        Shown::AmplitudePerLevel => "Distribution of the amplitude",
    };
    let strips = x.parts(STRIPS);
    let mut panel = Panel::new(Size::Large, title, x, y);
    let mut of_levels = Vec::new();
    for i in 0..view.n_levels() {
        let sorted = Sorted::finite(view.values(shown, i));
        panel.band(
            &format!("outer l{i}"),
            &confidence_band(
                &sorted,
                view.input.outcomes.len(),
                view.input.record.confidence(),
            ),
        );
        let corners = cumulative_steps(&sorted);
        panel.steps(&format!("level l{i}"), &corners, 0.0);
        panel.marks_along(i, &corners);
        of_levels.push(sorted);
    }
    for [from, to] in strips {
        let value = 0.5 * (from + to);
        let below =
            (of_levels.iter().enumerate()).filter(|(_, sorted)| !sorted.values().is_empty());
        let share = |(i, sorted): (usize, &Sorted)| {
            let values = sorted.values();
            let share = values.partition_point(|v| *v <= value) as f64 / values.len() as f64;
            format!("{}: {}", view.level_name(i), percent(share))
        };
        let first = format!("below {}", shown.in_words(value));
        let words: Vec<String> = std::iter::once(first).chain(below.map(share)).collect();
        panel.readout_between([from, to], &words);
    }
    view.note_if_empty(&mut panel);
    let caption = "Filled: 95 % confidence interval at each value (Clopper and Pearson), failed samples on either side.";
    view.figure(&panel, format!("distribution-{}", shown.word()), caption)
}
