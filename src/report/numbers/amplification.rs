//! How much larger mistuning makes the largest blade of a disk.

use super::distribution::Distribution;
use super::peaks::usable_peak;
use crate::ensemble::outcome::{LevelOutcome, MaybeReal, MistunedRecord};
use crate::statistics::{Observed, Side, Sorted, ToleranceBound, tolerance_bound};
use schemars::JsonSchema;
use serde::Serialize;

/// Share of disks that the tolerance bound of a factor holds for.
pub(in crate::report) const CONTENT: f64 = 0.95;

/// Amplification factors of a mistuned disk at one excitation level: largest amplitude of all blades and frequencies over the peak of the
/// tuned disk with the same inputs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AmplificationSummary {
    /// Against the tuned disk with the same friction.
    pub amplification: FactorSummary,
    /// Against the tuned disk with all contacts stuck.
    pub over_linear: FactorSummary,
    /// Of the disk with all contacts stuck, mistuned over tuned.
    pub linear: FactorSummary,
    /// How often each blade has the largest amplitude; as many numbers as the highest of these blades needs.
    pub largest_blades: Vec<usize>,
}

/// Statistics of a factor.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FactorSummary {
    /// Mean and quantiles.
    pub distribution: Distribution,
    /// Bound that 95 % of all disks are not above, with the confidence of the report.
    pub upper_bound: ToleranceBound,
}

impl AmplificationSummary {
    /// Of the samples of one level; none of a disk whose blades are equal, and of any other model, and where the samples are those of
    /// several outer points, `nested`.
    pub(super) fn of(records: &[&LevelOutcome], nested: bool, confidence: f64) -> Option<Self> {
        let known: Vec<&MistunedRecord> = (records.iter())
            .filter(|record| usable_peak(record).is_some())
            .filter_map(|record| record.around.mistuned())
            .collect();
        if known.is_empty() || nested {
            return None;
        }
        let factor = |of: fn(&MistunedRecord) -> MaybeReal| {
            let values = known.iter().filter_map(|record| of(record).get());
            let sorted = Sorted::finite(values);
            let failed = records.len() - sorted.values().len();
            let all = Observed::with_failed(sorted, failed);
            FactorSummary {
                upper_bound: tolerance_bound(&all, Side::Upper, CONTENT, confidence),
                distribution: Distribution::of_observed(&all, confidence),
            }
        };
        let blades = known.iter().map(|record| record.blade as usize);
        let mut largest_blades = vec![0; blades.clone().max().map_or(0, |last| last + 1)];
        blades.for_each(|blade| largest_blades[blade] += 1);
        Some(Self {
            amplification: factor(|record| record.amplification),
            over_linear: factor(|record| record.over_linear),
            linear: factor(|record| record.linear_amplification),
            largest_blades,
        })
    }
}
