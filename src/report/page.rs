//! The page: words and tables around the figures.

use super::display::{DASH, duration, hertz, percent, short, significant, with_digits};
use super::figure::level_colour;
use super::figures::{Captioned, Figures};
use super::summary::{Distribution, LevelSummary, Summary};
use super::{ReportError, ReportInput};
use crate::hb::Status;
use crate::statistics::{Interval, Limit, QuantileEstimate};
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};

/// One cell of an envelope table.
#[derive(serde::Serialize)]
struct Cell {
    value: String,
    interval: String,
    bounds: Option<String>,
}

/// One level of an envelope table.
#[derive(serde::Serialize)]
struct EnvelopeRow {
    level: String,
    colour: usize,
    nominal: String,
    cells: Vec<Cell>,
    mean: String,
}

/// A table of one quantity over all levels.
#[derive(serde::Serialize)]
struct Envelope {
    title: String,
    rows: Vec<EnvelopeRow>,
}

/// Renders the page.
pub(super) fn render(input: &ReportInput, summary: &Summary) -> Result<String, ReportError> {
    let figures = Figures::new(input, summary);
    let mut environment = Environment::new();
    // The name ends in .html, which switches escaping on.
    environment.add_template("report.html", include_str!("report.html.j2"))?;
    let template = environment.get_template("report.html")?;
    let n_levels = summary.levels.len();
    let colours: Vec<String> = (0..n_levels).map(|i| level_colour(i, n_levels)).collect();
    let level_names: Vec<String> = (0..n_levels).map(|i| figures.level_name(i)).collect();
    let page = template.render(context! {
        style => safe(include_str!("style.css")),
        colours,
        level_names => &level_names,
        study => &summary.provenance.study,
        facts => facts(summary),
        notices => notices(summary, &level_names),
        nominal_responses => figures.nominal_responses().map(safe),
        cloud => safe(figures.cloud()),
        bands => captioned(figures.bands()),
        envelopes => Serde(envelopes(&figures, summary, &level_names)),
        histograms => figures.histograms().map(safe_all).to_vec(),
        distributions => safe_all(figures.distributions()),
        inputs => safe_all(figures.input_scatter()),
        correlations => correlations(summary),
        statuses => statuses(summary),
        failure_rows => failure_rates(summary),
        failures => figures.failures().map(safe),
        truncation => figures.truncation().map(safe),
        truncation_rows => truncation_rows(summary, &level_names),
        contact_rows => contact_rows(summary, &level_names),
        work_rows => work_rows(summary, &level_names),
        provenance => provenance(summary),
        has_nominal => input.nominal.is_some(),
    })?;
    Ok(page)
}

fn safe(text: impl Into<String>) -> Value {
    Value::from_safe_string(text.into())
}

fn safe_all(texts: Vec<String>) -> Vec<Value> {
    texts.into_iter().map(safe).collect()
}

fn captioned(figures: Vec<Captioned>) -> Vec<Value> {
    let figure = |f: Captioned| context! { svg => safe(f.svg), caption => f.caption };
    figures.into_iter().map(figure).collect()
}

fn pair(name: &str, value: String) -> (String, String) {
    (name.to_owned(), value)
}

/// The GPU's part, and what its audit found.
fn device(summary: &Summary) -> Vec<(String, String)> {
    let Some(gpu) = &summary.backend.gpu else {
        return Vec::new();
    };
    let audit = format!(
        "{} of {} evaluations repeated in double precision; largest difference {:.1e} of a force, {:.1e} of a derivative",
        gpu.audited,
        gpu.evaluations,
        gpu.largest_force_difference,
        gpu.largest_derivative_difference
    );
    let taken_over = gpu.fallbacks + gpu.beyond_limit;
    let mut rows = vec![
        pair("contacts drafted by", gpu.adapter.name.clone()),
        pair("audit", audit),
    ];
    if taken_over > 0 {
        rows.push(pair("taken over by the processor", taken_over.to_string()));
    }
    rows
}

fn facts(summary: &Summary) -> Vec<(String, String)> {
    let solves = summary.samples * summary.levels.len();
    let failed: usize = summary.levels.iter().map(|l| l.failed).sum();
    vec![
        pair("samples", summary.samples.to_string()),
        pair("solutions", format!("{} of {solves}", solves - failed)),
        pair(
            "free resonance",
            format!("{} Hz", hertz(summary.free_frequency_hz)),
        ),
        pair(
            "fully stuck",
            format!("{} Hz", hertz(summary.stuck_frequency_hz)),
        ),
        pair("wall time", duration(summary.wall_time_s)),
    ]
    .into_iter()
    .chain(device(summary))
    .collect()
}

