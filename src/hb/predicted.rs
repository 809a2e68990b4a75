//! A resonance peak close to a predicted one: Newton's method for displacements and frequency together.
//!
//! Per iteration one factor J gives the correction of r at a fixed frequency, the tangent dr/dω and from both
//! d ln ŷ/dω = g + i p at the corrected point. Far from the branch the frequency follows the predicted phase of the
//! peak, δω = −δφ/p; close to it the growth g must vanish, δω = −g/g′, with g′ by secants, at first −p² as for one
//! oscillator.

use super::balance::Balance;
use super::newton::{Condition, Direction, Iterate, Point, WorkCount, newton_step, solve};
use super::peak::{PeakSettings, find_peak, sharp_enough};
use super::settings::NewtonSettings;
use super::solution::Solution;
use super::status::Status;
use crate::aft::{Accuracy, Backend};
use faer::prelude::c64;

/// Where a peak is expected.
#[derive(Debug, Clone)]
pub struct PeakPrediction {
    /// Displacements and frequency.
    pub point: Point,
    /// Unit phasor of response 0.
    pub phasor: c64,
}

impl PeakPrediction {
    /// The peak of a problem close to one whose peak is `solution`, on the same harmonics.
    #[must_use]
    pub fn of(solution: &Solution) -> Self {
        let response = solution.first_harmonic(0);
        Self {
            point: solution.point(),
            phasor: response / response.norm(),
        }
    }
}

/// Residual over the dynamic displacement below which the amplitude's growth is more reliable than the predicted phase.
const SETTLED: f64 = 1e-2;
/// Longest step of the phase (rad) in one iteration.
const LONGEST_STEP: f64 = 0.5;
/// Phases (rad) further apart than this measure the curvature.
const CURVATURE_RESOLUTION: f64 = 1e-3;
/// Step of the phase (rad) that measures it where all iterations were closer together.
const CURVATURE_STEP: f64 = 0.1;
/// Newton steps spent on that.
const CORRECTIONS: usize = 3;
/// Curvatures, as multiples of one oscillator's, that a secant may use; friction makes flat tops (0.03 has been seen).
const USABLE: std::ops::Range<f64> = 0.003..10.0;
/// Iterations before giving up.
const MAX_ITERATIONS: usize = 14;
/// Iterations in a row that may fail to halve the residual, on the way, or the frequency step, at the end: samples that
/// change their contact state make the growth jump, which no secant gets over.
const PATIENCE: usize = 3;

/// Relative step of the frequency above which a located peak takes one more: the distance left is then a few hundredths
/// of this, far below what was asked for, and the way on which the peak was found cannot be told from it.
const LAST_STEP: f64 = 1e-8;

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
) -> Result<(Iterate<'p>, WorkCount), (Status, WorkCount)> {
    if matches!(balance.problem.backend, Backend::Cpu) {
        return searched(balance, prediction, (settings, newton), Iterate::new);
    }
    match searched(
        balance,
        prediction.clone(),
        (settings, newton),
        Iterate::draft,
    ) {
        Ok(found) => Ok(found),
        Err((_, spent)) => {
            let again = searched(balance, prediction, (settings, newton), Iterate::new);
            let add = |mut count: WorkCount| {
                count += spent;
                count
            };
            again
                .map(|(found, count)| (found, add(count)))
                .map_err(|(status, count)| (status, add(count)))
        }
    }
}

/// The search behind [`correct`]; `evaluate` makes the iterates until one was evaluated in full.
fn searched<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    (settings, newton): (PeakSettings, NewtonSettings),
    evaluate: fn(&Balance<'p>, Point) -> Iterate<'p>,
) -> Result<(Iterate<'p>, WorkCount), (Status, WorkCount)> {
    let mut count = WorkCount::default();
    let phasor = prediction.phasor;
    let mut iterate = evaluate(balance, prediction.point);
    let tolerance = newton
        .tolerance
        .min(sharp_enough(balance, &iterate.point, settings));
    let settled = SETTLED * iterate.point.dynamic_share(balance).min(1.0);
    let mut search = Search::default();
    for _ in 0..MAX_ITERATIONS {
        let size = iterate.relative_residual(balance);
        if !size.is_finite() {
            return Err((Status::NonFinite, count));
        }
        let solved = size <= tolerance.max(iterate.attainable(balance));
        let closing = solved && search.located;
        if closing && (search.closed || search.step <= LAST_STEP) {
            return match search.is_maximum(balance, &iterate, &mut count) {
                true => Ok((iterate, count)),
                false => Err((Status::MaxIterations, count)),
            };
        }
        let local = Local::new(balance, &iterate, &mut count);
        search.closed |= closing;
        let by_growth = size <= settled && (closing || !search.located);
        let omega_step = if by_growth {
            search.growth_step(&local, settings.frequency_tolerance)
        } else if search.located {
            0.0
        } else {
            -(local.response / phasor).arg() / local.rate.im
        };
        if search.stalls((size, size > settled), omega_step) {
            break;
        }
        let longest = LONGEST_STEP / local.rate.im.abs();
        let omega_step = omega_step.clamp(-longest, longest);
        let point = local.along(&local.corrected(&iterate.point), omega_step);
        if by_growth {
            search.last = Some(local);
        }
        if !settings.band.contains(point.omega) {
            return Err((Status::NoPeakInBand, count));
        }
        iterate = match iterate.contact.accuracy {
            Accuracy::Draft => evaluate(balance, point),
            Accuracy::Full => Iterate::new(balance, point),
        };
    }
    Err((Status::MaxIterations, count))
}

