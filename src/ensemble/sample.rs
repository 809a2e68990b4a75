//! One sample: from its inputs to its peaks, curves and record.
//!
//! The peak is the highest maximum in the band, of those that grow from the modes of the stuck and the free structure
//! ([`crate::hb::peak::maxima`]). The maximum of a mode is predicted from the atlas and corrected, by damped steps where undamped ones fail. Where that fails it is
//! followed from the nearest anchor along the straight line between the inputs, and where that fails too the sample's own
//! track from the stuck state decides.

use super::applied::Applied;
use super::atlas::{Anchor, AnchorPeak, Atlas, AtlasPrediction, ModePeaks, Place};
use super::outcome::{CurvePoint, LevelOutcome, OtherMaximum, PeakRecord, SampleOutcome};
use super::{Ensemble, SampleSolver};
use crate::hb::equations::balance::balance_on;
use crate::hb::newton::WorkCount;
use crate::hb::newton::rest::stiffness_at_rest;
use crate::hb::peak::level_peak::LevelPeak;
use crate::hb::peak::maxima::{Maxima, ModeSearch, search_maxima};
use crate::hb::peak::predicted::{PeakPrediction, correct, maximum_near, phase_locked};
use crate::hb::peak::refine::refined_near;
use crate::hb::peak::search::PeakSettings;
use crate::hb::peak::track::track_mode;
use crate::hb::response::curve::response_curve;
use crate::hb::structure::resonance::{Candidate, candidates};
use crate::hb::{Balance, NewtonSettings, Problem, ProblemError, Solution, Status};
use crate::units::rad_s_to_hz;

/// Relative distance between the predicted and the found amplitude from which the prediction is not trusted to have
/// led to the same branch.
const SURPRISE: f64 = 0.2;
/// First and smallest share of the way from an anchor to a sample in one step.
const STEPS: [f64; 2] = [0.5, 1.0 / 64.0];
/// Relative tolerance of frequency and residual at the peaks between an anchor and a sample: they only lead on.
const WAYPOINT_TOLERANCE: f64 = 1e-3;

