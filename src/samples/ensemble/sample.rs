//! One sample: from its inputs to its peaks, curves and record.
//!
//! The peak is the highest maximum in the band, of those that grow from the modes of the stuck and the free structure
//! ([`crate::hb::peak::maxima`]); `mode_search` looks for that of one mode.

use super::applied::Applied;
use super::atlas::{Anchor, Atlas, ModePeaks};
use super::mode_search::ModeOfSample;
use super::outcome::{
    AroundPeak, CurvePoint, LevelOutcome, Maximum, PeakRecord, SampleOutcome, SweepRecord,
};
use super::shared::{Ensemble, SampleSolver};
use super::times::SampleTimes;
use crate::hb::equations::balance::balance_on;
use crate::hb::newton::rest::stiffness_at_rest;
use crate::hb::peak::branch_maximum::{Extent, other_on_branch};
use crate::hb::peak::maxima::{Maxima, ON_BRANCH, add_other_on_branches, search_maxima};
use crate::hb::peak::predicted::on_harmonics;
use crate::hb::response::curve::{self, response_curve};
use crate::hb::structure::resonance::{Candidate, candidates};
use crate::hb::{HbSettings, Problem, ProblemError, Solution, StabilityScope, Status};
use crate::sampling::design::in_32_bits;
use crate::units::rad_s_to_hz;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// What an outcome belongs to.
#[derive(Debug, Clone, Copy)]
enum Subject {
    /// The nominal constants of the study.
    Nominal,
    /// The sample with this index.
    Sample(u64),
}

/// Whether the stability of a curve is assessed, as far as the settings ask for it. That takes longer than the curve itself, and the curves
/// of samples are only drawn as a band.
#[derive(Debug, Clone, Copy)]
enum CurveStability {
    Assessed,
    NotAssessed,
}

/// What is found at some inputs.
pub(super) struct SampleResult {
    /// Shape: `[levels]`.
    pub(super) levels: Vec<LevelOutcome>,
    /// The peaks as starts for other samples. Shape: `[levels]`.
    pub(super) peaks: Vec<ModePeaks>,
    pub(super) times: SampleTimes,
}

