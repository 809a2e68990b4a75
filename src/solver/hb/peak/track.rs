//! Resonance peaks of one problem over ascending excitation levels, each grown from a mode of the stuck structure.
//!
//! Below slip onset the stuck structure is linear, and a track starts there. It follows the phase resonance with one harmonic,
//! which is cheap and smooth. The steps are in the amplitude: an amplitude belongs to one level only, but a level may have
//! several amplitudes. At each level asked for, a few harmonics are added step by step, and the maximum next to the phase
//! resonance is located. Then the maximum gets the harmonics of the study, and more until the error alert accepts it. If that
//! fails the other routes of [`PeakRoute`] are tried.

use super::band::{sliding_maximum, swept_maximum};
use super::branch_maximum::other_on_branch;
use super::level_peak::{LevelPeak, ModeSearch};
use super::maxima::{PeakChoice, add_other_on_branches, search_maxima};
use super::predicted::{PeakPrediction, correct, raised};
use super::refine::refined_maximum;
use super::search::{Located, PeakSettings, find_peak, highest_nearby};
use crate::contact::Events;
use crate::hb::equations::balance::Balance;
use crate::hb::equations::effort::Meter;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::Ladder;
use crate::hb::newton::rest::{Rest, stiffness_at_rest};
use crate::hb::newton::{Condition, Iterate, Point, solve};
use crate::hb::route::PeakRoute;
use crate::hb::settings::{HbSettings, NewtonSettings};
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::{Band, Candidate, candidates, linear_response};
use crate::linalg::LinalgError;
use faer::prelude::c64;

/// First and largest ratio between two amplitudes of the track.
const RATIOS: [f64; 2] = [2.0, 4.0];
/// The track ends if the ratio falls below this.
const SMALLEST_RATIO: f64 = 1.005;
/// Relative distance from the level asked for below which the level is fixed instead of the amplitude.
const NEAR_LEVEL: f64 = 0.02;
/// Longest step of ln amplitude towards this distance.
const LONGEST_SECANT: f64 = 0.7;
/// Most steps towards this distance.
const MOST_SECANTS: usize = 12;
/// Most Newton iterations of one step of the track; if they do not suffice the step was too long.
const TRACK_ITERATIONS: usize = 30;
/// Residual of the solutions between two levels. The solution at a level, from which the maximum is searched, is solved to
/// the study's tolerance.
const TRACK_TOLERANCE: f64 = 1e-5;
/// Maxima of the structure that slides without friction below this share of the reach of the mode do not count.
const LEAST_SLIDING: f64 = 0.5;
/// Most harmonics (0 included) on which the maximum is searched.
const FEW_HARMONICS: usize = 8;

/// How a maximum is located from a phase resonance of the track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Locating {
    /// By Newton's method, which may lead to the maximum of another mode where this one is low beside it; then by the other routes.
    Newton,
    /// By steps along the branch on which the amplitude grows, with the harmonics of the study, and by no other route.
    Uphill,
}

/// The track of one mode, with the phase-resonant solution that it has reached.
struct Track<'a, 'p> {
    /// The problem on sets with more and more harmonics. The track is followed on the first; the last is that of the study.
    ladder: &'a [Balance<'p>],
    /// Index in `ladder` of the set on which the maximum is searched first.
    few: usize,
    settings: &'a HbSettings,
    peak: PeakSettings,
    locating: Locating,
    /// Frequencies that the phase resonance may have.
    path: Band,
    /// Direction of the first harmonic, at resonance, of the response that defines it.
    phasor: c64,
    /// The structure at rest, if there is an equilibrium.
    rest: Option<Rest>,
    /// Largest amplitude of the mode per unit level (m).
    reach: f64,
    /// The last solution.
    at: Option<Iterate<'p>>,
    /// Ratio of the next amplitude to that of the last solution.
    ratio: f64,
    /// Work since the last peak.
    meter: Meter<'p>,
}

/// Search for the maximum at a level on one route.
type RouteSearch<'a, 'p> = fn(&mut Track<'a, 'p>, f64) -> Result<Located<'p>, Status>;