impl Ensemble<'_> {
    /// Outcome of sample `index` and what it is to others, started from `atlas`.
    #[must_use]
    pub fn sample(&self, index: u64, atlas: &Atlas) -> (SampleOutcome, Anchor) {
        let inputs = self.design.sample(index);
        let place = self.design.place(&inputs);
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
        let _turn = self.backend.turn();
        // bands are of the population
        let group = self.design.group(index);
        let curve = index < self.curve_samples && group.of_population();
        let (levels, peaks) = self.solved(&inputs, &place, atlas, curve);
        let outcome = SampleOutcome {
            index,
            group,
            inputs,
            levels,
        };
        (outcome, Anchor { place, peaks })
    }

    /// Records of the levels at inputs that are no sample, without curves.
    pub(super) fn levels(&self, inputs: &[f64], atlas: &Atlas) -> Vec<LevelOutcome> {
        let place = self.design.place(inputs);
        self.solved(inputs, &place, atlas, false).0
    }

    /// Records of the levels, with the forced response if wanted, and the peaks as starts for other samples.
    fn solved(
        &self,
        inputs: &[f64],
        place: &[f64],
        atlas: &Atlas,
        curve: bool,
    ) -> (Vec<LevelOutcome>, Vec<ModePeaks>) {
        match self.solver {
            SampleSolver::HarmonicBalance => self.balanced(inputs, place, atlas, curve),
            #[cfg(feature = "test-functions")]
            SampleSolver::Function(function) => self.evaluated(function, inputs),
        }
    }

    /// The same by harmonic balance.
    fn balanced(
        &self,
        inputs: &[f64],
        place: &[f64],
        atlas: &Atlas,
        curve: bool,
    ) -> (Vec<LevelOutcome>, Vec<ModePeaks>) {
        let solved = self.applied(inputs).and_then(|applied| {
            let levels = self.applied_levels(&applied);
            let problem = applied.problem(self.settings.anchor).map_err(status_of)?;
            let peaks = self.peaks(&problem, &levels, place, atlas);
            let peaks = peaks.map_err(status_of)?;
            let anchors = peaks.iter().map(ModePeaks::new).collect();
            let level = |(found, nominal)| self.level(&problem, found, nominal, curve);
            let of_levels = peaks.iter().zip(self.levels.iter().copied());
            Ok((of_levels.map(level).collect(), anchors))
        });
        solved.unwrap_or_else(|status| {
            let none = vec![ModePeaks::default(); self.levels.len()];
            (self.without_problem(status), none)
        })
    }

    /// The same from a function, which is the same at every level; of the medians where `inputs` is empty.
    #[cfg(feature = "test-functions")]
    fn evaluated(
        &self,
        function: super::test_function::TestFunction,
        inputs: &[f64],
    ) -> (Vec<LevelOutcome>, Vec<ModePeaks>) {
        let medians = self
            .design
            .inputs()
            .iter()
            .map(|(_, law)| law.quantile(0.5));
        let peak = match inputs {
            [] => function.peak(&medians.collect::<Vec<_>>()),
            inputs => function.peak(inputs),
        };
        let level = |&level: &f64| LevelOutcome {
            level,
            status: Status::Converged,
            peak: Some(peak),
            others: Vec::new(),
            curve: Vec::new(),
            newton_iterations: 0,
            factorizations: 0,
        };
        let levels = self.levels.iter().map(level).collect();
        (levels, vec![ModePeaks::default(); self.levels.len()])
    }

    /// Excitation levels of a sample. Shape: `[levels]`.
    fn applied_levels(&self, applied: &Applied) -> Vec<f64> {
        (self.levels.iter())
            .map(|level| level * applied.excitation_scale)
            .collect()
    }

    /// Maxima at the sample's own `levels`.
    fn peaks(
        &self,
        problem: &Problem<'_>,
        levels: &[f64],
        place: &[f64],
        atlas: &Atlas,
    ) -> Result<Vec<Maxima>, ProblemError> {
        let stiffness = stiffness_at_rest(problem, self.settings.aft, self.peak.band.low);
        let modes = candidates(problem.model, &stiffness, self.peak.band)?;
        let search = |mode: &Candidate, wanted: &[usize], known: &[Maxima]| {
            let of_mode = ModeOfSample {
                problem,
                mode,
                levels,
                place,
                known,
            };
            Ok(self.of_mode(&of_mode, wanted, atlas))
        };
        search_maxima(&modes, self.choice, levels, search)
    }

    /// Maxima of one mode at the `wanted` levels: from the atlas where that leads to what it promised, the others by the
    /// track of the mode.
    fn of_mode(&self, of: &ModeOfSample<'_>, wanted: &[usize], atlas: &Atlas) -> Vec<ModeSearch> {
        let mut searches: Vec<Search> = wanted.iter().map(|_| Search::default()).collect();
        let mut peaks: Vec<Option<LevelPeak>> = (wanted.iter().zip(&mut searches))
            .map(|(&level, search)| {
                of.problem.budget.grant(self.settings.newton.budget);
                let at = of.at(level);
                let prediction = atlas.predict(&at)?.at_level(of.levels[level]);
                let predicted = self.predicted(of, level, prediction, search);
                predicted.or_else(|| self.followed(of, level, atlas.nearest(&at)?, search))
            })
            .collect();
        let missing: Vec<usize> = (0..peaks.len()).filter(|&i| peaks[i].is_none()).collect();
        if !missing.is_empty() {
            let levels: Vec<f64> = (missing.iter()).map(|&i| of.levels[wanted[i]]).collect();
            let tracked = track_mode(of.problem, self.settings, self.peak, of.mode, &levels);
            missing
                .into_iter()
                .zip(tracked)
                .for_each(|(i, peak)| peaks[i] = Some(peak));
        }
        let found = peaks.into_iter().flatten().zip(searches);
        found.map(|(peak, search)| search.end(peak)).collect()
    }

    /// The peak that a prediction leads to, unless that is not what it promised, or the maximum of another mode.
    fn predicted(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        prediction: AtlasPrediction,
        search: &mut Search,
    ) -> Option<LevelPeak> {
        let AtlasPrediction {
            harmonics,
            peak,
            amplitude,
        } = prediction;
        let expected = |solution: &Solution| {
            !surprising(solution.amplitude(0), amplitude)
                && !of.known[level].is_of_another(of.mode.mode, solution)
        };
        match refined_near(of.problem, &harmonics, peak, self.settings, self.peak) {
            Ok(solution) if expected(&solution) => Some(LevelPeak::found(solution)),
            Ok(solution) => {
                search.spent += solution.work_count;
                search.aside.push(solution);
                None
            }
            Err((_, work)) => {
                search.spent += work;
                None
            }
        }
    }

    /// The peak at a level (its number), reached from an anchor by steps along the straight line between their places.
    fn followed(
        &self,
        of: &ModeOfSample<'_>,
        level: usize,
        (start, anchor): (&[f64], &AnchorPeak),
        search: &mut Search,
    ) -> Option<LevelPeak> {
        let (mut before, mut at) = (None, (0.0, anchor.clone()));
        let mut step = STEPS[0];
        loop {
            let share = 1.0f64.min(at.0 + step);
            let prediction = match &before {
                Some(before) => AnchorPeak::extrapolated(before, &at, share),
                None => at.1.as_prediction(),
            };
            if share == 1.0 {
                let prediction = prediction.at_level(of.levels[level]);
                if let Some(peak) = self.predicted(of, level, prediction, search) {
                    return Some(peak);
                }
            } else if let Some(next) = self.waypoint(
                level,
                (start, of.place, share),
                prediction,
                &mut search.spent,
            ) {
                before = Some(std::mem::replace(&mut at, (share, next)));
                step *= 2.0;
                continue;
            }
            step = 0.5 * (share - at.0);
            if step < STEPS[1] {
                return None;
            }
        }
    }

    /// The peak at level number `level` at a share of the way between two places, on the harmonics of the prediction.
    fn waypoint(
        &self,
        level: usize,
        (start, end, share): (&[f64], &[f64], f64),
        prediction: AtlasPrediction,
        spent: &mut WorkCount,
    ) -> Option<AnchorPeak> {
        let inputs: Vec<f64> = (self.design.inputs().iter().zip(start.iter().zip(end)))
            .map(|((_, distribution), (a, b))| distribution.quantile(a + share * (b - a)))
            .collect();
        let applied = self.applied(&inputs).ok()?;
        let prediction = prediction.at_level(self.applied_levels(&applied)[level]);
        let problem = applied.problem(self.settings.anchor).ok()?;
        let balance = balance_on(&problem, prediction.harmonics, self.settings);
        let amplitude = prediction.amplitude;
        let peak = PeakSettings {
            frequency_tolerance: self.peak.frequency_tolerance.max(WAYPOINT_TOLERANCE),
            ..self.peak
        };
        let newton = NewtonSettings {
            tolerance: self.settings.newton.tolerance.max(WAYPOINT_TOLERANCE),
            ..self.settings.newton
        };
        let corrected = correct(&balance, prediction.peak, peak, newton);
        let located = spent.tally(corrected).ok()?;
        let found = located.solution(&balance, WorkCount::default());
        (!surprising(found.amplitude(0), amplitude)).then(|| AnchorPeak::new(&found))
    }

    /// Record of the nominal level `level`, with the forced response through its peak if wanted.
    fn level(
        &self,
        problem: &Problem<'_>,
        maxima: &Maxima,
        level: f64,
        with_curve: bool,
    ) -> LevelOutcome {
        let mut count = maxima.count;
        let peak = maxima.peak();
        let curve = (peak.filter(|_| with_curve)).map_or_else(Vec::new, |solution| {
            self.curve(problem, solution, &mut count)
        });
        LevelOutcome {
            level,
            status: maxima.status(),
            peak: peak.map(record),
            others: peak.map_or_else(Vec::new, |_| others(maxima)),
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
        problem.budget.grant(self.settings.newton.budget);
        let n_relative = balance.layout.n_relative();
        let mut prediction = PeakPrediction::of(solution);
        prediction.point.r =
            (solution.harmonics).convert(&prediction.point.r, n_relative, harmonics);
        let start = match solution.harmonics == *harmonics {
            true => Ok(prediction.point),
            false => {
                let maximum = maximum_near(&balance, prediction.clone(), self.peak, newton, count);
                // a picture may start beside the maximum
                (maximum.map(|peak| peak.iterate))
                    .or_else(|_| phase_locked(&balance, prediction, newton, count))
                    .map(|found| found.point)
            }
        };
        let Ok(start) = start else {
            return Vec::new();
        };
        let (curve, work) = response_curve(&balance, &start, self.peak.band, newton);
        *count += work;
        (curve.iter())
            .map(|point| CurvePoint {
                frequency_hz: rad_s_to_hz(point.omega),
                amplitude_m: point.amplitude,
            })
            .collect()
    }

    /// A sample whose inputs make no harmonic balance problem fails at every level.
    fn without_problem(&self, status: Status) -> Vec<LevelOutcome> {
        (self.levels.iter())
            .map(|&level| LevelOutcome {
                level,
                status,
                peak: None,
                others: Vec::new(),
                curve: Vec::new(),
                newton_iterations: 0,
                factorizations: 0,
            })
            .collect()
    }
}

