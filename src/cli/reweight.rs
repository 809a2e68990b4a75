//! `reweight`: arguments and the table on the terminal.

use std::io::Write;
use std::path::PathBuf;

use super::levels::{INDICATIONS, at_point};
use super::terminal::print;
use clap::{ArgGroup, Args};
use microslip::Error;
use microslip::file::refuse_inputs;
use microslip::report::reweighting::{ReweightedPoint, Reweighting};
use microslip::study::reweight::REWEIGHTED;
use microslip::study::{NewInputs, OutputFolder, reweight};

#[derive(Args)]
#[command(group = ArgGroup::new("new inputs").required(true).args(["prior", "posterior"]))]
pub(super) struct ReweightArguments {
    /// Folder with the results of `run`.
    folder: PathBuf,
    /// TOML file with the new distributions, as [inputs.NAME] of a study file.
    #[arg(long, value_name = "FILE")]
    prior: Option<PathBuf>,
    /// Draws of the inputs, such as posterior.csv of `calibrate`: the samples stand for them.
    #[arg(long, value_name = "FILE")]
    posterior: Option<PathBuf>,
    /// Folder of reweighted.json, instead of that of the results.
    #[arg(long)]
    output: Option<PathBuf>,
    /// No table.
    #[arg(long)]
    quiet: bool,
}

impl ReweightArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let folder = self.output.as_ref().unwrap_or(&self.folder);
        let read = [&self.prior, &self.posterior].map(Clone::clone);
        let read: Vec<PathBuf> = read.into_iter().flatten().collect();
        refuse_inputs([folder.join(REWEIGHTED)], &read)?;
        let output = OutputFolder::open(folder)?;
        // one of the two is there: the arguments say so
        let prior = self.prior.clone().unwrap_or_default();
        let draws = self.posterior.clone().map(NewInputs::Draws);
        let new = draws.unwrap_or(NewInputs::Distributions(prior));
        let found = reweight(&self.folder, &new, &output)?;
        if self.quiet {
            return Ok(());
        }
        print(|out| {
            show(out, &found)?;
            writeln!(out, "reweighted.json is in {}", output.path().display())
        })
    }
}

fn show(out: &mut dyn Write, found: &Reweighting) -> std::io::Result<()> {
    for input in &found.inputs {
        writeln!(
            out,
            "{}: {} (sampled: {})",
            input.name, input.reweighted, input.sampled
        )?;
    }
    for point in &found.weights {
        let (samples, effective) = (point.samples, point.effective_samples);
        writeln!(
            out,
            "{samples} samples count for {effective:.1}{}",
            at_point(point.outer)
        )?;
    }
    if !found.independent {
        writeln!(out, "{INDICATIONS}")?;
    }
    for level in &found.levels {
        for point in &level.points {
            let (value, unit) = (level.level, &found.level_unit);
            writeln!(out, "level {value} {unit}{}", at_point(point.outer))?;
            show_point(out, point)?;
        }
    }
    Ok(())
}

/// Under the new distributions, then as sampled.
fn show_point(out: &mut dyn Write, point: &ReweightedPoint) -> std::io::Result<()> {
    let quantities: [(_, _, &dyn Fn(f64) -> String); 2] = [
        (&point.frequency_hz, "Hz", &|v| format!("{v:.3}")),
        (&point.amplitude_m, "m", &|v| format!("{v:.4e}")),
    ];
    for (quantiles, unit, show) in quantities {
        for quantile in quantiles {
            let (new, old) = (quantile.reweighted, quantile.sampled);
            writeln!(
                out,
                "  {:.0} %: {} ({}) {unit}; as sampled {} ({})",
                100.0 * new.probability,
                show(new.estimate),
                new.interval.in_words(" .. ", show),
                show(old.estimate),
                old.interval.in_words(" .. ", show),
            )?;
        }
    }
    for exceedance in &point.exceedances {
        let (new, old) = (exceedance.reweighted, exceedance.sampled.probability);
        let known =
            |estimate: Option<f64>| estimate.map_or_else(|| "-".to_owned(), |p| format!("{p:.3}"));
        writeln!(
            out,
            "  P(amplitude > {:.4e} m): {} ({:.3} .. {:.3}); as sampled {} ({:.3} .. {:.3})",
            new.threshold,
            known(new.estimate),
            new.lower,
            new.upper,
            known(old.known.map(|k| k.estimate)),
            old.lower,
            old.upper,
        )?;
    }
    Ok(())
}
