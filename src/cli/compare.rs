//! `compare`: arguments and the table on the terminal.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::levels::{INDICATIONS, at_point};
use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::report::compare::{Compared, DesignComparison, Pair, PointRanking};
use microslip::study::{OutputFolder, compare};
use microslip::units::count;

#[derive(Args)]
pub(super) struct CompareArguments {
    /// Folders with the results of `run`, one per design.
    #[arg(num_args = 2.., required = true)]
    folders: Vec<PathBuf>,
    /// Folder of comparison.json and comparison.html.
    #[arg(long, default_value = "comparison")]
    output: PathBuf,
    /// No table.
    #[arg(long)]
    quiet: bool,
}

impl CompareArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let folders: Vec<&Path> = self.folders.iter().map(PathBuf::as_path).collect();
        let output = OutputFolder::open(&self.output)?;
        let comparison = compare(&folders, &output)?;
        if self.quiet {
            return Ok(());
        }
        print(|out| {
            show(out, &comparison)?;
            let path = output.path().display();
            writeln!(out, "comparison.json and comparison.html are in {path}")
        })
    }
}

fn show(out: &mut dyn Write, comparison: &DesignComparison) -> std::io::Result<()> {
    for design in &comparison.designs {
        writeln!(
            out,
            "{}  {} ({})",
            design.label, design.folder, design.study
        )?;
    }
    let (seed, sampling) = (comparison.seed, &comparison.sampling);
    writeln!(out, "common samples: {sampling}, seed {seed}")?;
    if !comparison.design_inputs.is_empty() {
        let names = comparison.design_inputs.join(", ");
        writeln!(
            out,
            "paired at equal probability, as a part of the designs: {names}"
        )?;
    }
    if !comparison.independent {
        writeln!(out, "{INDICATIONS}")?;
    }
    for level in &comparison.levels {
        writeln!(out, "level {} {}", level.level, comparison.level_unit)?;
        for quantity in &level.quantities {
            for pair in &quantity.pairs {
                show_pair(out, comparison, quantity.quantity, pair)?;
            }
            for ranking in &quantity.rankings {
                let tied = quantity.all_tied(ranking.outer);
                show_ranking(out, comparison, ranking, tied)?;
            }
        }
    }
    Ok(())
}

/// Factor and unit in which a difference is shown.
fn shown(quantity: Compared) -> (f64, &'static str) {
    match quantity {
        Compared::FrequencyHz => (1.0, "Hz"),
        Compared::AmplitudeM => (1e6, "um"),
        Compared::FrequencyMargin => (100.0, "%"),
        Compared::ReserveFactor => (1.0, ""),
    }
}

fn show_pair(
    out: &mut dyn Write,
    comparison: &DesignComparison,
    quantity: Compared,
    pair: &Pair,
) -> std::io::Result<()> {
    let (scale, unit) = shown(quantity);
    let [a, b] = [pair.a, pair.b].map(|place| comparison.designs[place].label.as_str());
    let show = |v: f64| format!("{:.4}", v * scale);
    let median = match &pair.comparison.median_difference {
        None => "no pair is solved".to_owned(),
        Some(median) => {
            let space = if unit.is_empty() { "" } else { " " };
            format!(
                "median {} ({}){space}{unit}",
                show(median.estimate),
                median.interval.in_words(" .. ", show),
            )
        }
    };
    let (first, second) = (&pair.comparison.a_better, &pair.comparison.b_better);
    let word = quantity.word();
    let name = format!("{}{}", quantity.name(), at_point(pair.outer));
    let shares = [(a, first), (b, second)].map(|(label, share)| {
        let known = share
            .known
            .map_or_else(|| "-".to_owned(), |k| format!("{:.3}", k.estimate));
        let (lower, upper) = (share.lower, share.upper);
        format!("P({label} {word}) {known} ({lower:.3} .. {upper:.3})")
    });
    write!(
        out,
        "  {name:<20} {a} - {b}: {median}; {}",
        shares.join("; ")
    )?;
    match first.unknown {
        0 => writeln!(out),
        unknown => writeln!(out, "; {} unknown", count(unknown, "pair")),
    }
}

fn show_ranking(
    out: &mut dyn Write,
    comparison: &DesignComparison,
    found: &PointRanking,
    tied: bool,
) -> std::io::Result<()> {
    let ranking = &found.ranking;
    let labels = ranking
        .order
        .iter()
        .map(|&k| comparison.designs[k].label.as_str());
    let order: Vec<&str> = labels.collect();
    let point = at_point(found.outer);
    if tied {
        let all = order.join(" = ");
        return writeln!(
            out,
            "  {:<20} {all}{point}: no order, every pair is equal within its errors",
            ""
        );
    }
    let [least, most] = [ranking.surely, ranking.possibly].map(|share| 100.0 * share);
    let holds = match least < most {
        false => format!("in {least:.1} % of the resamples"),
        true => format!(
            "in {least:.1} % to {most:.1} % of the resamples, by the errors of the results and what unknown samples would have given"
        ),
    };
    writeln!(
        out,
        "  {:<20} {} by the {} % quantile{}: {holds}",
        "",
        order.join(" before "),
        100.0 * found.quantile,
        point,
    )
}
