//! A resonance peak close to a predicted one: Newton's method for displacements and frequency together.
//!
//! Per iteration one factor J gives the correction of r at a fixed frequency, the tangent dr/dω and from both
//! d ln ŷ/dω at the corrected point: the phase φ that a frequency step gives, and the growth g = d ln|ŷ|/dφ. Far from the
//! branch the frequency follows the predicted phase of the peak; close to it the growth must vanish, δφ = g/s. The sharpness
//! s = −g′ is measured by secants and predicted before, 1 as for one oscillator where it is not. The growth is wrong by as
//! much as the displacements: while that is more than it tells, the frequency rests.

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

    /// The peak on the harmonics of `to` where those of `from` have theirs at `peak`.
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

/// Residual over the dynamic displacement below which the amplitude's growth is more reliable than the predicted phase.
const SETTLED: f64 = 1e-2;
/// Error of the growth, per residual over the dynamic displacement.
const GROWTH_ERROR: f64 = 5.0;
/// Longest step of the phase (rad) in one iteration.
const LONGEST_STEP: f64 = 0.5;
/// Phases over the sum of the errors of the growth from which its changes measure the sharpness.
const RESOLUTION: f64 = 2.0;
/// Phases (rad) closer than this do not measure it: round-off.
const SHORTEST_SECANT: f64 = 1e-6;
/// Sharpness that a top may have where it could not be measured.
const UNMEASURED: f64 = 0.1;
/// Step of the phase (rad) that measures it where all iterations were closer together.
const ASIDE: f64 = 0.1;
/// Newton steps spent on that.
const CORRECTIONS: usize = 3;
/// Sharpness that a step may use; friction makes flat tops (0.03 has been seen).
const USABLE: std::ops::Range<f64> = 0.003..10.0;
/// Share of the frequency tolerance that the error of the growth may make of a step to leave nothing of the way.
const CLOSE: f64 = 0.1;
/// Iterations before giving up.
const MAX_ITERATIONS: usize = 20;
/// Iterations in a row that may fail to halve the residual, on the way, or the frequency step, at the end: samples that
/// change their contact state make the growth jump, which no secant gets over.
const PATIENCE: usize = 3;

/// The maximum of |ŷ| next to `prediction`.
///
/// A GPU may draft the contact forces on the way. What was found is decided in full; where nothing was found the way is
/// gone again in full, so that no failure is one of the drafts.
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
        return searched(balance, prediction, (settings, newton), Iterate::new);
    }
    let draft = prediction.clone();
    searched(balance, draft, (settings, newton), Iterate::draft)
        .or_else(|_| searched(balance, prediction, (settings, newton), Iterate::new))
}

