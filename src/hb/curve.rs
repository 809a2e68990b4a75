//! Forced response around a peak: few solutions along the branch, many points between them.
//!
//! Between two solutions ω and ŷ are cubic Hermite polynomials in arclength: the tangents are known, and the complex
//! amplitude is smooth where its modulus is not. The curve kept is what a sweep away from the peak meets: where the
//! branch folds back, the part behind the fold is left out.

use super::balance::Balance;
use super::continuation::{BranchPoint, StepSettings, walk};
use super::newton::{Iterate, Point, WorkCount};
use super::resonance::Band;
use super::settings::NewtonSettings;
use faer::prelude::c64;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Excitation frequency (rad/s).
    pub omega: f64,
    /// Amplitude |ŷ| of response 0 (m).
    pub amplitude: f64,
}

/// First and largest relative change of the displacements per solution.
const STEPS: [f64; 2] = [0.4, 0.8];
/// Solutions per side before the walk gives up.
const MOST_STEPS: usize = 60;
/// Points per step.
const POINTS_PER_STEP: usize = 6;
/// Residual over the largest dynamic displacement at the peak. The picture needs no more; the peak itself is solved to
/// the study's tolerance.
const TOLERANCE: f64 = 1e-5;

/// The forced response through `peak` inside `band`, ascending in frequency. Where the walk fails the curve ends.
#[must_use]
pub fn response_curve(
    balance: &Balance<'_>,
    peak: &Point,
    band: Band,
    newton: NewtonSettings,
) -> (Vec<CurvePoint>, WorkCount) {
    let newton = NewtonSettings {
        tolerance: newton
            .tolerance
            .max(TOLERANCE * peak.dynamic_share(balance).min(1.0)),
        ..newton
    };
    let steps = StepSettings {
        first: STEPS[0],
        largest: STEPS[1],
        max_steps: MOST_STEPS,
        ..StepSettings::for_band(band.width())
    };
    let mut count = WorkCount::default();
    let mut side = |upwards: bool| {
        let iterate = Iterate::new(balance, peak.clone());
        let (start, work) = BranchPoint::new(balance, iterate, steps.omega_scale, None, None);
        count += work;
        let sign = if upwards { 1.0 } else { -1.0 };
        let start = if upwards { start } else { start.reversed() };
        let mut points = vec![CurvePoint {
            omega: peak.omega,
            amplitude: start.response.norm(),
        }];
        let mut front = sign * peak.omega;
        let end = walk(balance, start, newton, steps, |from, to, length| {
            for point in between(balance, from, to, length) {
                let ahead = sign * point.omega > front;
                if ahead && band.contains(point.omega) {
                    points.push(point);
                }
                front = front.max(sign * point.omega);
            }
            band.contains(to.iterate.point.omega)
        });
        count += end.count;
        points
    };
    let mut curve = side(false);
    curve.reverse();
    curve.pop();
    curve.extend(side(true));
    (curve, count)
}

/// Hermite points in (0, 1] between two solutions `length` apart.
fn between(
    balance: &Balance<'_>,
    from: &BranchPoint<'_>,
    to: &BranchPoint<'_>,
    length: f64,
) -> impl Iterator<Item = CurvePoint> {
    let n = balance.layout.n_relative();
    // the tangent at the end is of unit length in the metric there; both ends must speak of the same arclength
    let stretch = length / from.metric.dot(n, &to.tangent, &to.tangent).sqrt();
    let omega = [from.iterate.point.omega, to.iterate.point.omega].map(c64::from);
    let omega_rate = [from.tangent.omega * length, to.tangent.omega * stretch].map(c64::from);
    let response = [from.response, to.response];
    let response_rate = [from.response_rate * length, to.response_rate * stretch];
    (1..=POINTS_PER_STEP).map(move |i| {
        let t = i as f64 / POINTS_PER_STEP as f64;
        CurvePoint {
            omega: hermite(t, omega, omega_rate).re,
            amplitude: hermite(t, response, response_rate).norm(),
        }
    })
}

/// Cubic with the given values and slopes at t = 0 and 1.
fn hermite(t: f64, value: [c64; 2], slope: [c64; 2]) -> c64 {
    let u = 1.0 - t;
    value[0] * (u * u * (1.0 + 2.0 * t))
        + value[1] * (t * t * (3.0 - 2.0 * t))
        + slope[0] * (t * u * u)
        - slope[1] * (t * t * u)
}
