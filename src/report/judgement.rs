//! The user's criteria, judged: PASS, FAIL or UNDECIDED.
//!
//! A verdict counts a sample without a trusted solution as one that may keep the limit or break it, and takes every other
//! sample within its own numerical error. What would decide, and how often a study of this size passes, goes with it.

use super::allowable::{allowable_amplitude_m, factor};
use super::error_budget::ErrorLine;
use super::ignorance::{IgnoranceResult, as_intervals};
use super::input::ReportInput;
use super::margins::smallest_margin;
use super::numerical_error::{NumericalErrors, Solved};
use super::outer_points::{nested, outer_groups};
use super::over_box::OverBox;
use super::peaks::usable_peak;
use super::requirement::{Criterion, Operation, Quantity, Stress};
use super::sentence::sentence;
use crate::ensemble::outcome::{LevelOutcome, PeakRecord, SampleOutcome};
use crate::statistics::{
    Counted, Criterion as Rule, Demonstration, Enclosed, Interval, Judgement, Limit, Observed,
    Remedy, exceedance, judge, quantile_estimate,
};
use serde::Serialize;

/// m → µm.
const UM_PER_M: f64 = 1e6;
/// Power for which the number of samples is named.
const HIGH_POWER: f64 = 0.9;

/// A criterion and its judgement.
#[derive(Debug, Clone, Serialize)]
pub struct CriterionResult {
    /// As the study file states it.
    pub criterion: Criterion,
    /// The worst of its levels: FAIL before UNDECIDED before PASS.
    pub judgement: Judgement,
    /// Whether the samples are no independent draws, so that the judgement is an indication and has no confidence.
    pub indication: bool,
    /// What was found, asked and, if undecided, what would decide.
    pub sentence: String,
    /// One entry per level that it holds for.
    pub levels: Vec<LevelResult>,
    /// The same with inputs of flat distributions taken as known to an interval only; absent without such inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_intervals: Option<IgnoranceResult>,
}

/// A criterion at one excitation level.
#[derive(Debug, Clone, Serialize)]
pub struct LevelResult {
    /// Excitation level.
    pub level: f64,
    /// Number that is judged, from the samples with a trusted solution: the quantile that leaves out 1 − share, or the
    /// probability; in the unit of the limit. Absent without samples.
    pub estimate: Option<f64>,
    /// Where it lies: the side that passes holds with the confidence of the criterion, the side that fails with it at all
    /// levels and outer points together; whatever samples without a trusted solution would have given, and wherever the
    /// others lie within their numerical errors.
    pub interval: Interval,
    /// Judgement.
    pub judgement: Judgement,
    /// Samples by what they say about the limit.
    #[serde(flatten)]
    pub counted: Counted,
    /// Why samples are unknown.
    pub unknown_because: Unknown,
    /// What the numerical error of the samples does to the interval.
    pub numerical_error: NumericalWidth,
    /// Frequency of PASS if the truth were better than the limit.
    pub power: Power,
    /// What would decide; absent where the judgement is PASS or FAIL.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<Remedy>,
    /// Engine order with the smallest margin in the samples at the estimate; absent for other quantities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine_order: Option<u32>,
    /// The outer point of the epistemic inputs that decides: the criterion must hold at each. Absent without such inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outer: Option<u64>,
    /// Where over the epistemic inputs the limit is kept and where not; absent without such inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_box: Option<OverBox>,
}

/// Samples that may keep a limit or break it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Unknown {
    /// Without a solution.
    pub failed: usize,
    /// With one that is not to be trusted: bouncing, or with a truncation error above the threshold.
    pub untrusted: usize,
    /// With the limit inside their numerical error.
    pub within_error: usize,
}

/// How far the numerical error of the samples moves the limits of an interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NumericalWidth {
    /// The lower limit, downwards, in the unit of the criterion; absent where the limit is open.
    pub lower: Option<f64>,
    /// The upper limit, upwards, likewise.
    pub upper: Option<f64>,
    /// Sources of error that nobody estimated and that are not in it.
    pub not_estimated: Vec<&'static str>,
}

/// How often a study of so many samples, all of them known, passes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Power {
    /// Share of the population that is taken to keep the limit: half of what may break it does.
    pub kept: f64,
    /// Probability of PASS.
    pub probability: f64,
    /// Samples with which it reaches 90 %; absent beyond a million.
    pub samples_for_90_percent: Option<usize>,
}

