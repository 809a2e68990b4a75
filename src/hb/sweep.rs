//! Solutions at prescribed frequencies, found as a slow frequency sweep would find them.
//!
//! Between two frequencies the branch is followed: by tangent steps where they predict the next solution well, else
//! by continuation to the first point with the wanted frequency. So where several solutions exist the one met first on
//! the branch is reported, past a fold the one beyond it. The first frequency is reached in the same way, with few
//! harmonics, from a frequency well off it, where the level is raised from stick.

use super::alert::pad;
use super::balance::Balance;
use super::continuation::{BranchPoint, StepSettings, on_if, walk};
use super::ladder::Ladder;
use super::newton::{Condition, Direction, Iterate, Metric, Point, WorkCount, polish, solve};
use super::settings::NewtonSettings;
use super::status::Status;
use super::track::stuck_point;

/// Largest distance between a start and its solution, relative to the displacements, that leaves no doubt that both
/// lie on one branch.
const CLOSE: f64 = 0.2;
/// Tangent steps into which the way to the next frequency may be cut.
const MOST_PARTS: u32 = 16;
/// Distance of the run-in from the first frequency, relative.
const RUN_IN: f64 = 0.4;
/// Largest steps of a walk, and of its repetition if the frequency could not be hit.
const LARGEST_STEPS: [f64; 2] = [0.3, 0.05];
/// Steps of a walk before giving up.
const MOST_STEPS: usize = 1500;
/// Level, relative to the wanted one, at which it starts to be raised.
const LOWEST_LEVEL: f64 = 1e-4;
/// First ratio between two levels.
const LEVEL_RATIO: f64 = 3.0;
/// Ratios below this end the raising of the level.
const SMALLEST_RATIO: f64 = 1.005;

/// Which way the frequencies go, and so which solution is met where there are several.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum SweepDirection {
    /// From low to high frequencies.
    #[default]
    Upward,
    /// From high to low frequencies.
    Downward,
}

impl SweepDirection {
    /// Name in study files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Upward => "upward",
            Self::Downward => "downward",
        }
    }
}

type Solved<'p> = Result<Iterate<'p>, Status>;

/// The state of a sweep.
#[derive(Debug)]
pub struct Sweep<'a, 'p> {
    ladder: &'a Ladder<'p>,
    newton: NewtonSettings,
    level: f64,
    direction: SweepDirection,
    /// The solution at the last frequency.
    at: Option<Point>,
    count: WorkCount,
}

impl<'a, 'p> Sweep<'a, 'p> {
    /// A sweep at `level` that has not begun.
    #[must_use]
    pub fn new(
        ladder: &'a Ladder<'p>,
        newton: NewtonSettings,
        level: f64,
        direction: SweepDirection,
    ) -> Self {
        Self {
            ladder,
            newton,
            level,
            direction,
            at: None,
            count: WorkCount::default(),
        }
    }

    /// The solution at the next frequency (rad/s) on the full set of harmonics, accurate to round-off.
    ///
    /// # Errors
    /// The status of the last attempt, and the work of all.
    pub fn next(&mut self, omega: f64) -> Result<(Iterate<'p>, WorkCount), (Status, WorkCount)> {
        self.count = WorkCount::default();
        let solved = match self.at.take() {
            Some(point) => self.follow_branch(point, omega),
            None => self.run_in(omega),
        };
        match solved {
            Ok(iterate) => {
                let (iterate, work) = polish(self.ladder.full(), iterate);
                self.count += work;
                self.at = Some(iterate.point.clone());
                Ok((iterate, self.count))
            }
            Err(status) => Err((status, self.count)),
        }
    }

