//! Files of a calibration.

use std::io::Write;
use std::path::PathBuf;

use super::found::{Calibrated, Calibration};
use super::page::html;
use crate::Error;
use crate::study::{OutputFolder, schema_of};
use serde_json::Value;

/// Summary of a calibration.
pub const CALIBRATION: &str = "calibration.json";
/// Page of a calibration.
pub const PAGE: &str = "calibration.html";
/// Draws of the posterior, which a design of kind "file" reads.
pub const POSTERIOR: &str = "posterior.csv";
/// All of them.
pub const FILES: [&str; 3] = [POSTERIOR, CALIBRATION, PAGE];

/// The schema (JSON Schema, draft 2020-12) of `calibration.json`, with the meaning and unit of every field.
#[must_use]
pub fn schema() -> Value {
    schema_of::<Calibration>("Microslip calibration.json")
}

impl Calibrated {
    /// Writes `posterior.csv`, `calibration.json` and `calibration.html` into `folder`, all or none; the files.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be written.
    pub fn write(&self, folder: &OutputFolder) -> Result<Vec<PathBuf>, Error> {
        let summary = |out: &mut dyn Write| {
            serde_json::to_writer_pretty(&mut *out, &self.summary)?;
            writeln!(out)
        };
        let page = |out: &mut dyn Write| {
            let page = html(self).map_err(std::io::Error::other)?;
            out.write_all(page.as_bytes())
        };
        folder.write_all(&[
            (POSTERIOR, &|out| self.write_draws(out)),
            (CALIBRATION, &summary),
            (PAGE, &page),
        ])
    }

    /// A line of names, then one line per draw. Draws of the chains alternate, so that the first ones are of all chains.
    fn write_draws(&self, out: &mut dyn Write) -> std::io::Result<()> {
        writeln!(
            out,
            "# draws of the posterior, for [design] kind = \"file\""
        )?;
        let names: Vec<&str> = self
            .summary
            .inputs
            .iter()
            .map(|i| i.name.as_str())
            .collect();
        writeln!(out, "{}", names.join(","))?;
        let draws = self.draws.first().map_or(0, Vec::len);
        for draw in 0..draws {
            for chain in &self.draws {
                let values: Vec<String> = chain[draw].iter().map(|v| format!("{v:?}")).collect();
                writeln!(out, "{}", values.join(","))?;
            }
        }
        Ok(())
    }
}
