//! What every number of a report is computed from.

use super::record::RunRecord;
use crate::ensemble::outcome::SampleOutcome;

/// What stands for the folder of the results in commands, where there is one run.
pub const RESULTS: &str = "RESULTS";

/// Everything a report is made from.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// All of the run beside its samples.
    pub record: &'a RunRecord,
    /// The samples of the population, failed ones included.
    pub outcomes: &'a [SampleOutcome],
    /// The mixed samples of a pick-freeze design, for its indices alone.
    pub mixed: &'a [SampleOutcome],
    /// The samples of the control variate on few harmonics, the first of them those of the population; empty without.
    pub control: &'a [SampleOutcome],
    /// Tables of the run whose content has changed since.
    pub changed: &'a [String],
    /// Folder of the results in commands that a reader may give. A page of one run says [`RESULTS`], wherever it lies, but that of one
    /// of several engine orders its own folder.
    pub folder: &'a str,
}
