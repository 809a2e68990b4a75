//! The highest maximum in a band, if no track leads to it: next to the resonances of the structure that slides without
//! friction, or on the branch through the whole band.

use super::search::{Located, PeakSettings, find_peak, higher, least_maximum_on, maximum_on};
use crate::hb::branch::branch_point::distance;
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::branch::continuation::ContinuationEnd;
use crate::hb::branch::sweep::{SweepDirection, SweepSettings};
use crate::hb::branch::sweep_start::Sweep;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::rest::Rest;
use crate::hb::newton::{Condition, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::status::Status;
use crate::hb::structure::resonance::linear_resonances;
use std::ops::ControlFlow;

/// Largest relative change of the displacements per step of a sweep.
pub(super) const SWEEP_STEP: f64 = 0.3;
/// The same of the second sweeps, where the first ones have failed: long steps may leave the branch.
const SHORT_STEP: f64 = 0.1;
/// Largest change of the frequency per step, as a share of the band.
const SWEEP_ADVANCE: f64 = 0.025;
/// Relative distance in frequency up to which solutions of two sweeps are one; that of the displacements is the root of it.
const SAME: f64 = 1e-6;

/// The highest maximum at `level` next to the resonances of the structure that slides without friction about its `rest`:
/// friction far below the level hardly moves it. Maxima below `least` per unit level (m) do not count.
///
/// # Errors
/// [`Status::NoPeakInBand`] where there is none, [`Status::NonFinite`] where the resonances cannot be found.
pub(super) fn sliding_maximum<'p>(
    balance: &Balance<'p>,
    rest: &Rest,
    least: f64,
    level: f64,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let stiffness = rest.sliding_stiffness();
    let resonances = linear_resonances(balance.problem.model, &stiffness, peak.band, least);
    let resonances = resonances.map_err(|_| Status::NonFinite)?;
    let maxima = resonances.into_iter().filter_map(|resonance| {
        let start = rest.sliding(balance, resonance.omega, level);
        let start = solve(balance, start, Condition::FixedFrequency, newton).ok()?;
        find_peak(balance, start, peak, newton).ok()
    });
    maxima
        .reduce(|best, other| higher(balance, best, other))
        .filter(|best| best.iterate.response(balance).norm() > least * level)
        .ok_or(Status::NoPeakInBand)
}

/// The highest maximum at `level` on the branch through the whole band, upwards or else downwards, on the harmonics of the
/// last of `rungs`; with short steps if that fails with long ones.
///
/// # Errors
/// [`Status::NoPeakInBand`] if the branch has none; [`Status::MaxIterations`] if a maximum that may be the highest could not be located; else
/// the status of the sweep that failed: a sweep that stopped inside the band says nothing about the rest of the band.
pub(super) fn swept_maximum<'p>(
    rungs: &[Balance<'p>],
    level: f64,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let swept = |step| {
        BandSweep {
            rungs,
            level,
            peak,
            newton,
            step,
        }
        .maximum()
    };
    match swept(SWEEP_STEP) {
        Err(status) if !matches!(status, Status::NoPeakInBand | Status::BudgetSpent) => {
            swept(SHORT_STEP)
        }
        ended => ended,
    }
}

/// The highest maximum on each sweep through the band at `level`, with short steps, too, if those with long ones do not cover it. What is met counts
/// also where a sweep stops inside the band.
pub(super) fn maxima_of_sweeps<'p>(
    balance: &Balance<'p>,
    level: f64,
    peak: PeakSettings,
    newton: NewtonSettings,
) -> Vec<Located<'p>> {
    let mut met = Vec::new();
    for step in [SWEEP_STEP, SHORT_STEP] {
        let rungs = std::slice::from_ref(balance);
        let (sweeps, status) = BandSweep {
            rungs,
            level,
            peak,
            newton,
            step,
        }
        .sweeps();
        met.extend(sweeps.into_iter().filter_map(|swept| swept.highest));
        if matches!(status, Status::Converged | Status::BudgetSpent) {
            break;
        }
    }
    met
}

/// Sweeps through a band at one level.
struct BandSweep<'a, 'p> {
    /// The same problem on ever more harmonics; the sweeps follow the branch on those of the last.
    rungs: &'a [Balance<'p>],
    level: f64,
    peak: PeakSettings,
    newton: NewtonSettings,
    /// Largest relative change of the displacements per step.
    step: f64,
}

