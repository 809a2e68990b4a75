//! A resonance peak close to a predicted one: Newton's method for displacements and frequency together.
//!
//! Each iteration factorises the Jacobian J once. This gives the correction of r at a fixed frequency and the tangent dr/dω.
//! Both together give d ln ŷ/dω at the corrected point: the change of the phase φ by a frequency step, and the growth
//! g = d ln|ŷ|/dφ. Far from the branch the frequency is chosen so that ŷ has the predicted phase of the peak. Close to the
//! branch it is chosen so that the growth vanishes: δφ = g/s. The sharpness s = −dg/dφ is measured by secants. Before it can
//! be measured it is the predicted one, or 1 as for one oscillator. The growth is only as exact as the displacements: while
//! its error is larger than the growth itself, the frequency stays as it is.

use super::search::{Located, PeakSettings, find_peak, sharp_enough};
use crate::aft::{Accuracy, Backend};
use crate::hb::equations::balance::Balance;
use crate::hb::newton::{Condition, Direction, Iterate, Point, newton_step, solve};
use crate::hb::settings::NewtonSettings;
use crate::hb::solution::Solution;
use crate::hb::status::Status;
use faer::prelude::c64;

/// Where a peak is expected.
#[derive(Debug, Clone)]
pub struct PeakPrediction {
    /// Displacements and frequency.
    pub point: Point,
    /// Unit phasor of response 0.
    pub phasor: c64,
    /// Sharpness of the peak (see [`Located`]).
    pub sharpness: Option<f64>,
}

impl PeakPrediction {
    /// The peak of a problem close to one whose peak is `solution`, on the same harmonics.
    #[must_use]
    pub fn of(solution: &Solution) -> Self {
        let response = solution.first_harmonic(0);
        Self {
            point: solution.point(),
            phasor: response / response.norm(),
            sharpness: solution.sharpness,
        }
    }

    /// The peak on the harmonics of `to`, if it is at `peak` on those of `from`.
    #[must_use]
    pub fn on_other_harmonics(from: &Balance<'_>, peak: &Located<'_>, to: &Balance<'_>) -> Self {
        let response = peak.iterate.response(from);
        Self {
            point: peak.iterate.point.padded(from, to),
            phasor: response / response.norm(),
            sharpness: peak.sharpness,
        }
    }
}

/// Residual over the dynamic displacement below which the growth of the amplitude is more reliable than the predicted phase.
const SETTLED: f64 = 1e-2;
/// Error of the growth, per residual over the dynamic displacement.
const GROWTH_ERROR: f64 = 5.0;
/// Longest step of the phase (rad) in one iteration.
const LONGEST_STEP: f64 = 0.5;
/// Two iterations measure the sharpness if their phases differ by more than this many times the sum of the errors of their
/// growths.
const RESOLUTION: f64 = 2.0;
/// Phases (rad) closer than this do not measure the sharpness: the difference is round-off.
const SHORTEST_SECANT: f64 = 1e-6;
/// Smallest sharpness that is assumed where it could not be measured.
const UNMEASURED: f64 = 0.1;
/// Step of the phase (rad) that measures the sharpness if all iterations were closer together.
const MEASURING_STEP: f64 = 0.1;
/// Newton steps spent on this measurement.
const CORRECTIONS: usize = 3;
/// Range of the sharpness that a step may use. Friction makes flat peaks (0.03 has been seen).
const USABLE: std::ops::Range<f64> = 0.003..10.0;
/// A step is exact enough to be the last one if the error of the growth changes it by less than this share of the frequency
/// tolerance.
const CLOSE: f64 = 0.1;
/// Most iterations.
const MAX_ITERATIONS: usize = 20;
/// Iterations in a row that may fail to halve the residual (far from the branch) or the frequency step (close to it). If
/// samples change their contact state the growth jumps, and secants do not converge.
const PATIENCE: usize = 3;

/// The maximum of |ŷ| next to `prediction`.
///
/// A GPU may draft the contact forces of the first iterations. The result is always evaluated in full. If nothing was found
/// the search is repeated in full, so that no failure is due to the drafts.
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
    if matches!(balance.problem.backend, Backend::Cpu) {
        return searched(balance, prediction, settings, newton, Iterate::new);
    }
    let draft = prediction.clone();
    searched(balance, draft, settings, newton, Iterate::draft)
        .or_else(|_| searched(balance, prediction, settings, newton, Iterate::new))
}

/// Evaluates everything at a point, as a draft or in full.
type Evaluate<'p> = fn(&Balance<'p>, Point) -> Iterate<'p>;

