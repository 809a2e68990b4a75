//! `schema`: the JSON Schema of the study file or of a result file, or the keys of the study file as a page.

use super::terminal::print;
use clap::{Args, ValueEnum};
use microslip::Error;
use microslip::calibrate;
use microslip::study::{OutputFile, key_reference, output_schema, schema};

#[derive(Args)]
pub(super) struct SchemaArguments {
    /// File whose schema is printed.
    #[arg(long, value_enum, value_name = "FILE", default_value_t = Described::Study)]
    of: Described,
    /// Print the keys of the study file as Markdown tables instead.
    #[arg(long, conflicts_with = "of")]
    markdown: bool,
}

/// A file with a schema.
#[derive(Clone, Copy, ValueEnum)]
enum Described {
    /// The study file.
    Study,
    /// `summary.json`.
    Summary,
    /// `report.json`.
    Report,
    /// `solution.json`.
    Solution,
    /// `calibration.json`.
    Calibration,
}

impl SchemaArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let schema = match self.of {
            Described::Study => schema(),
            Described::Summary => output_schema(OutputFile::Summary),
            Described::Report => output_schema(OutputFile::Report),
            Described::Solution => output_schema(OutputFile::Solution),
            Described::Calibration => calibrate::write::schema(),
        };
        print(|out| match self.markdown {
            true => write!(out, "{}", key_reference()),
            false => {
                serde_json::to_writer_pretty(&mut *out, &schema)?;
                writeln!(out)
            }
        })
    }
}
