//! `merge`: the results of shares that were solved in several folders.

use std::path::{Path, PathBuf};

use super::levels::show_result;
use super::process::Process;
use super::run_control::RunControl;
use super::terminal::Bar;
use clap::Args;
use microslip::Error;
use microslip::study::{OutputFolder, merge};

#[derive(Args)]
pub(super) struct MergeArguments {
    /// Folders with shares of one run.
    #[arg(required = true)]
    folders: Vec<PathBuf>,
    /// Folder of the results.
    #[arg(long)]
    output: PathBuf,
    #[command(flatten)]
    pub process: Process,
    #[command(flatten)]
    control: RunControl,
}

impl MergeArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        self.process.threads.start()?;
        let output = OutputFolder::open(&self.output)?;
        let settings = self
            .control
            .settings(&self.output, self.process.messages.log)?;
        let folders: Vec<&Path> = self.folders.iter().map(PathBuf::as_path).collect();
        let bar = Bar::new(&self.process.messages);
        let result = merge(&folders, &output, &settings, |progress| bar.show(progress))?;
        bar.clear();
        show_result(&result, &self.output, &self.process.messages)
    }
}
