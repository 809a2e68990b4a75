//! One sample: from its inputs to its peaks, curves and record.
//!
//! A peak is predicted from the atlas and corrected, by damped steps where undamped ones fail. Where that fails it is
//! followed from the nearest anchor along the straight line between the inputs, and where that fails too the sample's own
//! track from the stuck state decides.

use super::applied::Applied;
use super::atlas::{Anchor, AnchorPeak, Atlas, AtlasPrediction};
use super::outcome::{CurvePoint, LevelOutcome, PeakRecord, SampleOutcome};
use super::{Ensemble, SampleSolver};
use crate::hb::alert::on;
use crate::hb::curve::response_curve;
use crate::hb::newton::WorkCount;
use crate::hb::peak::PeakSettings;
use crate::hb::predicted::{PeakPrediction, correct, maximum_near, phase_locked};
use crate::hb::refine::refined_near;
use crate::hb::track::{LevelPeak, track_peaks};
use crate::hb::{Balance, NewtonSettings, Problem, ProblemError, Solution, Status};
use crate::units::rad_s_to_hz;

/// Relative distance between the predicted and the found amplitude from which the prediction is not trusted to have
/// led to the same branch.
const SURPRISE: f64 = 0.2;
/// First and smallest share of the way from an anchor to a sample in one step.
const STEPS: [f64; 2] = [0.5, 1.0 / 64.0];
/// Relative distances of frequency and amplitude up to which two solutions are one maximum.
const SAME: [f64; 2] = [1e-6, 1e-5];
/// The same for solutions on different harmonics, which the truncation sets apart.
const SAME_ON_OTHER_HARMONICS: [f64; 2] = [1e-4, 2e-2];
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
    ) -> (Vec<LevelOutcome>, Vec<Option<AnchorPeak>>) {
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
    ) -> (Vec<LevelOutcome>, Vec<Option<AnchorPeak>>) {
        let solved = self.applied(inputs).and_then(|applied| {
            let levels = self.applied_levels(&applied);
            let problem = applied.problem(self.settings.anchor).map_err(status_of)?;
            let peaks = self.peaks(&problem, &levels, place, atlas);
            let peaks = peaks.map_err(status_of)?;
            let anchor = |found: &Found| Some(AnchorPeak::new(found.peak.solution.as_ref()?));
            let anchors = peaks.iter().map(anchor).collect();
            let level = |(found, nominal)| self.level(&problem, found, nominal, curve);
            let of_levels = peaks.into_iter().zip(self.levels.iter().copied());
            Ok((of_levels.map(level).collect(), anchors))
        });
        solved.unwrap_or_else(|status| {
            let none = vec![None; self.levels.len()];
            (self.without_problem(status), none)
        })
    }

    /// The same from a function, which is the same at every level; of the medians where `inputs` is empty.
    #[cfg(feature = "test-functions")]
    fn evaluated(
        &self,
        function: super::test_function::TestFunction,
        inputs: &[f64],
    ) -> (Vec<LevelOutcome>, Vec<Option<AnchorPeak>>) {
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
            curve: Vec::new(),
            newton_iterations: 0,
            factorizations: 0,
        };
        let levels = self.levels.iter().map(level).collect();
        (levels, vec![None; self.levels.len()])
    }

    /// Excitation levels of a sample. Shape: `[levels]`.
    fn applied_levels(&self, applied: &Applied) -> Vec<f64> {
        (self.levels.iter())
            .map(|level| level * applied.excitation_scale)
            .collect()
    }

    /// Peaks at the sample's own `levels`: from the atlas where that leads to what it promised, the others by its track.
    fn peaks(
        &self,
        problem: &Problem<'_>,
        levels: &[f64],
        place: &[f64],
        atlas: &Atlas,
    ) -> Result<Vec<Found>, ProblemError> {
        let mut searches: Vec<Search> = levels.iter().map(|_| Search::default()).collect();
        let mut peaks: Vec<Option<LevelPeak>> = (searches.iter_mut().enumerate())
            .map(|(level, search)| {
                problem.budget.grant(self.settings.newton.budget);
                let prediction = atlas.predict(place, level)?.at_level(levels[level]);
                let predicted = self.predicted(problem, prediction, search);
                predicted.or_else(|| {
                    self.followed(
                        problem,
                        (level, levels[level]),
                        place,
                        atlas.nearest(place, level)?,
                        search,
                    )
                })
            })
            .collect();
        let missing: Vec<usize> = (0..peaks.len()).filter(|&i| peaks[i].is_none()).collect();
        if !missing.is_empty() {
            let levels: Vec<f64> = missing.iter().map(|&i| levels[i]).collect();
            let tracked = track_peaks(problem, self.settings, self.peak, &levels)?;
            missing
                .into_iter()
                .zip(tracked)
                .for_each(|(i, peak)| peaks[i] = Some(peak));
        }
        let found = peaks.into_iter().flatten().zip(searches);
        Ok(found.map(|(peak, search)| search.end(peak)).collect())
    }

    /// The peak that a prediction leads to, unless that is not what it promised.
    fn predicted(
        &self,
        problem: &Problem<'_>,
        prediction: AtlasPrediction,
        search: &mut Search,
    ) -> Option<LevelPeak> {
        let AtlasPrediction {
            harmonics,
            peak,
            amplitude,
        } = prediction;
        match refined_near(problem, &harmonics, peak, self.settings, self.peak) {
            Ok(solution) if !surprising(solution.amplitude(0), amplitude) => {
                Some(LevelPeak::found(solution))
            }
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

    /// The peak at `place` and at a level (its number and value there), reached from the anchor by steps along the straight line between their places.
    fn followed(
        &self,
        problem: &Problem<'_>,
        (level, target): (usize, f64),
        place: &[f64],
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
                let prediction = prediction.at_level(target);
                if let Some(peak) = self.predicted(problem, prediction, search) {
                    return Some(peak);
                }
            } else if let Some(next) =
                self.waypoint(level, (start, place, share), prediction, &mut search.spent)
            {
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
        let balance = on(&problem, prediction.harmonics, self.settings);
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
        Found { peak, others }: Found,
        level: f64,
        with_curve: bool,
    ) -> LevelOutcome {
        let mut count = peak.count;
        let curve = (peak.solution.as_ref().filter(|_| with_curve))
            .map_or_else(Vec::new, |solution| {
                self.curve(problem, solution, &mut count)
            });
        LevelOutcome {
            level,
            status: peak.status,
            peak: (peak.solution.as_ref()).map(|solution| record(solution, others)),
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
        // a picture may start beside the maximum
        let maximum = maximum_near(&balance, prediction.clone(), self.peak, newton, count);
        let start = maximum.map(|peak| peak.iterate);
        let start = start.or_else(|_| phase_locked(&balance, prediction, newton, count));
        let Ok(peak) = start else {
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

    /// A sample whose inputs make no harmonic balance problem fails at every level.
    fn without_problem(&self, status: Status) -> Vec<LevelOutcome> {
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

/// How a sample ends whose constants make no harmonic balance problem.
fn status_of(error: ProblemError) -> Status {
    match error {
        ProblemError::Linalg(_) => Status::NonFinite,
        _ => Status::NotHeld,
    }
}

/// What the search for one peak has spent and met on the way.
#[derive(Default)]
struct Search {
    spent: WorkCount,
    /// Maxima that were not those that a prediction had promised.
    aside: Vec<Solution>,
}

/// A peak, and how many other maxima were met.
struct Found {
    peak: LevelPeak,
    others: usize,
}

impl Search {
    /// The highest of `peak` and the maxima that were met before it.
    fn end(self, mut peak: LevelPeak) -> Found {
        let mut maxima: Vec<Solution> = peak.solution.take().into_iter().collect();
        for solution in self.aside {
            if !maxima.iter().any(|known| is_same_maximum(known, &solution)) {
                maxima.push(solution);
            }
        }
        let others = maxima.len().saturating_sub(1);
        // the first of equals: what is found does not depend on anything but the sample and its atlas
        let highest =
            maxima
                .into_iter()
                .reduce(|best, other| match other.amplitude(0) > best.amplitude(0) {
                    true => other,
                    false => best,
                });
        if let Some(highest) = highest {
            peak.status = highest.status;
            peak.solution = Some(highest);
        }
        peak.count += self.spent;
        Found { peak, others }
    }
}

/// Whether two solutions of one problem are the same maximum, perhaps on other harmonics.
fn is_same_maximum(a: &Solution, b: &Solution) -> bool {
    let apart = |a: f64, b: f64| (a / b - 1.0).abs();
    let [frequency, amplitude] = match a.harmonics == b.harmonics {
        true => SAME,
        false => SAME_ON_OTHER_HARMONICS,
    };
    apart(a.omega, b.omega) <= frequency && apart(a.amplitude(0), b.amplitude(0)) <= amplitude
}

/// Whether an amplitude is too far from the predicted one to lie on the same branch.
fn surprising(found: f64, predicted: f64) -> bool {
    (found / predicted - 1.0).abs() >= SURPRISE
}

fn record(solution: &Solution, other_maxima: usize) -> PeakRecord {
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
        other_maxima,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harmonics::HarmonicSet;
    use crate::hb::solution::{ContactFractions, CycleWork};

    /// A solution of one response, told apart by frequency and amplitude.
    fn maximum(omega: f64, amplitude: f64, highest: usize) -> Solution {
        let harmonics = HarmonicSet::up_to(highest);
        let mut responses = vec![0.0; harmonics.n_coefficients()];
        responses[1] = amplitude;
        Solution {
            status: Status::Converged,
            omega,
            level: 1.0,
            harmonics,
            relative: Vec::new(),
            force: Vec::new(),
            responses,
            residual: 0.0,
            contact: ContactFractions::default(),
            flight_fraction: 0.0,
            work: CycleWork::default(),
            truncation_error: None,
            sharpness: None,
            work_count: WorkCount::default(),
        }
    }

    /// Seen to fail with the lowest of the maxima, and with maxima on other harmonics counted apart.
    #[test]
    fn the_highest_maximum_is_reported_and_the_others_are_counted() {
        let end = |aside: Vec<Solution>| {
            let search = Search {
                aside,
                ..Search::default()
            };
            let found = search.end(LevelPeak::found(maximum(100.0, 2.0, 3)));
            let solution = found.peak.solution.unwrap();
            (solution.omega, found.others)
        };
        assert_eq!(end(vec![]), (100.0, 0));
        assert_eq!(end(vec![maximum(100.0, 2.0, 3)]), (100.0, 0));
        assert_eq!(
            end(vec![maximum(100.001, 2.01, 5)]),
            (100.0, 0),
            "harmonics"
        );
        assert_eq!(end(vec![maximum(100.001, 1.9, 3)]), (100.0, 1), "lower");
        let [lower, higher] = [maximum(99.0, 1.0, 3), maximum(101.0, 3.0, 3)];
        assert_eq!(end(vec![lower, higher.clone(), higher]), (101.0, 2));
    }
}
