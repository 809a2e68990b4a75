//! `completions`: what a shell needs to complete commands and options.

use super::Arguments;
use super::terminal::print;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use microslip::Error;

#[derive(Args)]
pub(super) struct CompletionsArguments {
    /// The shell.
    shell: Shell,
}

impl CompletionsArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let mut script = Vec::new();
        generate(
            self.shell,
            &mut Arguments::command(),
            "microslip",
            &mut script,
        );
        print(|out| out.write_all(&script))
    }
}
