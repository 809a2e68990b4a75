//! The resonance of a force cell with the mass before it: found where the contact slips, and taken out of the force.
//!
//! A cell shows the force in its spring, not that of the contact. With the mass M of the box before it and the spring and damper of the
//! cell, T = M b̈ + F and F = K b + D ḃ, so that for each harmonic of the circular frequency ω
//!
//! T = F (1 − r²/(1 + 2iζ r)),   r = ω/ω₀,   ω₀² = K/M,   2ζ = D ω₀/K.
//!
//! Where the contact slips T is ± μN, and what F adds to it is the free vibration of the mass, which tells ω₀ and ζ. It begins
//! anew with each slip and each reversal, the same in all cycles, so that no mean takes it out. Below the resonance
//! the mass also adds to a force that changes fast: at an eighth of ω₀ a stick branch without the correction is no line at all.

use super::equations::least_squares;
use super::mean_loop::{MeanLoop, extremes, largest, smooth};
use crate::identify::found::result::ForceResonance;
use crate::identify::golden::smallest;
use libm::{cos, exp, sin};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// Parts of the swing of the displacement, after the turn before, between which the vibration is sought: before them a contact may
/// stick, and after them, too, where the rig gives way while the motion turns.
const SOUGHT: [f64; 2] = [0.3, 0.95];
/// Fewest periods of the vibration between them...
const LEAST_PERIODS: f64 = 1.6;
/// ...and fewest samples of a period.
const LEAST_SAMPLES_OF_PERIOD: f64 = 4.0;
/// Frequencies that are tried per inverse length of the part.
const FINENESS: f64 = 8.0;
/// Damping ratio with which they are tried, and the largest that is found.
const DAMPING: f64 = 0.02;
const MOST_DAMPING: f64 = 0.2;
/// Times that frequency and damping are sharpened in turn, and steps of each.
const ROUNDS: usize = 3;
const STEPS: usize = 20;
/// Share of the variance about a parabola that a vibration must hold: noise of 180 samples gives at most a tenth. A vibration that
/// holds less is as small as the noise.
const HELD: f64 = 0.75;
/// Unknowns of a half of the cycle: a parabola, cosine and sine.
const UNKNOWNS: usize = 5;
/// Frequencies over that of the resonance, largest first, at which a Gaussian low-pass may have fallen to exp(−½). It rounds a corner
/// by a period over 2π times as much: the less, the more noise passes, which the correction makes larger.
const PASSED: [f64; 8] = [8.0, 6.5, 5.0, 4.0, 3.2, 2.5, 2.0, 1.5];
/// Rounding of a corner (samples, standard deviation) below which a wider low-pass tells nothing more and passes noise alone.
const ROUNDED: f64 = 2.0;
/// Noise of the mean force that may be left, over half its swing; as large as it was it may always be.
const NOISE_LEFT: f64 = 5e-3;

/// Resonance of the force of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LoopResonance {
    /// ω₀ over the circular frequency of the motion.
    harmonic: f64,
    /// ζ.
    damping: f64,
    /// Frequency over that of the resonance at which the low-pass has fallen to exp(−½); infinite without one.
    passed: f64,
}

