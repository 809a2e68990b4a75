//! `calibration.html`: the inputs before and after, what the calibrated model predicts, and whether the chains agree.

use super::found::{Calibrated, CalibratedInput, Calibration, Checked};
use super::observation::ObservedQuantity;
use crate::page::axis::Axis;
use crate::page::block::{Block, Cell, Figure, Key, Mark, Section, Table};
use crate::page::display::{DASH, from_to, level_name, percent, with_digits};
use crate::page::document::Document;
use crate::page::figure::{Panel, Size};
use crate::page::sheet::{fields, sheet};
use crate::page::style::figure_style;
use libm::exp;

/// Bars of a density.
const BARS: usize = 40;
/// Bars of a rank plot.
const RANKS: usize = 20;
/// Dots of a pair of inputs at most.
const MOST_DOTS: usize = 1000;

/// The page as HTML: one file, no network, no script.
///
/// # Errors
/// [`minijinja::Error`] if the template is broken.
pub fn html(found: &Calibrated) -> Result<String, minijinja::Error> {
    let chains = found.draws.len();
    let style = figure_style(chains.max(found.summary.origin.levels.len()));
    let sections = [
        Some(answer(found, &style)),
        pairs(found, &style),
        Some(predictions(&found.summary, &style)),
        Some(chain_section(found, &style)),
        Some(provenance(&found.summary)),
    ];
    let sections: Vec<Section> = sections.into_iter().flatten().collect();
    Document {
        subject: "Inputs of a study after a measurement",
        title: &found.summary.origin.study,
        n_levels: chains.max(found.summary.origin.levels.len()),
        sections: &sections,
    }
    .html()
}

fn show(value: f64) -> String {
    with_digits(value, 4)
}

/// Values of input `j` in all draws.
fn column(found: &Calibrated, j: usize) -> Vec<f64> {
    found
        .draws
        .iter()
        .flatten()
        .map(|values| values[j])
        .collect()
}

fn answer(found: &Calibrated, style: &str) -> Section {
    let summary = &found.summary;
    let mut table = Table::of(
        "Inputs before and after the measurement",
        "inputs",
        &[
            ("Input", &["input"]),
            (
                "Before",
                &["prior_median", "prior_2.5_percent", "prior_97.5_percent"],
            ),
            ("After", &["median", "2.5_percent", "97.5_percent"]),
            ("Beyond the prior's middle", &["beyond_prior"]),
        ],
    );
    for input in &summary.inputs {
        let of = |q: &super::found::Quantiles| {
            Cell::number(show(q.q50), Some(q.q50))
                .with_raw([q.q025, q.q975].map(Some))
                .with_small(from_to([q.q025, q.q975], show))
        };
        table.row(vec![
            Cell::text(&input.name).with_class("text brief"),
            of(&input.prior),
            of(&input.posterior),
            Cell::number(percent(input.beyond_prior), Some(input.beyond_prior)),
        ]);
    }
    let mut blocks = Vec::new();
    if !summary.warnings.is_empty() {
        blocks.push(Block::Notices(summary.warnings.clone()));
    }
    let p = summary.misfit_probability;
    blocks.push(Block::Sentence(format!(
        "A repetition of the whole measurement would lie as far from the calibrated model as this one with a probability of {}.",
        percent(p)
    )));
    blocks.push(table.block());
    blocks.push(Block::Hint(
        "Medians with 95 % intervals. Beyond the prior's middle: share of the posterior below the 2 % or above the 98 % quantile of the \
         prior, 4 % where nothing was learnt."
            .to_owned(),
    ));
    blocks.push(Block::Legend(vec![
        Key::new(Mark::Line, "nominal", "before"),
        Key::new(Mark::Band, "l0", "after"),
    ]));
    let inputs = summary.inputs.iter().enumerate();
    let figures = inputs.map(|(j, input)| density(input, column(found, j), style));
    blocks.push(Block::triples(figures.collect()));
    Section {
        id: "answer",
        title: "Answer".to_owned(),
        blocks,
    }
}