/// What must be known before any number of the report is used.
fn notices(summary: &Summary, level_names: &[String]) -> Vec<String> {
    let mut notices = Vec::new();
    let solves = summary.samples * summary.levels.len();
    for status in Status::ALL.into_iter().filter(|&s| s != Status::Converged) {
        let counts: Vec<usize> = summary
            .levels
            .iter()
            .map(|l| l.statuses[status.name()])
            .collect();
        let total: usize = counts.iter().sum();
        if total == 0 {
            continue;
        }
        let worst = counts
            .iter()
            .enumerate()
            .max_by_key(|(i, count)| (**count, usize::MAX - i));
        let most = worst.map_or(String::new(), |(i, count)| {
            format!("; most at {} ({count})", level_names[i])
        });
        let share = percent(total as f64 / solves as f64);
        notices.push(format!(
            "{total} of {solves} solves ({share}) ended as {}: {}{most}.",
            status.name(),
            status.explanation()
        ));
    }
    for (level, name) in summary.levels.iter().zip(level_names) {
        if level.frequency_hz.valid == 0 {
            notices.push(format!("No sample has a solution at {name}."));
        }
    }
    notices
}

fn envelopes(figures: &Figures, summary: &Summary, names: &[String]) -> Vec<Envelope> {
    let scale = figures.unit.per_metre;
    let envelope = |title: String,
                    distribution: &dyn Fn(&LevelSummary) -> &Distribution,
                    nominal: &dyn Fn(&LevelSummary) -> Option<f64>,
                    unit: f64,
                    show: &dyn Fn(f64) -> String| {
        let levels = summary.levels.iter().enumerate();
        let rows = levels.map(|(i, level)| EnvelopeRow {
            level: names[i].clone(),
            colour: i,
            nominal: nominal(level).map_or_else(|| DASH.to_owned(), show),
            cells: cells(distribution(level), level.failed, show),
            mean: mean(distribution(level), show, unit),
        });
        Envelope {
            title,
            rows: rows.collect(),
        }
    };
    vec![
        envelope(
            "Resonance frequency (Hz)".to_owned(),
            &|l| &l.frequency_hz,
            &|l| Some(l.nominal?.frequency_hz),
            1.0,
            &hertz,
        ),
        envelope(
            format!("Amplitude per excitation ({})", figures.amplitude_unit()),
            &|l| &l.amplitude_per_unit_level_m,
            &|l| Some(l.nominal?.amplitude_m / l.level),
            scale,
            &|v| significant(v * scale),
        ),
        envelope(
            format!("Amplitude ({})", figures.unit.symbol),
            &|l| &l.amplitude_m,
            &|l| Some(l.nominal?.amplitude_m),
            scale,
            &|v| significant(v * scale),
        ),
    ]
}

fn cells(distribution: &Distribution, failed: usize, show: &dyn Fn(f64) -> String) -> Vec<Cell> {
    let limits = |interval: Interval| {
        let side = |limit: Limit| limit.value().map_or_else(|| "open".to_owned(), show);
        format!("{} … {}", side(interval.lower), side(interval.upper))
    };
    let cell = |q: &QuantileEstimate| Cell {
        value: show(q.estimate),
        interval: limits(q.interval),
        bounds: (failed > 0).then(|| limits(q.failure_bounds)),
    };
    let mut cells: Vec<Cell> = distribution.quantiles.iter().map(cell).collect();
    cells.resize_with(super::summary::PROBABILITIES.len(), || Cell {
        value: DASH.to_owned(),
        interval: String::new(),
        bounds: None,
    });
    cells
}

/// Mean ± standard deviation, the latter with three digits in `unit` per SI unit.
fn mean(distribution: &Distribution, show: &dyn Fn(f64) -> String, unit: f64) -> String {
    match distribution.moments {
        None => DASH.to_owned(),
        Some(m) => match m.standard_deviation {
            None => show(m.mean),
            Some(deviation) => {
                format!("{} ± {}", show(m.mean), with_digits(deviation * unit, 3))
            }
        },
    }
}

/// Rows input, columns level; each cell with its strength for the shade behind it.
fn correlations(summary: &Summary) -> Vec<Value> {
    let table = |title: &str, value: fn(&super::summary::InputCorrelation) -> Option<f64>| {
        let rows = summary.inputs.iter().enumerate().map(|(j, name)| {
            let cell = |level: &LevelSummary| {
                let rho = level.rank_correlations.get(j).and_then(value);
                let text = rho.map_or_else(
                    || DASH.to_owned(),
                    |r| super::display::minus_sign(&format!("{r:+.2}")),
                );
                let strength = rho.map_or(0.0, |r| (r.abs() * 60.0).round());
                context! { text, strength, sign => if rho < Some(0.0) { "negative" } else { "positive" } }
            };
            context! { name, cells => summary.levels.iter().map(cell).collect::<Vec<_>>() }
        });
        context! { title, rows => rows.collect::<Vec<_>>() }
    };
    vec![
        table("Resonance frequency", |c| c.frequency),
        table("Amplitude", |c| c.amplitude),
    ]
}

