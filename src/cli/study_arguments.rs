//! Arguments of the commands on a study file.

use std::path::PathBuf;

use super::log::Messages;
use super::threads::Threads;
use clap::Args;
use microslip::Error;
use microslip::study::{OutputFolder, Study};

#[derive(Args)]
pub(super) struct StudyArguments {
    /// The study file.
    pub study: PathBuf,
    #[command(flatten)]
    pub threads: Threads,
    /// Folder of the results, instead of the study's own.
    #[arg(long)]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub messages: Messages,
}

impl StudyArguments {
    /// The folder of the results: opened before any work, so that an unwritable one costs no computation.
    pub(super) fn output_folder(&self, study: &Study) -> Result<OutputFolder, Error> {
        let own = study.folder().join(&study.output.folder);
        OutputFolder::open(self.output.as_deref().unwrap_or(&own))
    }
}