/// Density of an input before (line) and after (bars).
fn density(input: &CalibratedInput, values: Vec<f64>, style: &str) -> Figure {
    let (before, after) = (input.prior, input.posterior);
    let low = before.q025.min(after.q025);
    let high = before.q975.max(after.q975);
    let space = 0.05 * (high - low);
    let [low, high] = [low - space, high + space];
    let width = (high - low) / BARS as f64;
    let mut counts = vec![0.0; BARS];
    for value in &values {
        let bar = (value - low) / width;
        if (0.0..BARS as f64).contains(&bar) {
            counts[bar as usize] += 1.0;
        }
    }
    let heights: Vec<f64> = (counts.iter())
        .map(|count| count / (values.len() as f64 * width))
        .collect();
    let law = &input.law;
    let line = (0..=4 * BARS).map(|k| low + 0.25 * width * k as f64);
    let line: Vec<(f64, f64)> = line.map(|x| (x, law.density(x).unwrap_or(0.0))).collect();
    let most = heights.iter().copied().chain(line.iter().map(|p| p.1));
    let most = most.filter(|v| v.is_finite()).fold(0.0, f64::max);
    let x = Axis::linear(input.name.clone(), low, high);
    let y = Axis::linear("density", 0.0, 1.05 * most);
    let mut panel = Panel::new(Size::Small, input.name.clone(), x, y);
    let bars = heights.iter().enumerate();
    panel.bars(
        "l0",
        bars.map(|(k, h)| (low + width * k as f64, low + width * (k + 1) as f64, *h)),
    );
    panel.line("nominal", line.into_iter());
    Figure::new(
        &panel,
        style,
        format!("density_{}", input.name),
        String::new(),
    )
}

/// Draws of two inputs each; none with one input.
fn pairs(found: &Calibrated, style: &str) -> Option<Section> {
    let inputs = &found.summary.inputs;
    let columns: Vec<Vec<f64>> = (0..inputs.len()).map(|j| column(found, j)).collect();
    let mut figures = Vec::new();
    for a in 0..inputs.len() {
        for b in 0..a {
            let (x, y) = (&columns[b], &columns[a]);
            let axis = |j: usize| Axis::around(inputs[j].name.clone(), columns[j].iter().copied());
            let title = "Draws of the posterior";
            let mut panel = Panel::new(Size::Small, title, axis(b), axis(a));
            let step = x.len().div_ceil(MOST_DOTS).max(1);
            let dots = x.iter().copied().zip(y.iter().copied());
            panel.dots(0, dots.step_by(step));
            let rank = found.summary.rank_correlation[a][b];
            let caption = format!("Rank correlation {}.", with_digits(rank, 2));
            let file = format!("pair_{}_{}", inputs[b].name, inputs[a].name);
            figures.push(Figure::new(&panel, style, file, caption));
        }
    }
    (!figures.is_empty()).then(|| Section {
        id: "pairs",
        title: "Inputs together".to_owned(),
        blocks: vec![
            Block::triples(figures),
            Block::Hint("Draws of the posterior.".to_owned()),
        ],
    })
}

/// A number in the unit of the page: Hz, µm.
fn shown(quantity: ObservedQuantity, value: f64) -> f64 {
    match quantity {
        ObservedQuantity::Frequency => value,
        ObservedQuantity::LogAmplitude => 1e6 * exp(value),
    }
}

/// What the model predicts of each observation before and after.
fn predictions(summary: &Calibration, style: &str) -> Section {
    let mut figures = Vec::new();
    for (quantity, name) in [
        (ObservedQuantity::Frequency, "Resonance frequency (Hz)"),
        (ObservedQuantity::LogAmplitude, "Amplitude (µm)"),
    ] {
        let of = summary.observations.iter();
        let of: Vec<&Checked> = of.filter(|o| o.measured.quantity == quantity).collect();
        for (k, one) in of.iter().enumerate() {
            let ends =
                |q: &super::found::Quantiles| [q.q025, q.q50, q.q975].map(|v| shown(quantity, v));
            let (before, after) = (ends(&one.prior), ends(&one.posterior));
            let measured = shown(quantity, one.measured.mean);
            let values = before.iter().chain(&after).copied().chain([measured]);
            let level = level_name(summary.origin.levels[one.measured.level], "");
            let lines = ["before", "after", "measured"].map(str::to_owned).to_vec();
            let x = Axis::around(name, values);
            let title = format!("{name}, level {level}");
            let mut panel = Panel::new(Size::Rows(3), title, x, Axis::of_names(lines));
            panel.level_whisker("plain", 0.0, [before[0], before[2]]);
            panel.level_whisker("l0", -1.0, [after[0], after[2]]);
            panel.rule("nominal", measured);
            panel.ring("l0", (after[1], -1.0));
            let caption = format!(
                "Probability of a smaller mean: {} before, {} after.",
                percent(one.below_by_prior),
                percent(one.below_by_posterior)
            );
            let file = format!("prediction_{}_{k}", quantity as usize);
            figures.push(Figure::new(&panel, style, file, caption));
        }
    }
    Section {
        id: "predictions",
        title: "What the model predicts of the measurement".to_owned(),
        blocks: vec![
            Block::pairs(figures),
            Block::Hint(
                "95 % intervals of the model's answer, before from the prior and after from the posterior; the line is the measured mean. \
                 The errors of measurement and surrogate are in the probabilities, not in the intervals."
                    .to_owned(),
            ),
            surrogate_table(summary),
        ],
    }
}

