//! `export`: the model of a study as matrices.

use std::path::PathBuf;

use super::log::Log;
use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::study::{Study, export};

#[derive(Args)]
pub(super) struct ExportArguments {
    /// The study file.
    study: PathBuf,
    /// Folder that is written: matrices, names and study.toml. It must not exist or be empty.
    #[arg(long)]
    output: PathBuf,
    /// No summary.
    #[arg(long)]
    quiet: bool,
}

impl ExportArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let study = Study::read(&self.study)?;
        let exported = export(&study, &self.output)?;
        Log::default().warn(&study.warnings);
        Log::default().warn(&exported.warnings);
        if self.quiet {
            return Ok(());
        }
        print(|out| {
            writeln!(out, "degrees of freedom  {}", exported.dofs)?;
            writeln!(out, "contact pairs       {}", exported.contacts)?;
            writeln!(out, "study.toml is in {}", self.output.display())
        })
    }
}
