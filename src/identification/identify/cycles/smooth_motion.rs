//! The displacement of a rig that moves smoothly: noise and steps of the sensor are taken out of it.
//!
//! A platform moves as a few harmonics, p(t); the sensor sees that motion less what the rig between them gives way under the
//! force, u(t) = p(t) − c T(t). Where a force cell has a resonance its spring gives way under the force of the cell, and what lies between
//! cell and contact under that of the contact. Harmonics and the coefficients of the forces are fitted to a whole cycle, so that the few samples
//! in which the contact sticks have the displacement that all samples tell. Where the elastic travel is as small as a step of the
//! sensor, the samples of the travel alone would not. A rig that holds the displacement itself has c = 0. The coefficient is found
//! from the force above the harmonics, for of the others the motion has its own.

use super::force_resonance::LoopResonance;
use super::mean_loop::{
    HARMONICS, MeanLoop, largest, neighbour_correlation, noise as noise_of, up_to_harmonic,
};
use libm::{cos, exp, log, sin};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};
use std::iter::once;

/// Fewest samples of a cycle in which noise is told from high harmonics of the motion.
const LEAST_TO_SMOOTH: usize = 64;
/// Correlation of neighbours above which a rest is no noise. Lines between samples give noise up to 0.5, a seventh harmonic of 64
/// samples has 0.77.
pub(super) const NEIGHBOURS: f64 = 0.6;
/// Distance of a difference of values from a multiple of the step of a sensor, over the step, that is rounding.
const OFF_STEP: f64 = 0.01;
/// Rest of a displacement over its swing that is rounding.
const ROUNDING: f64 = 1e-9;
/// Blocks of a cycle whose means show what noise hides in single samples...
const BLOCKS: usize = 50;
/// ...and their root mean square, over that of noise, above which they are no noise.
const LIKE_NOISE: f64 = 1.3;
/// Steps left in a mean, over the noise of its blocks, below which they count as gone.
const NEGLIGIBLE: f64 = 0.3;
/// Parts of the phase that are left out in turn: a sensor stays on one step for about a twelfth of a cycle at a reversal.
const TWELFTHS: usize = 12;

/// Steps of a sensor, and what the noise before it leaves of them in a mean over cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct Steps {
    /// Step of the sensor.
    step: f64,
    /// Error of a mean over cycles by the steps (root mean square).
    pub(super) left: f64,
}

impl Steps {
    /// Of a sensor with this step, of whose signal a sample scatters by `scatter` from cycle to cycle.
    ///
    /// Normal noise of the standard deviation σ leaves exp(−2π²σ²/q²) of the error of steps q. Source: Widrow, Kollár 2008,
    /// Quantization Noise, sec. 9 (characteristic function of the noise at 2π/q).
    pub(super) fn new(step: f64, scatter: f64) -> Self {
        let of_rounding = step * step / 12.0;
        let noise = (scatter * scatter - of_rounding).max(0.0);
        let share = match step > 0.0 {
            true => exp(-2.0 * (PI / step).powi(2) * noise),
            false => 0.0,
        };
        Self {
            step,
            left: of_rounding.sqrt() * share,
        }
    }

    /// Relative standard error of a slope over a travel below one step; 0 over a longer one, in which the error changes its sign, so that
    /// the parts of the phase tell it.
    ///
    /// What noise leaves is a wave A sin(2π x/q + φ) of the displacement x. A line through it over the travel L has the slope
    /// 6A/L · j₁(πL/q) cos φ, with the spherical Bessel function j₁; where on its steps the sensor reverses nobody knows, so all φ are alike.
    pub(in crate::identify) fn error_of_slope(&self, travel: f64) -> f64 {
        if !(travel > 0.0 && travel < self.step) {
            return 0.0;
        }
        let k = PI * travel / self.step;
        let bessel = (sin(k) - k * cos(k)) / (k * k);
        // root mean square of A cos φ: that of the wave
        6.0 * self.left / travel * bessel
    }
}

/// What smoothing has left of the error that all cycles have in common.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::identify) struct CommonError {
    /// Mean loop without each part of the phase.
    pub(in crate::identify) without: Vec<MeanLoop>,
    /// Steps of the sensor; none where noise has blurred them.
    pub(in crate::identify) steps: Option<Steps>,
}

/// Step of the sensor that gave a signal: the least difference between two of its values, if all others are multiples of it; else 0.
pub(super) fn sensor_step(signal: &[f64]) -> f64 {
    let mut sorted = signal.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let swing = sorted[sorted.len() - 1] - sorted[0];
    let differences = || {
        let pairs = sorted.windows(2).map(|pair| pair[1] - pair[0]);
        pairs.filter(|difference| *difference > ROUNDING * swing)
    };
    let least = differences().fold(f64::INFINITY, f64::min);
    let off = |difference: f64| (difference / least - (difference / least).round()).abs();
    match differences().all(|difference| off(difference) < OFF_STEP) {
        true if least.is_finite() => least,
        _ => 0.0,
    }
}