/// Judges every criterion of the study.
pub(super) fn judge_all(input: &ReportInput, budget: &[ErrorLine]) -> Vec<CriterionResult> {
    let errors = NumericalErrors::of(input, budget);
    let criteria = input.record.requirements.criteria.iter();
    criteria
        .map(|criterion| result(input, criterion, &errors))
        .collect()
}

fn result(input: &ReportInput, criterion: &Criterion, errors: &NumericalErrors) -> CriterionResult {
    let levels = criterion.levels(&input.record.levels);
    let populations = levels.len() * outer_groups(input.outcomes).len();
    let judged = |&level: &usize| Judged {
        populations,
        ..Judged::new(*input, criterion, errors, level)
    };
    let judged: Vec<Judged> = levels.iter().map(judged).collect();
    let levels: Vec<LevelResult> = judged.iter().map(Judged::worst_point).collect();
    let any = |judgement| levels.iter().any(|l| l.judgement == judgement);
    let judgement = match (any(Judgement::Fail), any(Judgement::Undecided)) {
        (true, _) => Judgement::Fail,
        (false, true) => Judgement::Undecided,
        (false, false) => Judgement::Pass,
    };
    let mut result = CriterionResult {
        criterion: criterion.clone(),
        judgement,
        indication: !input.record.design.independent,
        sentence: String::new(),
        as_intervals: as_intervals(judgement, &judged),
        levels,
    };
    result.sentence = sentence(input.record, &result);
    result
}

impl CriterionResult {
    /// The level that decides: of those with the judgement of all, the one with the worst estimate.
    #[must_use]
    pub fn deciding(&self) -> Option<&LevelResult> {
        let levels = self.levels.iter().filter(|l| l.judgement == self.judgement);
        levels.max_by(|a, b| a.cost(&self.criterion).total_cmp(&b.cost(&self.criterion)))
    }
}

impl LevelResult {
    /// The larger, the worse. Without an estimate nothing is known: that is the worst.
    fn cost(&self, criterion: &Criterion) -> f64 {
        match self.estimate {
            None => f64::INFINITY,
            Some(v) if criterion.quantity.at_least() => -v,
            Some(v) => v,
        }
    }
}

/// What a criterion is judged by at one level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged<'a> {
    pub(super) input: ReportInput<'a>,
    pub(super) criterion: &'a Criterion,
    errors: &'a NumericalErrors,
    /// Number of the level.
    level: usize,
    /// Populations that the criterion is judged on: levels times outer points.
    populations: usize,
}

impl<'a> Judged<'a> {
    /// The samples of one population at level number `level`.
    pub(super) fn new(
        input: ReportInput<'a>,
        criterion: &'a Criterion,
        errors: &'a NumericalErrors,
        level: usize,
    ) -> Self {
        Self {
            input,
            criterion,
            errors,
            level,
            populations: 1,
        }
    }
}