impl Ensemble<'_> {
    /// Outcome of sample `index`, and its peaks as starts for other samples; its own starts come from `atlas`.
    #[must_use]
    pub fn sample(&self, index: u64, atlas: &Atlas) -> (SampleOutcome, Anchor) {
        let (outcome, anchor, _) = self.timed_sample(index, atlas);
        (outcome, anchor)
    }

    /// The same with its time.
    pub(super) fn timed_sample(
        &self,
        index: u64,
        atlas: &Atlas,
    ) -> (SampleOutcome, Anchor, SampleTimes) {
        self.outcome(Subject::Sample(index), atlas)
    }

    /// Outcome at the nominal constants of the study, with curves however many samples have them. Its `inputs` are empty: none
    /// was sampled.
    #[must_use]
    pub fn nominal(&self) -> SampleOutcome {
        self.outcome(Subject::Nominal, &Atlas::default()).0
    }

    /// The levels of this outcome alone, without curves.
    #[must_use]
    pub fn nominal_levels(&self) -> Vec<LevelOutcome> {
        self.found_at(&[], &[], &Atlas::default(), None).levels
    }

    fn outcome(&self, subject: Subject, atlas: &Atlas) -> (SampleOutcome, Anchor, SampleTimes) {
        let (index, inputs) = match subject {
            Subject::Nominal => (0, Vec::new()),
            Subject::Sample(index) => (index, self.design.sample(index)),
        };
        let group = self.design.group(index);
        let (place, curve) = match subject {
            // who wants no curves of samples waits for no verdict on the nominal ones
            Subject::Nominal if self.curve_samples == 0 => {
                (Vec::new(), Some(CurveStability::NotAssessed))
            }
            Subject::Nominal => (Vec::new(), Some(CurveStability::Assessed)),
            // bands are of the population
            Subject::Sample(_) => (
                self.design.place(&inputs),
                (index < self.curve_samples && group.of_population())
                    .then_some(CurveStability::NotAssessed),
            ),
        };
        let SampleResult {
            levels,
            peaks,
            times,
        } = self.found_at(&inputs, &place, atlas, curve);
        let outcome = SampleOutcome {
            index,
            group,
            inputs: inputs.into(),
            levels: levels.into(),
        };
        (outcome, Anchor { place, peaks }, times)
    }

    /// Records of the levels at any inputs, in the order of the design, without curves. They start from `atlas`, and depend on it and
    /// the inputs alone: a sample with this atlas has the same bits. Shape: `[levels]`.
    ///
    /// Nothing is checked: [`crate::sampling::Input::accepts_value`] has the rules.
    #[must_use]
    pub fn levels(&self, inputs: &[f64], atlas: &Atlas) -> Vec<LevelOutcome> {
        let place = self.design.place(inputs);
        self.found_at(inputs, &place, atlas, None).levels
    }

    /// Records of the levels, with the forced response if wanted.
    fn found_at(
        &self,
        inputs: &[f64],
        place: &[f64],
        atlas: &Atlas,
        curve: Option<CurveStability>,
    ) -> SampleResult {
        let solved = || match (self.solver, self.mistuned) {
            // without inputs it is the nominal disk, which is tuned
            (SampleSolver::HarmonicBalance, Some(disk)) if !inputs.is_empty() => {
                self.mistuned(disk, inputs, place)
            }
            (SampleSolver::HarmonicBalance, _) => self.balanced(inputs, place, atlas, curve),
            #[cfg(feature = "test-functions")]
            (SampleSolver::Function(function), _) => self.evaluated(function, inputs),
        };
        // a defect of the program costs this sample, not the run
        let solved = catch_unwind(AssertUnwindSafe(solved));
        solved.unwrap_or_else(|_| self.without_solution(Status::Panicked))
    }

    /// The same by harmonic balance.
    fn balanced(
        &self,
        inputs: &[f64],
        place: &[f64],
        atlas: &Atlas,
        curve: Option<CurveStability>,
    ) -> SampleResult {
        let begun = Instant::now();
        let solved = self.applied(inputs).and_then(|applied| {
            let levels = self.applied_levels(&applied);
            let problem = applied
                .problem(self.settings.anchor)
                .map_err(|error| error.status())?;
            let peaks = self.peaks(&problem, &levels, place, atlas);
            let peaks = peaks.map_err(|error| error.status())?;
            let to_peaks = begun.elapsed();
            let shapes = self.mode_shapes(problem.model);
            let level = |(found, nominal)| {
                let mut level = self.level(&problem, found, nominal, curve);
                if let Some(shapes) = &shapes {
                    let modes = self.followed_modes(&problem, shapes, found);
                    level.around.set_modes(modes);
                }
                level
            };
            let of_levels = peaks.iter().zip(self.levels.iter().copied());
            let levels: Vec<_> = of_levels.map(level).collect();
            Ok(SampleResult {
                peaks: peaks.iter().map(ModePeaks::new).collect(),
                times: SampleTimes::until_now(begun, to_peaks, &problem.effort, &levels),
                levels,
            })
        });
        solved.unwrap_or_else(|status| self.without_solution(status))
    }

    /// The same from a function, which is the same at every level; of the medians where `inputs` is empty.
    #[cfg(feature = "test-functions")]
    fn evaluated(
        &self,
        function: super::test_function::TestFunction,
        inputs: &[f64],
    ) -> SampleResult {
        let peak = match inputs {
            [] => function.peak(&self.design.medians()),
            inputs => function.peak(inputs),
        };
        self.everywhere(Status::Converged, Some(peak))
    }

    /// Excitation levels of a sample. Shape: `[levels]`.
    pub(super) fn applied_levels(&self, applied: &Applied) -> Vec<f64> {
        (self.levels.iter())
            .map(|level| level * applied.excitation_scale)
            .collect()
    }

    /// Maxima at the sample's own `levels`.
    pub(super) fn peaks(
        &self,
        problem: &Problem<'_>,
        levels: &[f64],
        place: &[f64],
        atlas: &Atlas,
    ) -> Result<Vec<Maxima>, ProblemError> {
        let stiffness = stiffness_at_rest(problem, self.settings.aft, self.peak.band.low);
        let modes = candidates(problem.model, &stiffness, self.peak.band)?;
        let mut extents: Vec<Option<Extent>> = vec![None; levels.len()];
        let search = |mode: &Candidate, wanted: &[usize], known: &[Maxima]| {
            let of_mode = ModeOfSample {
                problem,
                mode,
                stiffness: &stiffness,
                levels,
                place,
                known,
            };
            let found = self.of_mode(&of_mode, wanted, atlas);
            for (level, found) in wanted.iter().zip(&found) {
                if found.is_doubtful {
                    extents[*level] = Some(Extent::Resonance);
                }
            }
            Ok::<_, ProblemError>(found)
        };
        let mut maxima = search_maxima(&modes, self.choice, levels, search)?;
        for (level, extent) in extents.iter_mut().enumerate() {
            for mode in modes_on_branches(&modes, &atlas.modes_near(place, level)) {
                let of_mode = ModeOfSample {
                    problem,
                    mode: &mode,
                    stiffness: &stiffness,
                    levels,
                    place,
                    known: &maxima,
                };
                let found = self.found_from_atlas(&of_mode, level, atlas);
                if !maxima[level].add_predicted_on_branch(mode.mode, found) {
                    *extent = Some(Extent::Band);
                }
            }
        }
        let along = |found: &Solution, extent| {
            other_on_branch(problem, self.settings, self.peak, found, extent)
        };
        add_other_on_branches(&mut maxima, self.choice, &extents, along);
        Ok(maxima)
    }

    /// Record of the nominal level `level`, with the forced response through its peak if wanted.
    fn level(
        &self,
        problem: &Problem<'_>,
        maxima: &Maxima,
        level: f64,
        curve: Option<CurveStability>,
    ) -> LevelOutcome {
        let mut count = maxima.count;
        let before = problem.effort.count();
        let peak = (maxima.peak()).map(|peak| peak.clone().with_stability(problem, self.settings));
        let (curve, sweeps) = Option::zip(peak.as_ref(), curve)
            .map_or_else(Default::default, |(solution, stability)| {
                self.curve(problem, solution, stability)
            });
        count += problem.effort.count().since(before);
        LevelOutcome {
            level,
            status: peak
                .as_ref()
                .map_or_else(|| maxima.status(), |peak| peak.status),
            around: AroundPeak::new(
                peak.as_ref().map_or_else(Vec::new, |_| others(maxima)),
                curve,
                sweeps,
            ),
            peak: (peak.as_ref()).map(|peak| record(peak, peak.amplitude(0))),
            newton_iterations: in_32_bits(count.iterations),
            factorizations: in_32_bits(count.factorizations),
        }
    }

    /// The forced response through a peak, on the study's own harmonics, and what sweeps meet. These harmonics are enough for a plot;
    /// the peak may have more.
    fn curve(
        &self,
        problem: &Problem<'_>,
        solution: &Solution,
        stability: CurveStability,
    ) -> (Vec<CurvePoint>, Option<SweepRecord>) {
        let newton = self.settings.newton;
        let harmonics = &self.settings.harmonics;
        let balance = balance_on(problem, harmonics.clone(), self.settings);
        problem.effort.grant(self.settings.newton.budget);
        // the curve may start beside the maximum
        let start = on_harmonics(&balance, solution, self.peak, newton);
        let Ok(start) = start else {
            return Default::default();
        };
        let assessed = match stability {
            CurveStability::Assessed => self.settings.stability,
            CurveStability::NotAssessed => StabilityScope::Off,
        };
        let settings = HbSettings {
            stability: assessed,
            ..self.settings.clone()
        };
        let found = response_curve(&balance, &start, self.peak.band, &settings);
        let sweeps = found.sweeps.map(|sweeps| SweepRecord {
            upward: maximum(sweeps.upward.omega, sweeps.upward.amplitude),
            downward: maximum(sweeps.downward.omega, sweeps.downward.amplitude),
            several_hz: sweeps.several.map(|ends| ends.map(rad_s_to_hz)),
        });
        (found.points.into_iter().map(drawn).collect(), sweeps)
    }

    /// A sample that fails at every level.
    pub(super) fn without_solution(&self, status: Status) -> SampleResult {
        self.everywhere(status, None)
    }

    /// The same at every level, without a start for other samples.
    fn everywhere(&self, status: Status, peak: Option<PeakRecord>) -> SampleResult {
        let levels = (self.levels.iter()).map(|&level| LevelOutcome {
            level,
            status,
            peak,
            around: AroundPeak::default(),
            newton_iterations: 0,
            factorizations: 0,
        });
        SampleResult {
            levels: levels.collect(),
            peaks: vec![ModePeaks::default(); self.levels.len()],
            times: SampleTimes::default(),
        }
    }
}