/// Replaces the displacement of every loop by harmonics and a multiple of the force where these leave of the mean steady loop no more
/// than noise and steps, sample by sample and in blocks. The rest of another motion is small, but lies where the contact sticks.
///
/// Where steps are left in the mean all cycles have the same error, which the mean loop without each twelfth of the phase tells.
pub(super) fn smooth_motion(
    loops: &mut [MeanLoop],
    run_in: usize,
    step: f64,
    resonance: Option<&LoopResonance>,
) -> CommonError {
    let steady = &loops[run_in..];
    let mean = MeanLoop::of(steady);
    if mean.samples() < LEAST_TO_SMOOTH {
        return CommonError::default();
    }
    let model = SmoothMotion::of(&mean, resonance);
    let rest = model.rest(&mean);
    let rounding = largest(&rest) <= ROUNDING * largest(&mean.displacement);
    let blocks = Blocks::of(&rest);
    let steps = Steps::new(step, scatter(steady));
    let alone = neighbour_correlation(&rest) < NEIGHBOURS || steps.left > blocks.by_noise;
    let bound = LIKE_NOISE * blocks.by_noise.hypot(steps.left);
    if !(rounding || alone && blocks.deviation < bound) {
        return CommonError::default();
    }
    for cycle in loops {
        cycle.displacement = model.of_loop(cycle);
    }
    match !rounding && steps.left > NEGLIGIBLE * blocks.by_noise {
        true => CommonError {
            without: (0..TWELFTHS)
                .map(|part| model.without(&mean, part))
                .collect(),
            steps: Some(steps),
        },
        false => CommonError::default(),
    }
}

/// Harmonics of the platform and the force that the rig gives way under.
struct SmoothMotion<'r> {
    /// Highest harmonic of the platform.
    highest: usize,
    /// Resonance of the force.
    resonance: Option<&'r LoopResonance>,
    /// Forces of the mean loop above these harmonics.
    instruments: Vec<Vec<f64>>,
}

impl<'r> SmoothMotion<'r> {
    /// As many harmonics as the mean loop shows by Schwarz' criterion, with as many independent samples as the rest has: a harmonic that is
    /// not seen moves a stiffness by less than the noise of all of them would.
    fn of(mean: &MeanLoop, resonance: Option<&'r LoopResonance>) -> Self {
        let whole = Self::up_to(mean, HARMONICS, resonance);
        let rest = whole.rest(mean);
        let samples = rest.len() as f64;
        let independent = samples / Blocks::of(&rest).alike(&rest);
        let score = |model: &Self| {
            let square: f64 = model.rest(mean).iter().map(|r| r * r).sum();
            let unknowns = 2.0 * model.highest as f64;
            independent * log(square.max(f64::MIN_POSITIVE)) + unknowns * log(independent)
        };
        let mut best = (score(&whole), whole);
        for fewer in (1..HARMONICS).rev() {
            let model = Self::up_to(mean, fewer, resonance);
            let found = score(&model);
            if found <= best.0 {
                best = (found, model);
            }
        }
        best.1
    }

    fn up_to(mean: &MeanLoop, highest: usize, resonance: Option<&'r LoopResonance>) -> Self {
        Self {
            highest,
            resonance,
            instruments: forces(mean, highest, resonance),
        }
    }

    /// Harmonics of the displacement and the multiples of the forces above its harmonics. The multiples are found with the forces of the
    /// mean loop as instruments: noise of a single loop's force, in both sums, does not make them smaller.
    fn of_loop(&self, cycle: &MeanLoop) -> Vec<f64> {
        let own = forces(cycle, self.highest, self.resonance);
        let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let count = own.len();
        let with_forces =
            DMatrix::from_fn(count, count, |i, j| product(&own[j], &self.instruments[i]));
        let with_displacement = DVector::from_fn(count, |i, _| {
            product(&cycle.displacement, &self.instruments[i])
        });
        let multiples = match with_forces[(0, 0)] > 0.0 {
            true => with_forces.lu().solve(&with_displacement),
            false => None,
        };
        let motion = up_to_harmonic(&cycle.displacement, self.highest);
        let Some(multiples) = multiples else {
            return motion;
        };
        let given_way = |i: usize| -> f64 {
            let parts = multiples.iter().zip(&own);
            parts.map(|(multiple, force)| multiple * force[i]).sum()
        };
        let both = motion.iter().enumerate();
        both.map(|(i, p)| p + given_way(i)).collect()
    }

