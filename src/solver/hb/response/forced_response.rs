//! Forced response at one level: at given frequencies, or as a continuous curve over a band.
//!
//! Both follow the branch from one end of the band (see [`crate::hb::branch::sweep`]). If the branch cannot be followed to the
//! other end, the rest of the band is swept from there. The part that neither sweep reaches is the gap.

pub use super::gap::{Gap, Stop};
use super::level_problem::LevelProblem;
pub use super::polyline::PLOT_ERROR;
use super::polyline::Polyline;
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::sweep::{SweepDirection, SweepSettings};
use crate::hb::equations::effort::{Counted, Meter, WorkCount};
use crate::hb::equations::problem::Problem;
use crate::hb::newton::ladder::Ladder;
use crate::hb::newton::{Condition, Iterate, Point};
use crate::hb::peak::search::{PeakSettings, maximum_on};
use crate::hb::settings::HbSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Band;

/// Largest relative change of the displacements between two solutions of a curve.
const PLOT_STEP: f64 = 0.15;
/// Largest change of the frequency between two solutions of a curve, over the band.
const CURVE_ADVANCE: f64 = 0.025;
/// Relative change of frequency at which a maximum of a curve counts as located.
const PEAK_TOLERANCE: f64 = 1e-9;

/// The response at one level.
#[derive(Debug, Clone)]
pub struct Response {
    /// Solutions; a frequency without solution has the status that says why.
    pub solutions: Vec<Solution>,
    /// Newton iterations and factorisations spent on each of them. Shape: `[solutions]`.
    pub work: Vec<WorkCount>,
    /// Whether they are a curve; else they are at prescribed frequencies.
    pub is_curve: bool,
    /// Present if the branch could not be followed from one end of the band to the other, or to the last frequency asked for.
    pub gap: Option<Gap>,
}

/// How a curve is computed.
#[derive(Debug, Clone, Copy)]
pub struct CurveSettings {
    /// Frequencies of the curve.
    pub band: Band,
    /// Largest relative change of the displacements between two solutions.
    pub step: f64,
}

impl CurveSettings {
    /// Steps for a plot with straight lines between the solutions.
    #[must_use]
    pub fn for_plot(band: Band) -> Self {
        Self {
            band,
            step: PLOT_STEP,
        }
    }
}

/// What kind of value the largest amplitude of a response is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Largest {
    /// A maximum: the amplitude is smaller on both sides.
    Maximum,
    /// The largest of the values asked for, between smaller ones.
    OfValues,
    /// Value at an end of the band, or at the first or last frequency asked for; beyond it the amplitude may be larger.
    AtEdge,
    /// Largest value of a response with frequencies without solution, where the amplitude may be larger.
    OfPart,
}

/// Solutions along the branch from the lower to the upper end of the band, with the maxima of the amplitude that
/// defines resonance among them; overhanging parts are included, also where they leave the band.
///
/// All solutions are on the harmonics of the settings; the truncation error is estimated, not reduced. If the branch cannot
/// be followed to its end, a point with the status that says why ends the first part. The second part, swept from the upper
/// end of the band, then begins with such a point. `progress` is given the share of the band that the running
/// sweep has passed; the second sweep begins at 0 again.
#[must_use]
pub fn over_band(
    problem: &Problem<'_>,
    settings: &HbSettings,
    level: f64,
    curve: CurveSettings,
    progress: impl Fn(f64),
) -> Response {
    let ladder = Ladder::new(problem, settings);
    let level = LevelProblem::new(problem, &ladder, settings, level);
    let upward = level.sweep(curve, SweepDirection::Upward, None, &progress);
    let mut solutions = upward.solutions;
    let Some(below) = upward.stop else {
        return Response::new(solutions, true, None);
    };
    let downward = level.sweep(
        curve,
        SweepDirection::Downward,
        upward.last.as_ref(),
        &progress,
    );
    if downward.met {
        // the point without a solution
        solutions.pop();
    } else if downward.stop.is_none() {
        // the downward sweep has passed the whole band
        solutions.clear();
    }
    solutions.extend(downward.solutions.into_iter().rev());
    let gap = downward.stop.map(|above| Gap { below, above });
    Response::new(solutions, true, gap)
}

impl Response {
    pub(super) fn new(solved: Vec<Counted<Solution>>, is_curve: bool, gap: Option<Gap>) -> Self {
        let solved = solved.into_iter();
        let (solutions, work) = solved.map(|point| (point.solution, point.work)).unzip();
        Self {
            solutions,
            work,
            is_curve,
            gap,
        }
    }