impl LoopResonance {
    /// The resonance in the force of a mean loop; `None` where noise could look the same.
    pub(super) fn of(mean: &MeanLoop) -> Option<Self> {
        let n = mean.samples() as f64;
        let halves = halves(mean)?;
        let shorter = halves.iter().map(Vec::len).min()? as f64;
        let step = n / (FINENESS * shorter);
        let [least, most] = [LEAST_PERIODS * n / shorter, n / LEAST_SAMPLES_OF_PERIOD];
        let tried = (0..).map(|k| least + step * f64::from(k));
        let tried: Vec<f64> = tried.take_while(|harmonic| *harmonic <= most).collect();
        let rest = |harmonic: f64, damping: f64| rest(&halves, TAU * harmonic / n, damping);
        let each: Vec<f64> = tried.iter().map(|h| rest(*h, DAMPING)).collect();
        let best = (0..each.len()).min_by(|a, b| each[*a].total_cmp(&each[*b]))?;
        // a slow change that is no vibration is described best by the slowest one
        if best == 0 || best + 1 == each.len() {
            return None;
        }
        let mut found = Self {
            harmonic: tried[best],
            damping: DAMPING,
            passed: f64::INFINITY,
        };
        for _ in 0..ROUNDS {
            let about = [found.harmonic - step, found.harmonic + step];
            found.harmonic = smallest(about, STEPS, |harmonic| rest(harmonic, found.damping));
            let range = [0.0, MOST_DAMPING];
            found.damping = smallest(range, STEPS, |damping| rest(found.harmonic, damping));
        }
        let without: f64 = halves.iter().map(|half| parabola_rest(half)).sum();
        let left = rest(found.harmonic, found.damping);
        let freedom = halves.iter().map(Vec::len).sum::<usize>() - 2 * UNKNOWNS;
        found.passed = found.widest(mean, (left / freedom as f64).sqrt());
        (left < (1.0 - HELD) * without).then_some(found)
    }

    /// The widest low-pass that leaves a force with this noise (N) little enough of it.
    fn widest(&self, mean: &MeanLoop, noise: f64) -> f64 {
        let (n, half_swing) = (mean.samples(), largest(&mean.tangential));
        let least = PASSED[PASSED.len() - 1];
        let sharpest = n as f64 / (self.harmonic * TAU * ROUNDED);
        let small = |passed: &f64| {
            let with = Self {
                passed: *passed,
                ..*self
            };
            let gain = |k: usize| with.of_contact(with.over_resonance(k, n)).norm_sqr();
            let mean_square = (0..n).map(gain).sum::<f64>() / n as f64;
            noise * mean_square.sqrt() <= noise.max(NOISE_LEFT * half_swing)
        };
        let mut of_samples = PASSED.into_iter().filter(|passed| *passed <= sharpest);
        of_samples.find(small).unwrap_or(least)
    }

    fn low_pass(&self, r: f64) -> Complex64 {
        Complex64::new(exp(-0.5 * (r / self.passed).powi(2)), 0.0)
    }

    /// Force of the contact over that of the cell, both behind the low-pass.
    fn of_contact(&self, r: f64) -> Complex64 {
        self.low_pass(r) * (1.0 - r * r / self.carried(r))
    }

    /// Force of the cell over that in its spring.
    fn carried(&self, r: f64) -> Complex64 {
        Complex64::new(1.0, 2.0 * self.damping * r)
    }

    /// Frequency of a term of a spectrum of `n` terms, over that of the resonance.
    fn over_resonance(&self, k: usize, n: usize) -> f64 {
        k.min(n - k) as f64 / self.harmonic
    }

    /// Force in the spring of the cell, which the damper beside it does not carry: K b, in proportion to its displacement.
    pub(super) fn spring_force(&self, cycle: &MeanLoop) -> Vec<f64> {
        self.filtered(&cycle.tangential, |r| 1.0 / self.carried(r))
    }

    /// Tangential force of the contact.
    pub(super) fn contact_force(&self, cycle: &MeanLoop) -> Vec<f64> {
        self.filtered(&cycle.tangential, |r| self.of_contact(r))
    }

    /// Puts the force of the contact in place of that of the cell. All signals pass the same low-pass, so that a line stays a line.
    pub(super) fn take_out(&self, cycle: &mut MeanLoop) {
        cycle.tangential = self.contact_force(cycle);
        let others = [&mut cycle.displacement, &mut cycle.normal];
        for signal in others.into_iter().chain(&mut cycle.approach) {
            *signal = self.filtered(signal, |r| self.low_pass(r));
        }
    }

