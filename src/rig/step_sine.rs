//! A resonance as a laboratory finds it: the force is stepped through the frequencies around it, the vibrometer shows a record at each step, and a
//! curve through the amplitudes of its first harmonic has a maximum.

use super::chain::VibrometerSettings;
use super::noise::Noise;
use super::settings::{FEWEST_STEPS, StepSineSettings};
use crate::record::quantised;
use crate::units::um_to_m;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Steps whose amplitude is at least this share of the largest one take part in the fit, if they are beside each other.
const FITTED: f64 = 0.75;
/// Degrees of the polynomials that are fitted: a parabola is the curve of one oscillator, a slipping or opening contact is lopsided.
const DEGREES: [usize; 2] = [2, 4];
/// Steps for each degree of the polynomial, beside one.
const STEPS_OF_DEGREE: usize = 2;
/// Places at which the lowest point of a polynomial is looked for.
const PLACES: usize = 200;
/// Halvings after which its place is known to round-off.
const HALVINGS: usize = 50;

/// What the vibrometer makes of one step.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Step {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Amplitude of the first harmonic of the record (m).
    pub amplitude_m: f64,
    /// Samples at which the vibrometer was at the end of its range.
    pub out_of_range: usize,
}

/// The maximum of a curve through steps, with standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedPeak {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Amplitude (m).
    pub amplitude_m: f64,
    /// Standard deviation of the frequency (Hz).
    pub frequency_deviation_hz: f64,
    /// Standard deviation of the amplitude (m).
    pub amplitude_deviation_m: f64,
}

impl StepSineSettings {
    /// Frequencies around a resonance at `frequency` whose half-power half-width is `half_width`, in its unit. Ascending. Their middle is
    /// `shift` steps away from the resonance, which a laboratory does not know.
    #[must_use]
    pub fn frequencies(&self, frequency: f64, half_width: f64, shift: f64) -> Vec<f64> {
        let reach = self.half_widths * half_width;
        let middle = 0.5 * (self.steps - 1) as f64;
        let place = |i: usize| frequency + reach * (i as f64 + shift - middle) / middle;
        (0..self.steps).map(place).collect()
    }

    /// The record of a step at `frequency_hz` and what is read of it. `motion`: coefficients [q0, c1, s1, c2, ...] of the displacement (m)
    /// over `harmonics`; the vibrometer drifts by `drift_m_per_s`.
    pub fn step(
        &self,
        vibrometer: &VibrometerSettings,
        (frequency_hz, drift_m_per_s): (f64, f64),
        (harmonics, motion): (&[usize], &[f64]),
        noise: &mut Noise,
    ) -> Step {
        let per_cycle = self.samples_per_cycle;
        let most = um_to_m(vibrometer.range_v * vibrometer.sensitivity_um_per_v);
        let angle = |k: usize| TAU * k as f64 / per_cycle as f64;
        let moved = |k: usize| displacement(harmonics, motion, angle(k));
        let moved: Vec<f64> = (0..per_cycle).map(moved).collect();
        let mut out_of_range = 0;
        let mut mean_cycle = vec![0.0; per_cycle];
        let mut means = Vec::with_capacity(self.cycles);
        for cycle in 0..self.cycles {
            let mut mean = 0.0;
            for (k, of_phase) in mean_cycle.iter_mut().enumerate() {
                let time = (cycle * per_cycle + k) as f64 / (per_cycle as f64 * frequency_hz);
                let seen =
                    moved[k] + drift_m_per_s * time + um_to_m(vibrometer.noise_um) * noise.normal();
                let seen = quantised(seen, um_to_m(vibrometer.resolution_um));
                out_of_range += usize::from(seen.abs() > most);
                let seen = seen.clamp(-most, most);
                *of_phase += seen / self.cycles as f64;
                mean += seen / per_cycle as f64;
            }
            means.push(mean);
        }
        // a drift is a ramp in every cycle
        let ramp = (means[self.cycles - 1] - means[0]) / (self.cycles - 1) as f64;
        let level = |k: usize| mean_cycle[k] - ramp * k as f64 / per_cycle as f64;
        let part = |wave: fn(f64) -> f64| -> f64 {
            let of_phase = |k: usize| level(k) * wave(angle(k));
            2.0 / per_cycle as f64 * (0..per_cycle).map(of_phase).sum::<f64>()
        };
        Step {
            frequency_hz,
            amplitude_m: part(f64::cos).hypot(part(f64::sin)),
            out_of_range,
        }
    }
}

/// q(θ) = q0 + Σ ck cos kθ + sk sin kθ.
fn displacement(harmonics: &[usize], motion: &[f64], theta: f64) -> f64 {
    let pairs = harmonics.iter().skip(1).zip(motion[1..].chunks_exact(2));
    let waves = pairs.map(|(k, of)| {
        let (sin, cos) = (*k as f64 * theta).sin_cos();
        of[0] * cos + of[1] * sin
    });
    motion[0] + waves.sum::<f64>()
}

