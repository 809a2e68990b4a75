//! Resonance peaks of one problem over ascending excitation levels.
//!
//! Below slip onset the stuck structure is linear, so the track starts there and follows the phase resonance with one
//! harmonic, which is cheap and smooth, by steps of its amplitude: the level that an amplitude needs is unique where the
//! amplitude that a level gives is not. At each level asked for, harmonics are added step by step, the maximum next to
//! the phase resonance is located, and more harmonics follow until the error alert is silent. Where that fails the
//! whole band is swept by continuation.

use super::alert::{enlarged, pad, time_points, truncation_error};
use super::balance::Balance;
use super::continuation::{BranchPoint, StepSettings, walk};
use super::ladder::Ladder;
use super::newton::{Condition, Iterate, Point, WorkCount, solve};
use super::peak::{PeakSettings, find_peak};
use super::problem::Problem;
use super::resonance::{LinearResonance, linear_resonance};
use super::settings::{HbSettings, NewtonSettings};
use super::solution::Solution;
use super::status::Status;
use crate::linalg::LinalgError;
use faer::prelude::c64;

/// Peak at one level.
#[derive(Debug)]
pub struct LevelPeak {
    /// Excitation level.
    pub level: f64,
    /// How it ended.
    pub status: Status,
    /// The solution at the peak, if any.
    pub solution: Option<Solution>,
    /// The same peak on the study's own harmonics, before any were added: start of the forced response curve.
    pub on_first_harmonics: Option<Point>,
    /// Work spent on this level.
    pub count: WorkCount,
}

/// Share of the slip onset at which the track starts.
const START_BELOW_ONSET: f64 = 0.5;
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
/// Steps of the sweep that replaces a failed track.
const SWEEP_STEPS: usize = 200;

/// The phase-resonant solution the track has reached.
struct Track<'a, 'p> {
    /// The problem on sets with more and more harmonics: the track runs on the first, the study wants the last.
    ladder: &'a [Balance<'p>],
    settings: &'a HbSettings,
    peak: PeakSettings,
    /// Direction of the first harmonic of response 0 at resonance.
    phasor: c64,
    at: Option<Iterate<'p>>,
    ratio: f64,
    count: WorkCount,
}

/// Peaks of `problem` at the ascending, positive `levels`; a level that is not a positive number gives
/// [`Status::NonFinite`].
///
/// # Errors
/// [`LinalgError`] if the modes of the stuck structure cannot be found. Solves that fail are statuses.
pub fn track_peaks(
    problem: &Problem<'_>,
    settings: &HbSettings,
    peak: PeakSettings,
    levels: &[f64],
) -> Result<Vec<LevelPeak>, LinalgError> {
    let Some(resonance) = linear_resonance(problem.model, &problem.stuck_stiffness, peak.band)?
    else {
        let nothing = |&level| LevelPeak::failed(level, Status::NoPeakInBand, WorkCount::default());
        return Ok(levels.iter().map(nothing).collect());
    };
    let ladder = Ladder::new(problem, settings);
    let mut track = Track {
        ladder: ladder.rungs(),
        settings,
        peak,
        phasor: resonance.response / resonance.response.norm(),
        at: None,
        ratio: RATIOS[0],
        count: WorkCount::default(),
    };
    track.start(&resonance, levels.first().copied().unwrap_or(1.0));
    Ok(levels.iter().map(|&level| track.level(level)).collect())
}

impl LevelPeak {
    fn failed(level: f64, status: Status, count: WorkCount) -> Self {
        Self {
            level,
            status,
            solution: None,
            on_first_harmonics: None,
            count,
        }
    }
}

impl<'a, 'p> Track<'a, 'p> {
    /// Solves at or below the first level, where the stuck solution is a good start.
    fn start(&mut self, resonance: &LinearResonance, first_level: f64) {
        let balance = &self.ladder[0];
        let stuck = |level: f64| stuck_point(balance, resonance.omega, level);
        let onset = slip_onset(balance, &stuck(1.0));
        let level = first_level.min(START_BELOW_ONSET * onset);
        let newton = self.settings.newton;
        let held = solve(balance, stuck(level), Condition::FixedFrequency, newton);
        let locked = self.tally(held).and_then(|iterate| {
            let phase = Condition::PhaseLocked(self.phasor);
            let locked = solve(balance, iterate.point, phase, newton);
            self.tally(locked)
        });
        self.at = locked.ok();
    }

