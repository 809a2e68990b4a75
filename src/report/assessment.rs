//! What the samples say about the designer's requirements: `report.json`.
//!
//! Statements of the kind "95 % of the assumed prior with 95 % confidence" hold for the distributions of the inputs that the
//! study assumes; [`Assessment::condition`] says so wherever they go.

use super::convention::{CONFIDENCE, CONTENT};
use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::ensemble::store::Provenance;
use crate::report::asked::stopping::Stopping;
use crate::report::numbers::control_variate::{LevelControlVariate, control_variate};
use crate::report::numbers::epistemic::EpistemicSummary;
use crate::report::numbers::error_budget::{ErrorLine, error_budget};
use crate::report::numbers::margins::{OrderMargin, Reserve, order_margins, reserve};
use crate::report::numbers::outer_points::nested;
use crate::report::numbers::peaks::{usable_peak, values};
use crate::report::numbers::population::{Bound, Populations};
use crate::report::numbers::sensitivity::{InputInfluence, influences};
use crate::report::numbers::summary::Summary;
use crate::report::numbers::surrogate::{LevelSurrogates, surrogates};
use crate::report::run::input::ReportInput;
use crate::report::run::record::{FileRecord, InputRecord, RunRecord};
use crate::report::verdict::criterion_result::CriterionResult;
use crate::report::verdict::judgement::judge_all;
use crate::statistics::{
    FailurePattern, JointRegion, Prefix, QuantileEstimate, Side, convergence, failure_pattern,
    joint_region, quantile_estimate,
};
use schemars::JsonSchema;
use serde::Serialize;

/// First prefix of a convergence table.
const FIRST_PREFIX: usize = 16;
/// Groups of a failure rate.
const GROUPS: usize = 5;

/// Everything that a designer's report says in numbers. Field names are stable and end in their unit.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Assessment {
    /// Study, seed, version, commit, law and settings.
    pub provenance: Provenance,
    /// What every probability, quantile and bound depends on.
    pub condition: String,
    /// How the number of samples came out of the results; absent where it was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopping: Option<Stopping>,
    /// The distributions of the inputs, as assumed.
    pub inputs: Vec<InputRecord>,
    /// Number of samples, failed ones included.
    pub samples: usize,
    /// Share of the population in every tolerance bound.
    pub content: f64,
    /// Confidence of every interval and bound, but for criteria that state their own.
    pub confidence: f64,
    /// Judgements.
    pub criteria: Vec<CriterionResult>,
    /// One entry per excitation level.
    pub levels: Vec<LevelAssessment>,
    /// Where samples without a solution lie, one entry per input; empty unless some samples failed and some did not.
    pub failures: Vec<InputFailures>,
    /// What each approximation can change.
    pub error_budget: Vec<ErrorLine>,
    /// What computed the samples.
    pub backend: String,
    /// Name of the accelerator.
    pub adapter: Option<String>,
    /// The study file.
    pub study_file: FileRecord,
    /// The tables of the run.
    pub tables: Vec<FileRecord>,
    /// Tables whose content is not that of the run.
    pub changed_tables: Vec<String>,
}

/// Bounds, margins and sensitivities at one excitation level.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelAssessment {
    /// Excitation level (N on each blade for the built-in model, else a factor).
    pub level: f64,
    /// Lower and upper bound of the resonance frequency (Hz).
    pub frequency_bounds_hz: [Bound; 2],
    /// Upper bound of the amplitude (m).
    pub amplitude_bound_m: Bound,
    /// Region of frequency (x, Hz) and amplitude (y, m); absent where the samples belong to outer points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_region: Option<JointRegion>,
    /// Margin to each engine order; empty without `[operation]`.
    pub margins: Vec<OrderMargin>,
    /// Reserve against the allowable stress; absent without `[stress]`.
    pub reserve: Option<Reserve>,
    /// How much each input moves the results.
    pub influences: Vec<InputInfluence>,
    /// Surrogates of the results; absent unless the study wants them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surrogates: Option<LevelSurrogates>,
    /// Means and probabilities with the help of a control variate; absent unless the study wants one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control_variate: Option<LevelControlVariate>,
    /// 95 % quantile of the amplitude (m) over the first samples; empty where the samples belong to outer points.
    pub amplitude_q95_m: Vec<Prefix<Option<QuantileEstimate>>>,
    /// Median of the resonance frequency (Hz) over the first samples; empty where the samples belong to outer points.
    pub frequency_q50_hz: Vec<Prefix<Option<QuantileEstimate>>>,
}

/// How one input differs between samples that lack a solution at one level or more and all others.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct InputFailures {
    /// Name of the input.
    pub input: String,
    /// Shift and distance of the two, and the failure rate along the input.
    #[serde(flatten)]
    pub pattern: FailurePattern,
}

impl Assessment {
    /// Assesses the samples of a study.
    #[must_use]
    pub fn of(input: &ReportInput, summary: &Summary) -> Self {
        let record = input.record;
        let levels: Vec<LevelAssessment> = (0..record.levels.len())
            .map(|i| LevelAssessment::of(input, i))
            .collect();
        let surrogates = levels.iter().filter_map(|l| l.surrogates.as_ref());
        let error_budget = error_budget(input, summary, &surrogates.collect::<Vec<_>>());
        Self {
            provenance: record.provenance.clone(),
            condition: condition(record, summary.epistemic.as_ref()),
            stopping: record.stopping.clone(),
            inputs: record.inputs.clone(),
            samples: input.outcomes.len(),
            content: CONTENT,
            confidence: CONFIDENCE,
            criteria: judge_all(input, &error_budget),
            failures: failures(input),
            error_budget,
            levels,
            backend: record.backend.description(),
            adapter: record.backend.adapter(),
            study_file: record.study_file.clone(),
            tables: record.tables.clone(),
            changed_tables: input.changed.to_vec(),
        }
    }
}

