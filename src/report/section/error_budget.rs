//! Error budget: what each approximation can change, in one table, so that none hides behind another.

use super::super::block::{Block, Cell, Section, Table};
use super::super::display::{percent, significant};
use super::super::summary::{Distribution, LevelSummary};
use super::super::view::View;
use crate::contact::Events;

pub(super) fn section(view: &View) -> Section {
    let columns: [(&str, &'static [&'static str]); 4] = [
        ("Source of error", &["source"]),
        ("Frequency (Hz)", &["frequency_hz"]),
        ("Amplitude", &["amplitude_relative"]),
        ("How it is known", &["basis"]),
    ];
    let columns = columns.map(|(head, fields)| (head.to_owned(), fields));
    let mut table = Table::new("Largest error of any level", "error-budget", columns);
    for line in lines(view) {
        let unknown = || "not estimated".to_owned();
        let frequency = line.frequency_hz.map_or_else(unknown, significant);
        let amplitude = line.amplitude.map_or_else(unknown, percent);
        table.row(vec![
            Cell::text(line.source).with_class("text strong"),
            Cell::number(frequency, line.frequency_hz),
            Cell::number(amplitude, line.amplitude),
            Cell::text(line.basis).with_class("text"),
        ]);
    }
    Section {
        id: "error-budget",
        title: "Error budget".to_owned(),
        blocks: vec![
            table.block(),
            Block::Hint(
                "The ignorance of the inputs is no error and stands in no line: it is the width of the distributions \
                 themselves and does not shrink with more samples."
                    .to_owned(),
            ),
        ],
    }
}

/// One source of error; a number that nobody estimated is absent, never 0.
struct Line {
    source: &'static str,
    frequency_hz: Option<f64>,
    amplitude: Option<f64>,
    basis: String,
}

fn lines(view: &View) -> Vec<Line> {
    vec![
        sampling(view),
        harmonics(view),
        time_points(view),
        place_of_peak(view),
        precision(view),
        reduction(view),
        Line {
            source: "Surrogate",
            frequency_hz: Some(0.0),
            amplitude: Some(0.0),
            basis: "none is used: the balance equations are solved for every sample".to_owned(),
        },
    ]
}

/// Largest value over the levels; absent if no level has one.
fn largest(view: &View, value: impl Fn(&LevelSummary) -> Option<f64>) -> Option<f64> {
    let values = view.summary.levels.iter().filter_map(value);
    values.filter(|v| v.is_finite()).reduce(f64::max)
}

/// Half the confidence interval of the 95 % quantile; absent where a side is open.
fn half_width(distribution: &Distribution) -> Option<f64> {
    let interval = distribution.quantiles.last()?.valid_only.interval;
    Some(0.5 * (interval.upper? - interval.lower?))
}

fn sampling(view: &View) -> Line {
    let relative = |l: &LevelSummary| {
        let estimate = l.amplitude_m.quantiles.last()?.valid_only.estimate;
        Some(half_width(&l.amplitude_m)? / estimate)
    };
    Line {
        source: "Number of samples",
        frequency_hz: largest(view, |l| half_width(&l.frequency_hz)),
        amplitude: largest(view, relative),
        basis: "half the 95 % confidence interval of the 95 % quantile; shrinks with the root of the number of samples"
            .to_owned(),
    }
}

fn harmonics(view: &View) -> Line {
    let q95 = |l: &LevelSummary| Some(l.truncation_error.quantiles.last()?.valid_only.estimate);
    Line {
        source: "Harmonics left out",
        frequency_hz: None,
        amplitude: largest(view, q95),
        basis: match view.input.record.provenance.truncation_threshold {
            Some(_) => "95 % quantile of the change by one Newton step on a larger harmonic set",
            None => "the error alert is off",
        }
        .to_owned(),
    }
}

fn time_points(view: &View) -> Line {
    let located = view.input.record.provenance.events == Events::Located;
    let zero = located.then_some(0.0);
    Line {
        source: "Time points per period",
        frequency_hz: zero,
        amplitude: zero,
        basis: match located {
            true => "events are located to rounding and the forces between them integrated in closed form",
            false => "events are resolved between samples; compare a run with more time_points",
        }
        .to_owned(),
    }
}

fn place_of_peak(view: &View) -> Line {
    let record = view.input.record;
    let frequency = largest(view, |l| Some(l.frequency_hz.moments?.maximum));
    Line {
        source: "Place of the peak",
        frequency_hz: frequency.map(|f| f * record.frequency_tolerance),
        amplitude: Some(0.0),
        basis: "relative change of the frequency at which the search stops; the amplitude is stationary there".to_owned(),
    }
}

fn precision(view: &View) -> Line {
    Line {
        source: "Precision of the numbers",
        frequency_hz: None,
        amplitude: largest(view, |l| l.worst_work_balance),
        basis: format!(
            "{}; largest |input − viscous − frictional work| over the input work",
            view.input.record.backend
        ),
    }
}

fn reduction(view: &View) -> Line {
    let components = view.input.record.components.iter().map(|c| {
        let next = match c.first_left_out_hz {
            Some(f) => format!("the first one left out is at {f:.0} Hz"),
            None => "none is left out".to_owned(),
        };
        format!("{}: {} modes, {next}", c.name, c.modes)
    });
    let components: Vec<String> = components.collect();
    Line {
        source: "Reduction of the model",
        frequency_hz: None,
        amplitude: None,
        basis: match components.is_empty() {
            true => "the matrices are the user's".to_owned(),
            false => format!(
                "{}; compare a run with higher cut-offs",
                components.join("; ")
            ),
        },
    }
}
