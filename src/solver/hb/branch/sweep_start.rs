//! A sweep at one level, with the search for its first solution, where none is known yet.
//!
//! The search begins far outside the band. There the level is raised from a level at which the contacts stick, with few
//! harmonics. The branch is followed to the end of the band, and the other harmonics are added there.

use super::branch_point::{BranchPoint, distance};
use super::continuation::{ContinuationEnd, StepSettings, continue_branch, on_if};
use super::sweep::{SweepSettings, follow};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::ladder::climb;
use crate::hb::newton::rest::Rest;
use crate::hb::newton::{Condition, Direction, Iterate, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use std::ops::ControlFlow;

/// Largest distance between a start and its solution, relative to the displacements, at which both surely lie on one branch.
const CLOSE: f64 = 0.2;
/// Relative distance between the frequency where the level is raised and the end of the band.
const START_DISTANCE: f64 = 0.4;
/// Largest step of the continuation to the band, and of its repetition if the frequency was not met.
const LARGEST_STEPS: [f64; 2] = [0.3, 0.05];
/// Most steps of the continuation.
const MOST_STEPS: usize = 1500;
/// First level over the wanted one; it is lower if contacts slip there.
const LOWEST_LEVEL: f64 = 1e-4;
/// First ratio between two levels.
const LEVEL_RATIO: f64 = 3.0;
/// The level is raised no further if the ratio falls below this.
const SMALLEST_RATIO: f64 = 1.005;

type Solved<'p> = Result<Iterate<'p>, Status>;

/// A sweep at one level.
pub(in crate::hb) struct Sweep<'a, 'p> {
    /// The same problem on ever more harmonics; the sweep follows the branch on those of the last.
    pub rungs: &'a [Balance<'p>],
    /// Settings of every solve.
    pub newton: NewtonSettings,
    /// Excitation level.
    pub level: f64,
    /// Band, direction and steps.
    pub settings: SweepSettings,
}

