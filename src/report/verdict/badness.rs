//! How bad the number is that a criterion judges: what a search over the epistemic inputs makes as large as it can.
//!
//! For a quantile it is the quantile itself, with unknown samples and numerical errors at their worst. A probability of
//! breaking a limit is 0 over most of a box and gives a search no direction; the quantile that it bounds does.

use super::judged::Judged;
use super::numerical_error::NumericalErrors;
use crate::ensemble::outcome::SampleOutcome;
use crate::report::asked::requirement::Criterion;
use crate::report::run::input::{RESULTS, ReportInput};
use crate::report::run::record::RunRecord;
use crate::statistics::{Observed, quantile_rank};

/// The number that decides `criterion` at level number `level`, from the samples of one population: the larger, the worse.
/// Absent where unknown samples leave it open: such a point never passes, and what it would have given nobody knows.
#[must_use]
pub fn badness(
    record: &RunRecord,
    outcomes: &[SampleOutcome],
    criterion: &Criterion,
    level: usize,
) -> Option<f64> {
    let input = ReportInput {
        record,
        outcomes,
        mixed: &[],
        control: &[],
        changed: &[],
        folder: RESULTS,
    };
    let errors = NumericalErrors::of(&input, &[]);
    let judged = Judged::new(input, criterion, &errors, level);
    let observed = Observed::enclosed(&judged.results());
    let content = criterion.demonstration(1, 0).content;
    let rank = |p| quantile_rank(observed.total(), p);
    match criterion.quantity.at_least() {
        true => observed.lowest(rank(1.0 - content)).value().map(|v| -v),
        false => observed.highest(rank(content)).value(),
    }
}