    /// Follows the phase resonance to `level` and returns the peak there.
    fn level(&mut self, level: f64) -> LevelPeak {
        self.count = WorkCount::default();
        // Ratios of such levels are no numbers, and the track would never give up on them.
        if !(level.is_finite() && level > 0.0) {
            return LevelPeak::failed(level, Status::NonFinite, self.count);
        }
        let reached = self.follow(level);
        let located = reached
            .and_then(|start| self.climb(start))
            .and_then(|start| {
                let found = find_peak(self.full(), start, self.peak, self.settings.newton);
                self.tally(found)
            });
        match located.or_else(|_| self.sweep(level)) {
            Ok(point) => {
                let start = point.iterate.point.clone();
                let refined = self.refined(point.iterate);
                LevelPeak {
                    on_first_harmonics: Some(start),
                    ..refined
                }
            }
            Err(status) => LevelPeak::failed(level, status, self.count),
        }
    }

    /// The problem on the harmonic set of the study.
    fn full(&self) -> &'a Balance<'p> {
        &self.ladder[self.ladder.len() - 1]
    }

    /// Newton's method for solutions that only lead to others.
    fn on_the_way(&self) -> NewtonSettings {
        let newton = self.settings.newton;
        NewtonSettings {
            tolerance: newton.tolerance.max(TRACK_TOLERANCE),
            ..newton
        }
    }