impl Judged<'_> {
    /// The worst over the outer points, where there are such: their samples are no population together.
    fn worst_point(&self) -> LevelResult {
        if !nested(self.input.outcomes) {
            return self.population();
        }
        let of_point = |(outer, members): (Option<u64>, Vec<usize>)| {
            let outcomes: Vec<_> = (members.iter())
                .map(|&m| self.input.outcomes[m].clone())
                .collect();
            let input = ReportInput {
                outcomes: &outcomes,
                ..self.input
            };
            LevelResult {
                outer,
                ..Judged { input, ..*self }.population()
            }
        };
        let groups = outer_groups(self.input.outcomes);
        let points: Vec<LevelResult> = groups.into_iter().map(of_point).collect();
        let over_box = OverBox::of(&self.input, &points);
        let severity = |result: &LevelResult| {
            let word = match result.judgement {
                Judgement::Pass => 0,
                Judgement::Undecided => 1,
                Judgement::Fail => 2,
            };
            (word, result.cost(self.criterion))
        };
        let worse = |a: LevelResult, b: LevelResult| match severity(&b) > severity(&a) {
            true => b,
            false => a,
        };
        let worst = points.into_iter().reduce(worse);
        LevelResult {
            over_box: Some(over_box),
            ..worst.unwrap_or_else(|| self.population())
        }
    }

    /// Judges the samples of one population.
    fn population(&self) -> LevelResult {
        let results = self.results();
        let observed = Observed::enclosed(&results);
        let exact = Observed::of(results.iter().map(|r| r.value));
        let (estimate, interval) = self.estimate(&observed);
        let (_, without_error) = self.estimate(&exact);
        let judgement = judge(interval, self.rule(self.criterion.limit));
        let counted = self.counted(&observed);
        let demonstration = self.demonstration();
        LevelResult {
            level: self.input.record.levels[self.level],
            estimate,
            interval,
            judgement,
            counted,
            unknown_because: self.unknown(&counted),
            numerical_error: NumericalWidth {
                lower: distance(interval.lower, without_error.lower),
                upper: distance(interval.upper, without_error.upper),
                not_estimated: self.errors.not_estimated(self.solved()).to_vec(),
            },
            power: Power::of(&demonstration, counted.samples),
            remedy: (judgement == Judgement::Undecided).then(|| demonstration.remedy(&counted)),
            engine_order: estimate.and_then(|estimate| self.engine_order(&results, estimate)),
            outer: None,
            over_box: None,
        }
    }

    /// One result per sample, in the unit of the limit of each sample; NaN where none is to be trusted.
    pub(super) fn results(&self) -> Vec<Enclosed> {
        let lost = Enclosed {
            lower: f64::NAN,
            value: f64::NAN,
            upper: f64::NAN,
        };
        let of = |o: &SampleOutcome| trusted_peak(&o.levels[self.level]).map(|p| self.enclosed(&p));
        let outcomes = self.input.outcomes.iter();
        outcomes.map(|o| of(o).unwrap_or(lost)).collect()
    }

    /// Whether a result breaks the limit wherever it lies.
    pub(super) fn breaks(&self, result: &Enclosed) -> bool {
        match self.rule(self.limit_of_samples()) {
            Rule::AtLeast(limit) => result.upper < limit,
            Rule::AtMost(limit) => result.lower > limit,
        }
    }

    fn enclosed(&self, peak: &PeakRecord) -> Enclosed {
        let frequency = self.errors.frequency(peak);
        let amplitude = self.errors.amplitude(peak);
        let requirements = &self.input.record.requirements;
        match (
            self.criterion.quantity,
            &requirements.operation,
            &requirements.stress,
        ) {
            (Quantity::FrequencyMarginPercent, Some(operation), _) => margin(frequency, operation),
            (Quantity::ReserveFactor, _, Some(stress)) => reserve(amplitude, stress),
            _ => Enclosed {
                lower: amplitude.lower * UM_PER_M,
                value: amplitude.value * UM_PER_M,
                upper: amplitude.upper * UM_PER_M,
            },
        }
    }

    fn solved(&self) -> Solved {
        match self.criterion.quantity {
            Quantity::FrequencyMarginPercent => Solved::Frequency,
            _ => Solved::Amplitude,
        }
    }

    fn rule(&self, limit: f64) -> Rule {
        match self.criterion.quantity.at_least() {
            true => Rule::AtLeast(limit),
            false => Rule::AtMost(limit),
        }
    }

    /// The limit that each sample keeps or breaks: that of the criterion, or the amplitude (µm) of a reserve factor of 1.
    fn limit_of_samples(&self) -> f64 {
        let stress = self.input.record.requirements.stress.as_ref();
        match (self.criterion.quantity, stress) {
            (Quantity::ProbabilityOfExceedance, Some(stress)) => {
                UM_PER_M * allowable_amplitude_m(stress)
            }
            _ => self.criterion.limit,
        }
    }

    fn demonstration(&self) -> Demonstration {
        let look = self.input.record.look();
        self.criterion.demonstration(self.populations, look)
    }

    /// The number that is judged, with its interval: the side that passes has the confidence of PASS, the other one that
    /// of FAIL.
    fn estimate(&self, observed: &Observed) -> (Option<f64>, Interval) {
        let demonstration = self.demonstration();
        let (estimate, of_pass) = self.estimate_at(observed, demonstration.confidence);
        let (_, of_fail) = self.estimate_at(observed, demonstration.confidence_of_fail);
        let interval = match self.criterion.quantity.at_least() {
            true => Interval {
                lower: of_pass.lower,
                upper: of_fail.upper,
            },
            false => Interval {
                lower: of_fail.lower,
                upper: of_pass.upper,
            },
        };
        (estimate, interval)
    }

    /// The number with an interval each side of which has the given confidence.
    fn estimate_at(&self, observed: &Observed, confidence: f64) -> (Option<f64>, Interval) {
        let two_sided = 2.0 * confidence - 1.0;
        let none = (None, Interval::UNBOUNDED);
        if self.criterion.quantity == Quantity::ProbabilityOfExceedance {
            let found = exceedance(observed, self.limit_of_samples(), two_sided);
            return found.map_or(none, |found| {
                let share = found.probability;
                let known = exceedance_of_values(observed, self.limit_of_samples());
                (known, Interval::between(share.lower, share.upper))
            });
        }
        let probability = match self.criterion.quantity.at_least() {
            true => 1.0 - self.criterion.share(),
            false => self.criterion.share(),
        };
        let found = quantile_estimate(observed, probability, two_sided);
        found.map_or(none, |q| (Some(q.estimate), q.interval))
    }

    fn counted(&self, observed: &Observed) -> Counted {
        let below = |ends: &[f64], limit: f64| ends.partition_point(|&v| v < limit);
        let above = |ends: &[f64], limit: f64| ends.len() - ends.partition_point(|&v| v <= limit);
        let known = observed.valid().values().len();
        let (broken, possible) = match self.rule(self.limit_of_samples()) {
            Rule::AtLeast(limit) => (
                below(observed.upper_ends(), limit),
                below(observed.lower_ends(), limit),
            ),
            Rule::AtMost(limit) => (
                above(observed.lower_ends(), limit),
                above(observed.upper_ends(), limit),
            ),
        };
        Counted {
            samples: observed.total(),
            broken,
            unknown: possible - broken + observed.total() - known,
        }
    }

    fn unknown(&self, counted: &Counted) -> Unknown {
        let levels = self.input.outcomes.iter().map(|o| &o.levels[self.level]);
        let solved = levels.clone().filter(|l| usable_peak(l).is_some()).count();
        let trusted = levels.filter(|l| trusted_peak(l).is_some()).count();
        let failed = counted.samples - solved;
        Unknown {
            failed,
            untrusted: solved - trusted,
            within_error: counted.unknown - (counted.samples - trusted),
        }
    }

    /// The order with the smallest margin in the sample whose result is the estimate.
    fn engine_order(&self, results: &[Enclosed], estimate: f64) -> Option<u32> {
        let operation = self.input.record.requirements.operation.as_ref()?;
        if self.criterion.quantity != Quantity::FrequencyMarginPercent {
            return None;
        }
        let place = results.iter().position(|r| r.value == estimate)?;
        let peak = trusted_peak(&self.input.outcomes[place].levels[self.level])?;
        let size = |order: &u32| {
            let alone = Operation {
                engine_orders: vec![*order],
                ..operation.clone()
            };
            smallest_margin(peak.frequency_hz, &alone)
        };
        let orders = operation.engine_orders.iter();
        orders.min_by(|a, b| size(a).total_cmp(&size(b))).copied()
    }
}

