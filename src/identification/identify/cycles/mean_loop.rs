//! One cycle of all signals on a grid of phases, and means of several.

use crate::statistics::hull;
use libm::{cos, sin};
use std::f64::consts::TAU;

/// Signals over one cycle, at equal steps of the phase; sample 0 is at the greatest displacement. In SI units.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct MeanLoop {
    /// Relative displacement, about its mean.
    pub(in crate::identify) displacement: Vec<f64>,
    /// Tangential force, about its mean.
    pub(in crate::identify) tangential: Vec<f64>,
    /// Normal force.
    pub(in crate::identify) normal: Vec<f64>,
    /// Approach, where it was measured.
    pub(in crate::identify) approach: Option<Vec<f64>>,
}

/// A signal of a loop.
pub(super) type Signal = fn(&MeanLoop) -> &[f64];

/// Highest harmonic of a smooth motion.
pub(super) const HARMONICS: usize = 6;

impl MeanLoop {
    /// Samples of the cycle.
    pub(in crate::identify) fn samples(&self) -> usize {
        self.displacement.len()
    }

    /// Sample by sample mean of at least one loop.
    pub(super) fn of(loops: &[Self]) -> Self {
        let equal: Vec<(&Self, f64)> = loops.iter().map(|cycle| (cycle, 1.0)).collect();
        Self::weighted(&equal)
    }

    /// Mean of at least one loop, each with its weight.
    pub(super) fn weighted(loops: &[(&Self, f64)]) -> Self {
        let all: f64 = loops.iter().map(|(_, weight)| weight).sum();
        let mean = |signal: Signal| {
            let at = |i: usize| {
                let parts = loops
                    .iter()
                    .map(|(cycle, weight)| weight * signal(cycle)[i]);
                parts.sum::<f64>() / all
            };
            (0..loops[0].0.samples()).map(at).collect::<Vec<f64>>()
        };
        let measured = loops.iter().all(|(cycle, _)| cycle.approach.is_some());
        Self {
            displacement: mean(|l| &l.displacement),
            tangential: mean(|l| &l.tangential),
            normal: mean(|l| &l.normal),
            approach: measured.then(|| mean(|l| l.approach.as_deref().unwrap_or(&l.displacement))),
        }
    }

    /// The same with sample `first` as the first one.
    pub(super) fn rotate(&mut self, first: usize) {
        let signals = [
            &mut self.displacement,
            &mut self.tangential,
            &mut self.normal,
        ];
        for signal in signals.into_iter().chain(&mut self.approach) {
            signal.rotate_left(first);
        }
    }

    /// T/N, sample by sample; none where the normal force is too small to divide by.
    pub(in crate::identify) fn ratio(&self, i: usize, least_normal: f64) -> Option<f64> {
        (self.normal[i] > least_normal).then(|| self.tangential[i] / self.normal[i])
    }

    /// Energy per cycle ∮ T du (J), positive where the contact dissipates.
    ///
    /// The polygon through the samples cuts the corners of the loop, and its error goes with the square of the step: that of
    /// polygons through every second sample is four times as large, so a third of their difference is added (Richardson).
    pub(in crate::identify) fn energy(&self) -> f64 {
        self.polygon(1) + self.energy_at_corners()
    }

    /// What is added to the energy for the corners between samples (J). Where between two samples a corner lies changes it by as much.
    pub(in crate::identify) fn energy_at_corners(&self) -> f64 {
        (self.polygon(1) - self.polygon(2)) / 3.0
    }

    /// Area of the polygon through every sample, or mean area of those through every `stride`-th one.
    fn polygon(&self, stride: usize) -> f64 {
        let n = self.samples();
        let step = |i: usize| {
            let j = (i + stride) % n;
            let mean = 0.5 * (self.tangential[i] + self.tangential[j]);
            mean * (self.displacement[j] - self.displacement[i])
        };
        (0..n).map(step).sum::<f64>() / stride as f64
    }
}

/// The mean and the lowest harmonics of a periodic signal: noise and steps are gone, a smooth motion stays.
pub(in crate::identify) fn smooth(signal: &[f64]) -> Vec<f64> {
    up_to_harmonic(signal, HARMONICS)
}

/// The mean and the harmonics up to one of a periodic signal.
pub(super) fn up_to_harmonic(signal: &[f64], highest: usize) -> Vec<f64> {
    let n = signal.len();
    let mean = signal.iter().sum::<f64>() / n as f64;
    let mut sum = vec![mean; n];
    let waves: Vec<[f64; 2]> = (0..n)
        .map(|i| TAU * i as f64 / n as f64)
        .map(|phase| [cos(phase), sin(phase)])
        .collect();
    for harmonic in 1..=highest.min((n - 1) / 2) {
        let wave = |i: usize| waves[(harmonic * i) % n];
        let part = |k: usize| {
            let products = signal.iter().enumerate().map(|(i, x)| x * wave(i)[k]);
            2.0 / n as f64 * products.sum::<f64>()
        };
        let [a, b] = [part(0), part(1)];
        for (i, value) in sum.iter_mut().enumerate() {
            *value += a * wave(i)[0] + b * wave(i)[1];
        }
    }
    sum
}

