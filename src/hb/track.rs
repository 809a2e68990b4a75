//! Resonance peaks of one problem over ascending excitation levels.
//!
//! Below slip onset the stuck structure is linear, so the track starts there and follows the phase resonance in the
//! level with one harmonic, which is cheap and smooth. At each level asked for, harmonics are added step by step, the
//! maximum next to the phase resonance is located, and more harmonics follow until the error alert is silent. Where
//! that fails the whole band is swept by continuation.

use super::alert::{enlarged, pad, time_points, truncation_error};
use super::balance::Balance;
use super::continuation::{BranchPoint, StepSettings, walk};
use super::newton::{Condition, Direction, Iterate, Point, WorkCount, solve};
use super::peak::{PeakSettings, find_peak};
use super::problem::Problem;
use super::resonance::{StuckResonance, stuck_resonance};
use super::settings::{HbSettings, NewtonSettings};
use super::solution::Solution;
use super::status::Status;
use crate::harmonics::HarmonicSet;
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
    /// Work spent on this level.
    pub count: WorkCount,
}

/// Share of the slip onset at which the track starts.
const START_BELOW_ONSET: f64 = 0.5;
/// First and largest ratio between two levels of the track.
const RATIOS: [f64; 2] = [2.0, 4.0];
/// Ratios below this end the track.
const SMALLEST_RATIO: f64 = 1.02;
/// Newton iterations of one step of the track; more mean that the step was too long.
const TRACK_ITERATIONS: usize = 30;
/// Highest harmonics of the sets on the way from the track to the study's set.
const RUNGS: [usize; 3] = [1, 2, 3];
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
    let Some(resonance) = stuck_resonance(problem, peak.band)? else {
        let nothing = |&level| LevelPeak::failed(level, Status::NoPeakInBand, WorkCount::default());
        return Ok(levels.iter().map(nothing).collect());
    };
    let ladder: Vec<Balance<'_>> = (RUNGS.iter())
        .filter(|&&rung| rung < settings.harmonics.highest())
        .map(|&rung| HarmonicSet::up_to(rung))
        .chain([settings.harmonics.clone()])
        .map(|harmonics| Balance::new(problem, harmonics, settings.aft))
        .collect();
    let mut track = Track {
        ladder: &ladder,
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
            count,
        }
    }
}

impl<'a, 'p> Track<'a, 'p> {
    /// Solves at or below the first level, where the stuck solution is a good start.
    fn start(&mut self, resonance: &StuckResonance, first_level: f64) {
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
            Ok(point) => self.refined(point.iterate),
            Err(status) => LevelPeak::failed(level, status, self.count),
        }
    }

    /// The problem on the harmonic set of the study.
    fn full(&self) -> &'a Balance<'p> {
        &self.ladder[self.ladder.len() - 1]
    }

    /// Adds harmonics to a phase-resonant solution, rung by rung.
    fn climb(&mut self, start: Iterate<'p>) -> Result<Iterate<'p>, Status> {
        let phase = Condition::PhaseLocked(self.phasor);
        let mut iterate = start;
        for rungs in self.ladder.windows(2) {
            let padded = pad(&rungs[0], &iterate.point, &rungs[1]);
            iterate = self.tally(solve(&rungs[1], padded, phase, self.settings.newton))?;
        }
        Ok(iterate)
    }

    /// Moves the track to `level` by steps whose ratio adapts; gives a copy of the solution there.
    fn follow(&mut self, level: f64) -> Result<Iterate<'p>, Status> {
        let balance = &self.ladder[0];
        let newton = NewtonSettings {
            max_iterations: TRACK_ITERATIONS,
            ..self.settings.newton
        };
        loop {
            let at = self.at.as_ref().ok_or(Status::StepTooSmall)?;
            let left = level / at.point.level;
            if (left - 1.0).abs() < 1e-12 {
                return Ok(Iterate::new(balance, at.point.clone()));
            }
            let ratio = if left > self.ratio {
                self.ratio.min(left.sqrt().max(SMALLEST_RATIO))
            } else {
                left
            };
            let target = if ratio == left {
                level
            } else {
                at.point.level * ratio
            };
            let predicted = self.predict(at, target);
            let solved = solve(
                balance,
                predicted,
                Condition::PhaseLocked(self.phasor),
                newton,
            );
            match self.tally(solved) {
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
    }

    /// Tangent predictor in the level along the phase resonance.
    fn predict(&self, at: &Iterate<'_>, level: f64) -> Point {
        let balance = &self.ladder[0];
        let jacobian = at.jacobian(balance);
        let slope = balance.level_slope(&at.compliance);
        let by_level = Direction {
            r: jacobian.solve(&slope).iter().map(|x| -x).collect(),
            omega: 0.0,
        };
        let by_omega = Direction {
            r: at.frequency_rate(balance, &jacobian),
            omega: 1.0,
        };
        let off_phase = |direction: &Direction, level: f64| {
            let rate = at.response_rate(balance, &jacobian, direction, level);
            (rate * self.phasor.conj()).im
        };
        let step = level - at.point.level;
        let omega = -step * off_phase(&by_level, 1.0) / off_phase(&by_omega, 0.0);
        let rates = by_level.r.iter().zip(&by_omega.r);
        Point {
            r: at
                .point
                .r
                .iter()
                .zip(rates)
                .map(|(r, (l, o))| r + step * l + omega * o)
                .collect(),
            omega: at.point.omega + omega,
            level,
        }
    }

    /// Raises the harmonics from a converged peak until the alert is silent, and reports the peak.
    fn refined(&mut self, iterate: Iterate<'p>) -> LevelPeak {
        let Some(alert) = self.settings.alert else {
            return self.report(self.full(), &iterate, Status::Converged, None);
        };
        let problem = self.full().problem;
        let discretised = |harmonics| {
            let aft = time_points(self.settings.aft, &harmonics);
            Balance::new(problem, harmonics, aft)
        };
        let mut raised: Option<Balance<'p>> = None;
        let mut iterate = iterate;
        loop {
            let balance = raised.as_ref().unwrap_or(self.full());
            let highest = balance.harmonics.highest();
            let cap = (highest < alert.highest_harmonic).then_some(alert.highest_harmonic);
            let larger = discretised(enlarged(&balance.harmonics, cap));
            let y = iterate.response(balance);
            let condition = Condition::PhaseLocked(y / y.norm());
            let error = truncation_error(balance, &iterate, &larger, condition);
            self.count += WorkCount {
                iterations: 1,
                factorizations: 1,
            };
            if error <= alert.threshold {
                return self.report(balance, &iterate, Status::Converged, Some(error));
            }
            let next = match cap {
                Some(_) => self.raise(balance, &iterate, &larger, condition),
                None => Err(Status::TruncationAboveThreshold),
            };
            match next {
                Ok(point) => iterate = point,
                Err(_) => {
                    let status = Status::TruncationAboveThreshold;
                    return self.report(balance, &iterate, status, Some(error));
                }
            }
            raised = Some(larger);
        }
    }

    /// The same peak on more harmonics.
    fn raise(
        &mut self,
        balance: &Balance<'_>,
        iterate: &Iterate<'_>,
        larger: &Balance<'p>,
        condition: Condition<'_>,
    ) -> Result<Iterate<'p>, Status> {
        let newton = self.settings.newton;
        let start = self.tally(solve(
            larger,
            pad(balance, &iterate.point, larger),
            condition,
            newton,
        ))?;
        self.tally(find_peak(larger, start, self.peak, newton))
            .map(|point| point.iterate)
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
            status,
            solution: Some(solution),
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