impl Power {
    fn of(demonstration: &Demonstration, samples: usize) -> Self {
        let kept = 0.5 * (1.0 + demonstration.content);
        Self {
            kept,
            probability: demonstration.power(samples, kept),
            samples_for_90_percent: demonstration.samples_for_power(kept, HIGH_POWER),
        }
    }
}

/// The peak of a level if it may stand for the blade.
fn trusted_peak(level: &LevelOutcome) -> Option<PeakRecord> {
    usable_peak(level).filter(|_| level.status.is_trusted())
}

/// Share of the known samples above `threshold`; absent without such.
fn exceedance_of_values(observed: &Observed, threshold: f64) -> Option<f64> {
    let values = observed.valid().values();
    let above = values.len() - values.partition_point(|&v| v <= threshold);
    (!values.is_empty()).then(|| above as f64 / values.len() as f64)
}

/// Distance of two limits; absent where one is open.
fn distance(a: Limit, b: Limit) -> Option<f64> {
    Some((a.value()? - b.value()?).abs())
}

/// The smallest margin (%). Between two lines it changes by (1 + margin) times the relative change of the frequency at most.
fn margin(frequency: Enclosed, operation: &Operation) -> Enclosed {
    let value = smallest_margin(frequency.value, operation);
    let relative = (frequency.upper - frequency.value) / frequency.value;
    let error = relative * (1.0 + value);
    Enclosed {
        lower: 100.0 * (value - error).max(0.0),
        value: 100.0 * value,
        upper: 100.0 * (value + error),
    }
}

/// The reserve factor, largest where the amplitude is least; open above where the amplitude may be 0.
fn reserve(amplitude: Enclosed, stress: &Stress) -> Enclosed {
    Enclosed {
        lower: factor(amplitude.upper, stress),
        value: factor(amplitude.value, stress),
        upper: factor(amplitude.lower, stress),
    }
}
