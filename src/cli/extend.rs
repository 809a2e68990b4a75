//! `extend`: more samples for the results of a run.

use std::path::PathBuf;

use super::levels::{show_profile, show_result};
use super::process::Process;
use super::run_control::RunControl;
use super::terminal::{Bar, print};
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
    /// Show at the end where the time went.
    #[arg(long)]
    profile: bool,
    #[command(flatten)]
    pub process: Process,
    #[command(flatten)]
    control: RunControl,
}

impl ExtendArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        self.process.threads.start()?;
        let settings = self
            .control
            .settings(&self.folder, self.process.messages.log)?;
        let bar = Bar::new(&self.process.messages);
        let result = extend(&self.folder, self.samples, &settings, |progress| {
            bar.show(progress);
        })?;
        bar.clear();
        show_result(&result, &self.folder, &self.process.messages)?;
        match self.profile && !self.process.messages.quiet {
            true => print(|out| show_profile(out, &result.profile)),
            false => Ok(()),
        }
    }
}