/// The search behind [`correct`]; `evaluate` makes the iterates until one was evaluated in full.
fn searched<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    settings: PeakSettings,
    newton: NewtonSettings,
    evaluate: Evaluate<'p>,
) -> Result<Located<'p>, Status> {
    let phasor = prediction.phasor;
    let mut iterate = evaluate(balance, prediction.point);
    let limits = Limits::new(balance, &iterate.point, settings, newton);
    let mut history = GrowthHistory {
        predicted: prediction.sharpness,
        ..GrowthHistory::default()
    };
    for _ in 0..MAX_ITERATIONS {
        let size = iterate.relative_residual(balance);
        if !size.is_finite() {
            return Err(Status::NonFinite);
        }
        let solved = size <= limits.tolerance;
        if solved && !iterate.contact.steady {
            return Err(Status::NoSteadyCycle);
        }
        let closing = solved && history.located;
        if closing && history.closed {
            return history.maximum(balance, iterate);
        }
        if balance.problem.effort.is_spent() {
            return Err(Status::BudgetSpent);
        }
        let mut local = LocalBranch::new(balance, &iterate);
        // the growth is as exact as the displacements at which it was taken
        local.growth_error = GROWTH_ERROR * (size / limits.share);
        let by_growth = closing || (!history.located && limits.trust_growth(&local, size));
        let phase_step = if by_growth {
            history.growth_step(&local, limits.frequency)
        } else if history.last.is_none() && size > limits.settled() {
            (phasor / local.response).arg()
        } else {
            0.0
        };
        if history.stalls(size, by_growth.then_some(phase_step / local.phase_rate)) {
            break;
        }
        let phase_step = phase_step.clamp(-LONGEST_STEP, LONGEST_STEP);
        let omega_step = phase_step / local.phase_rate;
        let point = local.along(&local.corrected(&iterate.point), omega_step);
        if by_growth {
            history.closed |= closing || history.is_last_step(&local, limits.phase(&local));
            history.last = Some(local);
        }
        if !settings.band.contains(point.omega) {
            return Err(Status::NoPeakInBand);
        }
        iterate = next_iterate(balance, iterate, point, omega_step, evaluate);
    }
    Err(Status::MaxIterations)
}

/// The iterate at `point`, `omega_step` away from `last`, with the compliance of `last` at the same frequency.
fn next_iterate<'p>(
    balance: &Balance<'p>,
    last: Iterate<'p>,
    point: Point,
    omega_step: f64,
    evaluate: Evaluate<'p>,
) -> Iterate<'p> {
    match last.contact.accuracy {
        Accuracy::Draft => evaluate(balance, point),
        Accuracy::Full if omega_step == 0.0 => {
            Iterate::with_compliance(balance, point, last.compliance)
        }
        Accuracy::Full => Iterate::new(balance, point),
    }
}

/// How exactly a peak is searched.
struct Limits {
    /// Largest residual of a solution.
    tolerance: f64,
    /// Dynamic displacement at the prediction over the scale of the residual, 1 at most.
    share: f64,
    /// Relative tolerance of the frequency.
    frequency: f64,
}

impl Limits {
    fn new(
        balance: &Balance<'_>,
        predicted: &Point,
        settings: PeakSettings,
        newton: NewtonSettings,
    ) -> Self {
        let sharp = sharp_enough(balance, predicted, settings);
        Self {
            tolerance: newton.tolerance.min(sharp),
            share: predicted.dynamic_share(balance).min(1.0),
            frequency: settings.frequency_tolerance,
        }
    }

    /// Residual below which an iterate is close to the branch.
    fn settled(&self) -> f64 {
        SETTLED * self.share
    }

    /// Tolerance of the frequency as a phase (rad).
    fn phase(&self, at: &LocalBranch) -> f64 {
        self.frequency * at.omega * at.phase_rate.abs()
    }

    /// Whether the growth at an iterate with a residual of this `size` is exact enough to choose the frequency.
    fn trust_growth(&self, at: &LocalBranch, size: f64) -> bool {
        let trusted = 0.5 * at.growth.abs().max(self.phase(at));
        size <= self.settled() && at.growth_error <= trusted
    }
}

/// Newton step onto the branch and tangent of the branch, at one iterate.
struct LocalBranch {
    omega: f64,
    correction: Direction,
    tangent: Direction,
    /// ŷ after the correction.
    response: c64,
    /// Derivative of its phase by the frequency (s).
    phase_rate: f64,
    /// Derivative of ln |ŷ| by the phase along the branch, and its error.
    growth: f64,
    growth_error: f64,
}

impl LocalBranch {
    fn new(balance: &Balance<'_>, iterate: &Iterate<'_>) -> Self {
        let jacobian = iterate.jacobian(balance);
        balance.problem.effort.spend(jacobian.factorizations());
        let correction = newton_step(balance, iterate, &jacobian, Condition::FixedFrequency);
        let tangent = Direction {
            r: iterate.frequency_rate(balance, &jacobian),
            omega: 1.0,
        };
        let rate = |d: &Direction| iterate.response_rate(balance, &jacobian, d, 0.0);
        let response = iterate.response(balance) + rate(&correction);
        let by_omega = rate(&tangent) / response;
        Self {
            omega: iterate.point.omega,
            phase_rate: by_omega.im,
            growth: by_omega.re / by_omega.im,
            response,
            correction,
            tangent,
            growth_error: 0.0,
        }
    }

