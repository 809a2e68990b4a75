//! The files of an identification.

use super::found::identified::Identified;
use super::found::result::{LoopResult, LoopValue};
use super::identification::IdentifyError;
use super::page::html;
use crate::file;
use std::io::{Error as IoError, Result as IoResult, Write};
use std::path::Path;

/// The joint distribution, with everything that it is from.
pub const IDENTIFIED: &str = "identified.json";
/// Values of every cycle.
pub const LOOPS: &str = "loops.csv";

/// The page for people.
pub const REPORT: &str = "report.html";
/// All of them.
pub const FILES: [&str; 3] = [IDENTIFIED, LOOPS, REPORT];

/// Columns of `loops.csv`.
const COLUMNS: [&str; 15] = [
    "test",
    "cycle",
    "start_s",
    "steady",
    "normal_force_n",
    "friction_coefficient",
    "friction_coefficient_standard_error",
    "friction_from_energy",
    "tangential_stiffness_after_greatest_n_per_um",
    "tangential_stiffness_after_greatest_standard_error_n_per_um",
    "tangential_stiffness_after_least_n_per_um",
    "tangential_stiffness_after_least_standard_error_n_per_um",
    "normal_stiffness_n_per_um",
    "normal_stiffness_standard_error_n_per_um",
    "energy_j",
];

/// Writes `identified.json`, `loops.csv` and `report.html` into `folder`, all or none.
///
/// # Errors
/// [`IdentifyError`] if a file cannot be written.
pub fn write(folder: &Path, identified: &Identified) -> Result<(), IdentifyError> {
    let page = html(identified)?;
    file::replace_all(
        folder,
        &[
            (IDENTIFIED, &|file| {
                serde_json::to_writer_pretty(&mut *file, identified).map_err(IoError::from)?;
                file.write_all(b"\n")
            }),
            (LOOPS, &|file| loops(file, identified)),
            (REPORT, &|file| file.write_all(page.as_bytes())),
        ],
    )?;
    Ok(())
}

fn loops(file: &mut dyn Write, identified: &Identified) -> IoResult<()> {
    let mut table = csv::Writer::from_writer(file);
    table.write_record(COLUMNS)?;
    for test in &identified.tests {
        for one in &test.loops {
            table.write_record(row(&test.name, one))?;
        }
    }
    table.flush()
}

/// Cells of one cycle; empty where it has no value.
fn row(test: &str, one: &LoopResult) -> [String; 15] {
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    let both = |value: Option<LoopValue>| {
        let (value, error) = (value.map(|v| v.value), value.and_then(|v| v.standard_error));
        [number(value), number(error)]
    };
    let [friction, friction_error] = both(one.friction_coefficient);
    let [greatest, greatest_error] = both(one.tangential_stiffness_n_per_um[0]);
    let [least, least_error] = both(one.tangential_stiffness_n_per_um[1]);
    let [normal, normal_error] = both(one.normal_stiffness_n_per_um);
    [
        test.to_owned(),
        one.cycle.to_string(),
        one.start_s.to_string(),
        one.steady.to_string(),
        one.normal_force_n.to_string(),
        friction,
        friction_error,
        number(one.friction_from_energy),
        greatest,
        greatest_error,
        least,
        least_error,
        normal,
        normal_error,
        one.energy_j.to_string(),
    ]
}
