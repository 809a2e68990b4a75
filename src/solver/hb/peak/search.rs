//! The resonance peak: a maximum of the amplitude along the solution branch, found directly.
//!
//! Close to a resonance ln|ŷ| is nearly a parabola in arclength. Its curvature is −(d arg ŷ/ds)², as for one oscillator. The
//! curvature gives the first step, secants give the next ones, and the search ends when a bracket is narrow enough. Steps are
//! along the branch, not along the frequency axis, so that overhanging peaks are no difficulty.

use super::corner::maximum_between;
use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Iterate, Point};
use crate::hb::settings::NewtonSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Band;

/// How exactly, and where, a peak is located.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakSettings {
    /// Where the peak must lie.
    pub band: Band,
    /// The search ends if the relative change of frequency between the last two points is not above this.
    pub frequency_tolerance: f64,
}

/// Result of a search: a peak, or a solution at a frequency, whose sharpness is unknown.
#[derive(Debug)]
pub struct Located<'p> {
    /// The solution there.
    pub iterate: Iterate<'p>,
    /// −d² ln|ŷ|/dφ² by the phase φ of ŷ along the branch, where the search measured it: 1 for one oscillator.
    pub sharpness: Option<f64>,
}

impl Located<'_> {
    /// Everything reported of it.
    #[must_use]
    pub fn solution(&self, balance: &Balance<'_>) -> Solution {
        Solution {
            sharpness: self.sharpness,
            ..Solution::new(balance, &self.iterate, Status::Converged)
        }
    }

    /// Whether it is flat, or its sharpness unknown: then a higher maximum may lie beside it.
    pub(super) fn is_flat(&self) -> bool {
        self.sharpness.is_none_or(|sharpness| sharpness < FLAT)
    }
}

impl<'p> From<Iterate<'p>> for Located<'p> {
    /// A solution of unknown sharpness.
    fn from(iterate: Iterate<'p>) -> Self {
        Self {
            iterate,
            sharpness: None,
        }
    }
}

/// Shortest first step (relative change of the displacements). Round-off would spoil the curvature over a shorter one.
const SHORTEST_STEP: f64 = 1e-3;
/// Longest step: the curvature estimate holds only in a neighbourhood.
const LONGEST_STEP: f64 = 0.3;
/// Residual over the dynamic displacement, per relative frequency tolerance.
const GROWTH_SHARE: f64 = 1e-2;
/// Residuals below this are round-off.
const SHARPEST: f64 = 1e-13;
/// Steps up to this length (relative change of the displacements) are round-off: the solution from which one would begin is the maximum.
/// Where residuals must be close to round-off, Newton's method may fail on steps of some 1e-12.
const NEGLIGIBLE: f64 = 1e-10;
/// Most points of one search.
const MAX_POINTS: usize = 40;
/// Points around a maximum after which it is taken for a corner of the branch.
const MAX_SECANTS: usize = 12;
/// Distances at which [`highest_nearby`] starts its searches (relative change of the displacements).
const NEARBY: [f64; 4] = [-3e-3, -1.5e-3, 1.5e-3, 3e-3];
/// Distances at which searches on both sides of a maximum start, on each side.
pub(super) const BOTH_SIDES: [f64; 3] = [0.05, 0.1, 0.2];
/// Rates at which the growth of the amplitude falls around a maximum are those of one parabola up to this ratio.
const EVEN: f64 = 1.25;
/// Signs of the directions along the branch.
const SIDES: [f64; 2] = [-1.0, 1.0];
/// Below this sharpness the amplitude changes so little around a maximum that a second one may lie beside it.
const FLAT: f64 = 0.5;
/// Relative difference of height from which two maxima are two; searches of one maximum differ by less.
pub(super) const HIGHER: f64 = 1e-9;
/// Most halvings of one step.
const MAX_HALVINGS: usize = 8;

/// A point at arclength `s` from the start of the search.
struct ArcPoint<'p> {
    s: f64,
    point: BranchPoint<'p>,
}