    /// In Hz, of a motion of this frequency.
    pub(super) fn at(&self, frequency_hz: f64) -> ForceResonance {
        ForceResonance {
            frequency_hz: self.harmonic * frequency_hz,
            damping_ratio: self.damping,
        }
    }

    /// A periodic signal with each harmonic times a factor of its frequency over that of the resonance.
    fn filtered(&self, signal: &[f64], factor: impl Fn(f64) -> Complex64) -> Vec<f64> {
        let n = signal.len();
        let mut planner = FftPlanner::new();
        let complex = signal.iter().map(|value| Complex64::new(*value, 0.0));
        let mut spectrum: Vec<Complex64> = complex.collect();
        planner.plan_fft_forward(n).process(&mut spectrum);
        for (k, value) in spectrum.iter_mut().enumerate() {
            let factor = factor(self.over_resonance(k, n)) / n as f64;
            *value *= if 2 * k <= n { factor } else { factor.conj() };
        }
        planner.plan_fft_inverse(n).process(&mut spectrum);
        spectrum.iter().map(|value| value.re).collect()
    }
}

/// T less its mean ratio to N times N, where the vibration is sought in the half down and in the half up.
fn halves(mean: &MeanLoop) -> Option<[Vec<f64>; 2]> {
    let n = mean.samples();
    let motion = smooth(&mean.displacement);
    let [bottom, top] = extremes(&motion)?;
    let half = |from: usize, to: usize| -> Option<Vec<f64>> {
        let whole = motion[to] - motion[from];
        let all = (0..(to + n - from) % n).map(|place| (from + place) % n);
        let passed = |part: f64| {
            let mut places = all.clone();
            places.position(|i| (motion[i] - motion[from]) / whole >= part)
        };
        let [begin, end] = [passed(SOUGHT[0])?, passed(SOUGHT[1])?];
        let places: Vec<usize> = all.skip(begin).take(end - begin).collect();
        let sum = |signal: &[f64]| places.iter().map(|i| signal[*i]).sum::<f64>();
        let ratio = sum(&mean.tangential) / sum(&mean.normal);
        let rest = |i: &usize| mean.tangential[*i] - ratio * mean.normal[*i];
        (places.len() > 2 * UNKNOWNS).then(|| places.iter().map(rest).collect())
    };
    Some([half(top, bottom)?, half(bottom, top)?])
}

/// Sum of the squares that a parabola and a vibration in each half leave; `phase`: of the vibration, per sample.
fn rest(halves: &[Vec<f64>; 2], phase: f64, damping: f64) -> f64 {
    let of_half = |half: &Vec<f64>| {
        left(half, |i, x| {
            let phase = phase * i as f64;
            let size = exp(-damping * phase);
            [1.0, x, x * x, size * cos(phase), size * sin(phase)]
        })
    };
    halves.iter().map(of_half).sum()
}

/// The same without a vibration.
fn parabola_rest(half: &[f64]) -> f64 {
    left(half, |_, x| [1.0, x, x * x])
}