/// A search for the solution of a balance at a frequency (rad/s).
type Attempt<'a, 'p> = fn(&Sweep<'a, 'p>, &Balance<'p>, f64) -> Solved<'p>;

impl<'a, 'p> Sweep<'a, 'p> {
    /// The solution on all harmonics at the end of the band where the sweep begins.
    ///
    /// # Errors
    /// The status of the last attempt.
    pub(in crate::hb) fn first(&self) -> Solved<'p> {
        self.first_by([Self::raised_outside, Self::raised])
    }

    /// The same, first tried at that end itself: where many resonances lie between it and a frequency far outside, as below the band of
    /// a mistuned disk, the branch from there is long.
    ///
    /// # Errors
    /// The status of the last attempt.
    pub(in crate::hb) fn first_at_end(&self) -> Solved<'p> {
        self.first_by([Self::raised, Self::raised_outside])
    }

    /// Follows the branch from its `first` solution, as [`follow`] does.
    pub(in crate::hb) fn followed(
        &self,
        first: Iterate<'p>,
        visit: impl FnMut(BranchPoint<'p>, &BranchPoint<'p>) -> ControlFlow<()>,
    ) -> ContinuationEnd<'p> {
        let balance = &self.rungs[self.rungs.len() - 1];
        follow(balance, first, self.settings, self.newton, visit)
    }

    /// The first solution that an attempt finds: those of `on_few` on the fewest harmonics, then on all of them, and last about the
    /// structure that slides.
    fn first_by(&self, on_few: [Attempt<'a, 'p>; 2]) -> Solved<'p> {
        let [omega, _] = self.settings.direction.ends(self.settings.band);
        if !(omega.is_finite() && self.level.is_finite()) {
            return Err(Status::NonFinite);
        }
        let mut attempts = on_few.map(|attempt| (0, attempt)).to_vec();
        let full = self.rungs.len() - 1;
        // with one rung these have been tried
        if full > 0 {
            attempts.push((full, Self::raised_outside));
            attempts.push((full, Self::raised));
        }
        attempts.push((0, Self::sliding));
        let mut failure = Status::StepTooSmall;
        for (rung, attempt) in attempts {
            let start = attempt(self, &self.rungs[rung], omega);
            match start.and_then(|start| self.climb(rung, start)) {
                Ok(first) => return Ok(first),
                Err(status) => failure = status,
            }
        }
        Err(failure)
    }

    /// Takes a solution on `rung` to all harmonics.
    fn climb(&self, rung: usize, start: Iterate<'p>) -> Solved<'p> {
        let condition = Condition::FixedFrequency;
        climb(&self.rungs[rung..], start.point, condition, self.newton)
    }

    /// The solution at the frequency `omega`, with the level raised far outside the band, and the branch followed from there.
    fn raised_outside(&self, balance: &Balance<'p>, omega: f64) -> Solved<'p> {
        let away = omega * (1.0 - START_DISTANCE * self.settings.direction.sign());
        let start = self.raised(balance, away)?;
        self.continued(balance, &start.point, omega)
    }

    /// The solution at the frequency of `start`, and whether it is close to `start`.
    fn close_to(&self, balance: &Balance<'p>, start: Point) -> (Solved<'p>, bool) {
        let fixed = Condition::FixedFrequency;
        let solved = solve(balance, start.clone(), fixed, self.newton);
        let close =
            (solved.as_ref()).is_ok_and(|found| distance(balance, &found.point, &start) <= CLOSE);
        (solved, close)
    }

    /// The solution close to that of the structure that slides without friction: friction far below the level hardly moves
    /// it.
    fn sliding(&self, balance: &Balance<'p>, omega: f64) -> Solved<'p> {
        let rest = Rest::new(balance, omega)?;
        match self.close_to(balance, rest.sliding(balance, omega, self.level)) {
            (solved, true) => solved,
            (solved, false) => Err(solved.err().unwrap_or(Status::StepTooSmall)),
        }
    }

    /// The solution at the frequency `omega`, with the level raised from one at which the contacts stick.
    fn raised(&self, balance: &Balance<'p>, omega: f64) -> Solved<'p> {
        let rest = Rest::new(balance, omega)?;
        let (direct, close) = self.close_to(balance, rest.excited(self.level));
        if close {
            return direct;
        }
        let stuck = rest.stuck_level(balance.problem);
        let lowest = stuck.min(LOWEST_LEVEL * self.level);
        let (start, _) = self.close_to(balance, rest.excited(lowest));
        let mut at = start?;
        let mut ratio = LEVEL_RATIO;
        while at.point.level < self.level {
            let level = self.level.min(at.point.level * ratio);
            let predicted = by_level(balance, &at, level);
            match self.close_to(balance, predicted) {
                (Ok(next), true) => {
                    at = next;
                    ratio = (ratio * 1.3).min(LEVEL_RATIO);
                }
                _ => {
                    ratio = ratio.sqrt();
                    if ratio < SMALLEST_RATIO {
                        return direct.map_err(|_| Status::StepTooSmall);
                    }
                }
            }
        }
        Ok(at)
    }

    /// The first point with the frequency `omega` on the branch from `from`, followed in the direction of the sweep.
    fn continued(&self, balance: &Balance<'p>, from: &Point, omega: f64) -> Solved<'p> {
        let mut failure = Status::StepTooSmall;
        for largest in LARGEST_STEPS {
            let start = Iterate::new(balance, from.clone());
            let scale = start.point.omega;
            let start = BranchPoint::new(balance, start, scale);
            let steps = StepSettings {
                largest,
                first: largest.min(0.05),
                max_steps: MOST_STEPS,
                ..StepSettings::for_band((omega - from.omega).abs())
            };
            let mut crossing = None;
            let start = start.towards(self.settings.direction.sign());
            let end = continue_branch(balance, start, self.newton, steps, |before, after, _| {
                let (a, b) = (before.iterate.point.omega, after.iterate.point.omega);
                if (a - omega) * (b - omega) <= 0.0 {
                    let (before, after) = (&before.iterate.point, &after.iterate.point);
                    crossing = Some(before.at_frequency(after, omega));
                }
                let reach = 2.0 * (omega - from.omega).abs();
                on_if(crossing.is_none() && (b - from.omega).abs() < reach)
            });
            failure = match (end.status, crossing) {
                (_, Some(start)) => match self.close_to(balance, start) {
                    (solved, true) => return solved,
                    (solved, false) => solved.err().unwrap_or(Status::StepTooSmall),
                },
                (Status::Converged, None) => return Err(Status::StepTooSmall),
                (status, None) => status,
            };
        }
        Err(failure)
    }
}

/// Tangent predictor in the level at a fixed frequency.
fn by_level(balance: &Balance<'_>, at: &Iterate<'_>, level: f64) -> Point {
    let rate = Direction {
        r: at.level_rate(balance, &at.jacobian(balance)),
        omega: 0.0,
    };
    Point {
        level,
        ..at.point.moved(&rate, level - at.point.level)
    }
}
