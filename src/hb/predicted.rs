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
/// Step of the phase (rad) that measures the curvature where the iterations were too close together.
const CURVATURE_STEP: f64 = 0.05;
/// Iterations before giving up.
const MAX_ITERATIONS: usize = 14;
/// Iterations in a row that may fail to halve the residual, on the way, or the frequency step, at the end: samples that
/// change their contact state make the growth jump, which no secant gets over.
const PATIENCE: usize = 3;

/// d ln ŷ/dω at a frequency, after correction of the displacements.
#[derive(Clone, Copy)]
struct Slope {
    omega: f64,
    growth: f64,
    phase_rate: f64,
}

impl Slope {
    /// Slope of the growth between two frequencies that are far enough apart.
    fn curvature(self, other: Self) -> Option<f64> {
        let apart = (self.omega - other.omega) * self.phase_rate;
        (apart.abs() > 0.02 * CURVATURE_STEP)
            .then(|| (self.growth - other.growth) / (self.omega - other.omega))
    }
}

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
    let mut slopes: Vec<Slope> = Vec::new();
    let mut curvature = None;
    let mut smallest = [f64::INFINITY; 2];
    let mut worse = 0;
    for _ in 0..MAX_ITERATIONS {
        let size = iterate.relative_residual(balance);
        if !size.is_finite() {
            return Err((Status::NonFinite, count));
        }
        let jacobian = iterate.jacobian(balance);
        count += WorkCount {
            iterations: 1,
            factorizations: jacobian.factorizations(),
        };
        let step = newton_step(balance, &iterate, &jacobian, Condition::FixedFrequency);
        let tangent = Direction {
            r: iterate.frequency_rate(balance, &jacobian),
            omega: 1.0,
        };
        let response =
            iterate.response(balance) + iterate.response_rate(balance, &jacobian, &step, 0.0);
        let rate = iterate.response_rate(balance, &jacobian, &tangent, 0.0) / response;
        drop(jacobian);
        let omega = iterate.point.omega;
        let slope = Slope {
            omega,
            growth: rate.re,
            phase_rate: rate.im,
        };
        let longest = LONGEST_STEP / rate.im.abs();
        let mut omega_step = if size > SETTLED {
            -(response / phasor).arg() / rate.im
        } else {
            if let Some(measured) = slopes.last().and_then(|last| slope.curvature(*last)) {
                curvature = Some(measured);
            }
            slopes.push(slope);
            let oscillator = -rate.im * rate.im;
            let usable = curvature.filter(|c| (0.1..10.0).contains(&(c / oscillator)));
            -rate.re / usable.unwrap_or(oscillator)
        };
        let there = size <= tolerance.max(iterate.attainable(balance))
            && omega_step.abs() <= settings.frequency_tolerance * omega;
        if there {
            match curvature {
                Some(c) if c < 0.0 => return Ok((iterate, count)),
                Some(_) => break,
                // not seen from two sides yet: look from a little further away
                None => omega_step = CURVATURE_STEP / rate.im,
            }
        }
        let (kind, now) = match size > SETTLED {
            true => (0, size),
            false => (1, omega_step.abs()),
        };
        worse = if now <= 0.5 * smallest[kind] {
            0
        } else {
            worse + 1
        };
        smallest[kind] = smallest[kind].min(now);
        if worse >= PATIENCE {
            break;
        }
        let omega_step = omega_step.clamp(-longest, longest);
        let omega = omega + omega_step;
        if !settings.band.contains(omega) {
            return Err((Status::NoPeakInBand, count));
        }
        let r = iterate.point.r.iter().zip(&step.r).zip(&tangent.r);
        let point = Point {
            r: r.map(|((r, d), t)| r + d + omega_step * t).collect(),
            omega,
            level: iterate.point.level,
        };
        iterate = Iterate::new(balance, point);
    }
    Err((Status::MaxIterations, count))
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