/// Finds the maximum of |ŷ| next to `start`.
///
/// # Errors
/// [`Status::NoPeakInBand`] if the search leaves the band, else the status of the solve that failed.
pub fn find_peak<'p>(
    balance: &Balance<'p>,
    start: Iterate<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let exact = NewtonSettings {
        tolerance: newton
            .tolerance
            .min(sharp_enough(balance, &start.point, settings)),
        ..newton
    };
    let first = along_branch(balance, start, settings);
    let metric = first.metric;
    let mut step = first.growth() / first.phase_rate().powi(2);
    step = step
        .abs()
        .clamp(SHORTEST_STEP, LONGEST_STEP)
        .copysign(first.growth());
    let mut bracket = Bracket::new(ArcPoint {
        s: 0.0,
        point: first,
    });
    for _ in 0..MAX_POINTS {
        let from = bracket.nearest(step);
        if bracket.is_maximum() && (step - from.s).abs() <= NEGLIGIBLE {
            return Ok(bracket.ended());
        }
        let (iterate, length) = match halving_step(balance, &from.point, step - from.s, exact) {
            Err(_) if bracket.holds_maximum() => break,
            stepped => stepped?,
        };
        let point = BranchPoint::in_metric(balance, iterate, metric).following(&from.point.tangent);
        let omega = point.iterate.point.omega;
        if !settings.band.contains(omega) {
            return Err(Status::NoPeakInBand);
        }
        let s = from.s + length;
        let moved = (omega - from.point.iterate.point.omega).abs() / omega;
        bracket.add(ArcPoint { s, point });
        // the last point must be a solution: at a kink a small predicted step does not mean that the maximum is close
        let tolerance = settings.frequency_tolerance;
        if bracket.is_maximum() && (moved <= tolerance || bracket.bracket_width() <= tolerance) {
            return Ok(bracket.ended());
        }
        if bracket.secants >= MAX_SECANTS {
            break;
        }
        step = bracket.next();
    }
    match bracket.ends() {
        Some(ends) => {
            let tolerance = settings.frequency_tolerance;
            Ok(maximum_between(balance, ends, tolerance, [exact, newton])?.into())
        }
        None => Err(Status::MaxIterations),
    }
}

/// Amplitude that a maximum on a segment of the branch has at least (m), if there surely is one: the amplitude grows at its start and
/// falls at its end, and both are in the band.
pub(crate) fn least_maximum_on(segment: &BranchSegment<'_, '_>, band: Band) -> Option<f64> {
    let (from, to) = (segment.from, segment.to);
    let turns = from.growth() > 0.0 && to.growth() <= 0.0;
    let is_inside = [from, to].map(|end| band.contains(end.iterate.point.omega));
    (turns && is_inside == [true; 2]).then(|| f64::max(from.response.norm(), to.response.norm()))
}

/// The maximum of the amplitude on a segment of the branch, if there is one and it can be located.
pub(crate) fn maximum_on<'p>(
    segment: &BranchSegment<'_, 'p>,
    balance: &Balance<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Option<Located<'p>> {
    let (from, to) = (segment.from, segment.to);
    let falls = from.response.norm() > to.response.norm();
    // it rises from the lower end, but past a minimum; or it falls to the lower end, but past a maximum
    if (from.growth() <= 0.0 && falls) || (to.growth() > 0.0 && !falls) {
        return None;
    }
    let higher = match falls {
        true => from,
        false => to,
    };
    let start = Iterate::new(balance, higher.iterate.point.clone());
    let found = find_peak(balance, start, settings, newton).ok()?;
    let top = found.iterate.response(balance).norm();
    let is_on_it = segment.passes(&found.iterate.point)
        && top >= f64::max(from.response.norm(), to.response.norm());
    is_on_it.then_some(found)
}

/// The highest maximum in the neighbourhood of the maximum `found`.
///
/// If changes of the contact states are placed at time points the amplitude is ragged: there are maxima side by side, and
/// each is an exact maximum of the discretised equations. Searches from both sides look for a higher one.
pub(crate) fn highest_nearby<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Located<'p> {
    let first = along_branch(balance, found.iterate, settings);
    let others = NEARBY.iter().filter_map(|&step| {
        let start = first.step(balance, step, newton).ok()?;
        find_peak(balance, start, settings, newton).ok()
    });
    let others: Vec<Located<'p>> = others.collect();
    let found = Located {
        iterate: first.iterate,
        ..found
    };
    (others.into_iter()).fold(found, |best, other| higher(balance, best, other))
}