/// Newton step and tangent at one iterate.
struct Local {
    omega: f64,
    correction: Direction,
    tangent: Direction,
    /// ŷ after the correction.
    response: c64,
    /// d ln ŷ/dω there.
    rate: c64,
}

impl Local {
    fn new(balance: &Balance<'_>, iterate: &Iterate<'_>, count: &mut WorkCount) -> Self {
        let jacobian = iterate.jacobian(balance);
        *count += WorkCount {
            iterations: 1,
            factorizations: jacobian.factorizations(),
        };
        let correction = newton_step(balance, iterate, &jacobian, Condition::FixedFrequency);
        let tangent = Direction {
            r: iterate.frequency_rate(balance, &jacobian),
            omega: 1.0,
        };
        let rate = |d: &Direction| iterate.response_rate(balance, &jacobian, d, 0.0);
        let response = iterate.response(balance) + rate(&correction);
        Self {
            omega: iterate.point.omega,
            rate: rate(&tangent) / response,
            response,
            correction,
            tangent,
        }
    }

    /// dg/dω of one oscillator with this phase rate.
    fn oscillator(&self) -> f64 {
        -self.rate.im * self.rate.im
    }

    /// Whether a secant may use this dg/dω: it belongs to a maximum, and not to a kink.
    fn usable(&self, curvature: f64) -> bool {
        USABLE.contains(&(curvature / self.oscillator()))
    }

    /// The point after the Newton step.
    fn corrected(&self, from: &Point) -> Point {
        moved(from, &self.correction, 1.0)
    }

    /// The point moved along the tangent.
    fn along(&self, from: &Point, omega_step: f64) -> Point {
        moved(from, &self.tangent, omega_step)
    }
}

fn moved(from: &Point, direction: &Direction, length: f64) -> Point {
    Point {
        r: (from.r.iter().zip(&direction.r))
            .map(|(r, d)| r + length * d)
            .collect(),
        omega: from.omega + length * direction.omega,
        level: from.level,
    }
}

/// What the iterations have seen of the growth.
#[derive(Default)]
struct Search {
    /// The last iteration that stepped to where the growth vanishes.
    last: Option<Local>,
    /// dg/dω where it could be measured.
    curvature: Option<f64>,
    /// Whether a frequency step was within the tolerance: the rest is up to the displacements.
    located: bool,
    /// The last such step, over the frequency; whether it was made from a solved iterate within the tolerance.
    step: f64,
    closed: bool,
    /// Smallest residual and smallest such step, and iterations since one of them was halved.
    smallest: [Option<f64>; 2],
    worse: usize,
}

impl Search {
    /// Frequency step to where the growth vanishes.
    fn growth_step(&mut self, here: &Local, tolerance: f64) -> f64 {
        if let Some(last) = &self.last {
            let apart = here.omega - last.omega;
            if (apart * here.rate.im).abs() > CURVATURE_RESOLUTION {
                self.curvature = Some((here.rate.re - last.rate.re) / apart);
            }
        }
        let measured = self.curvature.filter(|c| here.usable(*c));
        let step = -here.rate.re / measured.unwrap_or(here.oscillator());
        self.step = step.abs() / here.omega;
        self.located = self.step <= tolerance;
        step
    }

    /// Whether the peak `at` is a maximum: by the growth seen on the way, else by the growth a little further on.
    fn is_maximum(&self, balance: &Balance<'_>, at: &Iterate<'_>, count: &mut WorkCount) -> bool {
        let Some(here) = &self.last else {
            return false;
        };
        if self.curvature.is_some_and(|c| here.usable(c)) {
            return true;
        }
        let step = CURVATURE_STEP / here.rate.im.abs();
        let mut point = here.along(&at.point, step);
        for _ in 0..CORRECTIONS {
            let aside = Iterate::new(balance, point);
            let there = Local::new(balance, &aside, count);
            if here.usable((there.rate.re - here.rate.re) / step) {
                return true;
            }
            point = there.corrected(&aside.point);
        }
        false
    }

    /// Whether neither the residual, on the way, nor the frequency step has been halved for long.
    fn stalls(&mut self, (size, on_the_way): (f64, bool), omega_step: f64) -> bool {
        let (kind, now) = match on_the_way || self.located {
            true => (0, size),
            false => (1, omega_step.abs()),
        };
        let smallest = self.smallest[kind].unwrap_or(f64::INFINITY);
        self.worse = match now <= 0.5 * smallest {
            true => 0,
            false => self.worse + 1,
        };
        self.smallest[kind] = Some(smallest.min(now));
        self.worse >= PATIENCE
    }
}

/// The maximum next to a prediction: directly, else by a search along the branch from the solution with the predicted
/// phase. Where that fails too the solution with the predicted phase stands for the maximum.
///
/// # Errors
/// The status of the solve at the predicted phase.
pub fn maximum_near<'p>(
    balance: &Balance<'p>,
    prediction: PeakPrediction,
    settings: PeakSettings,
    newton: NewtonSettings,
    count: &mut WorkCount,
) -> Result<Iterate<'p>, Status> {
    let PeakPrediction { point, phasor } = prediction.clone();
    if let Ok(found) = count.tally(correct(balance, prediction, settings, newton)) {
        return Ok(found);
    }
    let phase = Condition::PhaseLocked(phasor);
    let locked = count.tally(solve(balance, point, phase, newton))?;
    let point = locked.point.clone();
    match count.tally(find_peak(balance, locked, settings, newton)) {
        Ok(found) => Ok(found.iterate),
        Err(_) => Ok(Iterate::new(balance, point)),
    }
}