    /// Phase (rad) that `other` is behind.
    fn ahead_of(&self, other: &Self) -> f64 {
        (self.response / other.response).arg()
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

/// Whether a step may use this sharpness: it belongs to a maximum, and not to a kink.
fn usable(sharpness: &f64) -> bool {
    USABLE.contains(sharpness)
}

/// Growth of the amplitude over the iterations so far.
#[derive(Default)]
struct GrowthHistory {
    /// The last iteration that stepped to where the growth vanishes.
    last: Option<LocalBranch>,
    /// Sharpness −dg/dφ as predicted, and where it could be measured.
    predicted: Option<f64>,
    measured: Option<f64>,
    /// Whether a frequency step was within the tolerance: only the displacements are still to be solved.
    located: bool,
    /// Whether the last frequency step is done. The result must not depend on the iterations before it: so the step was by a
    /// growth that is exact enough, or it was one more step at a solved iterate.
    closed: bool,
    /// Smallest residual since the last frequency step.
    smallest_residual: Option<f64>,
    /// Smallest frequency step.
    smallest_step: Option<f64>,
    /// Iterations since one of the two was halved.
    worse: usize,
}

impl GrowthHistory {
    /// The smallest sharpness that is possible after the iterations so far.
    fn flattest(&self) -> f64 {
        let measured = self.measured.filter(usable);
        measured.map_or(UNMEASURED, |sharpness| sharpness.min(1.0))
    }

    /// Whether the step from `here`, by the growth, is within the `tolerance` (a phase), and its error far below.
    fn is_last_step(&self, here: &LocalBranch, tolerance: f64) -> bool {
        self.located && here.growth_error <= CLOSE * tolerance * self.flattest()
    }

    /// Phase step to the point where the growth vanishes.
    fn growth_step(&mut self, here: &LocalBranch, tolerance: f64) -> f64 {
        if let Some(last) = &self.last {
            let apart = here.ahead_of(last);
            let errors = here.growth_error + last.growth_error;
            if apart.abs() > SHORTEST_SECANT.max(RESOLUTION * errors) {
                self.measured = Some((last.growth - here.growth) / apart);
            }
        }
        let farthest = here.growth.abs().max(here.growth_error) / self.flattest();
        self.located = farthest <= tolerance * here.omega * here.phase_rate.abs();
        let sharpness = self.measured.filter(usable);
        let sharpness = sharpness.or(self.predicted.filter(usable));
        here.growth / sharpness.unwrap_or(1.0)
    }

    /// Whether the peak `at` is a maximum: by the growth of the iterations, or else by the growth a little further along the
    /// branch.
    fn is_maximum(&self, balance: &Balance<'_>, at: &Iterate<'_>) -> bool {
        let Some(here) = &self.last else {
            return false;
        };
        if self.measured.as_ref().is_some_and(usable) {
            return true;
        }
        let mut point = here.along(&at.point, MEASURING_STEP / here.phase_rate.abs());
        for _ in 0..CORRECTIONS {
            let further = Iterate::new(balance, point);
            let there = LocalBranch::new(balance, &further);
            if usable(&((here.growth - there.growth) / there.ahead_of(here))) {
                return true;
            }
            point = there.corrected(&further.point);
        }
        false
    }

    /// The peak `iterate` at which the search has ended, if it is a maximum.
    fn maximum<'p>(
        &self,
        balance: &Balance<'p>,
        iterate: Iterate<'p>,
    ) -> Result<Located<'p>, Status> {
        match self.is_maximum(balance, &iterate) {
            true => Ok(Located {
                iterate,
                sharpness: self.measured.or(self.predicted).filter(usable),
            }),
            false => Err(Status::MaxIterations),
        }
    }

    /// Whether neither the residual nor the frequency steps by the growth have been halved for [`PATIENCE`] iterations. Each
    /// such step may raise the residual.
    fn stalls(&mut self, size: f64, growth_step: Option<f64>) -> bool {
        let (smallest, now) = match growth_step {
            Some(step) => {
                self.smallest_residual = None;
                (&mut self.smallest_step, step.abs())
            }
            None => (&mut self.smallest_residual, size),
        };
        let before = smallest.unwrap_or(f64::INFINITY);
        *smallest = Some(before.min(now));
        self.worse = match now <= 0.5 * before {
            true => 0,
            false => self.worse + 1,
        };
        self.worse >= PATIENCE
    }
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
    let locked = phase_locked(balance, prediction.clone(), newton)?;
    let start = PeakPrediction {
        point: locked.point.clone(),
        ..prediction
    };
    correct(balance, start, settings, newton)
        .or_else(|_| find_peak(balance, locked, settings, newton))
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
