//! From the inputs of a sample to its outcome, for many samples at once.
//!
//! The outcome of sample i is a function of the study and i alone: samples share nothing but read-only data, so the
//! number of threads and the order of the samples change no bit.

use super::atlas::{Anchor, AnchorPeak, Atlas, AtlasPrediction};
use super::outcome::{CurvePoint, LevelOutcome, PeakRecord, SampleOutcome};
use crate::contact::ContactParameters;
use crate::hb::curve::response_curve;
use crate::hb::newton::{Point, WorkCount};
use crate::hb::peak::PeakSettings;
use crate::hb::predicted::{PeakPrediction, maximum_near};
use crate::hb::refine::refined_near;
use crate::hb::track::{LevelPeak, track_peaks};
use crate::hb::{Balance, HbSettings, LinearModel, Problem, ProblemError, Solution, Status};
use crate::sampling::{Design, Input};
use crate::units::rad_s_to_hz;
use rayon::prelude::*;

/// What all samples of a study share.
#[derive(Debug, Clone, Copy)]
pub struct Ensemble<'a> {
    /// Linear part of the model.
    pub linear: &'a LinearModel,
    /// Nominal constants of the contact pairs.
    pub contacts: &'a [ContactParameters<f64>],
    /// Random inputs.
    pub design: &'a Design,
    /// Excitation levels, ascending.
    pub levels: &'a [f64],
    /// Solver.
    pub settings: &'a HbSettings,
    /// Where peaks are searched and how exactly.
    pub peak: PeakSettings,
    /// Samples with a forced response curve: 0 … this − 1.
    pub curve_samples: u64,
}

/// Samples solved without help: the first part of the atlas.
const FIRST_ANCHORS: u64 = 32;
/// Samples in the atlas at most.
const MOST_ANCHORS: u64 = 1024;
/// Relative distance between the predicted and the found amplitude from which the prediction is not trusted to have
/// led to the same branch.
const SURPRISE: f64 = 0.2;