/// Peaks of `problem` at the ascending, positive `levels`: the highest of the maxima that grow from its modes. A level
/// that is not a positive number gives [`Status::NonFinite`].
///
/// # Errors
/// [`LinalgError`] if the modes of the stuck structure cannot be found. Solves that fail are statuses.
pub fn track_peaks(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    levels: &[f64],
) -> Result<Vec<LevelPeak>, LinalgError> {
    let stiffness = stiffness_at_rest(problem, settings.aft, peak.band.low);
    let modes = candidates(problem.model, &stiffness, peak.band)?;
    let search = |mode: &Candidate, at: &[usize], _: &[_]| {
        let levels: Vec<f64> = at.iter().map(|&i| levels[i]).collect();
        let found = track_mode(problem, settings, peak, mode, &levels, Locating::Newton);
        Ok::<_, LinalgError>(found.into_iter().map(ModeSearch::from).collect())
    };
    let mut maxima = search_maxima(&modes, PeakChoice::Highest, levels, search)?;
    let along = |found: &Solution, extent| other_on_branch(problem, settings, peak, found, extent);
    let predicted = vec![None; levels.len()];
    add_other_on_branches(&mut maxima, PeakChoice::Highest, &predicted, along);
    Ok(maxima.into_iter().map(LevelPeak::from).collect())
}

/// The maxima of `problem` that grow from a mode of the stuck structure, at the ascending `levels`.
#[must_use]
pub fn track_mode(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    mode: &Candidate,
    levels: &[f64],
    locating: Locating,
) -> Vec<LevelPeak> {
    problem.effort.grant(settings.newton.budget);
    let meter = Meter::new(&problem.effort);
    let ladder = Ladder::new(problem, settings);
    let are_few = |rung: &Balance<'_>| rung.harmonics.orders().len() <= FEW_HARMONICS;
    let rest = Rest::new(ladder.first(), mode.omega);
    let stiffness = match &rest {
        Ok(rest) => &rest.stiffness,
        Err(_) => &problem.stuck_stiffness,
    };
    let response = linear_response(problem.model, stiffness, mode.omega);
    let mut track = Track {
        ladder: ladder.rungs(),
        few: ladder.rungs().iter().rposition(are_few).unwrap_or(0),
        settings,
        peak,
        locating,
        path: mode.path,
        phasor: response / response.norm(),
        rest: None,
        reach: mode.reach,
        at: None,
        ratio: RATIOS[0],
        meter,
    };
    if let Ok(rest) = rest {
        track.at = track.start(&rest, levels.first().copied().unwrap_or(1.0));
        track.rest = Some(rest);
    }
    levels.iter().map(|&level| track.peak_at(level)).collect()
}

