//! `schema`: the JSON Schema of the study file.

use super::terminal::print;
use microslip::Error;
use microslip::study::schema;

pub(super) fn execute() -> Result<(), Error> {
    print(|out| {
        serde_json::to_writer_pretty(&mut *out, &schema())?;
        writeln!(out)
    })
}
