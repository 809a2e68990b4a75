//! A resonance peak close to a predicted one: Newton's method for displacements and frequency together.
//!
//! Each iteration factorises the Jacobian J once. This gives the correction of r at a fixed frequency and the tangent dr/dω.
//! Both together give d ln ŷ/dω at the corrected point: the change of the phase φ by a frequency step, and the growth
//! g = d ln|ŷ|/dφ. Far from the branch the frequency is chosen so that ŷ has the predicted phase of the peak. Close to the
//! branch it is chosen so that the growth vanishes: δφ = g/s. The sharpness s = −dg/dφ is measured by secants. Before it can
//! be measured it is the predicted one, or 1 as for one oscillator. The growth is only as exact as the displacements: while
//! its error is larger than the growth itself, the frequency stays as it is.

use super::growth::{Growth, Limits, MAX_ITERATIONS, PeakSearch};
use super::search::{Located, PeakSettings, find_peak, sharp_enough};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Direction, Iterate, Point, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use faer::prelude::c64;

/// Where a peak is expected.
#[derive(Debug, Clone)]
pub struct PeakPrediction {
    /// Displacements and frequency.
    pub point: Point,
    /// Unit phasor of the response that defines resonance.
    pub phasor: c64,
    /// Sharpness of the peak (see [`Located`]).
    pub sharpness: Option<f64>,
}

impl PeakPrediction {
    /// A peak at `point` where the response that defines resonance is `response`.
    #[must_use]
    pub fn new(point: Point, response: c64, sharpness: Option<f64>) -> Self {
        Self {
            point,
            phasor: response / response.norm(),
            sharpness,
        }
    }

    /// The peak of a problem close to one whose peak is `solution`, on the same harmonics.
    #[must_use]
    pub fn of(solution: &Solution) -> Self {
        let response = solution.first_harmonic(0);
        Self::new(solution.point(), response, solution.sharpness)
    }

    /// The peak on the harmonics of `to`, if it is at `peak` on those of `from`.
    #[must_use]
    pub(crate) fn on_other_harmonics(
        from: &Balance<'_>,
        peak: &Located<'_>,
        to: &Balance<'_>,
    ) -> Self {
        let point = peak.iterate.point.padded(from, to);
        Self::new(point, peak.iterate.response(from), peak.sharpness)
    }
}

/// Step of the phase (rad) that measures the sharpness if all iterations were closer together.
pub(super) const MEASURING_STEP: f64 = 0.1;
/// Newton steps spent on this measurement.
pub(super) const CORRECTIONS: usize = 3;
/// Residual over the dynamic displacement at which damped steps have led close enough to a solution.
const ROUGH: f64 = 1e-3;

/// The maximum of |ŷ| next to `prediction`.
///
/// # Errors
/// [`Status::NoPeakInBand`] if the frequency leaves the band, [`Status::MaxIterations`] if the prediction was too far
/// away or no maximum is there, [`Status::NonFinite`].
pub fn correct<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let mut iterate = Iterate::new(balance, prediction.point);
    let limits = limits(balance, &iterate.point, settings, newton);
    let mut search = PeakSearch::new(limits, prediction.phasor, prediction.sharpness);
    let mut last = None;
    for _ in 0..MAX_ITERATIONS {
        let size = iterate.relative_residual(balance);
        if search.ends(size, iterate.contact.steady)? {
            return maximum(balance, iterate, &search, last.as_ref());
        }
        if balance.problem.effort.is_spent() {
            return Err(Status::BudgetSpent);
        }
        let local = LocalBranch::new(balance, &iterate, limits.growth_error(size));
        let step = search.step(size, local.at)?;
        let omega_step = step.length / local.at.phase_rate;
        let point = local.along(&local.corrected(&iterate.point), omega_step);
        if step.by_growth {
            last = Some(local);
        }
        if !settings.band.contains(point.omega) {
            return Err(Status::NoPeakInBand);
        }
        iterate = match omega_step == 0.0 {
            true => Iterate::with_compliance(balance, point, iterate.compliance),
            false => Iterate::new(balance, point),
        };
    }
    Err(Status::MaxIterations)
}

