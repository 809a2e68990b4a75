//! The numbers of a study: `summary.json`.

use super::amplification::AmplificationSummary;
use super::correlation::{InputCorrelation, correlations};
use super::distribution::Distribution;
use super::epistemic::{EpistemicSummary, PointStatistics};
use super::modes::{ModeSummary, of_modes};
use super::outer_points::nested;
use super::peak_error::work_imbalance;
use super::peaks::{counted_status, mean_fractions, usable_peak};
use super::replicate_means::ReplicateMeans;
use super::several_answers::SeveralAnswers;
use crate::ensemble::backend::BackendReport;
use crate::ensemble::outcome::{LevelOutcome, PeakRecord, SampleOutcome};
use crate::ensemble::store::Provenance;
use crate::hb::{ContactFractions, PeakRoute, Status};
use crate::report::convention::CONFIDENCE;
use crate::report::run::input::ReportInput;
use crate::statistics::{Proportion, Sorted, proportion, quantile};
use schemars::Schema;
use serde_json::json;
use std::collections::BTreeMap;

/// All numbers of a study. Field names are stable and end in their unit.
#[derive(Debug, Clone, serde::Serialize, schemars::JsonSchema)]
pub struct Summary {
    /// Study, seed, version, law and settings.
    pub provenance: Provenance,
    /// Names of the sampled inputs.
    pub inputs: Vec<String>,
    /// Number of samples of the population, failed ones included: all but the mixed ones of a pick-freeze design.
    pub samples: usize,
    /// Unit of the excitation levels.
    pub level_unit: String,
    /// Resonance frequency without contact forces, nominal inputs (Hz); absent where the band holds none.
    pub free_frequency_hz: Option<f64>,
    /// Resonance frequency with all contacts stuck, nominal inputs (Hz); absent where the band holds none.
    pub stuck_frequency_hz: Option<f64>,
    /// Confidence of every interval.
    pub confidence: f64,
    /// Wall time of the command that wrote the results (s); earlier ones, whose samples it took over, are not in it.
    pub wall_time_s: f64,
    /// Whether a GPU improved the predicted peaks, with its audit.
    pub backend: BackendReport,
    /// One entry per excitation level.
    pub levels: Vec<LevelSummary>,
    /// Statistics by outer point and their ranges; absent without epistemic inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epistemic: Option<EpistemicSummary>,
}

/// Statistics of the population at one excitation level.
///
/// Samples of different outer points are no population: what is absent where samples belong to such stands in
/// `epistemic`, by point.
#[derive(Debug, Clone, serde::Serialize, schemars::JsonSchema)]
pub struct LevelSummary {
    /// Excitation level, in `level_unit`.
    pub level: f64,
    /// Samples per status, every status listed; they add up to the number of samples.
    #[schemars(transform = per_status)]
    pub statuses: BTreeMap<&'static str, usize>,
    /// Peaks per route on which they were found, every route listed; what did not come from the solver is not counted.
    #[schemars(transform = per_route)]
    pub routes: BTreeMap<&'static str, usize>,
    /// Samples without a solution.
    pub failed: usize,
    /// Share of samples without a solution, with confidence limits; absent without samples, and where these belong to outer
    /// points.
    pub failure_rate: Option<Proportion>,
    /// Peak at the nominal inputs; absent where it was not found.
    pub nominal: Option<PeakRecord>,
    /// Resonance frequency (Hz).
    pub frequency_hz: Distribution,
    /// Amplitude (m).
    pub amplitude_m: Distribution,
    /// Amplitude over excitation level (m per unit level).
    pub amplitude_per_unit_level_m: Distribution,
    /// Equivalent damping ratio of the resonance; `valid` counts the peaks that have one.
    pub damping_ratio: Distribution,
    /// Amplification factors of a mistuned disk; absent of any other model, and where the samples belong to outer points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplification: Option<AmplificationSummary>,
    /// The maximum of each mode; absent where the study does not follow all modes, and where the samples belong to outer points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modes: Option<Vec<ModeSummary>>,
    /// Means over the replicates of a quasi-random design; absent for any other, and where the samples belong to outer
    /// points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replicate_means: Option<ReplicateMeans>,
    /// Stated relative error of the amplitude by the harmonics left out.
    pub truncation_error: Distribution,
    /// Number of solutions per highest harmonic.
    pub highest_harmonics: BTreeMap<usize, usize>,
    /// Samples whose search met other, lower maxima too.
    pub several_maxima: usize,
    /// Samples with several solutions at some frequency, of those with a curve.
    pub several_answers: SeveralAnswers,
    /// Mean shares of the contact states; absent where the samples belong to outer points.
    pub mean_contact_fractions: Option<ContactFractions>,
    /// Largest |input − viscous − friction| work per cycle over the input work.
    pub worst_work_balance: Option<f64>,
    /// Newton iterations per sample, failed ones included.
    pub newton_iterations: WorkPerSample,
    /// Linear factorisations per sample, failed ones included.
    pub factorizations: WorkPerSample,
    /// How strongly each input orders the results.
    pub rank_correlations: Vec<InputCorrelation>,
    /// How the mixed samples of a pick-freeze design ended; absent for any other design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mixed: Option<MixedSummary>,
}

