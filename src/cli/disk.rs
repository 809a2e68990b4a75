//! `disk`: arguments and the table on the terminal.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::report::disk::DiskSummary;
use microslip::study::{OutputFolder, disk};

#[derive(Args)]
pub(super) struct DiskArguments {
    /// Folders with the results of `run`, one per engine order.
    #[arg(num_args = 1.., required = true)]
    folders: Vec<PathBuf>,
    /// Folder of disk.json and disk.html.
    #[arg(long, default_value = "disk")]
    output: PathBuf,
    /// No table.
    #[arg(long)]
    quiet: bool,
}

impl DiskArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let folders: Vec<&Path> = self.folders.iter().map(PathBuf::as_path).collect();
        let output = OutputFolder::open(&self.output)?;
        gather(&folders, &output, self.quiet)
    }
}

/// Writes what the results in `folders` say together, and shows it.
pub(super) fn gather(folders: &[&Path], output: &OutputFolder, quiet: bool) -> Result<(), Error> {
    let summary = disk(folders, output)?;
    if quiet {
        return Ok(());
    }
    print(|out| {
        show(out, &summary)?;
        let path = output.path().display();
        writeln!(out, "disk.json and disk.html are in {path}")
    })
}

fn show(out: &mut dyn Write, disk: &DiskSummary) -> std::io::Result<()> {
    writeln!(out, "disk of {} sectors", disk.sectors)?;
    for order in &disk.orders {
        writeln!(
            out,
            "engine order {}, nodal diameter {}",
            order.engine_order, order.nodal_diameter
        )?;
        for level in &order.levels {
            let words = |bar: Option<[f64; 3]>, scale: f64, digits: usize| match bar {
                None => "-".to_owned(),
                Some(values) => values.map(|v| format!("{:.digits$}", v * scale)).join(" "),
            };
            let frequency = words(level.frequency_hz, 1.0, 2);
            let amplitude = words(level.amplitude_m, 1e6, 3);
            writeln!(
                out,
                "  {} {}: {frequency} Hz, {amplitude} um (1, 50, 99 %), {} failed, {} of {} assessed peaks unstable, {}",
                level.level,
                disk.level_unit,
                level.failed,
                level.stability.unstable,
                level.stability.assessed,
                level.several_answers.in_words()
            )?;
        }
        for result in &order.criteria {
            writeln!(
                out,
                "  {}: {}",
                result.criterion.name,
                order.sentence(result)
            )?;
        }
    }
    Ok(())
}
