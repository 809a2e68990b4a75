//! Resonance peaks of one problem over ascending excitation levels, each grown from a mode of the stuck structure.
//!
//! Below slip onset the stuck structure is linear, so a track starts there and follows the phase resonance with one
//! harmonic, which is cheap and smooth, by steps of its amplitude: the level that an amplitude needs is unique where the
//! amplitude that a level gives is not. At each level asked for, a few harmonics are added step by step and the maximum
//! next to the phase resonance is located. More harmonics are added to the located maximum, first those of the study, then
//! until the error alert is silent. Where that fails the phase resonance is taken to the harmonics of the study before
//! the maximum is located; then the maxima of the structure that slides without friction are tried, which friction far below
//! the level hardly moves; and where that fails too the whole band is swept by continuation, on few harmonics and at last
//! on those of the study, whose maximum may be too far from that on few.

use super::alert::AlertSets;
use super::level_peak::LevelPeak;
use super::maxima::{COMPETES, ModeSearch, PeakChoice, search_maxima};
use super::predicted::{PeakPrediction, correct, maximum_near};
use super::refine::{Kept, refined};
use super::search::{Located, PeakSettings, find_peak, highest_nearby, maximum_on};
use crate::contact::Events;
use crate::hb::branch::run_in::first_solution;
use crate::hb::branch::stretch::Stretch;
use crate::hb::branch::sweep::{Route, SweepDirection, follow};
use crate::hb::equations::balance::Balance;
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::Ladder;
use crate::hb::newton::rest::{Rest, stiffness_at_rest};
use crate::hb::newton::{Condition, Iterate, Point, WorkCount, solve};
use crate::hb::settings::{HbSettings, NewtonSettings};
use crate::hb::status::Status;
use crate::hb::structure::resonance::{
    Band, Candidate, candidates, linear_resonances, linear_response,
};
use crate::linalg::LinalgError;
use faer::prelude::c64;
use std::ops::ControlFlow;

/// First and largest ratio between two amplitudes of the track.
const RATIOS: [f64; 2] = [2.0, 4.0];
/// Ratios below this end the track.
const SMALLEST_RATIO: f64 = 1.005;
/// Relative distance from the level asked for at which the level is fixed instead of the amplitude.
const NEAR_LEVEL: f64 = 0.02;
/// Longest step of ln amplitude on the way.
const LONGEST_SECANT: f64 = 0.7;
/// Amplitudes tried to come that near.
const MOST_SECANTS: usize = 12;
/// Newton iterations of one step of the track; more mean that the step was too long.
const TRACK_ITERATIONS: usize = 30;
/// Residual accepted on the way to a level; the solution there, from which the maximum is searched, is solved to the
/// study's tolerance.
const TRACK_TOLERANCE: f64 = 1e-5;
/// Largest relative change of the displacements, and of the frequency over the band, per step of the sweep that replaces a
/// failed track.
const SWEEP_STEP: f64 = 0.3;
const SWEEP_ADVANCE: f64 = 0.025;
/// Most harmonics (0 included) on which the maximum is searched.
const FEW_HARMONICS: usize = 8;

/// The phase-resonant solution the track has reached.
struct Track<'a, 'p> {
    /// The problem on sets with more and more harmonics: the track runs on the first, the study wants the last.
    ladder: &'a [Balance<'p>],
    /// Number of the set on which the maximum is searched.
    few: usize,
    settings: &'a HbSettings,
    peak: PeakSettings,
    /// Where the phase resonance may be on the way.
    path: Band,
    /// Direction of the first harmonic of response 0 at resonance.
    phasor: c64,
    /// The structure at rest, if there is an equilibrium.
    rest: Option<Rest>,
    /// Largest amplitude of the mode per unit level (m).
    reach: f64,
    at: Option<Iterate<'p>>,
    ratio: f64,
    count: WorkCount,
}

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
        let found = track_mode(problem, settings, peak, mode, &levels);
        Ok::<_, LinalgError>(found.into_iter().map(ModeSearch::from).collect())
    };
    let maxima = search_maxima(&modes, PeakChoice::Highest, levels, search)?;
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
) -> Vec<LevelPeak> {
    let ladder = Ladder::new(problem, settings);
    let are_few = |rung: &Balance<'_>| rung.harmonics.orders().len() <= FEW_HARMONICS;
    let rest = Rest::new(ladder.first(), mode.omega);
    let stiffness = match &rest {
        Ok((rest, _)) => &rest.stiffness,
        Err(_) => &problem.stuck_stiffness,
    };
    let response = linear_response(problem.model, stiffness, mode.omega);
    let mut track = Track {
        ladder: ladder.rungs(),
        few: ladder.rungs().iter().rposition(are_few).unwrap_or(0),
        settings,
        peak,
        path: mode.path,
        phasor: response / response.norm(),
        rest: None,
        reach: mode.reach,
        at: None,
        ratio: RATIOS[0],
        count: WorkCount::default(),
    };
    problem.budget.grant(settings.newton.budget);
    if let Ok((rest, work)) = rest {
        track.count += work;
        track.at = track.start(&rest, levels.first().copied().unwrap_or(1.0));
        track.rest = Some(rest);
    }
    levels.iter().map(|&level| track.level(level)).collect()
}