/// A maximum next to the maximum `found` whose amplitude is more than `least` times that of `found`, the higher one of both sides. A start
/// close to `found` may lead back to it; then one farther away is taken, `n_starts` at most. Where the amplitude is one parabola there is
/// no other maximum, and nothing is searched.
pub(crate) fn higher_on_both_sides<'p>(
    balance: &Balance<'p>,
    found: &Iterate<'p>,
    least: f64,
    n_starts: usize,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Option<Located<'p>> {
    let first = branch_through(balance, &found.point, settings);
    let sides: Vec<Vec<ArcPoint<'p>>> = beside(balance, &first, &BOTH_SIDES, newton)
        .map(|starts| {
            let on_branch = |(s, start)| {
                let point = BranchPoint::in_metric(balance, start, first.metric);
                let point = point.following(&first.tangent);
                ArcPoint { s, point }
            };
            starts.take(n_starts).map(on_branch).collect()
        })
        .collect();
    if sides.iter().all(|points| points.len() == n_starts)
        && is_one_parabola(sides.iter().flatten())
    {
        return None;
    }
    let height = |iterate: &Iterate<'p>| iterate.response(balance).norm();
    let own = height(&first.iterate);
    let maxima = sides.into_iter().filter_map(|starts| {
        let mut maxima = (starts.into_iter())
            .filter_map(|start| find_peak(balance, start.point.iterate, settings, newton).ok());
        maxima.find(|maximum| height(&maximum.iterate) > least * own)
    });
    maxima.reduce(|best, other| higher(balance, best, other))
}

/// Whether the growth of the amplitude falls at one rate from all `points` on both sides of a maximum at arclength 0.
fn is_one_parabola<'a, 'p: 'a>(points: impl Iterator<Item = &'a ArcPoint<'p>>) -> bool {
    let falls = points.map(|at| -at.point.growth() / at.s);
    let (least, largest) = falls.fold((f64::INFINITY, 0.0), |(least, largest), fall| {
        (fall.min(least), fall.max(largest))
    });
    least > 0.0 && largest <= EVEN * least
}

/// On each side of the point `first`, the solutions at these `distances` that can be found, the closest one first, with their arclengths
/// from `first`.
pub(super) fn beside<'a, 'p>(
    balance: &'a Balance<'p>,
    first: &'a BranchPoint<'p>,
    distances: &'a [f64],
    newton: NewtonSettings,
) -> impl Iterator<Item = impl Iterator<Item = (f64, Iterate<'p>)>> {
    SIDES.into_iter().map(move |side| {
        let steps = distances.iter().map(move |step| side * step);
        steps.filter_map(move |step| Some((step, first.step(balance, step, newton).ok()?)))
    })
}

/// The highest maximum next to the maximum `found`, if that one is flat or its sharpness unknown. It is searched from the nearest starts
/// alone, since each maximum on each set of harmonics is searched so; farther ones are on the branch that is followed at the end.
///
/// Where a contact begins or ends to slip or to lift off in a period, the slope of the amplitude may jump. At a flat maximum a small
/// jump is enough for two maxima side by side, and which of them a search meets depends on its start.
pub(crate) fn highest_beside<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Located<'p> {
    if !found.is_flat() {
        return found;
    }
    let least = 1.0 + HIGHER;
    let higher = higher_on_both_sides(balance, &found.iterate, least, 1, settings, newton);
    higher.unwrap_or(found)
}

/// The solution at `point` on its branch, in the metric of searches.
pub(super) fn branch_through<'p>(
    balance: &Balance<'p>,
    point: &Point,
    settings: PeakSettings,
) -> BranchPoint<'p> {
    along_branch(balance, Iterate::new(balance, point.clone()), settings)
}

fn along_branch<'p>(
    balance: &Balance<'p>,
    iterate: Iterate<'p>,
    settings: PeakSettings,
) -> BranchPoint<'p> {
    let omega_scale = 2.0 * settings.band.width();
    BranchPoint::new(balance, iterate, omega_scale)
}

/// The higher of two maxima, the first of equals.
pub(super) fn higher<'p>(
    balance: &Balance<'_>,
    first: Located<'p>,
    second: Located<'p>,
) -> Located<'p> {
    let height = |peak: &Located<'_>| peak.iterate.response(balance).norm();
    match height(&second) > height(&first) {
        true => second,
        false => first,
    }
}

/// Residual that makes the growth of the amplitude exact enough for the frequency tolerance. A small residual is needed for
/// two reasons: a small error moves a flat peak far, and a small excitation moves the contacts little compared with the scale
/// of the residual.
pub(in crate::hb) fn sharp_enough(
    balance: &Balance<'_>,
    start: &Point,
    settings: PeakSettings,
) -> f64 {
    let share = GROWTH_SHARE * settings.frequency_tolerance * start.dynamic_share(balance);
    share.max(SHARPEST)
}

