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
use super::status::Status;
use faer::prelude::c64;

/// Where a peak is expected.
#[derive(Debug, Clone)]
pub struct PeakPrediction {
    /// Displacements and frequency.
    pub point: Point,
    /// Unit phasor of response 0.
    pub phasor: c64,
}

/// Relative residual below which the amplitude's growth is more reliable than the predicted phase.
const SETTLED: f64 = 1e-2;
/// Longest step of the phase (rad) in one iteration.
const LONGEST_STEP: f64 = 0.5;
/// Phases (rad) further apart than this measure the curvature.
const CURVATURE_RESOLUTION: f64 = 1e-3;
/// Step of the phase (rad) that measures it where all iterations were closer together.
const CURVATURE_STEP: f64 = 0.03;
/// Curvatures, as multiples of one oscillator's, that a secant may use.
const USABLE: std::ops::Range<f64> = 0.1..10.0;
/// Iterations before giving up.
const MAX_ITERATIONS: usize = 14;
/// Iterations in a row that may fail to halve the residual, on the way, or the frequency step, at the end: samples that
/// change their contact state make the growth jump, which no secant gets over.
const PATIENCE: usize = 3;

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
) -> Result<(Iterate<'p>, WorkCount), (Status, WorkCount)> {
    let mut count = WorkCount::default();
    let phasor = prediction.phasor;
    let mut iterate = Iterate::new(balance, prediction.point);
    let tolerance = newton
        .tolerance
        .min(sharp_enough(balance, &iterate, settings));
    let mut search = Search::default();
    for _ in 0..MAX_ITERATIONS {
        let size = iterate.relative_residual(balance);
        if !size.is_finite() {
            return Err((Status::NonFinite, count));
        }
        let solved = size <= tolerance.max(iterate.attainable(balance));
        let located = search.last_step <= settings.frequency_tolerance * iterate.point.omega;
        if solved && located {
            if search.curvature.is_none() {
                search.look_aside(balance, &iterate, &mut count);
            }
            return match search.curvature {
                Some(c) if c < 0.0 => Ok((iterate, count)),
                _ => Err((Status::MaxIterations, count)),
            };
        }
        let local = Local::new(balance, &iterate, &mut count);
        let omega_step = match size > SETTLED {
            true => -(local.response / phasor).arg() / local.rate.im,
            false => search.growth_step(local.slope()),
        };
        if search.stalls(size, omega_step) {
            break;
        }
        let longest = LONGEST_STEP / local.rate.im.abs();
        let point = local.step(&iterate.point, omega_step.clamp(-longest, longest));
        if !settings.band.contains(point.omega) {
            return Err((Status::NoPeakInBand, count));
        }
        iterate = Iterate::new(balance, point);
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

    fn slope(&self) -> Slope {
        Slope {
            omega: self.omega,
            growth: self.rate.re,
            phase_rate: self.rate.im,
        }
    }

    /// The corrected point, moved along the tangent.
    fn step(&self, from: &Point, omega_step: f64) -> Point {
        let r = (from.r.iter()).zip(&self.correction.r).zip(&self.tangent.r);
        Point {
            r: r.map(|((r, d), t)| r + d + omega_step * t).collect(),
            omega: from.omega + omega_step,
            level: from.level,
        }
    }
}

/// d ln ŷ/dω at a frequency.
#[derive(Clone, Copy)]
struct Slope {
    omega: f64,
    growth: f64,
    phase_rate: f64,
}

/// What the iterations have seen of the growth.
struct Search {
    last: Option<Slope>,
    /// dg/dω where it could be measured.
    curvature: Option<f64>,
    /// Last frequency step that made the growth vanish (rad/s).
    last_step: f64,
    /// Smallest residual and smallest such step, and iterations since one of them was halved.
    smallest: [f64; 2],
    worse: usize,
}

impl Default for Search {
    fn default() -> Self {
        Self {
            last: None,
            curvature: None,
            last_step: f64::INFINITY,
            smallest: [f64::INFINITY; 2],
            worse: 0,
        }
    }
}

impl Search {
    /// Frequency step to where the growth vanishes.
    fn growth_step(&mut self, slope: Slope) -> f64 {
        if let Some(last) = self.last.replace(slope) {
            let apart = slope.omega - last.omega;
            if (apart * slope.phase_rate).abs() > CURVATURE_RESOLUTION {
                self.curvature = Some((slope.growth - last.growth) / apart);
            }
        }
        let oscillator = -slope.phase_rate * slope.phase_rate;
        let measured = self
            .curvature
            .filter(|c| USABLE.contains(&(c / oscillator)));
        let step = -slope.growth / measured.unwrap_or(oscillator);
        self.last_step = step.abs();
        step
    }

    /// Measures the curvature at a solution by the growth a little further on.
    fn look_aside(&mut self, balance: &Balance<'_>, at: &Iterate<'_>, count: &mut WorkCount) {
        let here = Local::new(balance, at, count);
        let step = CURVATURE_STEP / here.rate.im.abs();
        let aside = Iterate::new(balance, here.step(&at.point, step));
        let there = Local::new(balance, &aside, count);
        self.curvature = Some((there.rate.re - here.rate.re) / step);
    }

    fn stalls(&mut self, size: f64, omega_step: f64) -> bool {
        let (kind, now) = match size > SETTLED {
            true => (0, size),
            false => (1, omega_step.abs()),
        };
        self.worse = match now <= 0.5 * self.smallest[kind] {
            true => 0,
            false => self.worse + 1,
        };
        self.smallest[kind] = self.smallest[kind].min(now);
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
