//! The numbers of a comparison: `comparison.json`.
//!
//! Sample i of every design has the same random numbers, so the difference of a pair is due to the designs alone where it is larger than
//! the numerical errors of both. A pair of which one failed or is not to be trusted is unknown, never dropped. With epistemic inputs the samples of each outer point are compared
//! apart: together they are no population.

use crate::ensemble::outcome::{PeakRecord, SampleOutcome};
use crate::report::convention::CONFIDENCE;
use crate::report::numbers::allowable::factor;
use crate::report::numbers::margins::smallest_margin;
use crate::report::numbers::outer_points::{chosen, outer_groups};
use crate::report::numbers::peaks::trusted_peak;
use crate::report::run::record::InputRecord;
use crate::report::run::stored_run::StoredRun;
use crate::report::verdict::NumericalErrors;
use crate::statistics::{Better, Bootstrap, Comparison, Enclosed, Ranking, compare, rank_designs};
use serde::Serialize;
use std::path::Path;

/// Relative error of a peak without an estimated one: what results differ by less than says nothing about the designs.
const RESOLUTION: f64 = 5e-7;
/// Resamples behind the probability of a ranking.
const REPLICATES: u32 = 1000;

/// A number of a peak in which designs are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Compared {
    /// Resonance frequency (Hz); a higher one is not better in itself.
    FrequencyHz,
    /// Amplitude (m).
    AmplitudeM,
    /// Smallest distance to an engine order, a share.
    FrequencyMargin,
    /// Allowable over actual alternating stress.
    ReserveFactor,
}

impl Compared {
    /// All, in the order of tables.
    pub const ALL: [Self; 4] = [
        Self::FrequencyHz,
        Self::AmplitudeM,
        Self::FrequencyMargin,
        Self::ReserveFactor,
    ];

    /// Which side "better" means in the shares.
    #[must_use]
    pub fn better(self) -> Better {
        match self {
            Self::AmplitudeM => Better::Smaller,
            Self::FrequencyHz | Self::FrequencyMargin | Self::ReserveFactor => Better::Larger,
        }
    }

    /// Probability of the quantile by which designs are ranked: the one that 95 % of the assumed prior keep. A frequency has none.
    #[must_use]
    pub fn ranked_by(self) -> Option<f64> {
        match self {
            Self::FrequencyHz => None,
            Self::AmplitudeM => Some(0.95),
            Self::FrequencyMargin | Self::ReserveFactor => Some(0.05),
        }
    }

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FrequencyHz => "resonance frequency",
            Self::AmplitudeM => "amplitude",
            Self::FrequencyMargin => "frequency margin",
            Self::ReserveFactor => "reserve factor",
        }
    }

    /// Whether it is the distance to a limit.
    #[must_use]
    pub fn is_margin(self) -> bool {
        matches!(self, Self::FrequencyMargin | Self::ReserveFactor)
    }

    /// What the share of the better samples is called: a frequency is only higher.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::FrequencyHz => "higher",
            _ => "better",
        }
    }

    /// One result per sample at level `i`, with what may be wrong in it: harmonics left out, and the place of the peak, as far as they are
    /// estimated. Unknown where a sample failed or is not to be trusted; `None` without the table that the number needs.
    pub(super) fn of(self, run: &StoredRun, i: usize) -> Option<Vec<Enclosed>> {
        let requirements = &run.record.requirements;
        let (operation, stress) = (
            requirements.operation.as_ref(),
            requirements.stress.as_ref(),
        );
        let lacks = match self {
            Self::FrequencyHz | Self::AmplitudeM => false,
            Self::FrequencyMargin => operation.is_none(),
            Self::ReserveFactor => stress.is_none(),
        };
        let errors = NumericalErrors::of(&run.input(), &[]);
        let half = |ends: Enclosed| 0.5 * (ends.upper - ends.lower);
        let enclosed = |peak: PeakRecord| {
            let shift = half(errors.frequency(&peak));
            let share = half(errors.amplitude(i, &peak)) / peak.amplitude_m;
            let (value, error) = match self {
                Self::FrequencyHz => (peak.frequency_hz, shift),
                Self::AmplitudeM => (peak.amplitude_m, share * peak.amplitude_m),
                // a share of the frequency already
                Self::FrequencyMargin => (
                    operation.map_or(f64::NAN, |o| smallest_margin(peak.frequency_hz, o)),
                    shift / peak.frequency_hz,
                ),
                Self::ReserveFactor => {
                    let value = stress.map_or(f64::NAN, |s| factor(peak.amplitude_m, s));
                    (value, share * value)
                }
            };
            Enclosed::within(value, error.max(self.resolution(value)))
        };
        let of = |outcome: &SampleOutcome| {
            trusted_peak(&outcome.levels[i]).map_or(Enclosed::UNKNOWN, enclosed)
        };
        (!lacks).then(|| run.outcomes.iter().map(of).collect())
    }

    /// What is wrong at least in a value, whatever is estimated.
    fn resolution(self, value: f64) -> f64 {
        match self {
            Self::FrequencyMargin => RESOLUTION,
            _ => RESOLUTION * value.abs(),
        }
    }
}

/// What a comparison says in numbers.
#[derive(Debug, Clone, Serialize)]
pub struct DesignComparison {
    /// The designs, in the order of the arguments.
    pub designs: Vec<ComparedDesign>,
    /// Number of common samples, failed ones included.
    pub samples: usize,
    /// Common seed.
    pub seed: u64,
    /// Common design of the samples, in words.
    pub sampling: String,
    /// Whether the samples are independent draws, as the intervals presume.
    pub independent: bool,
    /// Inputs whose distribution differs: they belong to the designs, paired at equal probability.
    pub design_inputs: Vec<String>,
    /// Confidence of every interval.
    pub confidence: f64,
    /// Unit of the excitation levels.
    pub level_unit: String,
    /// One entry per excitation level.
    pub levels: Vec<ComparedLevel>,
}