/// One step, halved while the solve fails.
fn halving_step<'p>(
    balance: &Balance<'p>,
    from: &BranchPoint<'p>,
    mut length: f64,
    newton: NewtonSettings,
) -> Result<(Iterate<'p>, f64), Status> {
    let mut last = Status::StepTooSmall;
    for _ in 0..MAX_HALVINGS {
        match from.step(balance, length, newton) {
            Ok(iterate) => return Ok((iterate, length)),
            Err(status) => {
                last = status;
                length *= 0.5;
            }
        }
    }
    Err(last)
}

/// The last two points, or the two that bracket the maximum.
struct Bracket<'p> {
    older: Option<ArcPoint<'p>>,
    newer: ArcPoint<'p>,
    /// Factor on the growth of the older end. It is halved each time that this end stays in the bracket (Illinois rule).
    weight: f64,
    /// Points since both ends are around a maximum.
    secants: usize,
}

impl<'p> Bracket<'p> {
    fn new(first: ArcPoint<'p>) -> Self {
        Self {
            older: None,
            newer: first,
            weight: 1.0,
            secants: 0,
        }
    }

    fn bracketed(&self) -> bool {
        (self.older.as_ref()).is_some_and(|o| o.point.growth() * self.newer.point.growth() <= 0.0)
    }

    /// Whether the growth falls along the branch, so that its zero is a maximum.
    fn is_maximum(&self) -> bool {
        self.older.as_ref().is_some_and(|older| {
            (self.newer.point.growth() - older.point.growth()) * (self.newer.s - older.s) < 0.0
        })
    }

    /// Whether a maximum lies between the two points.
    fn holds_maximum(&self) -> bool {
        self.bracketed() && self.is_maximum()
    }

    /// The two points around a maximum, in the order of the arclength.
    fn ends(self) -> Option<[BranchPoint<'p>; 2]> {
        if !self.holds_maximum() {
            return None;
        }
        let (newer, older) = (self.newer, self.older?);
        Some(match older.s < newer.s {
            true => [older.point, newer.point],
            false => [newer.point, older.point],
        })
    }

    /// Relative frequency distance of the bracket's ends.
    fn bracket_width(&self) -> f64 {
        match &self.older {
            Some(older) if self.bracketed() => {
                let (a, b) = (
                    older.point.iterate.point.omega,
                    self.newer.point.iterate.point.omega,
                );
                (a - b).abs() / b
            }
            _ => f64::INFINITY,
        }
    }

    fn nearest(&self, s: f64) -> &ArcPoint<'p> {
        match &self.older {
            Some(older) if (older.s - s).abs() < (self.newer.s - s).abs() => older,
            _ => &self.newer,
        }
    }

    fn add(&mut self, added: ArcPoint<'p>) {
        let same_side = added.point.growth() * self.newer.point.growth() > 0.0;
        if self.bracketed() && same_side {
            self.weight *= 0.5;
            self.newer = added;
        } else {
            self.weight = 1.0;
            self.older = Some(std::mem::replace(&mut self.newer, added));
        }
        self.secants += usize::from(self.holds_maximum());
    }

    /// Arclength at which the growth vanishes by the secant. If the secant has no maximum: a limited step towards larger
    /// amplitudes.
    fn next(&self) -> f64 {
        let Some(older) = &self.older else {
            return self.newer.s;
        };
        let (g_old, g_new) = (older.point.growth(), self.newer.point.growth());
        let span = self.newer.s - older.s;
        if self.bracketed() {
            return self.newer.s - g_new * span / (g_new - self.weight * g_old);
        }
        let limit = (3.0 * span.abs()).min(LONGEST_STEP);
        let secant = g_new * span / (g_new - g_old);
        let step = if self.is_maximum() {
            secant.abs().min(limit)
        } else {
            limit
        };
        self.newer.s + step.copysign(g_new)
    }

    /// The higher of the two, with the sharpness between them.
    fn ended(self) -> Located<'p> {
        let newer = self.newer.point;
        let Some(ArcPoint { s, point: older }) = self.older else {
            return newer.iterate.into();
        };
        let fall = (older.growth() - newer.growth()) / (self.newer.s - s);
        let sharpness = Some(fall / newer.phase_rate().powi(2));
        let best = match older.response.norm() > newer.response.norm() {
            true => older,
            false => newer,
        };
        Located {
            iterate: best.iterate,
            sharpness,
        }
    }
}