    /// The largest amplitude of the response that defines resonance in `band`, and what it is.
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
        // values that the opposite sweep answers leave nothing open
        let is_open = self.is_curve && self.gap.is_some();
        let is_part = is_open || solved.len() < self.solutions.len();
        let what = match (is_part, is_inside) {
            (true, _) => Largest::OfPart,
            (false, false) => Largest::AtEdge,
            (false, true) if self.is_curve => Largest::Maximum,
            (false, true) => Largest::OfValues,
        };
        Some((solved[i], what))
    }
}

/// The part of the band that one sweep has passed.
struct SweptPart {
    /// Solutions in the order of the sweep.
    solutions: Vec<Counted<Solution>>,
    /// Where the sweep ended, unless it reached the other end of the band or met the opposite sweep.
    stop: Option<Stop>,
    /// Whether it met the opposite sweep.
    met: bool,
    /// The last solution.
    last: Option<Point>,
}

impl<'p> LevelProblem<'_, 'p> {
    /// The solution with its truncation error.
    fn with_error(&self, iterate: &Iterate<'_>, solution: Solution) -> Solution {
        let Some(sets) = &self.sets else {
            return solution;
        };
        if iterate.contact.active.is_empty() {
            // a linear structure responds to one harmonic with the same harmonic alone
            return sets.with_error(solution, 0.0);
        }
        let fixed = Condition::FixedFrequency;
        let by_step = sets.estimate_by_step(0, iterate, fixed);
        let estimate = sets.estimate_by_solve(0, iterate, by_step, fixed);
        sets.with_error(solution, estimate.error)
    }

    /// One sweep through the band, to its far end or to the solution `other` of the opposite sweep.
    fn sweep(
        &self,
        curve: CurveSettings,
        direction: SweepDirection,
        other: Option<&Point>,
        progress: &impl Fn(f64),
    ) -> SweptPart {
        let sweep = SweepSettings {
            band: curve.band,
            direction,
            largest_step: curve.step,
            largest_advance: CURVE_ADVANCE,
        };
        let first = match self.first(sweep) {
            Ok(solution) => Counted {
                solution,
                work: self.meter.read(),
            },
            Err(stop) => {
                return SweptPart {
                    solutions: vec![self.unsolved(stop.omega, stop.status)],
                    stop: Some(stop),
                    met: false,
                    last: None,
                };
            }
        };
        let (balance, newton) = (self.balance(), self.settings.newton);
        let (mut polyline, end) = Polyline::swept(balance, first, sweep, newton, other, progress);
        self.with_own_budget(|| polyline.refine());
        let mut solutions = self.solutions(&polyline, curve.band);
        let last = polyline.points.pop().map(|point| point.solution.iterate);
        let stop = (last.as_ref())
            .filter(|_| end.status != Status::Converged)
            .map(|last| Stop {
                omega: last.point.omega,
                status: end.status,
            });
        if let (Some(last), true) = (&last, stop.is_some()) {
            solutions.push(Counted {
                solution: Solution::new(balance, last, end.status),
                work: end.work,
            });
        }
        SweptPart {
            solutions,
            stop,
            met: end.met,
            last: last.map(|last| last.point),
        }
    }

    /// The solutions of a sweep with their truncation errors, with the maxima between them, and with a status without solution
    /// on segments that could not be refined.
    fn solutions(&self, polyline: &Polyline<'_, 'p>, band: Band) -> Vec<Counted<Solution>> {
        let solved = |point: &Counted<BranchPoint<'_>>| {
            let iterate = &point.solution.iterate;
            let solution = Solution::new(self.balance(), iterate, Status::Converged);
            Counted {
                solution: self.with_own_budget(|| self.with_error(iterate, solution)),
                work: point.work,
            }
        };
        let mut solutions: Vec<Counted<Solution>> =
            polyline.points.first().map(solved).into_iter().collect();
        for ((segment, failure), to) in polyline.segments().zip(&polyline.points[1..]) {
            solutions.extend(failure.map(|status| {
                let ends = [segment.from, segment.to].map(|p| p.iterate.point.omega);
                self.unsolved(0.5 * (ends[0] + ends[1]), status)
            }));
            solutions.extend(self.with_own_budget(|| self.maximum(&segment, band)));
            solutions.push(solved(to));
        }
        solutions
    }

    /// The maximum of the amplitude on a segment of the curve, if there is one and it can be located.
    fn maximum(&self, segment: &BranchSegment<'_, 'p>, band: Band) -> Option<Counted<Solution>> {
        let search = PeakSettings {
            band,
            frequency_tolerance: PEAK_TOLERANCE,
        };
        let (balance, newton) = (self.balance(), self.settings.newton);
        let meter = Meter::new(&balance.problem.effort);
        let found = maximum_on(segment, balance, search, newton)?;
        let work = meter.read();
        let solution = self.with_error(&found.iterate, found.solution(balance));
        Some(Counted { solution, work })
    }
}