    fn rest(&self, cycle: &MeanLoop) -> Vec<f64> {
        let fitted = self.of_loop(cycle);
        let both = cycle.displacement.iter().zip(fitted);
        both.map(|(u, f)| u - f).collect()
    }

    /// The mean loop with its displacement fitted without one twelfth of the phases; unchanged if the fit fails.
    fn without(&self, mean: &MeanLoop, part: usize) -> MeanLoop {
        let n = mean.samples();
        // parts begin half of one before the reversal, so that it lies in their middle
        let of_part = |i: usize| (2 * TWELFTHS * i / n).div_ceil(2) % TWELFTHS;
        let of_force = |force: &Vec<f64>| largest(force).max(f64::MIN_POSITIVE);
        let scales: Vec<f64> = self.instruments.iter().map(of_force).collect();
        let row = |i: usize| {
            let wave = |k: usize| {
                let phase = TAU * ((k.div_ceil(2) * i) % n) as f64 / n as f64;
                if k % 2 == 1 { cos(phase) } else { sin(phase) }
            };
            let waves = (1..=2 * self.highest).map(wave);
            let forces = self.instruments.iter().zip(&scales);
            let forces = forces.map(|(force, scale)| force[i] / scale);
            let row: Vec<f64> = once(1.0).chain(forces).chain(waves).collect();
            DVector::from_vec(row)
        };
        let unknowns = 1 + self.instruments.len() + 2 * self.highest;
        let mut normal = DMatrix::zeros(unknowns, unknowns);
        let mut right = DVector::zeros(unknowns);
        for i in (0..n).filter(|i| of_part(*i) != part) {
            let row = row(i);
            right += &row * mean.displacement[i];
            normal += &row * row.transpose();
        }
        let mut of_others = mean.clone();
        of_others.displacement = match normal.cholesky() {
            Some(factor) => {
                let found = factor.solve(&right);
                (0..n).map(|i| row(i).dot(&found)).collect()
            }
            None => self.of_loop(mean),
        };
        of_others
    }
}

/// Forces that a rig gives way under, without their harmonics up to one: that of the cell's spring and, where the cell has a resonance,
/// of the contact.
fn forces(cycle: &MeanLoop, highest: usize, resonance: Option<&LoopResonance>) -> Vec<Vec<f64>> {
    let forces = match resonance {
        None => vec![cycle.tangential.clone()],
        Some(resonance) => vec![
            resonance.spring_force(cycle),
            resonance.contact_force(cycle),
        ],
    };
    forces.iter().map(|force| above(force, highest)).collect()
}

/// A signal without its mean and its harmonics up to one.
fn above(signal: &[f64], highest: usize) -> Vec<f64> {
    let below = up_to_harmonic(signal, highest);
    signal.iter().zip(below).map(|(v, s)| v - s).collect()
}

/// Means of a rest over blocks of the cycle.
struct Blocks {
    /// Samples of a block.
    length: usize,
    /// Root mean square of the means...
    deviation: f64,
    /// ...and what noise of single samples makes of it.
    by_noise: f64,
}

impl Blocks {
    fn of(rest: &[f64]) -> Self {
        let length = (rest.len() / BLOCKS).max(1);
        let mean = |block: &[f64]| block.iter().sum::<f64>() / length as f64;
        let blocks: Vec<f64> = rest.chunks_exact(length).map(mean).collect();
        let square = blocks.iter().map(|b| b * b).sum::<f64>() / blocks.len() as f64;
        Self {
            length,
            deviation: square.sqrt(),
            by_noise: noise_of(rest) / (length as f64).sqrt(),
        }
    }

    /// Neighbours that are alike: one where all are independent.
    fn alike(&self, rest: &[f64]) -> f64 {
        let square = rest.iter().map(|r| r * r).sum::<f64>() / rest.len() as f64;
        let alike = self.deviation.powi(2) * self.length as f64 / square.max(f64::MIN_POSITIVE);
        alike.clamp(1.0, self.length as f64)
    }
}

/// Standard deviation of a sample of the displacement from cycle to cycle; 0 of one cycle.
fn scatter(loops: &[MeanLoop]) -> f64 {
    let (n, samples) = (loops.len() as f64, loops[0].samples());
    if loops.len() < 2 {
        return 0.0;
    }
    let variance = |i: usize| {
        let mean = loops.iter().map(|l| l.displacement[i]).sum::<f64>() / n;
        let square = loops.iter().map(|l| (l.displacement[i] - mean).powi(2));
        square.sum::<f64>() / (n - 1.0)
    };
    ((0..samples).map(variance).sum::<f64>() / samples as f64).sqrt()
}