impl<'a, 'p> Track<'a, 'p> {
    /// Solves at or below the first level, where the response that is linear about the rest is a good start.
    fn start(&self, rest: &Rest, first_level: f64) -> Option<Iterate<'p>> {
        let balance = &self.ladder[0];
        let level = first_level.min(rest.stuck_level(balance.problem));
        let newton = self.settings.newton;
        let excited = rest.excited(level);
        let held = solve(balance, excited, Condition::FixedFrequency, newton).ok()?;
        let phase = Condition::PhaseLocked(self.phasor);
        solve(balance, held.point, phase, newton).ok()
    }

    /// The peak at `level`.
    fn peak_at(&mut self, level: f64) -> LevelPeak {
        let effort = &self.full().problem.effort;
        effort.grant(self.settings.newton.budget);
        // Ratios of such levels are no numbers, and the track would never give up on them.
        if !(level.is_finite() && level > 0.0) {
            return LevelPeak::failed(level, Status::NonFinite, self.meter.read());
        }
        let mut end = Status::StepTooSmall;
        for (route, search) in self.searches() {
            match search(self, level) {
                Ok(found) => {
                    let solution = Solution {
                        route: Some(route),
                        ..self.reported(found)
                    };
                    return LevelPeak::found(solution, self.meter.read());
                }
                Err(status) => end = status,
            }
        }
        if effort.is_spent() {
            end = Status::BudgetSpent;
        }
        LevelPeak::failed(level, end, self.meter.read())
    }

    /// The routes to the maximum at a level, in the order in which they are tried.
    fn searches(&self) -> Vec<(PeakRoute, RouteSearch<'a, 'p>)> {
        let on_all: (PeakRoute, RouteSearch<'a, 'p>) = (PeakRoute::TrackedOnAll, |track, level| {
            track.located(level, track.last())
        });
        if self.locating == Locating::Uphill {
            return vec![on_all];
        }
        let mut searches: Vec<(PeakRoute, RouteSearch<'a, 'p>)> = vec![
            (PeakRoute::Tracked, |track, level| {
                let found = track.located(level, track.few)?;
                track.raised(track.few, found)
            }),
            on_all,
            (PeakRoute::Sliding, |track, level| {
                let found = track.sliding(level)?;
                track.raised(0, found)
            }),
            (PeakRoute::SweptOnOne, |track, level| track.swept(level, 0)),
            (PeakRoute::SweptOnFew, |track, level| {
                track.swept(level, track.few)
            }),
        ];
        let few_are_all = self.few == self.last();
        searches.retain(|(route, _)| !(few_are_all && *route == PeakRoute::TrackedOnAll));
        searches
    }

    /// Index in `ladder` of the set of the study.
    fn last(&self) -> usize {
        self.ladder.len() - 1
    }

    /// The problem on the harmonics of the study.
    fn full(&self) -> &'a Balance<'p> {
        &self.ladder[self.last()]
    }

    /// What is reported of the maximum `found` on the harmonics of the study, with as many more as the alert asks for.
    fn reported(&self, found: Located<'p>) -> Solution {
        let (full, settings) = (self.full(), self.settings);
        let found = match settings.aft.events {
            Events::Located => found,
            _ => highest_nearby(full, found, self.peak, settings.newton),
        };
        refined_maximum(full, found, settings, self.peak)
    }

    /// The maximum on the harmonics of `rung` next to the phase resonance at `level`.
    fn located(&mut self, level: f64, rung: usize) -> Result<Located<'p>, Status> {
        let start = self.follow(level)?;
        let start = self.climb(start, rung)?;
        self.maximum(start, rung)
    }

    /// The maximum next to the phase resonance `start`: directly, else, or where nothing else is wanted, by a search along the branch.
    fn maximum(&self, start: Iterate<'p>, rung: usize) -> Result<Located<'p>, Status> {
        let (balance, newton) = (&self.ladder[rung], self.settings.newton);
        if self.locating == Locating::Uphill {
            return find_peak(balance, start, self.peak, newton);
        }
        let prediction = PeakPrediction {
            point: start.point.clone(),
            phasor: self.phasor,
            sharpness: None,
        };
        correct(balance, prediction, self.peak, newton)
            .or_else(|_| find_peak(balance, start, self.peak, newton))
    }

    /// The maximum on the harmonics of the study that belongs to the maximum `found` on those of `rung`.
    fn raised(&self, rung: usize, found: Located<'p>) -> Result<Located<'p>, Status> {
        raised(&self.ladder[rung..], found, self.peak, self.settings.newton)
    }

    /// Newton's method for solutions that are only starts for others.
    fn intermediate_newton(&self) -> NewtonSettings {
        let newton = self.settings.newton;
        NewtonSettings {
            tolerance: newton.tolerance.max(TRACK_TOLERANCE),
            ..newton
        }
    }

    /// Adds the harmonics up to those of `last` to a phase-resonant solution, rung by rung at its amplitude, then
    /// returns to its level.
    fn climb(&self, start: Iterate<'p>, last: usize) -> Result<Iterate<'p>, Status> {
        let level = start.point.level;
        let newton = self.intermediate_newton();
        let mut iterate = start;
        for rung in 1..=last {
            let (from, to) = (&self.ladder[rung - 1], &self.ladder[rung]);
            let amplitude = iterate.response(from).norm();
            let condition = Condition::Amplitude {
                phasor: self.phasor,
                amplitude,
            };
            iterate = solve(to, iterate.point.padded(from, to), condition, newton)?;
        }
        self.bring_to_level(last, iterate, level)
    }

    /// Moves the track up to `level` by steps whose ratio adapts; gives a copy of the solution there.
    fn follow(&mut self, level: f64) -> Result<Iterate<'p>, Status> {
        let newton = NewtonSettings {
            max_iterations: TRACK_ITERATIONS.min(self.settings.newton.max_iterations),
            ..self.intermediate_newton()
        };
        loop {
            let at = self.at.as_ref().ok_or(Status::StepTooSmall)?;
            if at.point.level >= level * (1.0 - 1e-9) {
                break;
            }
            // a little more than a linear structure would need
            let ratio = self.ratio.min(1.1 * level / at.point.level);
            let (point, amplitude) = (at.point.clone(), at.response(&self.ladder[0]).norm());
            match self.scaled(0, &point, amplitude, ratio, newton) {
                Ok(iterate) if self.path.contains(iterate.point.omega) => {
                    self.at = Some(iterate);
                    self.ratio = (self.ratio * 1.3).min(RATIOS[1]);
                }
                _ => {
                    self.ratio = ratio.sqrt();
                    if self.ratio < SMALLEST_RATIO {
                        return Err(Status::StepTooSmall);
                    }
                }
            }
        }
        let at = self.at.as_ref().ok_or(Status::StepTooSmall)?;
        let start = Iterate::new(&self.ladder[0], at.point.clone());
        self.bring_to_level(0, start, level)
    }

    /// The phase resonance on rung `rung` whose amplitude is `ratio` times the `amplitude` at `point`.
    fn scaled(
        &self,
        rung: usize,
        point: &Point,
        amplitude: f64,
        ratio: f64,
        newton: NewtonSettings,
    ) -> Result<Iterate<'p>, Status> {
        let balance = &self.ladder[rung];
        let n_relative = balance.layout.n_relative();
        let mut start = point.clone();
        // the blades carry the contacts along: dynamic displacements grow with the amplitude
        start.r[n_relative..].iter_mut().for_each(|r| *r *= ratio);
        start.level *= ratio;
        let condition = Condition::Amplitude {
            phasor: self.phasor,
            amplitude: ratio * amplitude,
        };
        solve(balance, start, condition, newton)
    }

    /// Corrects a phase resonance to exactly `level`: by secants in the amplitude until near, then at the fixed level.
    fn bring_to_level(
        &self,
        rung: usize,
        start: Iterate<'p>,
        level: f64,
    ) -> Result<Iterate<'p>, Status> {
        let balance = &self.ladder[rung];
        let newton = self.intermediate_newton();
        let mut at = start;
        let (mut slope, mut longest) = (1.0, LONGEST_SECANT);
        for _ in 0..MOST_SECANTS {
            let gap = libm::log(level / at.point.level);
            if gap.abs() <= NEAR_LEVEL {
                break;
            }
            let step = (gap * slope).clamp(-longest, longest);
            let amplitude = at.response(balance).norm();
            match self.scaled(rung, &at.point, amplitude, libm::exp(step), newton) {
                Ok(next) => {
                    let moved = libm::log(next.point.level / at.point.level);
                    slope = (step / moved).clamp(0.1, 3.0);
                    at = next;
                }
                Err(_) => longest = 0.5 * step.abs(),
            }
        }
        let point = Point { level, ..at.point };
        let phase = Condition::PhaseLocked(self.phasor);
        solve(balance, point, phase, self.settings.newton)
    }

    /// The highest maximum next to the resonances of the structure that slides without friction, on one harmonic.
    fn sliding(&self, level: f64) -> Result<Located<'p>, Status> {
        let rest = self.rest.as_ref().ok_or(Status::NoPeakInBand)?;
        let least = LEAST_SLIDING * self.reach;
        let newton = self.settings.newton;
        sliding_maximum(&self.ladder[0], rest, least, level, self.peak, newton)
    }

    /// The maximum that belongs to the highest one on the branch through the band on the harmonics of `rung`.
    fn swept(&self, level: f64, rung: usize) -> Result<Located<'p>, Status> {
        let newton = self.settings.newton;
        let found = swept_maximum(&self.ladder[..=rung], level, self.peak, newton)?;
        self.raised(rung, found)
    }
}
