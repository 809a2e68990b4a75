//! Whether the samples so far are enough: one look at a study that grows.

use super::assessment::Assessment;
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::report::asked::stopping::{ResultOfSample, Stopping, StoppingRule};
use crate::report::numbers::peaks::values;
use crate::report::numbers::summary::Summary;
use crate::report::run::input::{RESULTS, ReportInput};
use crate::report::run::record::RunRecord;
use crate::statistics::{Judgement, Observed, quantile_estimate};

/// What was planned, after its first `looks` looks, of which the last one judges the samples so far.
#[must_use]
pub fn at_look(
    plan: &Stopping,
    looks: usize,
    record: &RunRecord,
    outcomes: &[SampleOutcome],
) -> Stopping {
    let so_far = Stopping {
        looks: plan.looks[..looks].to_vec(),
        met: false,
        ..plan.clone()
    };
    let record = RunRecord {
        stopping: Some(so_far.clone()),
        ..record.clone()
    };
    Stopping {
        met: is_met(plan.rule, &record, outcomes),
        ..so_far
    }
}

/// Whether the samples so far meet the rule; the record knows at which look.
fn is_met(rule: StoppingRule, record: &RunRecord, outcomes: &[SampleOutcome]) -> bool {
    let input = ReportInput {
        record,
        outcomes,
        mixed: &[],
        control: &[],
        changed: &[],
        folder: RESULTS,
    };
    match rule {
        StoppingRule::Decided => {
            let criteria = Assessment::of(&input, &Summary::of(&input)).criteria;
            let decided = |judgement| judgement != Judgement::Undecided;
            criteria.iter().all(|c| decided(c.judgement))
        }
        StoppingRule::Width {
            of,
            quantile,
            relative,
        } => (0..record.levels.len()).all(|level| {
            let value = |peak: &PeakRecord| match of {
                ResultOfSample::Frequency => peak.frequency_hz,
                ResultOfSample::Amplitude => peak.amplitude_m,
            };
            let observed = Observed::of(values(outcomes, level, value));
            let found = quantile_estimate(&observed, quantile, record.confidence());
            let width = found.and_then(|found| {
                let (lower, upper) = (found.interval.lower, found.interval.upper);
                Some((upper.value()? - lower.value()?) / found.estimate.abs())
            });
            width.is_some_and(|width| width <= relative)
        }),
    }
}