/// How a sample ends whose constants make no harmonic balance problem.
fn status_of(error: ProblemError) -> Status {
    match error {
        ProblemError::Linalg(_) => Status::NonFinite,
        _ => Status::NotHeld,
    }
}

/// One mode of a sample.
struct ModeOfSample<'a> {
    problem: &'a Problem<'a>,
    mode: &'a Candidate,
    /// The sample's own levels, and its place among the others.
    levels: &'a [f64],
    place: &'a [f64],
    /// What was found of other modes. Shape: `[levels]`.
    known: &'a [Maxima],
}

impl ModeOfSample<'_> {
    /// Where the atlas is asked for level number `level`.
    fn at(&self, level: usize) -> Place<'_> {
        Place {
            inputs: self.place,
            level,
            mode: self.mode.mode,
        }
    }
}

/// What the search for one peak has spent and met on the way.
#[derive(Default)]
struct Search {
    spent: WorkCount,
    /// Maxima that were not those that a prediction had promised.
    aside: Vec<Solution>,
}

impl Search {
    fn end(self, mut peak: LevelPeak) -> ModeSearch {
        peak.count += self.spent;
        let aside = self.aside;
        ModeSearch { peak, aside }
    }
}

/// Whether an amplitude is too far from the predicted one to lie on the same branch.
fn surprising(found: f64, predicted: f64) -> bool {
    (found / predicted - 1.0).abs() >= SURPRISE
}

/// The maxima below the highest one.
fn others(maxima: &Maxima) -> Vec<OtherMaximum> {
    let others = maxima.distinct().into_iter().skip(1);
    others
        .map(|other| OtherMaximum {
            frequency_hz: rad_s_to_hz(other.omega),
            amplitude_m: other.amplitude(0),
        })
        .collect()
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
