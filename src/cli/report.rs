//! `report`: the report of a run again, from what is stored.

use std::path::PathBuf;

use super::levels::show_levels;
use super::log::Log;
use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::report::render;
use microslip::report::run::CHANGED;
use microslip::study::write_arrow_tables;

#[derive(Args)]
pub(super) struct ReportArguments {
    /// Folder of the results of a run.
    folder: PathBuf,
    /// Write the tables as Arrow files, too: samples.arrow and curves.arrow.
    #[arg(long)]
    arrow: bool,
    /// No summary.
    #[arg(long)]
    quiet: bool,
}

impl ReportArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let (summary, run) = render(&self.folder)?;
        let changed = |name: &String| format!("{}: {CHANGED}", self.folder.join(name).display());
        Log::Text.warn(&run.changed.iter().map(changed).collect::<Vec<_>>());
        if self.arrow {
            write_arrow_tables(&self.folder, |_| true)?;
        }
        if self.quiet {
            return Ok(());
        }
        print(|out| {
            show_levels(out, &summary)?;
            let tables = match self.arrow {
                true => "samples.arrow, curves.arrow, ",
                false => "",
            };
            let path = self.folder.display();
            writeln!(
                out,
                "{tables}summary.json, report.json and report.html are in {path}"
            )
        })
    }
}