/// Samples that serve sensitivity indices alone, at one excitation level.
#[derive(Debug, Clone, serde::Serialize, schemars::JsonSchema)]
pub struct MixedSummary {
    /// Number of samples, failed ones included.
    pub samples: usize,
    /// Samples per status, every status listed.
    #[schemars(transform = per_status)]
    pub statuses: BTreeMap<&'static str, usize>,
    /// Samples without a solution: one is enough to refuse the indices.
    pub failed: usize,
}

/// Work of the solver per sample.
#[derive(Debug, Clone, Copy, serde::Serialize, schemars::JsonSchema)]
pub struct WorkPerSample {
    /// Median.
    pub median: Option<f64>,
    /// 95 % quantile.
    pub q95: Option<f64>,
    /// Sum over all samples.
    pub total: usize,
}

impl Summary {
    /// Statistics of a study.
    ///
    /// Shape: every outcome, and the nominal one, has one record per entry of `input.levels`.
    #[must_use]
    pub fn of(input: &ReportInput) -> Self {
        let record = input.record;
        let all = input.outcomes.iter().chain(input.mixed);
        for outcome in all.chain(&record.nominal) {
            assert_eq!(
                outcome.levels.len(),
                record.levels.len(),
                "one record per excitation level"
            );
        }
        Self {
            provenance: record.provenance.clone(),
            inputs: record.inputs.iter().map(|i| i.name.clone()).collect(),
            samples: input.outcomes.len(),
            level_unit: record.level_unit.clone(),
            free_frequency_hz: record.free.frequency_hz,
            stuck_frequency_hz: record.stuck.frequency_hz,
            confidence: CONFIDENCE,
            wall_time_s: record.wall_time_s,
            backend: record.backend.clone(),
            levels: (0..record.levels.len())
                .map(|i| LevelSummary::of(input, i))
                .collect(),
            epistemic: EpistemicSummary::of(input),
        }
    }

    /// Means over replicates with the place of their level and their outer point; empty without replicates.
    #[must_use]
    pub fn replicate_means(&self) -> Vec<(usize, Option<u64>, ReplicateMeans)> {
        let of_level = |(i, l): (usize, &LevelSummary)| Some((i, None, l.replicate_means?));
        let levels = self.levels.iter().enumerate().filter_map(of_level);
        let epistemic = self.epistemic.iter().flat_map(|e| &e.levels).enumerate();
        let of_points = epistemic.flat_map(|(i, l)| {
            let of_point = move |p: &PointStatistics| Some((i, Some(p.outer), p.replicate_means?));
            l.points.iter().filter_map(of_point)
        });
        levels.chain(of_points).collect()
    }
}