/// The sentence that goes with every statement of probability.
fn condition(record: &RunRecord, epistemic: Option<&EpistemicSummary>) -> String {
    let priors = priors(&record.inputs).join("; ");
    let none_random = "No input is random: the samples do not scatter.".to_owned();
    let start = match (record.has_random_inputs(), epistemic) {
        (true, _) => format!("Conditional on the assumed distributions of {priors}."),
        (false, _) if record.inputs.is_empty() => return none_random,
        (false, None) => return format!("{none_random} Inputs: {priors}."),
        (false, Some(_)) => {
            format!("No input is random: the samples of a point do not scatter. Inputs: {priors}.")
        }
    };
    format!(
        "{start} Design of the samples: {}.{}",
        record.design.description,
        epistemic.map_or_else(String::new, |e| format!(" {}", pooling(e)))
    )
}

/// Most neighbouring inputs of one distribution that are named one by one.
const NAMED: usize = 3;

/// Inputs with their distributions; many neighbours of one distribution, as the blades of a disk have, by the first and the last.
fn priors(inputs: &[InputRecord]) -> Vec<String> {
    let of_one = inputs.chunk_by(|a, b| a.assumption() == b.assumption());
    let named = |inputs: &[InputRecord]| -> Vec<String> {
        match inputs {
            [first, .., last] if inputs.len() > NAMED => vec![format!(
                "{} to {} ({} inputs, each {})",
                first.name,
                last.name,
                inputs.len(),
                first.assumption()
            )],
            _ => (inputs.iter())
                .map(|i| format!("{} ({})", i.name, i.assumption()))
                .collect(),
        }
    };
    of_one.flat_map(named).collect()
}

/// What statistics over all samples are not, where some inputs are epistemic.
pub(super) fn pooling(epistemic: &EpistemicSummary) -> String {
    format!(
        "{} only known to an interval: samples of all {} outer points together are no population, and their shares, \
         quantiles and bands no probabilities. These are given by outer point, with their ranges.",
        match epistemic.inputs.as_slice() {
            [one] => format!("{one} is"),
            several => format!("{} are", several.join(", ")),
        },
        epistemic.points.len(),
    )
}

impl LevelAssessment {
    fn of(input: &ReportInput, i: usize) -> Self {
        // columns of a million samples are held no longer than they are needed
        let results: [fn(&PeakRecord) -> f64; 2] = [|p| p.frequency_hz, |p| p.amplitude_m];
        let bounds = |result| {
            let populations = Populations::of(input, i, result);
            [Side::Lower, Side::Upper].map(|side| populations.bound(side))
        };
        let nested = nested(input.outcomes);
        let prefixes = |result, p: f64| match nested {
            true => Vec::new(),
            false => convergence(&values(input.outcomes, i, result), FIRST_PREFIX, |o| {
                quantile_estimate(o, p, input.record.confidence())
            }),
        };
        let requirements = &input.record.requirements;
        let [_, amplitude_bound_m] = bounds(results[1]);
        Self {
            level: input.record.levels[i],
            frequency_bounds_hz: bounds(results[0]),
            amplitude_bound_m,
            joint_region: (!nested).then(|| region(input, i)),
            margins: (requirements.operation.as_ref())
                .map_or_else(Vec::new, |operation| order_margins(input, i, operation)),
            reserve: (requirements.stress.as_ref()).map(|stress| reserve(input, i, stress)),
            influences: influences(input, i),
            surrogates: surrogates(input, i),
            control_variate: control_variate(input, i),
            amplitude_q95_m: prefixes(results[1], 0.95),
            frequency_q50_hz: prefixes(results[0], 0.5),
        }
    }
}

/// Region of frequency and amplitude at level `i`.
fn region(input: &ReportInput, i: usize) -> JointRegion {
    let result = |o: &SampleOutcome| {
        let peak = usable_peak(&o.levels[i]);
        peak.map_or((f64::NAN, f64::NAN), |p| (p.frequency_hz, p.amplitude_m))
    };
    let pairs: Vec<(f64, f64)> = input.outcomes.iter().map(result).collect();
    joint_region(&pairs, CONTENT, input.record.confidence())
}

fn failures(input: &ReportInput) -> Vec<InputFailures> {
    let lost = |o: &SampleOutcome| o.levels.iter().any(|l| usable_peak(l).is_none());
    let lost: Vec<bool> = input.outcomes.iter().map(lost).collect();
    let inputs = input.record.inputs.iter().enumerate();
    let of_input = |(j, record): (usize, &InputRecord)| {
        let x: Vec<f64> = input.outcomes.iter().map(|o| o.inputs[j]).collect();
        Some(InputFailures {
            input: record.name.clone(),
            pattern: failure_pattern(&x, &lost, GROUPS, input.record.confidence())?,
        })
    };
    inputs.filter_map(of_input).collect()
}