    /// Adds harmonics to a phase-resonant solution, rung by rung at its amplitude, then returns to its level.
    fn climb(&mut self, start: Iterate<'p>) -> Result<Iterate<'p>, Status> {
        let level = start.point.level;
        let newton = self.on_the_way();
        let mut iterate = start;
        for rung in 1..self.ladder.len() {
            let (from, to) = (&self.ladder[rung - 1], &self.ladder[rung]);
            let amplitude = iterate.response(from).norm();
            let condition = Condition::Amplitude {
                phasor: self.phasor,
                amplitude,
            };
            iterate = self.tally(solve(to, pad(from, &iterate.point, to), condition, newton))?;
        }
        self.bring_to_level(self.ladder.len() - 1, iterate, level)
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
                Ok(iterate) if self.peak.band.contains(iterate.point.omega) => {
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
        self.tally(solve(balance, start, condition, newton))
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
            let gap = (level / at.point.level).ln();
            if gap.abs() <= NEAR_LEVEL {
                break;
            }
            let step = (gap * slope).clamp(-longest, longest);
            let amplitude = at.response(balance).norm();
            match self.scaled(rung, &at.point, amplitude, step.exp(), newton) {
                Ok(next) => {
                    let moved = (next.point.level / at.point.level).ln();
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
        self.tally(solved)
    }

    /// Raises the harmonics from a converged peak until the alert is silent, and reports the peak.
    ///
    /// On the way the solution keeps the phase of the last peak; the maximum is searched once, on the final set.
    fn refined(&mut self, iterate: Iterate<'p>) -> LevelPeak {
        let Some(alert) = self.settings.alert else {
            return self.report(self.full(), &iterate, Status::Converged, None);
        };
        let y = iterate.response(self.full());
        let phase = Condition::PhaseLocked(y / y.norm());
        let mut raised: Option<Balance<'p>> = None;
        let mut iterate = iterate;
        let (status, error) = loop {
            let balance = raised.as_ref().unwrap_or(self.full());
            let below_cap = balance.harmonics.highest() < alert.highest_harmonic;
            let larger = self.enlarged(balance, below_cap.then_some(alert.highest_harmonic));
            let error = truncation_error(balance, &iterate, &larger, phase);
            self.count += WorkCount {
                iterations: 1,
                factorizations: 1,
            };
            if error <= alert.threshold {
                break (Status::Converged, error);
            }
            if !below_cap {
                break (Status::TruncationAboveThreshold, error);
            }
            let padded = pad(balance, &iterate.point, &larger);
            match self.tally(solve(&larger, padded, phase, self.settings.newton)) {
                Ok(solved) => iterate = solved,
                Err(_) => break (Status::TruncationAboveThreshold, error),
            }
            raised = Some(larger);
        };
        let Some(balance) = raised else {
            return self.report(self.full(), &iterate, status, Some(error));
        };
        let start = iterate.point.clone();
        let found = find_peak(&balance, iterate, self.peak, self.settings.newton);
        let peak = match self.tally(found) {
            Ok(point) => point.iterate,
            // the phase resonance stands for the maximum that could not be located
            Err(_) => Iterate::new(&balance, start),
        };
        self.report(&balance, &peak, status, Some(error))
    }

    /// The same problem on the next larger set, up to `cap`.
    fn enlarged(&self, balance: &Balance<'p>, cap: Option<usize>) -> Balance<'p> {
        let harmonics = enlarged(&balance.harmonics, cap);
        let aft = time_points(self.settings.aft, &harmonics);
        Balance::new(balance.problem, harmonics, aft)
    }

    /// Walks through the whole band at `level` and refines the highest point met.
    fn sweep(&mut self, level: f64) -> Result<BranchPoint<'p>, Status> {
        let band = self.peak.band;
        let newton = self.settings.newton;
        let balance = self.full();
        let start = stuck_point(balance, band.low, level);
        let start = self.tally(solve(balance, start, Condition::FixedFrequency, newton))?;
        let steps = StepSettings {
            max_steps: SWEEP_STEPS,
            ..StepSettings::for_band(band.width())
        };
        let (first, work) = BranchPoint::new(balance, start, steps.omega_scale, None, None);
        self.count += work;
        let mut best: Option<(f64, Point)> = None;
        let end = walk(balance, first, newton, steps, |_, point, _| {
            let amplitude = point.response.norm();
            let omega = point.iterate.point.omega;
            if band.contains(omega)
                && best
                    .as_ref()
                    .is_none_or(|(highest, _)| amplitude > *highest)
            {
                best = Some((amplitude, point.iterate.point.clone()));
            }
            omega < band.high && omega > 0.5 * band.low
        });
        self.count += end.count;
        let point = match (end.status, best) {
            (Status::Converged, Some((_, point))) => point,
            (Status::Converged, None) => return Err(Status::NoPeakInBand),
            // a walk that stopped inside the band says nothing about the part it has not seen
            (status, _) => return Err(status),
        };
        let start = Iterate::new(balance, point);
        self.tally(find_peak(balance, start, self.peak, newton))
    }

    fn report(
        &self,
        balance: &Balance<'_>,
        iterate: &Iterate<'_>,
        status: Status,
        truncation_error: Option<f64>,
    ) -> LevelPeak {
        let mut solution = Solution::new(balance, iterate, status, self.count);
        solution.truncation_error = truncation_error;
        LevelPeak {
            level: iterate.point.level,
            status: solution.status,
            solution: Some(solution),
            on_first_harmonics: None,
            count: self.count,
        }
    }

    fn tally<T>(
        &mut self,
        result: Result<(T, WorkCount), (Status, WorkCount)>,
    ) -> Result<T, Status> {
        match result {
            Ok((value, work)) => {
                self.count += work;
                Ok(value)
            }
            Err((status, work)) => {
                self.count += work;
                Err(status)
            }
        }
    }
}

/// Solution of the fully stuck structure.
#[must_use]
pub fn stuck_point(balance: &Balance<'_>, omega: f64, level: f64) -> Point {
    let at = balance.compliance(omega);
    let zero = vec![0.0; balance.layout.n_unknowns()];
    let force = zero.clone();
    let residual = balance.residual(&at, level, &zero, &force);
    Point {
        r: residual.iter().map(|r| -r).collect(),
        omega,
        level,
    }
}

/// Level at which the stuck solution, given per unit level, first breaks the Coulomb limit or opens a pair.
fn slip_onset(balance: &Balance<'_>, unit: &Point) -> f64 {
    let n_c = balance.layout.n_pairs;
    let n = balance.layout.n_relative();
    let dynamic = |i: usize| unit.r[n + i].hypot(unit.r[2 * n + i]);
    (balance.problem.contacts.iter().enumerate())
        .map(|(pair, c)| {
            let preload = c.n_0 + c.k_n * unit.r[2 * n_c + pair];
            let [t1, t2] = [0, 1].map(|axis| c.k_t[axis] * dynamic(axis * n_c + pair));
            let normal = c.k_n * dynamic(2 * n_c + pair);
            preload.max(0.0) * (c.mu / (t1.hypot(t2) + c.mu * normal)).min(1.0 / normal)
        })
        .filter(|level| *level > 0.0)
        .fold(f64::INFINITY, f64::min)
}
