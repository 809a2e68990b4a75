//! Forced response at one level: at given frequencies, or as a continuous curve over a band.
//!
//! Both follow the branch from one end of the band (see [`crate::hb::branch::sweep`]). Where it cannot be followed further, the other
//! part of the band is walked from the other end; what lies between is named as a gap.

pub use super::stations::PICTURE_ERROR;
use super::stations::Stations;
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::run_in::first_solution;
use crate::hb::branch::stretch::Stretch;
use crate::hb::branch::sweep::{Route, SweepDirection};
use crate::hb::equations::balance::Balance;
use crate::hb::equations::effort::{Meter, WorkCount};
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::Ladder;
use crate::hb::newton::{Condition, Iterate, Point, polish};
use crate::hb::peak::alert::AlertSets;
use crate::hb::peak::search::{PeakSettings, maximum_on};
use crate::hb::peak::track::stuck_point;
use crate::hb::settings::HbSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Band;

/// Largest relative change of the displacements between two solutions of a curve.
const PICTURE_STEP: f64 = 0.15;
/// Largest change of the frequency between two solutions of a curve, over the band.
const CURVE_ADVANCE: f64 = 0.025;
/// Relative change of frequency at which a maximum of a curve counts as located.
const PEAK_TOLERANCE: f64 = 1e-9;

/// What was found at one level.
#[derive(Debug, Clone)]
pub struct Response {
    /// Solutions, and what was not solved with its status.
    pub solutions: Vec<Solution>,
    /// Whether they are a curve, not those at prescribed frequencies.
    pub is_curve: bool,
    /// Where the branch could not be followed from one end of the band to the other, or to the last frequency asked for.
    pub gap: Option<Gap>,
}

/// The part of the band between the ends of the ways from both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Where the way from the lower end of the band ended, and why; [`Status::Converged`] where nothing further was asked
    /// for.
    pub below: Stop,
    /// The same of the way from the upper end.
    pub above: Stop,
}

impl Gap {
    pub(in crate::hb) fn has_spent_budget(self) -> bool {
        let stops = [self.below, self.above].map(|stop| stop.status);
        stops.contains(&Status::BudgetSpent)
    }

    /// Whether every frequency asked for was met by a sweep, from one side or from the other.
    #[must_use]
    pub fn is_answered(self) -> bool {
        [self.below, self.above]
            .map(|stop| stop.status)
            .contains(&Status::Converged)
    }
}

/// The end of a way through the band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Frequency that was reached (rad/s).
    pub omega: f64,
    /// Why it was the last one.
    pub status: Status,
}

/// How a curve is walked.
#[derive(Debug, Clone, Copy)]
pub struct CurveSettings {
    /// From its lower to its upper end.
    pub band: Band,
    /// Largest relative change of the displacements between two solutions.
    pub step: f64,
}

impl CurveSettings {
    /// As a picture with straight lines between the solutions needs.
    #[must_use]
    pub fn picture(band: Band) -> Self {
        Self {
            band,
            step: PICTURE_STEP,
        }
    }
}

/// What the largest amplitude of a response is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Largest {
    /// A maximum: the amplitude is smaller on both sides.
    Maximum,
    /// The largest of the values asked for, between smaller ones.
    OfValues,
    /// Found at an end of the band, or of the values, beyond which it may grow on.
    AtEdge,
    /// That of a response with frequencies where nothing was found, and where it may be larger.
    OfPart,
}

