//! What a run gives, beside its files.

use super::profile::Profile;
use crate::report::Summary;
use crate::report::run::StoredRun;

/// What a run gives, beside its files.
#[derive(Debug)]
pub struct RunResult {
    /// The run as its files hold it: record and outcomes.
    pub stored: StoredRun,
    /// Statistics as in `summary.json`.
    pub summary: Summary,
    /// Why the model was not folded although `mirror` allows it.
    pub unfolded: Option<String>,
    /// Samples that were taken over from earlier processes.
    pub taken_over: u64,
    /// Where the time of this process went.
    pub profile: Profile,
    /// What a user should know of the taking over and of the model, one line each.
    pub notes: Vec<String>,
}