/// The maximum of a curve through steps of ascending frequency: 1/A² is nearly a polynomial in the frequency. The scatter about it and what one
/// degree more or less changes give the deviations. Absent where too few steps lie around the largest one, or a polynomial has no maximum of A
/// among them.
#[must_use]
pub fn fitted_peak(steps: &[Step]) -> Option<FittedPeak> {
    let top =
        (0..steps.len()).max_by(|&a, &b| steps[a].amplitude_m.total_cmp(&steps[b].amplitude_m))?;
    let highest = steps[top].amplitude_m;
    let high = |step: &&Step| step.amplitude_m >= FITTED * highest;
    let before = steps[..top].iter().rev().take_while(high).count();
    let after = steps[top..].iter().take_while(high).count();
    let fitted = &steps[top - before..top + after];
    let scale = fitted.last()?.frequency_hz - fitted.first()?.frequency_hz;
    if fitted.len() < FEWEST_STEPS || highest <= 0.0 {
        return None;
    }
    let point = |step: &Step| Fitted {
        x: (step.frequency_hz - steps[top].frequency_hz) / scale,
        y: (highest / step.amplitude_m).powi(2),
    };
    let points: Vec<Fitted> = fitted.iter().map(point).collect();
    let [least, most] = DEGREES;
    let degree = ((points.len() - 1) / STEPS_OF_DEGREE).clamp(least, most);
    let other = if degree > least {
        degree - 1
    } else {
        degree + 1
    };
    let [lowest, other] = [degree, other].map(|degree| Lowest::of_polynomial(&points, degree));
    let (lowest, other) = (lowest?, other?);
    let amplitude = |at: &Lowest| highest / at.y.sqrt();
    let amplitude_m = amplitude(&lowest);
    let of_x = lowest.deviations[0].hypot(lowest.x - other.x);
    let of_y = 0.5 * amplitude_m / lowest.y * lowest.deviations[1];
    Some(FittedPeak {
        frequency_hz: steps[top].frequency_hz + scale * lowest.x,
        amplitude_m,
        frequency_deviation_hz: scale * of_x,
        amplitude_deviation_m: of_y.hypot(amplitude_m - amplitude(&other)),
    })
}

/// A step in the coordinates of the fit.
#[derive(Debug, Clone, Copy)]
struct Fitted {
    /// Frequency from that of the largest step, over the range of the steps that are fitted.
    x: f64,
    /// (A_max/A)².
    y: f64,
}

/// The lowest point of a polynomial through steps, with the standard deviations of `x` and `y` by the scatter of the steps.
struct Lowest {
    x: f64,
    y: f64,
    deviations: [f64; 2],
}

impl Lowest {
    /// That of the polynomial of the degree `degree`, if it lies among the steps.
    fn of_polynomial(points: &[Fitted], degree: usize) -> Option<Self> {
        let powers = |x: f64, from: usize, of: fn(f64) -> f64| {
            let power = |k: usize| x.powi(k.saturating_sub(from) as i32);
            DVector::from_fn(degree + 1, |k, _| of(k as f64) * power(k))
        };
        let row = |x: f64| powers(x, 0, |_| 1.0);
        let slope = |x: f64| powers(x, 1, |k| k);
        let bend = |x: f64| powers(x, 2, |k| k * (k - 1.0));
        let mut normal = DMatrix::zeros(degree + 1, degree + 1);
        let mut right = DVector::zeros(degree + 1);
        // an error of A counts alike at all of them: σ_y = 2 y^(3/2) σ_A / A_max
        for point in points {
            let (weight, row) = (point.y.powi(-3), row(point.x));
            normal += weight * &row * row.transpose();
            right += weight * point.y * row;
        }
        let inverse = normal.try_inverse()?;
        let curve = &inverse * right;
        let missed =
            |point: &Fitted| point.y.powi(-3) * (point.y - row(point.x).dot(&curve)).powi(2);
        let freedom = points.len().checked_sub(degree + 1).filter(|n| *n > 0)?;
        let variance = points.iter().map(missed).sum::<f64>() / freedom as f64;
        let (from, to) = (points.first()?.x, points.last()?.x);
        let at = |i: usize| from + (to - from) * i as f64 / PLACES as f64;
        let height = |i: usize| row(at(i)).dot(&curve);
        let lowest = (0..=PLACES).min_by(|a, b| height(*a).total_cmp(&height(*b)))?;
        if lowest == 0 || lowest == PLACES {
            return None;
        }
        let [mut before, mut after] = [at(lowest - 1), at(lowest + 1)];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + after);
            match slope(middle).dot(&curve) < 0.0 {
                true => before = middle,
                false => after = middle,
            }
        }
        let x = 0.5 * (before + after);
        let (y, bend) = (row(x).dot(&curve), bend(x).dot(&curve));
        if !(y > 0.0 && bend > 0.0) {
            return None;
        }
        // by the curve's coefficients: the slope is 0 at x, the height there is y
        let deviation = |of: DVector<f64>| (variance * of.dot(&(&inverse * &of))).sqrt();
        Some(Self {
            x,
            y,
            deviations: [deviation(slope(x) / bend), deviation(row(x))],
        })
    }
}

/// The largest step in place of a maximum, where the response jumps beside it. The peak lies within a step of it; its amplitude is known to what the
/// step on the side without the jump differs by. Absent where it is the first or the last step: the peak may lie beyond.
#[must_use]
pub fn largest_step(steps: &[Step]) -> Option<FittedPeak> {
    let inner = 1..steps.len().saturating_sub(1);
    let higher = |a: &usize, b: &usize| steps[*a].amplitude_m.total_cmp(&steps[*b].amplitude_m);
    let top = (0..steps.len())
        .max_by(higher)
        .filter(|top| inner.contains(top))?;
    let Step {
        frequency_hz,
        amplitude_m,
        ..
    } = steps[top];
    let beside = f64::max(steps[top - 1].amplitude_m, steps[top + 1].amplitude_m);
    // even within the bounds
    let deviation = |bound: f64| bound / 3_f64.sqrt();
    Some(FittedPeak {
        frequency_hz,
        amplitude_m,
        frequency_deviation_hz: deviation(frequency_hz - steps[top - 1].frequency_hz),
        amplitude_deviation_m: deviation(amplitude_m - beside),
    })
}
