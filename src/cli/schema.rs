//! `schema`: the JSON Schema of the study file, or its keys as a page.

use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::study::{key_reference, schema};

#[derive(Args)]
pub(super) struct SchemaArguments {
    /// Print its keys as Markdown tables instead.
    #[arg(long)]
    markdown: bool,
}

impl SchemaArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        print(|out| match self.markdown {
            true => write!(out, "{}", key_reference()),
            false => {
                serde_json::to_writer_pretty(&mut *out, &schema())?;
                writeln!(out)
            }
        })
    }
}