    /// Follows the branch from the last solution: by tangent steps in the frequency, shorter where the prediction is
    /// poor; where that ends, at a fold, by continuation with few harmonics, then with all.
    fn follow_branch(&mut self, from: Point, omega: f64) -> Solved<'p> {
        let full = self.ladder.full();
        let shortest = (omega - from.omega).abs() / f64::from(MOST_PARTS);
        let mut at = from;
        let mut step = omega - at.omega;
        while step.abs() >= shortest {
            let target = if (omega - at.omega).abs() <= step.abs() {
                omega
            } else {
                at.omega + step
            };
            let (branch, work) = self.branch(full, Iterate::new(full, at.clone()));
            self.count += work;
            let length = (target - at.omega) / branch.tangent.omega;
            let predicted = Point {
                r: moved(&at.r, length, &branch.tangent.r),
                omega: target,
                level: at.level,
            };
            match self.close_to(full, predicted) {
                (Ok(solved), true) if target == omega => return Ok(solved),
                (Ok(solved), true) => {
                    at = solved.point;
                    step *= 2.0;
                }
                _ => step *= 0.5,
            }
        }
        self.walk_with_few(&at, omega)
            .or_else(|_| self.walk(full, &at, omega))
            .or_else(|_| self.run_in(omega))
    }

    /// Continuation with few harmonics, the others added at the end.
    fn walk_with_few(&mut self, from: &Point, omega: f64) -> Solved<'p> {
        let first = self.ladder.first();
        let few = pad(self.ladder.full(), from, first);
        let (start, _) = self.close_to(first, few);
        let start = self.walk(first, &start?.point, omega)?;
        self.climb(start)
    }

    /// Finds a first solution.
    fn run_in(&mut self, omega: f64) -> Solved<'p> {
        let ladder = self.ladder;
        let full = ladder.full();
        let away = match self.direction {
            SweepDirection::Upward => omega * (1.0 - RUN_IN),
            SweepDirection::Downward => omega * (1.0 + RUN_IN),
        };
        let first = ladder.first();
        let reached = (self.raised(first, away))
            .and_then(|start| self.walk(first, &start.point, omega))
            .and_then(|start| self.climb(start));
        reached
            .or_else(|_| {
                let start = self.raised(first, omega)?;
                self.climb(start)
            })
            .or_else(|_| {
                let start = self.raised(full, away)?;
                self.walk(full, &start.point, omega)
            })
            .or_else(|_| {
                let (direct, _) = self.close_to(full, stuck_point(full, omega, self.level));
                direct
            })
    }

    fn climb(&mut self, start: Iterate<'p>) -> Solved<'p> {
        let condition = Condition::FixedFrequency;
        let climbed = self.ladder.climb(start.point, condition, self.newton);
        self.tally(climbed)
    }

    /// Solves at the frequency of `start`, and says whether the solution is close to it.
    fn close_to(&mut self, balance: &Balance<'p>, start: Point) -> (Solved<'p>, bool) {
        let solved = solve(
            balance,
            start.clone(),
            Condition::FixedFrequency,
            self.newton,
        );
        let solved = self.tally(solved);
        let close = solved.as_ref().is_ok_and(|iterate| {
            let metric = Metric::at(balance, &iterate.point, 1.0);
            let gone = Direction {
                r: moved(&iterate.point.r, -1.0, &start.r),
                omega: 0.0,
            };
            metric.dot(balance.layout.n_relative(), &gone, &gone) <= CLOSE * CLOSE
        });
        (solved, close)
    }

    /// Raises the level at the frequency `omega` from where the structure sticks.
    fn raised(&mut self, balance: &Balance<'p>, omega: f64) -> Solved<'p> {
        let (direct, close) = self.close_to(balance, stuck_point(balance, omega, self.level));
        if close {
            return direct;
        }
        let lowest = stuck_point(balance, omega, LOWEST_LEVEL * self.level);
        let (start, _) = self.close_to(balance, lowest);
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

    /// Continuation from `from`, in the direction of the sweep, to the first point with the frequency `omega`.
    fn walk(&mut self, balance: &Balance<'p>, from: &Point, omega: f64) -> Solved<'p> {
        let mut failure = Status::StepTooSmall;
        for largest in LARGEST_STEPS {
            let (start, work) = self.branch(balance, Iterate::new(balance, from.clone()));
            self.count += work;
            let steps = StepSettings {
                largest,
                first: largest.min(0.05),
                max_steps: MOST_STEPS,
                ..StepSettings::for_band((omega - from.omega).abs())
            };
            let mut crossing = None;
            let end = walk(balance, start, self.newton, steps, |before, after, _| {
                let (a, b) = (before.iterate.point.omega, after.iterate.point.omega);
                if (a - omega) * (b - omega) <= 0.0 {
                    crossing = Some(between(&before.iterate.point, &after.iterate.point, omega));
                }
                let reach = 2.0 * (omega - from.omega).abs();
                on_if(crossing.is_none() && (b - from.omega).abs() < reach)
            });
            self.count += end.count;
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

    /// The tangent at `iterate` in the direction of the sweep.
    fn branch(&self, balance: &Balance<'p>, iterate: Iterate<'p>) -> (BranchPoint<'p>, WorkCount) {
        let scale = iterate.point.omega;
        let (branch, work) = BranchPoint::new(balance, iterate, scale, None, None);
        let branch = match self.direction {
            SweepDirection::Upward => branch,
            SweepDirection::Downward => branch.reversed(),
        };
        (branch, work)
    }

    fn tally(
        &mut self,
        result: Result<(Iterate<'p>, WorkCount), (Status, WorkCount)>,
    ) -> Solved<'p> {
        let (result, work) = match result {
            Ok((iterate, work)) => (Ok(iterate), work),
            Err((status, work)) => (Err(status), work),
        };
        self.count += work;
        result
    }
}

/// Tangent predictor in the level at a fixed frequency.
fn by_level(balance: &Balance<'_>, at: &Iterate<'_>, level: f64) -> Point {
    let slope = at
        .jacobian(balance)
        .solve(&balance.level_slope(&at.compliance));
    Point {
        r: moved(&at.point.r, at.point.level - level, &slope),
        omega: at.point.omega,
        level,
    }
}

/// The point with the frequency `omega` on the straight line from `a` to `b`.
fn between(a: &Point, b: &Point, omega: f64) -> Point {
    let share = (omega - a.omega) / (b.omega - a.omega);
    let gone = moved(&b.r, -1.0, &a.r);
    Point {
        r: moved(&a.r, share, &gone),
        omega,
        level: a.level,
    }
}

/// `from + step · along`.
fn moved(from: &[f64], step: f64, along: &[f64]) -> Vec<f64> {
    from.iter().zip(along).map(|(x, d)| x + step * d).collect()
}
