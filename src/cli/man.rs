//! `man`: a manual page for each command.

use std::path::PathBuf;

use super::Arguments;
use clap::{Args, CommandFactory};
use clap_mangen::generate_to;
use microslip::Error;
use microslip::study::OutputFolder;

#[derive(Args)]
pub(super) struct ManArguments {
    /// Folder of the pages.
    folder: PathBuf,
}

impl ManArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let folder = OutputFolder::open(&self.folder)?;
        generate_to(Arguments::command(), folder.path())
            .map_err(|source| Error::file(folder.path(), source))
    }
}