fn statuses(summary: &Summary) -> Vec<Value> {
    let row = |status: Status| {
        let counts: Vec<usize> = summary
            .levels
            .iter()
            .map(|l| l.statuses[status.name()])
            .collect();
        context! {
            name => status.name(),
            explanation => status.explanation(),
            total => counts.iter().sum::<usize>(),
            solution => status.has_solution(),
            counts,
        }
    };
    Status::ALL.into_iter().map(row).collect()
}

/// Failure rate per level with its limits.
fn failure_rates(summary: &Summary) -> Vec<[String; 3]> {
    let rate = |level: &LevelSummary| match level.failure_rate {
        None => [DASH; 3].map(str::to_owned),
        Some(r) => [r.estimate, r.lower, r.upper].map(percent),
    };
    summary.levels.iter().map(rate).collect()
}

fn truncation_rows(summary: &Summary, names: &[String]) -> Vec<Vec<String>> {
    let row = |(level, name): (&LevelSummary, &String)| {
        let quantiles = &level.truncation_error.quantiles;
        let error = |i: usize| {
            quantiles
                .get(i)
                .map_or_else(|| DASH.to_owned(), |q| percent(q.estimate))
        };
        let largest = level.truncation_error.moments;
        let harmonics = level.highest_harmonics.iter();
        let used: Vec<String> = harmonics.map(|(h, n)| format!("{h} ({n})")).collect();
        vec![
            name.clone(),
            error(1),
            error(2),
            largest.map_or_else(|| DASH.to_owned(), |m| percent(m.maximum)),
            if used.is_empty() {
                DASH.to_owned()
            } else {
                used.join(", ")
            },
        ]
    };
    summary.levels.iter().zip(names).map(row).collect()
}

fn contact_rows(summary: &Summary, names: &[String]) -> Vec<Vec<String>> {
    let row = |(level, name): (&LevelSummary, &String)| {
        let fractions = level.mean_contact_fractions;
        let share = |value: Option<f64>| value.map_or_else(|| DASH.to_owned(), percent);
        vec![
            name.clone(),
            share(fractions.map(|f| f.stick)),
            share(fractions.map(|f| f.slip)),
            share(fractions.map(|f| f.separated)),
        ]
    };
    summary.levels.iter().zip(names).map(row).collect()
}

fn work_rows(summary: &Summary, names: &[String]) -> Vec<Vec<String>> {
    let row = |(level, name): (&LevelSummary, &String)| {
        let count = |value: Option<f64>| value.map_or_else(|| DASH.to_owned(), short);
        let balance = level.worst_work_balance;
        vec![
            name.clone(),
            count(level.newton_iterations.median),
            count(level.newton_iterations.q95),
            count(level.factorizations.median),
            count(level.factorizations.q95),
            balance.map_or_else(|| DASH.to_owned(), significant),
        ]
    };
    summary.levels.iter().zip(names).map(row).collect()
}

/// The provenance as rows, in the words of its own field names.
fn provenance(summary: &Summary) -> Vec<(String, String)> {
    let p = &summary.provenance;
    let absent = || "not used".to_owned();
    vec![
        pair("Study", p.study.clone()),
        pair("Model", p.model.clone()),
        pair("Program", format!("microslip {}", p.version)),
        pair("Seed", p.seed.to_string()),
        pair("Inputs", summary.inputs.join(", ")),
        pair("Friction law", word(p.law)),
        pair("Slider anchor", word(p.anchor)),
        pair("Events between samples", word(p.events)),
        pair("Harmonics", list(&p.harmonics)),
        pair("Time points per period", p.time_points.to_string()),
        pair(
            "Contacts solved",
            if p.folded {
                "half, the mirror gives the other"
            } else {
                "all"
            }
            .to_owned(),
        ),
        pair(
            "Truncation threshold",
            p.truncation_threshold.map_or_else(absent, percent),
        ),
        pair(
            "Highest harmonic allowed",
            p.highest_harmonic.map_or_else(absent, |h| h.to_string()),
        ),
    ]
}

/// The name that an enum has in files.
fn word(value: impl serde::Serialize) -> String {
    Value::from(Serde(value)).to_string()
}

fn list(numbers: &[usize]) -> String {
    let texts: Vec<String> = numbers.iter().map(usize::to_string).collect();
    texts.join(", ")
}
