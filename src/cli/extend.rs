//! `extend`: more samples for the results of a run.

use std::path::PathBuf;

use super::levels::show_result;
use super::terminal::Bar;
use super::threads::Threads;
use clap::Args;
use microslip::Error;
use microslip::study::extend;

#[derive(Args)]
pub(super) struct ExtendArguments {
    /// Folder with the results of `run`.
    folder: PathBuf,
    /// Number of samples in all.
    #[arg(long)]
    samples: u64,
    #[command(flatten)]
    threads: Threads,
    /// No progress and no summary.
    #[arg(long)]
    quiet: bool,
}

impl ExtendArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        self.threads.start()?;
        let bar = Bar::new(self.quiet);
        let result = extend(&self.folder, self.samples, |progress| bar.show(progress))?;
        bar.clear();
        if self.quiet {
            return Ok(());
        }
        show_result(&result, &self.folder)
    }
}
