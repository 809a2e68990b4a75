//! How bad the number is that a criterion judges: what a search over the epistemic inputs makes as large as it can.
//!
//! For a quantile it is the quantile itself, with unknown samples and numerical errors at their worst. A probability of
//! breaking a limit is 0 over most of a box and gives a search no direction; the quantile that it bounds does.

use super::judged::Judged;
use super::numerical_error::NumericalErrors;
use crate::ensemble::outcome::SampleOutcome;
use crate::report::asked::requirement::{Criterion, Operation};
use crate::report::numbers::margins::signed_margin;
use crate::report::numbers::peaks::values;
use crate::report::run::input::{RESULTS, ReportInput};
use crate::report::run::record::RunRecord;
use crate::statistics::{Observed, Sorted, quantile, quantile_rank};

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

/// On which side of an engine order the resonances of one population lie at level number `level`: their median margin (a share), negative
/// below the order, 0 where it crosses them in the range of speeds; absent without a solution.
#[must_use]
pub fn side_of_order(
    operation: &Operation,
    outcomes: &[SampleOutcome],
    engine_order: u32,
    level: usize,
) -> Option<f64> {
    let speeds = operation.speed_rpm;
    let margins = values(outcomes, level, |peak| {
        signed_margin(peak.frequency_hz, operation, engine_order, speeds)
    });
    quantile(&Sorted::finite(margins), 0.5)
}