/// Solutions along the branch from the lower to the upper end of the band, with the maxima of the amplitude of response 0
/// among them; overhanging parts are included, also where they leave the band.
///
/// All on the harmonics of the settings; the truncation error is estimated, not reduced. If the branch cannot be
/// followed to its end, a point with the status that says why ends the first part, and the second part, from the upper end
/// of the band, begins with such a point. `progress` is given the share of the band that is done.
#[must_use]
pub fn over_band(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    curve: CurveSettings,
    progress: impl Fn(f64),
) -> Response {
    let ladder = Ladder::new(problem, settings);
    let level = Level::new(problem, &ladder, settings, level);
    let upward = level.part(curve, SweepDirection::Upward, None, &progress);
    let mut solutions = upward.solutions;
    let Some(below) = upward.stop else {
        return Response {
            solutions,
            is_curve: true,
            gap: None,
        };
    };
    let downward = level.part(
        curve,
        SweepDirection::Downward,
        upward.last.as_ref(),
        &progress,
    );
    if downward.met {
        // the point without a solution
        solutions.pop();
    } else if downward.stop.is_none() {
        // the way down has passed the whole band
        solutions.clear();
    }
    solutions.extend(downward.solutions.into_iter().rev());
    Response {
        solutions,
        is_curve: true,
        gap: downward.stop.map(|above| Gap { below, above }),
    }
}