impl<'p> BandSweep<'_, 'p> {
    fn balance(&self) -> &Balance<'p> {
        &self.rungs[self.rungs.len() - 1]
    }

    /// The highest maximum that the upward sweep passes, or else the downward one; of both where they cover the band together. Where a sweep
    /// passes a maximum that may be higher, but could not be located, the highest maximum is not known.
    ///
    /// # Errors
    /// As of [`swept_maximum`].
    fn maximum(&self) -> Result<Located<'p>, Status> {
        let (mut sweeps, status) = self.sweeps();
        if status != Status::Converged {
            return Err(status);
        }
        if let Some(whole) = sweeps.iter().position(Swept::is_whole) {
            sweeps = vec![sweeps.swap_remove(whole)];
        }
        let lost = sweeps.iter().map(|swept| swept.lost).fold(0.0, f64::max);
        let met = sweeps.into_iter().filter_map(|swept| swept.highest);
        match met.reduce(|best, other| higher(self.balance(), best, other)) {
            Some(highest) if highest.iterate.response(self.balance()).norm() >= lost => Ok(highest),
            None if lost == 0.0 => Err(Status::NoPeakInBand),
            _ => Err(Status::MaxIterations),
        }
    }

    /// The upward sweep and, unless it passes the whole band, the downward one; [`Status::Converged`] if they cover the band, else the status of
    /// the last. Two sweeps that stop within the band cover all of it together if one of them stops at a solution that the other has reached.
    fn sweeps(&self) -> (Vec<Swept<'p>>, Status) {
        let upward = self.swept(SweepDirection::Upward);
        if upward.as_ref().is_ok_and(Swept::is_whole) {
            return (upward.into_iter().collect(), Status::Converged);
        }
        let downward = self.swept(SweepDirection::Downward);
        let status = match (&upward, &downward) {
            (_, Err(status)) => *status,
            (_, Ok(downward)) if downward.is_whole() => Status::Converged,
            (Ok(upward), Ok(downward)) if upward.joins(downward, self.balance(), self.newton) => {
                Status::Converged
            }
            (_, Ok(downward)) => downward.end.status,
        };
        (upward.into_iter().chain(downward).collect(), status)
    }

    /// One sweep.
    ///
    /// # Errors
    /// The status of the search for its first solution.
    fn swept(&self, direction: SweepDirection) -> Result<Swept<'p>, Status> {
        let (balance, newton, peak) = (self.balance(), self.newton, self.peak);
        let sweep = Sweep {
            rungs: self.rungs,
            newton,
            level: self.level,
            settings: SweepSettings {
                band: peak.band,
                direction,
                largest_step: self.step,
                largest_advance: SWEEP_ADVANCE,
            },
        };
        let first = sweep.first()?;
        let mut passed = vec![first.point.clone()];
        let (mut maxima, mut lost) = (Vec::new(), 0.0_f64);
        let end = sweep.followed(first, |from, to| {
            passed.push(to.iterate.point.clone());
            let segment = BranchSegment::new(&from, to);
            match maximum_on(&segment, balance, peak, newton) {
                Some(found) => maxima.push(found),
                None => lost = lost.max(least_maximum_on(&segment, peak.band).unwrap_or(0.0)),
            }
            ControlFlow::Continue(())
        });
        let maxima = maxima.into_iter();
        Ok(Swept {
            highest: maxima.reduce(|best, other| higher(balance, best, other)),
            lost,
            passed,
            end,
        })
    }
}

/// What a sweep through the band has passed.
struct Swept<'p> {
    highest: Option<Located<'p>>,
    /// Amplitude that the highest of the maxima that could not be located has at least (m); 0 without such.
    lost: f64,
    /// The solutions at the ends of its steps, one after the other.
    passed: Vec<Point>,
    end: ContinuationEnd<'p>,
}

impl<'p> Swept<'p> {
    /// Whether it has passed the whole band.
    fn is_whole(&self) -> bool {
        self.end.status == Status::Converged
    }

    /// Whether one of two sweeps from both ends of the band stopped at a solution of the other. A branch does not divide, so
    /// that they are on one branch then, and have passed all of it between the ends of the band.
    fn joins(&self, other: &Self, balance: &Balance<'p>, newton: NewtonSettings) -> bool {
        let [one, two] = [self, other].map(|swept| &swept.end.last.iterate.point);
        is_same(balance, one, two)
            || self.has_passed(two, balance, newton)
            || other.has_passed(one, balance, newton)
    }

    /// Whether this sweep has passed `solution`: between two of its points around the frequency of `solution` Newton's method
    /// leads there.
    fn has_passed(&self, solution: &Point, balance: &Balance<'p>, newton: NewtonSettings) -> bool {
        let steps = self.passed.windows(2);
        let mut between = steps.filter_map(|step| interpolated(step, solution.omega));
        between.any(|start| {
            let solved = solve(balance, start, Condition::FixedFrequency, newton);
            solved.is_ok_and(|found| is_same(balance, &found.point, solution))
        })
    }
}

/// The point at the frequency `omega` (rad/s) on the straight line of a step, if the step passes it.
fn interpolated(step: &[Point], omega: f64) -> Option<Point> {
    let [from, to] = step else { return None };
    let share = (omega - from.omega) / (to.omega - from.omega);
    (0.0..=1.0)
        .contains(&share)
        .then(|| from.at_frequency(to, omega))
}

/// Whether two solutions are one.
fn is_same(balance: &Balance<'_>, one: &Point, other: &Point) -> bool {
    let apart = (one.omega / other.omega - 1.0).abs();
    apart <= SAME && distance(balance, one, other) <= SAME.sqrt()
}
