//! From outcomes to files: Parquet, summary and page.

mod synthetic;

use microslip::report;
use synthetic::SyntheticStudy;

/// Writes the report of a synthetic study into the folder named by `MICROSLIP_REPORT`, to be looked at.
#[test]
#[ignore = "writes a report to look at"]
fn write_a_report_to_look_at() {
    let folder = std::env::var("MICROSLIP_REPORT").unwrap();
    let study = SyntheticStudy::new(400);
    report::write(folder.as_ref(), &study.input()).unwrap();
}