fn surrogate_table(summary: &Calibration) -> Block {
    let mut table = Table::of(
        "Surrogates: their errors where they shaped nothing, and at the posterior by the solver",
        "surrogates",
        &[
            ("Level", &["level"]),
            ("Quantity", &["quantity"]),
            ("Held out", &["held_out_rms"]),
            ("In the likelihood", &["deviation"]),
            ("At the posterior", &["at_posterior_rms"]),
        ],
    );
    for one in &summary.observations {
        let quantity = match one.measured.quantity {
            ObservedQuantity::Frequency => "frequency (Hz)",
            ObservedQuantity::LogAmplitude => "amplitude (relative)",
        };
        let level = summary.origin.levels[one.measured.level];
        let error = one.error_at_posterior;
        table.row(vec![
            Cell::number(level_name(level, ""), Some(level)),
            Cell::text(quantity).with_class("text brief"),
            Cell::number(with_digits(one.held_out.rms, 2), Some(one.held_out.rms)),
            Cell::number(
                with_digits(one.surrogate_deviation, 2),
                Some(one.surrogate_deviation),
            ),
            Cell::number(error.map_or(DASH.to_owned(), |e| with_digits(e, 2)), error),
        ]);
    }
    table.block()
}

/// Rank plots and diagnostics.
fn chain_section(found: &Calibrated, style: &str) -> Section {
    let mut table = Table::of(
        "Chains",
        "chains",
        &[
            ("Input", &["input"]),
            ("R-hat", &["r_hat"]),
            ("Effective draws, bulk", &["bulk_effective"]),
            ("Effective draws, tails", &["tail_effective"]),
        ],
    );
    for input in &found.summary.inputs {
        let mixing = input.mixing;
        let number = |value: Option<f64>, digits: i32| {
            Cell::number(
                value.map_or(DASH.to_owned(), |v| with_digits(v, digits)),
                value,
            )
        };
        table.row(vec![
            Cell::text(&input.name).with_class("text brief"),
            number(mixing.map(|m| m.r_hat), 4),
            number(mixing.map(|m| m.bulk_effective), 3),
            number(mixing.map(|m| m.tail_effective), 3),
        ]);
    }
    let inputs = found.summary.inputs.iter().enumerate();
    let figures = inputs.map(|(j, input)| rank_plot(found, j, &input.name, style));
    Section {
        id: "chains",
        title: "Whether the chains agree".to_owned(),
        blocks: vec![
            table.block(),
            Block::triples(figures.collect()),
            Block::Hint(
                "Ranks of the draws of each chain among those of all: even lines where the chains agree. R-hat should be at most 1.01, \
                 effective draws 400 or more."
                    .to_owned(),
            ),
        ],
    }
}

fn rank_plot(found: &Calibrated, j: usize, name: &str, style: &str) -> Figure {
    let values: Vec<Vec<f64>> = (found.draws.iter())
        .map(|chain| chain.iter().map(|draw| draw[j]).collect())
        .collect();
    let mut all: Vec<f64> = values.concat();
    all.sort_by(f64::total_cmp);
    let share = 1.0 / RANKS as f64;
    let counts: Vec<Vec<f64>> = (values.iter())
        .map(|chain| {
            let mut counts = vec![0.0; RANKS];
            for value in chain {
                let rank = all.partition_point(|other| other < value);
                counts[(rank * RANKS / all.len()).min(RANKS - 1)] +=
                    RANKS as f64 / chain.len() as f64;
            }
            counts
        })
        .collect();
    let most = counts.iter().flatten().copied().fold(1.0, f64::max);
    let x = Axis::linear("rank over all draws", 0.0, 1.0);
    let y = Axis::linear("share over the even one", 0.0, 1.1 * most);
    let mut panel = Panel::new(Size::Small, name, x, y);
    for (chain, counts) in counts.iter().enumerate() {
        let points = counts.iter().enumerate();
        let points = points.map(|(k, count)| ((k as f64 + 0.5) * share, *count));
        panel.line(&format!("l{chain}"), points);
    }
    Figure::new(&panel, style, format!("ranks_{name}"), String::new())
}

fn provenance(summary: &Calibration) -> Section {
    let mut rows = fields(&summary.origin);
    rows.extend(fields(&summary.settings));
    Section {
        id: "provenance",
        title: "Provenance".to_owned(),
        blocks: vec![sheet(
            "Where this calibration comes from",
            "provenance",
            rows,
        )],
    }
}