impl LevelSummary {
    fn of(input: &ReportInput, i: usize) -> Self {
        let (level, confidence) = (input.record.levels[i], input.record.confidence());
        let records: Vec<&LevelOutcome> = input.outcomes.iter().map(|o| &o.levels[i]).collect();
        // copies of a million peaks would take as much memory as the samples
        let peaks = || records.iter().filter_map(|r| usable_peak(r));
        let solved = peaks().count();
        let failed = records.len() - solved;
        let distribution = |value: &dyn Fn(&PeakRecord) -> Option<f64>| {
            Distribution::of(peaks().filter_map(|peak| value(&peak)), failed, confidence)
        };
        let nested = nested(input.outcomes);
        let population = if nested { &[] } else { input.outcomes };
        let of_population = |value: &dyn Fn(&PeakRecord) -> Option<f64>| match nested {
            true => Distribution {
                valid: peaks().filter_map(|peak| value(&peak)).count(),
                ..Distribution::default()
            },
            false => distribution(value),
        };
        let mut highest_harmonics = BTreeMap::new();
        for peak in peaks() {
            *highest_harmonics
                .entry(peak.highest_harmonic as usize)
                .or_insert(0) += 1;
        }
        Self {
            level,
            statuses: count_statuses(&records),
            routes: count_routes(peaks()),
            failed,
            failure_rate: proportion(failed, population.len(), confidence),
            nominal: input
                .record
                .nominal
                .as_ref()
                .and_then(|o| usable_peak(&o.levels[i])),
            frequency_hz: of_population(&|p| Some(p.frequency_hz)),
            amplitude_m: of_population(&|p| Some(p.amplitude_m)),
            amplitude_per_unit_level_m: of_population(&|p| Some(p.amplitude_m / level)),
            damping_ratio: of_population(&|p| p.damping_ratio.get()),
            amplification: AmplificationSummary::of(&records, nested, confidence),
            modes: of_modes(input, &records, confidence),
            replicate_means: ReplicateMeans::of(population.iter(), i),
            truncation_error: distribution(&|p| p.truncation_error.get()),
            highest_harmonics,
            several_maxima: (records.iter())
                .filter(|r| usable_peak(r).is_some() && !r.around.others().is_empty())
                .count(),
            several_answers: SeveralAnswers::of(input.outcomes, i, confidence),
            mean_contact_fractions: mean_fractions(population.iter(), i),
            worst_work_balance: worst_work_balance(peaks()),
            newton_iterations: WorkPerSample::of(records.iter().map(|r| r.newton_iterations)),
            factorizations: WorkPerSample::of(records.iter().map(|r| r.factorizations)),
            rank_correlations: correlations(input.record, population.iter(), i),
            mixed: MixedSummary::of(input.mixed, i),
        }
    }
}

impl MixedSummary {
    fn of(mixed: &[SampleOutcome], i: usize) -> Option<Self> {
        let records: Vec<&LevelOutcome> = mixed.iter().map(|o| &o.levels[i]).collect();
        let solved = records.iter().filter(|r| usable_peak(r).is_some()).count();
        (!records.is_empty()).then(|| Self {
            samples: records.len(),
            statuses: count_statuses(&records),
            failed: records.len() - solved,
        })
    }
}

impl WorkPerSample {
    fn of(counts: impl Iterator<Item = u32> + Clone) -> Self {
        let sorted = Sorted::finite(counts.clone().map(f64::from));
        Self {
            median: quantile(&sorted, 0.5),
            q95: quantile(&sorted, 0.95),
            total: counts.map(|c| c as usize).sum(),
        }
    }
}

/// The schema of counts that has one for every status.
fn per_status(schema: &mut Schema) {
    one_each(schema, &Status::ALL.map(Status::name));
}

/// The schema of counts that has one for every route.
fn per_route(schema: &mut Schema) {
    one_each(schema, &PeakRoute::ALL.map(PeakRoute::name));
}

fn one_each(schema: &mut Schema, names: &[&str]) {
    schema.insert("propertyNames".to_owned(), json!({ "enum": names }));
    schema.insert("required".to_owned(), json!(names));
}

fn count_statuses(records: &[&LevelOutcome]) -> BTreeMap<&'static str, usize> {
    let mut counts: BTreeMap<_, _> = Status::ALL.iter().map(|s| (s.name(), 0)).collect();
    for record in records {
        *counts.entry(counted_status(record).name()).or_insert(0) += 1;
    }
    counts
}

fn count_routes(peaks: impl Iterator<Item = PeakRecord>) -> BTreeMap<&'static str, usize> {
    let mut counts: BTreeMap<_, _> = PeakRoute::ALL.iter().map(|r| (r.name(), 0)).collect();
    for route in peaks.filter_map(|peak| peak.route) {
        *counts.entry(route.name()).or_insert(0) += 1;
    }
    counts
}

fn worst_work_balance(peaks: impl Iterator<Item = PeakRecord>) -> Option<f64> {
    peaks
        .filter_map(|peak| work_imbalance(&peak))
        .reduce(f64::max)
}