/// Of the modes `near` that are maxima on the branches of others, those of the sample's own `candidates`.
fn modes_on_branches(candidates: &[Candidate], near: &BTreeSet<usize>) -> Vec<Candidate> {
    let on_branch = near.iter().filter(|mode| **mode >= ON_BRANCH);
    let of_sample = |&mode: &usize| {
        let mut own = candidates.iter();
        let own = own.find(|candidate| candidate.mode == mode % ON_BRANCH)?;
        Some(Candidate {
            mode,
            ..own.clone()
        })
    };
    on_branch.filter_map(of_sample).collect()
}

fn drawn(point: curve::CurvePoint) -> CurvePoint {
    CurvePoint {
        frequency_hz: rad_s_to_hz(point.omega),
        amplitude_m: point.amplitude,
        unstable: point.unstable,
    }
}

/// The maxima below the highest one.
fn others(maxima: &Maxima) -> Vec<Maximum> {
    let others = maxima.distinct().into_iter().skip(1);
    others
        .map(|other| maximum(other.omega, other.amplitude(0)))
        .collect()
}

fn maximum(omega: f64, amplitude_m: f64) -> Maximum {
    Maximum {
        frequency_hz: rad_s_to_hz(omega),
        amplitude_m,
    }
}

/// What is stored of a peak; `amplitude_m` is that of the response that defines it.
pub(super) fn record(solution: &Solution, amplitude_m: f64) -> PeakRecord {
    PeakRecord {
        frequency_hz: rad_s_to_hz(solution.omega),
        amplitude_m,
        route: solution.route,
        truncation_error: solution.truncation_error.into(),
        multiplier_real: solution.stability.map(|s| s.multiplier.re).into(),
        multiplier_imaginary: solution.stability.map(|s| s.multiplier.im).into(),
        highest_harmonic: in_32_bits(solution.harmonics.highest()),
        stick_fraction: solution.contact.stick,
        slip_fraction: solution.contact.slip,
        separated_fraction: solution.contact.separated,
        work_input_j: solution.work.input,
        work_viscous_j: solution.work.viscous,
        work_friction_j: solution.work.friction,
        damping_ratio: solution.damping_ratio().into(),
        residual: solution.residual,
    }
}
