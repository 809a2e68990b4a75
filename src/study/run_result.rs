//! What a run gives, beside its files.

use crate::ensemble::outcome::SampleOutcome;
use crate::report::Summary;
use crate::report::asked::Stopping;

/// What a run gives, beside its files.
#[derive(Debug)]
pub struct RunResult {
    /// Outcomes in the order of the samples.
    pub outcomes: Vec<SampleOutcome>,
    /// Statistics as in `summary.json`.
    pub summary: Summary,
    /// Why the model was not folded although `mirror` allows it.
    pub unfolded: Option<String>,
    /// How the number of samples came out of the results; absent where it was given.
    pub stopping: Option<Stopping>,
    /// Samples that were taken over from earlier processes.
    pub taken_over: u64,
    /// What a user should know of the taking over, one line each.
    pub notes: Vec<String>,
}