impl<'a, 'p> Track<'a, 'p> {
    /// Solves at or below the first level, where the response that is linear about the rest is a good start.
    fn start(&mut self, rest: &Rest, first_level: f64) -> Option<Iterate<'p>> {
        let balance = &self.ladder[0];
        let level = first_level.min(rest.stuck_level(balance.problem));
        let newton = self.settings.newton;
        let excited = rest.excited(level);
        let held = solve(balance, excited, Condition::FixedFrequency, newton);
        let held = self.count.tally(held).ok()?;
        let phase = Condition::PhaseLocked(self.phasor);
        let locked = solve(balance, held.point, phase, newton);
        self.count.tally(locked).ok()
    }

    /// Follows the phase resonance to `level` and returns the peak there.
    fn level(&mut self, level: f64) -> LevelPeak {
        self.count = WorkCount::default();
        let budget = &self.ladder[0].problem.budget;
        budget.grant(self.settings.newton.budget);
        // Ratios of such levels are no numbers, and the track would never give up on them.
        if !(level.is_finite() && level > 0.0) {
            return LevelPeak::failed(level, Status::NonFinite, self.count);
        }
        let (few, last) = (self.few, self.ladder.len() - 1);
        // on all harmonics there is something left to try only where the search was on few
        let with_more = |status| if few < last { Ok(()) } else { Err(status) };
        let found = self
            .located(level, few)
            .and_then(|found| self.raised(few, found))
            .or_else(|status| {
                with_more(status)?;
                self.located(level, last)
            })
            .or_else(|_| {
                let found = self.sliding(level)?;
                self.raised(0, found)
            })
            .or_else(|_| {
                let found = self.sweep(level, 0)?;
                self.raised(0, found)
            })
            .or_else(|_| {
                let found = self.sweep(level, few)?;
                self.raised(few, found)
            })
            .or_else(|status| {
                with_more(status)?;
                self.sweep(level, last)
            });
        match found {
            Ok(found) => {
                let full = &self.ladder[last];
                let found = match self.settings.aft.events {
                    Events::Located => found,
                    _ => {
                        let newton = self.settings.newton;
                        highest_nearby(full, found, self.peak, newton, &mut self.count)
                    }
                };
                let settings = self.settings;
                let sets = AlertSets::new(full.problem, &settings.harmonics, settings);
                let kept = (Kept::Maximum(self.peak), settings.newton);
                let solution = refined(full, found, sets.as_ref(), kept, self.count);
                LevelPeak::found(solution)
            }
            Err(_) if budget.is_spent() => {
                LevelPeak::failed(level, Status::BudgetSpent, self.count)
            }
            Err(status) => LevelPeak::failed(level, status, self.count),
        }
    }

    /// The maximum on the harmonics of `rung` next to the phase resonance at `level`.
    fn located(&mut self, level: f64, rung: usize) -> Result<Located<'p>, Status> {
        let start = self.follow(level)?;
        let start = self.climb(start, rung)?;
        self.maximum(start, rung)
    }

    /// The maximum next to the phase resonance `start`: directly, else by a search along the branch.
    fn maximum(&mut self, start: Iterate<'p>, rung: usize) -> Result<Located<'p>, Status> {
        let (balance, newton) = (&self.ladder[rung], self.settings.newton);
        let prediction = PeakPrediction {
            point: start.point.clone(),
            phasor: self.phasor,
            sharpness: None,
        };
        let direct = self
            .count
            .tally(correct(balance, prediction, self.peak, newton));
        match direct {
            Ok(found) => Ok(found),
            Err(_) => (self.count).tally(find_peak(balance, start, self.peak, newton)),
        }
    }

    /// The maximum on the harmonics of the study that belongs to the maximum `found` on those of `rung`.
    fn raised(&mut self, rung: usize, found: Located<'p>) -> Result<Located<'p>, Status> {
        let newton = self.settings.newton;
        let mut found = found;
        for pair in self.ladder[rung..].windows(2) {
            let prediction = PeakPrediction::on_other_harmonics(&pair[0], &found, &pair[1]);
            found = maximum_near(&pair[1], prediction, self.peak, newton, &mut self.count)?;
        }
        Ok(found)
    }

    /// Newton's method for solutions that only lead to others.
    fn on_the_way(&self) -> NewtonSettings {
        let newton = self.settings.newton;
        NewtonSettings {
            tolerance: newton.tolerance.max(TRACK_TOLERANCE),
            ..newton
        }
    }

    /// Adds the harmonics up to those of `last` to a phase-resonant solution, rung by rung at its amplitude, then
    /// returns to its level.
    fn climb(&mut self, start: Iterate<'p>, last: usize) -> Result<Iterate<'p>, Status> {
        let level = start.point.level;
        let newton = self.on_the_way();
        let mut iterate = start;
        for rung in 1..=last {
            let (from, to) = (&self.ladder[rung - 1], &self.ladder[rung]);
            let amplitude = iterate.response(from).norm();
            let condition = Condition::Amplitude {
                phasor: self.phasor,
                amplitude,
            };
            iterate =
                self.count
                    .tally(solve(to, iterate.point.padded(from, to), condition, newton))?;
        }
        self.bring_to_level(last, iterate, level)
    }

    /// Moves the track up to `level` by steps whose ratio adapts; gives a copy of the solution there.
    fn follow(&mut self, level: f64) -> Result<Iterate<'p>, Status> {
        let newton = NewtonSettings {
            max_iterations: TRACK_ITERATIONS.min(self.settings.newton.max_iterations),
            ..self.on_the_way()
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
        &mut self,
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
        self.count.tally(solve(balance, start, condition, newton))
    }

    /// Corrects a phase resonance to exactly `level`: by secants in the amplitude until near, then at the fixed level.
    fn bring_to_level(
        &mut self,
        rung: usize,
        start: Iterate<'p>,
        level: f64,
    ) -> Result<Iterate<'p>, Status> {
        let balance = &self.ladder[rung];
        let newton = self.on_the_way();
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
        let solved = solve(
            balance,
            point,
            Condition::PhaseLocked(self.phasor),
            self.settings.newton,
        );
        self.count.tally(solved)
    }

    /// The highest maximum next to the resonances of the structure that slides without friction, on few harmonics, where it
    /// comes near what the mode can reach: friction far below the level hardly moves it.
    fn sliding(&mut self, level: f64) -> Result<Located<'p>, Status> {
        let (balance, newton) = (&self.ladder[0], self.settings.newton);
        let rest = self.rest.as_ref().ok_or(Status::NoPeakInBand)?;
        let least = COMPETES * self.reach;
        let stiffness = rest.sliding_stiffness();
        let model = balance.problem.model;
        let resonances = linear_resonances(model, &stiffness, self.peak.band, least);
        let height = |found: &Located<'_>| found.iterate.response(balance).norm();
        let mut best: Option<Located<'p>> = None;
        for resonance in resonances.map_err(|_| Status::NonFinite)? {
            let start = rest.sliding(balance, resonance.omega, level);
            let start = solve(balance, start, Condition::FixedFrequency, newton);
            let found = (self.count.tally(start)).and_then(|start| {
                self.count
                    .tally(find_peak(balance, start, self.peak, newton))
            });
            let higher = found.ok().filter(|found| {
                let least = best.as_ref().map_or(least * level, height);
                height(found) > least
            });
            best = higher.or(best);
        }
        best.ok_or(Status::NoPeakInBand)
    }

    /// The highest maximum on the branch through the whole band at `level`, on the harmonics of `rung`.
    fn sweep(&mut self, level: f64, rung: usize) -> Result<Located<'p>, Status> {
        let highest = self
            .highest_of_way(level, rung, SweepDirection::Upward)
            .or_else(|_| self.highest_of_way(level, rung, SweepDirection::Downward))?;
        highest.ok_or(Status::NoPeakInBand)
    }

    /// The highest maximum on the way through the band.
    fn highest_of_way(
        &mut self,
        level: f64,
        rung: usize,
        direction: SweepDirection,
    ) -> Result<Option<Located<'p>>, Status> {
        let (balance, newton) = (&self.ladder[rung], self.settings.newton);
        let band = self.peak.band;
        let [omega, _] = direction.ends(band);
        let rungs = &self.ladder[..=rung];
        let first = first_solution(rungs, newton, level, (omega, direction));
        let first = self.count.tally(first)?;
        let route = Route {
            band,
            direction,
            largest_step: SWEEP_STEP,
            largest_advance: SWEEP_ADVANCE,
        };
        let height = |found: &Located<'_>| found.iterate.response(balance).norm();
        let (mut best, mut count): (Option<Located<'p>>, _) = (None, WorkCount::default());
        let end = follow(balance, first, route, newton, |from, to, _| {
            let stretch = Stretch::new(balance, &from, to);
            let higher =
                (maximum_on(&stretch, balance, self.peak, newton, &mut count)).filter(|found| {
                    best.as_ref()
                        .is_none_or(|best| height(found) > height(best))
                });
            best = higher.or(best.take());
            ControlFlow::Continue(())
        });
        self.count += count;
        self.count += end.count;
        match end.status {
            Status::Converged => Ok(best),
            // a walk that stopped inside the band says nothing about the part it has not seen
            status => Err(status),
        }
    }
}

/// Solution of the fully stuck structure.
#[must_use]
pub fn stuck_point(balance: &Balance<'_>, omega: f64, level: f64) -> Point {
    let at = balance.compliance(omega);
    let zero = vec![0.0; balance.layout.n_unknowns()];
    let force = zero.clone();
    let motion = balance.motion(&at, level, &zero, &force);
    let residual = balance.residual(&motion, &zero, &force);
    Point {
        r: residual.iter().map(|r| -r).collect(),
        omega,
        level,
    }
}
