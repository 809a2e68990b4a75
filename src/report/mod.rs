//! What the designer asks and reads: `summary.json` and `report.json` for programs, `report.html` for people.
//!
//! The page shows the numbers of [`Summary`] and [`Assessment`] and adds figures. A sample without a solution is counted, shown
//! and bounded, never dropped in silence. Knows how results look, not how they were computed.
//!
//! From the bottom up: [`convention`] (what every statement holds with), [`asked`] (by the study
//! file), [`run`] (what a report is made from), [`numbers`] (`summary.json`), [`verdict`] (criteria judged),
//! [`mod@assessment`] (`report.json`), `page` (`report.html`). Beside the report of one run: [`compare`] and [`reweighting`].
//! Start reading in `write`, which makes the three files.
//!
//! The numbers of a run, read back from its folder:
//!
//! ```no_run
//! use microslip::report::{StoredRun, Summary};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let run = StoredRun::read("results".as_ref())?;
//! assert!(run.changed.is_empty(), "files of the run have been edited");
//! let summary = Summary::of(&run.input());
//! for level in &summary.levels {
//!     println!("{}: {:?} {:?}", level.level, level.statuses, level.frequency_hz.quantiles);
//! }
//! # Ok(())
//! # }
//! ```

pub mod asked;
pub mod assessment;
pub mod compare;
pub mod convention;
pub mod disk;
mod enough;
mod error;
pub mod numbers;
mod page;
pub mod reweighting;
pub mod run;
pub mod verdict;
mod write;

pub use assessment::Assessment;
pub use enough::at_look;
pub use error::ReportError;
pub use numbers::Summary;
pub use run::{ReportInput, RunRecord, StoredRun};
pub use write::{REPORT_FILES, outdated, render, write};