/// The search behind [`correct`]; `evaluate` makes the iterates until one was evaluated in full.
fn searched<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    (settings, newton): (PeakSettings, NewtonSettings),
    evaluate: fn(&Balance<'p>, Point) -> Iterate<'p>,
) -> Result<Located<'p>, Status> {
    let phasor = prediction.phasor;
    let mut iterate = evaluate(balance, prediction.point);
    let tolerance = newton
        .tolerance
        .min(sharp_enough(balance, &iterate.point, settings));
    let share = iterate.point.dynamic_share(balance).min(1.0);
    let settled = SETTLED * share;
    let enough = |at: &LocalBranch| settings.frequency_tolerance * at.omega * at.phase_rate.abs();
    let mut history = GrowthHistory {
        predicted: prediction.sharpness,
        ..GrowthHistory::default()
    };
    for _ in 0..MAX_ITERATIONS {
        let size = iterate.relative_residual(balance);
        if !size.is_finite() {
            return Err(Status::NonFinite);
        }
        let solved = size <= tolerance;
        if solved && !iterate.contact.steady {
            return Err(Status::NoSteadyCycle);
        }
        let closing = solved && history.located;
        if closing && history.closed {
            return match history.is_maximum(balance, &iterate) {
                true => Ok(history.ended(iterate)),
                false => Err(Status::MaxIterations),
            };
        }
        if balance.problem.effort.is_spent() {
            return Err(Status::BudgetSpent);
        }
        let mut local = LocalBranch::new(balance, &iterate);
        // the growth is as exact as the displacements that it was taken at
        local.growth_error = GROWTH_ERROR * (size / share);
        let trusted = 0.5 * local.growth.abs().max(enough(&local));
        let tells = size <= settled && local.growth_error <= trusted;
        let by_growth = closing || (!history.located && tells);
        let phase_step = if by_growth {
            history.growth_step(&local, settings.frequency_tolerance)
        } else if history.last.is_none() && size > settled {
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
            history.closed |= closing || history.leaves_nothing(&local, enough(&local));
            history.last = Some(local);
        }
        if !settings.band.contains(point.omega) {
            return Err(Status::NoPeakInBand);
        }
        iterate = match iterate.contact.accuracy {
            Accuracy::Draft => evaluate(balance, point),
            Accuracy::Full if omega_step == 0.0 => {
                Iterate::with_compliance(balance, point, iterate.compliance)
            }
            Accuracy::Full => Iterate::new(balance, point),
        };
    }
    Err(Status::MaxIterations)
}

/// Newton step and tangent at one iterate.
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

/// What the iterations have seen of the growth.
#[derive(Default)]
struct GrowthHistory {
    /// The last iteration that stepped to where the growth vanishes.
    last: Option<LocalBranch>,
    /// Sharpness −dg/dφ as predicted, and where it could be measured.
    predicted: Option<f64>,
    measured: Option<f64>,
    /// Whether a frequency step was within the tolerance: the rest is up to the displacements.
    located: bool,
    /// Whether a step within the tolerance has left nothing of the way on which the iterate was found: one by a growth that
    /// is exact enough, or one more where the iterate is solved.
    closed: bool,
    /// Smallest residual since the last such step, smallest such step, and iterations since one of them was halved.
    smallest_residual: Option<f64>,
    smallest_step: Option<f64>,
    worse: usize,
}

impl GrowthHistory {
    /// The flattest top that the growth seen so far allows.
    fn flattest(&self) -> f64 {
        let measured = self.measured.filter(usable);
        measured.map_or(UNMEASURED, |sharpness| sharpness.min(1.0))
    }

    /// Whether the step from `here`, by the growth, is within the tolerance (a phase) and its error far below.
    fn leaves_nothing(&self, here: &LocalBranch, tolerance: f64) -> bool {
        self.located && here.growth_error <= CLOSE * tolerance * self.flattest()
    }

    /// Phase step to where the growth vanishes.
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

    /// Whether the peak `at` is a maximum: by the growth seen on the way, else by the growth a little further on.
    fn is_maximum(&self, balance: &Balance<'_>, at: &Iterate<'_>) -> bool {
        let Some(here) = &self.last else {
            return false;
        };
        if self.measured.as_ref().is_some_and(usable) {
            return true;
        }
        let mut point = here.along(&at.point, ASIDE / here.phase_rate.abs());
        for _ in 0..CORRECTIONS {
            let aside = Iterate::new(balance, point);
            let there = LocalBranch::new(balance, &aside);
            if usable(&((here.growth - there.growth) / there.ahead_of(here))) {
                return true;
            }
            point = there.corrected(&aside.point);
        }
        false
    }

    /// The peak `iterate` where the search ended.
    fn ended<'p>(&self, iterate: Iterate<'p>) -> Located<'p> {
        Located {
            iterate,
            sharpness: self.measured.or(self.predicted).filter(usable),
        }
    }

    /// Whether neither the residual nor the steps by the growth have been halved for long; each such step may raise the
    /// residual.
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

/// The maximum next to a prediction that may be far: from the solution with the predicted phase, which damped steps
/// reach, directly or else by a search along the branch.
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