impl Ensemble<'_> {
    /// Outcomes of the samples 0 … `samples` − 1, in that order; `done` is called after each, from any thread.
    ///
    /// The first samples are solved on their own, each later one starts from samples before the last power of two: what
    /// sample i starts from depends on i, not on the order of solving or the number of samples.
    #[must_use]
    pub fn run(&self, samples: u64, done: impl Fn() + Sync) -> Vec<SampleOutcome> {
        let mut atlas = Atlas::default();
        let mut outcomes = Vec::new();
        let mut first = 0;
        while first < samples {
            let end = match first {
                0 => FIRST_ANCHORS,
                _ if first < MOST_ANCHORS => 2 * first,
                _ => samples,
            };
            let solved: Vec<(SampleOutcome, Option<Anchor>)> = (first..end.min(samples))
                .into_par_iter()
                .map(|index| {
                    let (outcome, anchor) = self.sample(index, &atlas);
                    done();
                    (outcome, (index < MOST_ANCHORS).then_some(anchor))
                })
                .collect();
            let (solved, anchors): (Vec<_>, Vec<_>) = solved.into_iter().unzip();
            outcomes.extend(solved);
            atlas.extend(anchors.into_iter().flatten());
            first = end;
        }
        outcomes
    }

    /// Outcome of one sample and what it is to others, started from `atlas`.
    #[must_use]
    pub fn sample(&self, index: u64, atlas: &Atlas) -> (SampleOutcome, Anchor) {
        let inputs = self.design.sample(index);
        let place = (self.design.inputs().iter().zip(&inputs))
            .map(|((_, distribution), value)| distribution.cdf(*value))
            .collect();
        self.outcome(index, inputs, place, atlas)
    }

    /// Outcome at the nominal constants of the study. Inputs are NaN-free but meaningless: none was sampled.
    #[must_use]
    pub fn nominal(&self) -> SampleOutcome {
        let alone = Atlas::default();
        self.outcome(0, Vec::new(), Vec::new(), &alone).0
    }

    /// Outcome at the given inputs, in the order of the design; nominal where `inputs` is empty.
    fn outcome(
        &self,
        index: u64,
        inputs: Vec<f64>,
        place: Vec<f64>,
        atlas: &Atlas,
    ) -> (SampleOutcome, Anchor) {
        let values = self
            .design
            .inputs()
            .iter()
            .map(|(input, _)| *input)
            .zip(inputs.iter().copied());
        let (contacts, load_scale) = apply_inputs(self.contacts, values);
        let curve = index < self.curve_samples;
        let solved = Problem::new(self.linear, contacts, load_scale, self.settings.anchor)
            .and_then(|problem| {
                let peaks = self.peaks(&problem, &place, atlas)?;
                let anchor = |peak: &LevelPeak| Some(AnchorPeak::new(peak.solution.as_ref()?));
                let anchors = peaks.iter().map(anchor).collect();
                let level = |peak| self.level(&problem, peak, curve);
                Ok((peaks.into_iter().map(level).collect(), anchors))
            });
        let (levels, anchors) = solved
            .unwrap_or_else(|error| (self.without_problem(&error), vec![None; self.levels.len()]));
        let outcome = SampleOutcome {
            index,
            inputs,
            levels,
        };
        let anchor = Anchor {
            place,
            peaks: anchors,
        };
        (outcome, anchor)
    }

    /// Peaks at all levels: from the atlas where that leads to what it promised, the others by their own track.
    fn peaks(
        &self,
        problem: &Problem<'_>,
        place: &[f64],
        atlas: &Atlas,
    ) -> Result<Vec<LevelPeak>, ProblemError> {
        let mut spent = vec![WorkCount::default(); self.levels.len()];
        let mut peaks: Vec<Option<LevelPeak>> = (spent.iter_mut().enumerate())
            .map(|(level, spent)| self.predicted(problem, atlas.predict(place, level)?, spent))
            .collect();
        let missing: Vec<usize> = (0..peaks.len()).filter(|&i| peaks[i].is_none()).collect();
        if !missing.is_empty() {
            let levels: Vec<f64> = missing.iter().map(|&i| self.levels[i]).collect();
            let tracked = track_peaks(problem, self.settings, self.peak, &levels)?;
            for (i, mut peak) in missing.into_iter().zip(tracked) {
                peak.count += spent[i];
                peaks[i] = Some(peak);
            }
        }
        Ok(peaks.into_iter().flatten().collect())
    }

    /// The peak that a prediction leads to, unless that is not what it promised.
    fn predicted(
        &self,
        problem: &Problem<'_>,
        prediction: AtlasPrediction,
        spent: &mut WorkCount,
    ) -> Option<LevelPeak> {
        let AtlasPrediction {
            harmonics,
            peak,
            amplitude,
        } = prediction;
        let found = refined_near(problem, &harmonics, peak, self.settings, self.peak);
        match found {
            Ok(solution) => {
                *spent = solution.work_count;
                let surprise = (solution.amplitude(0) / amplitude - 1.0).abs();
                (surprise < SURPRISE).then(|| LevelPeak::found(solution))
            }
            Err((e, work)) => {
                *spent = work;
                None
            }
        }
    }

    /// Record of one level, with the forced response through its peak if wanted.
    fn level(&self, problem: &Problem<'_>, peak: LevelPeak, with_curve: bool) -> LevelOutcome {
        let mut count = peak.count;
        let curve = (peak.solution.as_ref().filter(|_| with_curve))
            .map_or_else(Vec::new, |solution| {
                self.curve(problem, solution, &mut count)
            });
        LevelOutcome {
            level: peak.level,
            status: peak.status,
            peak: peak.solution.as_ref().map(record),
            curve,
            newton_iterations: count.iterations,
            factorizations: count.factorizations,
        }
    }

    /// The forced response through a peak, on the study's own harmonics: the picture needs no more, the peak may have.
    fn curve(
        &self,
        problem: &Problem<'_>,
        solution: &Solution,
        count: &mut WorkCount,
    ) -> Vec<CurvePoint> {
        let newton = self.settings.newton;
        let harmonics = &self.settings.harmonics;
        let balance = Balance::new(problem, harmonics.clone(), self.settings.aft);
        let n_relative = balance.layout.n_relative();
        let r = solution
            .harmonics
            .convert(&solution.relative, n_relative, harmonics);
        let response = solution.first_harmonic(0);
        let prediction = PeakPrediction {
            point: Point {
                r,
                omega: solution.omega,
                level: solution.level,
            },
            phasor: response / response.norm(),
        };
        let Ok(peak) = maximum_near(&balance, prediction, self.peak, newton, count) else {
            return Vec::new();
        };
        let (curve, work) = response_curve(&balance, &peak.point, self.peak.band, newton);
        *count += work;
        (curve.iter())
            .map(|point| CurvePoint {
                frequency_hz: rad_s_to_hz(point.omega),
                amplitude_m: point.amplitude,
            })
            .collect()
    }

    /// A sample whose constants make no harmonic balance problem fails at every level.
    fn without_problem(&self, error: &ProblemError) -> Vec<LevelOutcome> {
        let status = match error {
            ProblemError::Linalg(_) => Status::NonFinite,
            _ => Status::NotHeld,
        };
        (self.levels.iter())
            .map(|&level| LevelOutcome {
                level,
                status,
                peak: None,
                curve: Vec::new(),
                newton_iterations: 0,
                factorizations: 0,
            })
            .collect()
    }
}

/// Contact constants and factor on the static load at the given input values.
fn apply_inputs(
    nominal: &[ContactParameters<f64>],
    values: impl Iterator<Item = (Input, f64)>,
) -> (Vec<ContactParameters<f64>>, f64) {
    let mut contacts = nominal.to_vec();
    let mut load_scale = 1.0;
    for (input, value) in values {
        for contact in &mut contacts {
            match input {
                Input::StiffnessScale => {
                    contact.k_n *= value;
                    contact.k_t = contact.k_t.map(|k| k * value);
                }
                Input::NormalStiffnessScale => contact.k_n *= value,
                Input::TangentialStiffnessScale => contact.k_t = contact.k_t.map(|k| k * value),
                Input::FrictionCoefficient => contact.mu = value,
                Input::StaticLoadScale => {}
            }
        }
        if input == Input::StaticLoadScale {
            load_scale = value;
        }
    }
    (contacts, load_scale)
}

fn record(solution: &Solution) -> PeakRecord {
    PeakRecord {
        frequency_hz: rad_s_to_hz(solution.omega),
        amplitude_m: solution.amplitude(0),
        truncation_error: solution.truncation_error,
        highest_harmonic: solution.harmonics.highest(),
        stick_fraction: solution.contact.stick,
        slip_fraction: solution.contact.slip,
        separated_fraction: solution.contact.separated,
        work_input_j: solution.work.input,
        work_viscous_j: solution.work.viscous,
        work_friction_j: solution.work.friction,
        residual: solution.residual,
    }
}