/// Sum of the squares that least squares leave of values; `row`: of the place and its distance from the middle over the length.
fn left<const N: usize>(values: &[f64], row: impl Fn(usize, f64) -> [f64; N]) -> f64 {
    let n = values.len() as f64;
    let middle = values.iter().sum::<f64>() / n;
    let points = values.iter().enumerate();
    let points = points.map(|(i, value)| (row(i, (i as f64 + 0.5) / n - 0.5), value - middle));
    let fitted = least_squares(points);
    (fitted.square - fitted.held).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: usize = 500;

    /// An elastic-Coulomb contact of 30 N/um and 40 N at slip under 5 um, with N = 100 N.
    fn contact(limit: impl Fn(usize) -> f64) -> MeanLoop {
        let at = |i: usize| 5e-6 * cos(TAU * i as f64 / SAMPLES as f64);
        let mut tangential = vec![0.0; SAMPLES];
        let mut force = 0.0_f64;
        for step in 1..3 * SAMPLES {
            let (i, before) = (step % SAMPLES, (step - 1) % SAMPLES);
            let most = 40.0 * limit(i);
            force = (force + 30e6 * (at(i) - at(before))).clamp(-most, most);
            tangential[i] = force;
        }
        MeanLoop {
            displacement: (0..SAMPLES).map(at).collect(),
            tangential,
            normal: (0..SAMPLES).map(|i| 100.0 * limit(i)).collect(),
            approach: None,
        }
    }

    /// What a cell shows of it, with noise of this size (N).
    fn measured(cell: LoopResonance, noise: f64) -> MeanLoop {
        let mut cycle = contact(|_| 1.0);
        cycle.tangential = cell.filtered(&cycle.tangential, |r| {
            let carried = Complex64::new(1.0, 2.0 * cell.damping * r);
            carried / (carried - r * r)
        });
        let irrational = |i: usize| ((i as f64 + 1.0) * 0.618_033_988_75).fract() - 0.5;
        for (i, force) in cycle.tangential.iter_mut().enumerate() {
            *force += noise * irrational(i * i);
        }
        cycle
    }

    fn cell(harmonic: f64, damping: f64) -> LoopResonance {
        LoopResonance {
            harmonic,
            damping,
            passed: f64::INFINITY,
        }
    }

    /// From 60 samples of a period to 5. Seen to fail without the damping in the correction: 0.3 N of 40.
    #[test]
    fn frequency_and_damping_of_a_cell_are_found_and_its_mass_is_taken_out() {
        let truth = contact(|_| 1.0);
        for (harmonic, damping) in [(8.3, 0.01), (21.4, 0.03), (50.3, 0.01), (98.7, 0.02)] {
            let mut cycle = measured(cell(harmonic, damping), 0.0);
            let found = LoopResonance::of(&cycle).unwrap();
            let case = format!("{harmonic}, {damping}: {found:?}");
            println!("CASE {case}");
            println!("CASE {case}");
            assert!((found.harmonic / harmonic - 1.0).abs() < 2e-3, "{case}");
            assert!((found.damping - damping).abs() < 2e-3, "{case}");
            found.take_out(&mut cycle);
            let far = |i: &usize| (cycle.tangential[*i] - truth.tangential[*i]).abs();
            // away from the corners, which the low-pass rounds
            let inside = (0..SAMPLES).filter(|i| (100..230).contains(&(i % 250)));
            let worst = inside.map(|i| far(&i)).fold(0.0, f64::max);
            assert!(worst < 0.01, "{case}: {worst} N of 40");
        }
    }

    /// Seen to fail with a vibration that may hold a hundredth of the variance.
    #[test]
    fn noise_has_no_resonance() {
        for noise in [1e-9, 0.01, 1.0] {
            // 1e4 samples of a period: a cell without resonance
            let found = LoopResonance::of(&measured(cell(1e4, 0.01), noise));
            assert_eq!(found, None, "noise {noise}");
        }
    }

    /// A normal force that swings, slowly or fast, moves the plateaus with it.
    ///
    /// Seen to fail with T in place of T less its ratio to N times N.
    #[test]
    fn a_force_that_follows_the_normal_force_has_no_resonance() {
        for times in [2.0, 16.0] {
            let swing = |i: usize| 1.0 + 0.2 * cos(times * TAU * i as f64 / SAMPLES as f64);
            let found = LoopResonance::of(&contact(swing));
            assert_eq!(found, None, "{times} times the frequency");
        }
    }

    /// Seen to fail with the lowest frequency that is tried allowed as a resonance.
    #[test]
    fn a_force_that_goes_on_rising_has_no_resonance() {
        for power in [1, 3, 5] {
            let mut cycle = contact(|_| 1.0);
            for (force, x) in cycle.tangential.iter_mut().zip(&cycle.displacement) {
                *force += 10.0 * (x / 5e-6).powi(power);
            }
            assert_eq!(LoopResonance::of(&cycle), None, "power {power}");
        }
    }
}