/// One of the designs.
#[derive(Debug, Clone, Serialize)]
pub struct ComparedDesign {
    /// `A`, `B`, …
    pub label: String,
    /// Name of its study.
    pub study: String,
    /// Folder of its results, as given.
    pub folder: String,
    /// Its random inputs.
    pub inputs: Vec<InputRecord>,
}

/// Comparison at one excitation level.
#[derive(Debug, Clone, Serialize)]
pub struct ComparedLevel {
    /// Excitation level.
    pub level: f64,
    /// One entry per number that all designs have.
    pub quantities: Vec<ComparedQuantity>,
}

/// Comparison of one number.
#[derive(Debug, Clone, Serialize)]
pub struct ComparedQuantity {
    /// The number, with its unit.
    pub quantity: Compared,
    /// Every pair of designs, at every outer point.
    pub pairs: Vec<Pair>,
    /// Order of all designs, at every outer point; empty where no value is better.
    pub rankings: Vec<PointRanking>,
}

/// Two designs on the same samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pair {
    /// Place of the first design.
    pub a: usize,
    /// Place of the second one.
    pub b: usize,
    /// Outer point; absent without epistemic inputs.
    pub outer: Option<u64>,
    /// Differences a − b, in the unit of the quantity, and the shares of the samples.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Order of the designs by a quantile.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointRanking {
    /// Outer point; absent without epistemic inputs.
    pub outer: Option<u64>,
    /// Probability of the quantile.
    pub quantile: f64,
    /// Places of the designs, best first, and how sure that is.
    #[serde(flatten)]
    pub ranking: Ranking,
}

/// Label of the design at a place: `A`, `B`, …, `Z`, then numbers.
#[must_use]
pub fn label(place: usize) -> String {
    match u8::try_from(place) {
        Ok(k) if k < 26 => char::from(b'A' + k).to_string(),
        _ => (place + 1).to_string(),
    }
}

impl DesignComparison {
    /// Compares the runs of `folders`.
    ///
    /// Shape: all runs have the same samples, by index, and the same levels and input names.
    #[must_use]
    pub fn of(folders: &[&Path], runs: &[StoredRun]) -> Self {
        let first = &runs[0].record;
        let design = |(k, (folder, run)): (usize, (&&Path, &StoredRun))| ComparedDesign {
            label: label(k),
            study: run.record.provenance.study.clone(),
            folder: folder.display().to_string(),
            inputs: run.record.inputs.clone(),
        };
        let differs = |j: &usize| {
            let prior = |run: &StoredRun| run.record.inputs[*j].prior != first.inputs[*j].prior;
            runs.iter().any(prior)
        };
        Self {
            designs: folders.iter().zip(runs).enumerate().map(design).collect(),
            samples: runs[0].outcomes.len(),
            seed: first.provenance.seed,
            sampling: first.design.description.clone(),
            independent: first.design.independent,
            design_inputs: (0..first.inputs.len())
                .filter(differs)
                .map(|j| first.inputs[j].name.clone())
                .collect(),
            confidence: CONFIDENCE,
            level_unit: first.level_unit.clone(),
            levels: (0..first.levels.len())
                .map(|i| ComparedLevel::of(runs, i))
                .collect(),
        }
    }
}

impl ComparedLevel {
    fn of(runs: &[StoredRun], i: usize) -> Self {
        let quantity = |compared: Compared| {
            let designs: Option<Vec<Vec<Enclosed>>> =
                runs.iter().map(|run| compared.of(run, i)).collect();
            Some(ComparedQuantity::of(compared, &designs?, runs))
        };
        Self {
            level: runs[0].record.levels[i],
            quantities: Compared::ALL.into_iter().filter_map(quantity).collect(),
        }
    }
}

impl ComparedQuantity {
    /// Whether no pair of designs at an outer point differs in any sample by more than its errors: an order of them says nothing.
    #[must_use]
    pub fn all_tied(&self, outer: Option<u64>) -> bool {
        let mut pairs = self.pairs.iter().filter(|pair| pair.outer == outer);
        pairs.all(|pair| {
            let shares = [&pair.comparison.a_better, &pair.comparison.b_better];
            shares.iter().all(|share| share.yes + share.unknown == 0)
        })
    }

    /// Shape of `designs`: designs × samples.
    fn of(quantity: Compared, designs: &[Vec<Enclosed>], runs: &[StoredRun]) -> Self {
        let bootstrap = Bootstrap {
            seed: runs[0].record.provenance.seed,
            replicates: REPLICATES,
            confidence: CONFIDENCE,
        };
        let (mut pairs, mut rankings) = (Vec::new(), Vec::new());
        for (outer, members) in outer_groups(&runs[0].outcomes) {
            let here: Vec<Vec<Enclosed>> = designs.iter().map(|v| chosen(v, &members)).collect();
            for b in 1..here.len() {
                for a in 0..b {
                    let found = compare(&here[a], &here[b], quantity.better(), CONFIDENCE);
                    pairs.extend(found.map(|comparison| Pair {
                        a,
                        b,
                        outer,
                        comparison,
                    }));
                }
            }
            let ranked = quantity.ranked_by().and_then(|quantile| {
                let ranking = rank_designs(&here, quantile, quantity.better(), &bootstrap)?;
                Some(PointRanking {
                    outer,
                    quantile,
                    ranking,
                })
            });
            rankings.extend(ranked);
        }
        Self {
            quantity,
            pairs,
            rankings,
        }
    }
}