/// How exactly the peak close to `predicted` is searched.
pub(crate) fn limits(
    balance: &Balance<'_>,
    predicted: &Point,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Limits {
    let sharp = sharp_enough(balance, predicted, settings);
    Limits {
        tolerance: newton.tolerance.min(sharp),
        share: predicted.dynamic_share(balance).min(1.0),
        frequency: settings.frequency_tolerance,
    }
}

/// Newton step onto the branch and tangent of the branch, at one iterate.
struct LocalBranch {
    at: Growth,
    correction: Direction,
    tangent: Direction,
}

impl LocalBranch {
    fn new(balance: &Balance<'_>, iterate: &Iterate<'_>, error: f64) -> Self {
        let jacobian = iterate.jacobian(balance);
        balance.problem.effort.spend(jacobian.factorizations());
        let [correction, tangent] = iterate.correction_and_frequency_rate(balance, &jacobian);
        let correction = Direction {
            r: correction,
            omega: 0.0,
        };
        let tangent = Direction {
            r: tangent,
            omega: 1.0,
        };
        let rate = |d: &Direction| iterate.response_rate(balance, &jacobian, d, 0.0);
        let response = iterate.response(balance) + rate(&correction);
        Self {
            at: Growth::new(iterate.point.omega, response, rate(&tangent), error),
            correction,
            tangent,
        }
    }

    /// The point after the Newton step.
    fn corrected(&self, from: &Point) -> Point {
        from.moved(&self.correction, 1.0)
    }

    /// The point moved along the tangent.
    fn along(&self, from: &Point, omega_step: f64) -> Point {
        from.moved(&self.tangent, omega_step)
    }
}

/// The peak `iterate` at which `search` has ended, if it is a maximum; `last` is its last iteration that stepped by the growth.
fn maximum<'p>(
    balance: &Balance<'p>,
    iterate: Iterate<'p>,
    search: &PeakSearch,
    last: Option<&LocalBranch>,
) -> Result<Located<'p>, Status> {
    let falls = |here| falls_further_on(balance, &iterate, here);
    match search.has_measured_maximum() || last.is_some_and(falls) {
        true => Ok(Located {
            iterate,
            sharpness: search.sharpness(),
        }),
        false => Err(Status::MaxIterations),
    }
}

/// Whether the growth falls from `here`, the branch at the peak `at`, to a point a little further along the branch.
fn falls_further_on(balance: &Balance<'_>, at: &Iterate<'_>, here: &LocalBranch) -> bool {
    let mut point = here.along(&at.point, MEASURING_STEP / here.at.phase_rate.abs());
    for _ in 0..CORRECTIONS {
        let further = Iterate::new(balance, point);
        let there = LocalBranch::new(balance, &further, 0.0);
        if here.at.falls_to(&there.at) {
            return true;
        }
        point = there.corrected(&further.point);
    }
    false
}

/// The maximum next to a prediction that may be far away. Damped Newton steps lead to the solution with the predicted phase.
/// From there the maximum is found by [`correct`], or else by a search along the branch.
///
/// # Errors
/// The status of the solve at the predicted phase, or of the search.
pub fn maximum_near<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    let share = prediction.point.dynamic_share(balance).min(1.0);
    let rough = NewtonSettings {
        tolerance: newton.tolerance.max(ROUGH * share),
        ..newton
    };
    let locked = phase_locked(balance, prediction.clone(), rough)?;
    let start = PeakPrediction {
        point: locked.point,
        phasor: prediction.phasor,
        sharpness: prediction.sharpness,
    };
    correct(balance, start.clone(), settings, newton).or_else(|_| {
        let locked = phase_locked(balance, start, newton)?;
        find_peak(balance, locked, settings, newton)
    })
}

/// The maximum on the last of `rungs` that belongs to the maximum `found` on the first: rung by rung.
///
/// # Errors
/// The status of the rung that failed.
pub(super) fn raised<'p>(
    rungs: &[Balance<'p>],
    found: Located<'p>,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Result<Located<'p>, Status> {
    rungs.windows(2).try_fold(found, |found, pair| {
        let prediction = PeakPrediction::on_other_harmonics(&pair[0], &found, &pair[1]);
        maximum_near(&pair[1], prediction, settings, newton)
    })
}

/// The maximum `found` on the harmonics of `balance`; where it is not found there, the solution with its phase.
///
/// # Errors
/// The status of the solve at that phase.
pub fn on_harmonics(
    balance: &Balance<'_>,
    found: &Solution,
    settings: PeakSettings,
    newton: NewtonSettings,
) -> Result<Point, Status> {
    let mut prediction = PeakPrediction::of(found);
    if found.harmonics == balance.harmonics {
        return Ok(prediction.point);
    }
    let n_relative = balance.layout.n_relative();
    let r = &prediction.point.r;
    prediction.point.r = (found.harmonics).convert(r, n_relative, &balance.harmonics);
    let maximum = maximum_near(balance, prediction.clone(), settings, newton);
    (maximum.map(|peak| peak.iterate))
        .or_else(|_| phase_locked(balance, prediction, newton))
        .map(|found| found.point)
}

/// The solution with the predicted phase.
///
/// # Errors
/// The status of the solve.
pub fn phase_locked<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    newton: NewtonSettings,
) -> Result<Iterate<'p>, Status> {
    let phase = Condition::PhaseLocked(prediction.phasor);
    solve(balance, prediction.point, phase, newton)
}
