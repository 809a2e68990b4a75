//! The resonance peak: a maximum of the amplitude along the solution branch, found directly.
//!
//! Close to a resonance ln|ŷ| is nearly a parabola in arclength whose curvature is −(d arg ŷ/ds)², as for one
//! oscillator; that gives the first step, secants the next ones, and a bracket makes an end of it. Walking along the
//! arc instead of the frequency axis keeps overhanging peaks harmless.

use crate::hb::branch::branch_point::BranchPoint;
use crate::hb::branch::branch_segment::BranchSegment;
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Iterate, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use crate::hb::structure::resonance::Band;

/// How exactly, and where, a peak is located.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakSettings {
    /// Where the peak must lie.
    pub band: Band,
    /// Relative change of frequency between the last two points at which the search ends.
    pub frequency_tolerance: f64,
}

/// What a search ends with: a peak, or a solution at a frequency, whose sharpness is unknown.
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

/// First steps shorter than this (relative change of the displacements) would measure curvature in round-off.
const SHORTEST_STEP: f64 = 1e-3;
/// Longer steps would leave the neighbourhood in which the curvature estimate holds.
const LONGEST_STEP: f64 = 0.3;
/// Residual over the dynamic displacement, per relative frequency tolerance.
const GROWTH_SHARE: f64 = 1e-2;
/// Residuals below this are round-off.
const SHARPEST: f64 = 1e-13;
/// Points visited before giving up.
const MAX_POINTS: usize = 40;
/// Where [`highest_nearby`] and [`highest_on_both_sides`] start their searches (relative change of the displacements).
const NEARBY: [f64; 4] = [-3e-3, -1.5e-3, 1.5e-3, 3e-3];
const ASIDE: [f64; 3] = [0.05, 0.1, 0.2];
/// Halvings of one step before giving up.
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
    let newton = NewtonSettings {
        tolerance: newton
            .tolerance
            .min(sharp_enough(balance, &start.point, settings)),
        ..newton
    };
    let omega_scale = 2.0 * settings.band.width();
    let first = BranchPoint::new(balance, start, omega_scale, None, None);
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
        let (iterate, length) = halving_step(balance, &from.point, step - from.s, newton)?;
        let point = BranchPoint::new(
            balance,
            iterate,
            omega_scale,
            Some(metric),
            Some(&from.point.tangent),
        );
        let omega = point.iterate.point.omega;
        if !settings.band.contains(omega) {
            return Err(Status::NoPeakInBand);
        }
        let s = from.s + length;
        let moved = (omega - from.point.iterate.point.omega).abs() / omega;
        bracket.add(ArcPoint { s, point });
        // the last point must have been solved where the secant wanted it: a kink makes a liar of a prediction
        let tolerance = settings.frequency_tolerance;
        if bracket.is_maximum() && (moved <= tolerance || bracket.bracket_width() <= tolerance) {
            return Ok(bracket.ended());
        }
        step = bracket.next();
    }
    if bracket.is_maximum() && bracket.bracket_width() <= 10.0 * settings.frequency_tolerance {
        return Ok(bracket.ended());
    }
    Err(Status::MaxIterations)
}

/// The maximum of the amplitude on a step along the branch, if there is one and it can be located.
pub fn maximum_on<'p>(
    segment: &BranchSegment<'_, 'p>,
    balance: &Balance<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Option<Located<'p>> {
    let (from, to) = (segment.from, segment.to);
    if from.growth() <= 0.0 || to.growth() > 0.0 {
        return None;
    }
    let higher = match from.response.norm() > to.response.norm() {
        true => from,
        false => to,
    };
    let start = Iterate::new(balance, higher.iterate.point.clone());
    let found = find_peak(balance, start, settings, newton).ok()?;
    let top = found.iterate.response(balance).norm();
    let is_on_it = segment.passes(balance, &found.iterate.point)
        && top >= f64::max(from.response.norm(), to.response.norm());
    is_on_it.then_some(found)
}

/// The highest maximum in the neighbourhood of the maximum `found`.
///
/// Where the changes of the contact states are decided at time points the amplitude is ragged: maxima stand side by
/// side, each an exact one of the discretised equations. Searches from both sides look for a higher one.
pub fn highest_nearby<'p>(
    balance: &Balance<'p>,
    found: Located<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Located<'p> {
    let first = along_branch(balance, found.iterate, settings);
    let others = NEARBY.iter().filter_map(|&step| {
        let aside = first.step(balance, step, newton).ok()?;
        find_peak(balance, aside, settings, newton).ok()
    });
    let others: Vec<Located<'p>> = others.collect();
    let found = Located {
        iterate: first.iterate,
        ..found
    };
    (others.into_iter()).fold(found, |best, other| higher(balance, best, other))
}

/// The highest maximum on `larger` harmonics next to the maximum `found` on those of `balance`, searched from both sides:
/// more harmonics may split a maximum, so that there is none where it was.
pub fn highest_on_both_sides<'p>(
    balance: &Balance<'p>,
    found: &Iterate<'p>,
    larger: &Balance<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Option<Located<'p>> {
    let found = Iterate::new(balance, found.point.clone());
    let first = along_branch(balance, found, settings);
    let search = |step: f64| {
        let aside = first.step(balance, step, newton).ok()?;
        let start = aside.point.padded(balance, larger);
        let start = solve(larger, start, Condition::FixedFrequency, newton).ok()?;
        find_peak(larger, start, settings, newton).ok()
    };
    let sides = [-1.0, 1.0].into_iter();
    let maxima = sides.filter_map(|side| ASIDE.iter().find_map(|step| search(side * step)));
    maxima.reduce(|best, other| higher(larger, best, other))
}

fn along_branch<'p>(
    balance: &Balance<'p>,
    iterate: Iterate<'p>,
    settings: PeakSettings,
) -> BranchPoint<'p> {
    let omega_scale = 2.0 * settings.band.width();
    BranchPoint::new(balance, iterate, omega_scale, None, None)
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

/// Residual that leaves the growth of the amplitude exact enough for the frequency asked for: a flat top moves far for
/// little, and a small excitation moves the contacts little compared with the scale of the residual.
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

/// The last two stations, or the two that bracket the maximum.
struct Bracket<'p> {
    older: Option<ArcPoint<'p>>,
    newer: ArcPoint<'p>,
    /// Factor on the growth of the older end: halved each time that end stays in the bracket (Illinois rule).
    weight: f64,
}

impl<'p> Bracket<'p> {
    fn new(first: ArcPoint<'p>) -> Self {
        Self {
            older: None,
            newer: first,
            weight: 1.0,
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
    }

    /// Where the growth vanishes by the secant; a limited step uphill where the secant has no maximum.
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
