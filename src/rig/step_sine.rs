//! A resonance as a laboratory finds it: the force is stepped through the frequencies around it, the vibrometer shows a record at each step, and a
//! curve through the amplitudes of its first harmonic has a maximum.

use super::chain::VibrometerSettings;
use super::noise::Noise;
use super::settings::{FEWEST_STEPS, StepSineSettings};
use crate::record::quantised;
use crate::units::um_to_m;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Steps whose amplitude is at least this share of the largest one take part in the fit, if they are beside each other.
const FITTED: f64 = 0.75;

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
    /// Frequencies around a resonance at `frequency` whose half-power half-width is `half_width`, in its unit. Ascending.
    #[must_use]
    pub fn frequencies(&self, frequency: f64, half_width: f64) -> Vec<f64> {
        let reach = self.half_widths * half_width;
        let middle = 0.5 * (self.steps - 1) as f64;
        let place = |i: usize| frequency + reach * (i as f64 - middle) / middle;
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

/// The maximum of a curve through steps of ascending frequency. 1/A² of one oscillator is nearly a parabola in the frequency; its scatter about the
/// fitted one gives the deviations. Absent where too few steps lie around the largest one, or the parabola has no maximum of A among them.
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
    // y = (A_max/A)² over x in [-1, 1]; an error of A counts alike at all of them: σ_y = 2 y^(3/2) σ_A / A_max
    let place = |f: f64| (f - steps[top].frequency_hz) / scale;
    let row = |x: f64| Vector3::new(1.0, x, x * x);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let points = fitted.iter().map(|step| {
        let y = (highest / step.amplitude_m).powi(2);
        (place(step.frequency_hz), y, y.powi(-3))
    });
    let points: Vec<(f64, f64, f64)> = points.collect();
    for &(x, y, weight) in &points {
        normal += weight * row(x) * row(x).transpose();
        right += weight * y * row(x);
    }
    let inverse = normal.try_inverse()?;
    let curve = inverse * right;
    let rest = (points.iter()).map(|&(x, y, weight)| weight * (y - row(x).dot(&curve)).powi(2));
    let variance = rest.sum::<f64>() / (points.len() - 3) as f64;
    let x = -0.5 * curve[1] / curve[2];
    let y = row(x).dot(&curve);
    let inside = points.first()?.0 < x && x < points.last()?.0;
    if !(curve[2] > 0.0 && inside && y > 0.0) {
        return None;
    }
    // by the curve's coefficients: x = −b/2c, y at its minimum
    let of_x = Vector3::new(0.0, -0.5 / curve[2], 0.5 * curve[1] / curve[2].powi(2));
    let of_y = row(x);
    let deviation = |of: Vector3<f64>| (variance * (of.transpose() * inverse * of)[0]).sqrt();
    let amplitude_m = highest / y.sqrt();
    Some(FittedPeak {
        frequency_hz: steps[top].frequency_hz + scale * x,
        amplitude_m,
        frequency_deviation_hz: scale * deviation(of_x),
        amplitude_deviation_m: 0.5 * amplitude_m / y * deviation(of_y),
    })
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
