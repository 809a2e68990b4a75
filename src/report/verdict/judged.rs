//! A criterion judged on the samples of one population at one excitation level.
//!
//! A sample without a trusted solution counts as one that may keep the limit or break it, and every other sample is taken
//! within its own numerical error. What would decide, and how often a study of this size passes, goes with it.

use super::criterion_result::{LevelResult, NumericalWidth, Power, Unknown};
use super::numerical_error::{NumericalErrors, Solved};
use crate::ensemble::outcome::{Maximum, PeakRecord, SampleOutcome};
use crate::report::asked::requirement::{Criterion, Operation, RequiredQuantity, Stress};
use crate::report::numbers::allowable::{allowable_amplitude_m, factor};
use crate::report::numbers::margins::smallest_margin;
use crate::report::numbers::peaks::{above_peak, trusted_peak, usable_peak};
use crate::report::run::input::ReportInput;
use crate::statistics::{
    Counted, Criterion as Rule, Demonstration, Enclosed, Interval, Judgement, Limit, Observed,
    Remedy, exceedance, judge, quantile_estimate,
};
use crate::units::m_to_um;

/// Power for which the number of samples is named.
const HIGH_POWER: f64 = 0.9;

/// What a criterion is judged by at one level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged<'a> {
    pub(super) input: ReportInput<'a>,
    pub(super) criterion: &'a Criterion,
    pub(super) errors: &'a NumericalErrors,
    /// Number of the level.
    pub(super) level: usize,
    /// Populations that the criterion is judged on: levels times outer points.
    pub(super) populations: usize,
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
    /// Judges the samples of one population.
    pub(super) fn population(&self) -> LevelResult {
        let results = self.results();
        let observed = Observed::enclosed(&results);
        let exact = Observed::of(results.iter().map(|r| r.value));
        let (estimate, interval) = self.estimate(&observed);
        let (_, without_error) = self.estimate(&exact);
        let judgement = judge(interval, self.rule(self.criterion.limit));
        let counted = self.counted(&observed);
        let demonstration = self.demonstration();
        let random = self.input.record.has_random_inputs();
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
            power: random.then(|| power(&demonstration, counted.samples)),
            remedy: (judgement == Judgement::Undecided).then(|| match random {
                true => demonstration.remedy(&counted),
                false => Remedy::FewerUnknown,
            }),
            engine_order: estimate.and_then(|estimate| self.engine_order(&results, estimate)),
            outer: None,
            over_box: None,
        }
    }

    /// One result per sample, in the unit of the limit of each sample; NaN where none is to be trusted.
    pub(super) fn results(&self) -> Vec<Enclosed> {
        let of = |o: &SampleOutcome| {
            let level = &o.levels[self.level];
            let above = above_peak(self.input.record, level);
            Some(self.enclosed(&trusted_peak(level)?, above))
        };
        let outcomes = self.input.outcomes.iter();
        outcomes
            .map(|o| of(o).unwrap_or(Enclosed::UNKNOWN))
            .collect()
    }

    /// Whether a result breaks the limit wherever it lies.
    pub(super) fn breaks(&self, result: &Enclosed) -> bool {
        match self.rule(self.limit_of_samples()) {
            Rule::AtLeast(limit) => result.upper < limit,
            Rule::AtMost(limit) => result.lower > limit,
        }
    }

    /// The result of a peak; where a sweep meets more, the peak may be there.
    fn enclosed(&self, peak: &PeakRecord, above: Option<Maximum>) -> Enclosed {
        let mut frequency = self.errors.frequency(peak);
        let mut amplitude = self.errors.amplitude(self.level, peak);
        if let Some(above) = above {
            frequency.lower = frequency.lower.min(above.frequency_hz);
            frequency.upper = frequency.upper.max(above.frequency_hz);
            amplitude.upper = amplitude.upper.max(above.amplitude_m);
        }
        let requirements = &self.input.record.requirements;
        match (
            self.criterion.quantity,
            &requirements.operation,
            &requirements.stress,
        ) {
            (RequiredQuantity::FrequencyMarginPercent, Some(operation), _) => {
                margin(frequency, operation)
            }
            (RequiredQuantity::ReserveFactor, _, Some(stress)) => reserve(amplitude, stress),
            _ => Enclosed {
                lower: m_to_um(amplitude.lower),
                value: m_to_um(amplitude.value),
                upper: m_to_um(amplitude.upper),
            },
        }
    }

    fn solved(&self) -> Solved {
        match self.criterion.quantity {
            RequiredQuantity::FrequencyMarginPercent => Solved::Frequency,
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
            (RequiredQuantity::ProbabilityOfExceedance, Some(stress)) => {
                m_to_um(allowable_amplitude_m(stress))
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
        if !self.input.record.has_random_inputs() {
            return self.estimate_of_worst(observed);
        }
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

    /// The number where no input is random: each sample has the result of all, within its numerical error. Where they differ all the
    /// same (the search met several maxima) it is the worst that was met; what an unknown one would have been stays open.
    fn estimate_of_worst(&self, observed: &Observed) -> (Option<f64>, Interval) {
        if self.criterion.quantity == RequiredQuantity::ProbabilityOfExceedance {
            let counted = self.counted(observed);
            let some = |count: usize| f64::from(u8::from(count > 0));
            let share = exceedance_of_values(observed, self.limit_of_samples());
            return (
                share.map(|share| f64::from(u8::from(share > 0.0))),
                Interval::between(some(counted.broken), some(counted.broken + counted.unknown)),
            );
        }
        let of = |n: usize| match self.criterion.quantity.at_least() {
            true => 1,
            false => n,
        };
        let rank = of(observed.total());
        let values = observed.valid();
        let interval = Interval {
            lower: observed.lowest(rank),
            upper: observed.highest(rank),
        };
        (values.order_statistic(of(values.values().len())), interval)
    }

    /// The number with an interval each side of which has the given confidence.
    fn estimate_at(&self, observed: &Observed, confidence: f64) -> (Option<f64>, Interval) {
        let two_sided = 2.0 * confidence - 1.0;
        let none = (None, Interval::UNBOUNDED);
        if self.criterion.quantity == RequiredQuantity::ProbabilityOfExceedance {
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

    /// The order with the smallest margin in most of the samples whose result is the estimate: those that orders cross all have the
    /// margin 0, each perhaps of another order.
    fn engine_order(&self, results: &[Enclosed], estimate: f64) -> Option<u32> {
        let operation = self.input.record.requirements.operation.as_ref()?;
        if self.criterion.quantity != RequiredQuantity::FrequencyMarginPercent {
            return None;
        }
        let at_estimate = results.iter().zip(self.input.outcomes);
        let at_estimate = at_estimate.filter(|(result, _)| result.value == estimate);
        let frequencies: Vec<[f64; 2]> = at_estimate
            .filter_map(|(_, o)| Some(trusted_peak(&o.levels[self.level])?.frequency_hz))
            .map(|frequency| [frequency, smallest_margin(frequency, operation)])
            .collect();
        let nearest = |order: &u32| {
            let alone = Operation {
                engine_orders: vec![*order],
                ..operation.clone()
            };
            let of = |[frequency, smallest]: &&[f64; 2]| {
                smallest_margin(*frequency, &alone) <= *smallest
            };
            frequencies.iter().filter(of).count()
        };
        // of several the first one
        let orders = operation.engine_orders.iter().rev();
        orders.copied().max_by_key(nearest)
    }
}

fn power(demonstration: &Demonstration, samples: usize) -> Power {
    let kept = 0.5 * (1.0 + demonstration.content);
    Power {
        kept,
        probability: demonstration.power(samples, kept),
        samples_for_90_percent: demonstration.samples_for_power(kept, HIGH_POWER),
    }
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