impl Response {
    /// The largest amplitude of response 0 in `band`, and what it is.
    #[must_use]
    pub fn largest(&self, band: Band) -> Option<(&Solution, Largest)> {
        let solved: Vec<&Solution> = (self.solutions.iter())
            .filter(|solution| solution.status.has_solution())
            .collect();
        let amplitude = |i: usize| solved.get(i).map(|solution| solution.amplitude(0));
        // a curve may overhang the band; values lie where they were asked for
        let counts = |i: &usize| !self.is_curve || band.contains(solved[*i].omega);
        let highest = (0..solved.len())
            .filter(counts)
            .filter_map(|i| Some((i, amplitude(i)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let (i, top) = highest?;
        let below = |j: Option<usize>| j.and_then(amplitude).is_some_and(|a| a <= top);
        let is_inside = below(i.checked_sub(1)) && below(Some(i + 1));
        let is_part = match self.is_curve {
            true => self.gap.is_some(),
            false => solved.len() < self.solutions.len(),
        };
        let what = match (is_part, is_inside) {
            (true, _) => Largest::OfPart,
            (false, false) => Largest::AtEdge,
            (false, true) if self.is_curve => Largest::Maximum,
            (false, true) => Largest::OfValues,
        };
        Some((solved[i], what))
    }
}

/// A problem at one level on its way through the band.
pub(in crate::hb) struct Level<'a, 'p> {
    ladder: &'a Ladder<'p>,
    pub(in crate::hb) settings: &'a HbSettings,
    pub(in crate::hb) sets: Option<AlertSets<'a, 'p>>,
    level: f64,
    pub(in crate::hb) meter: Meter<'p>,
}

/// The solutions of one way through the band, in the order of the way.
struct Part {
    solutions: Vec<Solution>,
    /// Where it ended, unless at the other end of the band or where it met the other part.
    stop: Option<Stop>,
    met: bool,
    /// The last solution.
    last: Option<Point>,
}

impl<'a, 'p> Level<'a, 'p> {
    pub(in crate::hb) fn new(
        problem: &'p Problem<'p>,
        ladder: &'a Ladder<'p>,
        settings: &'a HbSettings,
        level: f64,
    ) -> Self {
        Self {
            ladder,
            settings,
            sets: AlertSets::new(problem, &settings.harmonics, settings),
            level,
            meter: Meter::new(&problem.effort),
        }
    }

    pub(in crate::hb) fn balance(&self) -> &'a Balance<'p> {
        self.ladder.full()
    }

    /// A search on a budget of its own: what it takes does not depend on what was searched before, nor on what is listed.
    pub(in crate::hb) fn apart<T>(&self, search: impl FnOnce() -> T) -> T {
        let effort = &self.balance().problem.effort;
        effort.apart(self.settings.newton.budget, search)
    }

    /// A frequency without solution.
    pub(in crate::hb) fn unsolved(&self, omega: f64, status: Status) -> Solution {
        let stuck = stuck_point(self.balance(), omega, self.level);
        let iterate = Iterate::new(self.balance(), stuck);
        Solution::new(self.balance(), &iterate, status)
    }

    /// The solution at the end of `band` where a way in `direction` begins.
    pub(in crate::hb) fn first(
        &self,
        band: Band,
        direction: SweepDirection,
    ) -> Result<Iterate<'p>, Stop> {
        let [omega, _] = direction.ends(band);
        let newton = self.settings.newton;
        self.balance().problem.effort.grant(newton.budget);
        first_solution(self.ladder.rungs(), newton, self.level, (omega, direction))
            .map(|first| polish(self.balance(), first))
            .map_err(|status| Stop { omega, status })
    }

    /// The solution with its truncation error.
    fn judged(&self, iterate: &Iterate<'_>, solution: Solution) -> Solution {
        let Some(sets) = &self.sets else {
            return solution;
        };
        if iterate.contact.active.is_empty() {
            // a linear structure answers one harmonic with one
            return sets.with_error(solution, 0.0);
        }
        let fixed = Condition::FixedFrequency;
        let by_step = sets.estimate_by_step(0, iterate, fixed);
        let estimate = sets.estimate_by_solve(0, iterate, by_step, fixed);
        sets.with_error(solution, estimate.error)
    }

    /// One way through the band, to its far end or to where it meets `other`.
    fn part(
        &self,
        curve: CurveSettings,
        direction: SweepDirection,
        other: Option<&Point>,
        progress: &impl Fn(f64),
    ) -> Part {
        let balance = self.balance();
        let first = match self.first(curve.band, direction) {
            Ok(first) => (first, self.meter.read()),
            Err(stop) => {
                return Part {
                    solutions: vec![self.unsolved(stop.omega, stop.status)],
                    stop: Some(stop),
                    met: false,
                    last: None,
                };
            }
        };
        let route = Route {
            band: curve.band,
            direction,
            largest_step: curve.step,
            largest_advance: CURVE_ADVANCE,
        };
        let newton = self.settings.newton;
        let (mut stations, end) =
            Stations::walked(balance, first, route, newton, (other, progress));
        self.apart(|| stations.refine());
        let solved = |(point, count): &(BranchPoint<'_>, WorkCount)| {
            let solution = Solution {
                work_count: *count,
                ..Solution::new(balance, &point.iterate, Status::Converged)
            };
            self.apart(|| self.judged(&point.iterate, solution))
        };
        let mut solutions: Vec<Solution> =
            stations.points.first().map(solved).into_iter().collect();
        for ((stretch, failure), to) in stations.stretches().zip(&stations.points[1..]) {
            solutions.extend(failure.map(|status| {
                let ends = [stretch.from, stretch.to].map(|p| p.iterate.point.omega);
                self.unsolved(0.5 * (ends[0] + ends[1]), status)
            }));
            solutions.extend(self.apart(|| self.maximum(&stretch, curve.band)));
            solutions.push(solved(to));
        }
        let last = stations.points.pop().map(|(point, _)| point.iterate);
        let stop = (last.as_ref())
            .filter(|_| end.status != Status::Converged)
            .map(|last| Stop {
                omega: last.point.omega,
                status: end.status,
            });
        if let (Some(last), true) = (&last, stop.is_some()) {
            solutions.push(Solution {
                work_count: end.count,
                ..Solution::new(balance, last, end.status)
            });
        }
        Part {
            solutions,
            stop,
            met: end.met,
            last: last.map(|last| last.point),
        }
    }

    /// The maximum of the amplitude on a step of the curve, if there is one and it can be located.
    fn maximum(&self, stretch: &Stretch<'_, 'p>, band: Band) -> Option<Solution> {
        let search = PeakSettings {
            band,
            frequency_tolerance: PEAK_TOLERANCE,
        };
        let (balance, newton) = (self.balance(), self.settings.newton);
        let meter = Meter::new(&balance.problem.effort);
        let found = maximum_on(stretch, balance, search, newton)?;
        let solution = Solution {
            work_count: meter.read(),
            ..found.solution(balance)
        };
        Some(self.judged(&found.iterate, solution))
    }
}