/// Greatest size of a value.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| v.abs().max(most))
}

/// Middle of the values, of two the mean; none of no values.
pub(in crate::identify) fn median(values: &mut [f64]) -> Option<f64> {
    let n = values.len();
    if n == 0 {
        return None;
    }
    let (below, middle, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    let upper = *middle;
    match n % 2 {
        1 => Some(upper),
        _ => below
            .iter()
            .copied()
            .max_by(f64::total_cmp)
            .map(|lower| 0.5 * (lower + upper)),
    }
}

/// Standard deviation of normal values over their median absolute deviation.
pub(in crate::identify) const OF_MEDIAN_DEVIATION: f64 = 1.482_602_218_505_602;

/// Median, and the standard deviation from the median absolute deviation; none of no values.
pub(in crate::identify) fn robust_scale(values: &[f64]) -> Option<[f64; 2]> {
    let middle = median(&mut values.to_vec())?;
    let mut deviations: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    median(&mut deviations).map(|deviation| [middle, OF_MEDIAN_DEVIATION * deviation])
}

/// Correlation of neighbouring values about their mean; 0 of equal values.
pub(in crate::identify) fn neighbour_correlation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let product = values
        .windows(2)
        .map(|pair| (pair[0] - mean) * (pair[1] - mean));
    match square > 0.0 {
        true => product.sum::<f64>() / square,
        false => 0.0,
    }
}

/// Places of the least and of the greatest value of a periodic signal.
pub(in crate::identify) fn extremes(signal: &[f64]) -> Option<[usize; 2]> {
    let places = 0..signal.len();
    let order = |a: &usize, b: &usize| signal[*a].total_cmp(&signal[*b]);
    Some([places.clone().min_by(order)?, places.max_by(order)?])
}

/// Greatest less least value over a cycle.
pub(in crate::identify) fn swing(signal: &[f64]) -> f64 {
    hull(signal.iter().copied()).map_or(0.0, |[low, high]| high - low)
}

/// Half of it: the amplitude.
pub(in crate::identify) fn half_swing(signal: &[f64]) -> f64 {
    0.5 * swing(signal)
}

/// Standard deviation of the noise of a periodic signal, from its second differences, in which a smooth signal is gone.
pub(in crate::identify) fn noise(values: &[f64]) -> f64 {
    let n = values.len();
    let second = |i: usize| values[(i + n - 1) % n] - 2.0 * values[i] + values[(i + 1) % n];
    let mut sizes: Vec<f64> = (0..n).map(|i| second(i).abs()).collect();
    // the squares of 1, -2, 1 add up to 6
    OF_MEDIAN_DEVIATION * median(&mut sizes).unwrap_or(0.0) / 6_f64.sqrt()
}

/// Share of the values at each end of their range that may be spikes.
const CLIPPED: f64 = 0.02;

/// Ends of the range of the values without the least and the greatest ones.
pub(super) fn inner_range(values: &[f64]) -> [f64; 2] {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let place = (CLIPPED * sorted.len() as f64).ceil() as usize;
    [sorted[place], sorted[sorted.len() - 1 - place]]
}

#[cfg(test)]
mod tests {
    use super::MeanLoop;
    use std::f64::consts::TAU;

    /// Loop of a contact of 30 N/um and 40 N at slip under 5 um; the first sample is this share of a step after the reversal.
    fn elastic_coulomb(samples: usize, share: f64) -> MeanLoop {
        let at = |i: usize| 5e-6 * (TAU * (i as f64 + share) / samples as f64).cos();
        let fine = 64;
        let mut force = 0.0_f64;
        let mut tangential = vec![0.0; samples];
        for step in 1..3 * samples * fine {
            let [before, now] =
                [step - 1, step].map(|k| (k / fine, (k % fine) as f64 / fine as f64));
            let place = |(i, part): (usize, f64)| {
                5e-6 * (TAU * (i as f64 + part + share) / samples as f64).cos()
            };
            force = (force + 30e6 * (place(now) - place(before))).clamp(-40.0, 40.0);
            if step % fine == 0 {
                tangential[step / fine % samples] = force;
            }
        }
        MeanLoop {
            displacement: (0..samples).map(at).collect(),
            tangential,
            normal: vec![100.0; samples],
            approach: None,
        }
    }

    /// Seen to fail with the polygon alone: up to -2.4e-2 with 20 samples.
    #[test]
    fn the_energy_of_few_samples_has_no_bias_and_its_error_is_known() {
        let exact = 4.0 * 40.0 * (5e-6 - 40.0 / 30e6);
        for (samples, bias) in [(20, 1e-3), (41, 1e-4), (100, 1e-5), (500, 1e-6)] {
            let mut mean = 0.0;
            for share in 0..16 {
                let cycle = elastic_coulomb(samples, f64::from(share) / 16.0);
                let error = cycle.energy() / exact - 1.0;
                let told = cycle.energy_at_corners().abs() / exact;
                assert!(
                    error.abs() < 1.1 * told,
                    "{samples} samples: {error:e}, told {told:e}"
                );
                mean += error / 16.0;
            }
            assert!(mean.abs() < bias, "{samples} samples: {mean:e}");
        }
    }
}
