//! Tables for one harmonic set and one number of time points.

use super::settings::AftSettings;
use crate::contact::Real;
use crate::harmonics::HarmonicSet;
use std::f64::consts::TAU;

/// Coefficients that a loop handles together: rows of derivatives are padded to whole chunks.
pub(super) const CHUNK: usize = 8;

/// Points of the half period that a transform handles together.
pub(super) const POINTS: usize = 16;

/// Part of a padded row.
pub(super) type Chunk<T> = [T; CHUNK];

/// Everything of a contact evaluation that does not depend on the state.
#[derive(Debug, Clone)]
pub struct AftPlan<T> {
    pub(super) settings: AftSettings,
    /// Instruction set of the processor.
    pub(super) arch: pulp::Arch,
    /// Number m of coefficients of one displacement.
    pub(super) m: usize,
    /// Harmonic orders, ascending from 0.
    pub(crate) orders: Vec<usize>,
    /// The same as numbers, without 0.
    pub(super) order_numbers: Vec<T>,
    /// b: values of the basis functions. Shape: `[time][coefficient]`.
    pub(super) basis: Vec<T>,
    /// b and b', padded. Shape: `[time][2][chunk]`.
    waves: Vec<Chunk<T>>,
    /// Weight w of each coefficient in the analysis: 1/Nt for the mean, 2/Nt else. Shape: `[coefficient]`.
    pub(super) weight: Vec<T>,
    /// Cosines (mean included) and sines over the first half period (points 0 to Nt/2).
    /// Shape: `[half][cosine]`, `[half][sine]`.
    pub(super) cosines: Vec<T>,
    pub(super) sines: Vec<T>,
    /// The same times w, for the analysis of folded signals, [`POINTS`] at a time.
    /// Shape: `[half by POINTS][cosine][point]`, `[half by POINTS][sine][point]`.
    pub(super) cosine_weights: Vec<T>,
    pub(super) sine_weights: Vec<T>,
    /// Samples per radian over k, for k = 0..=2H (over 1 for k = 0): integrals in samples. Shape: `[2H + 1]`.
    pub(super) per_order: Vec<T>,
    /// Sums over the points before i of cos kθ and sin kθ for k = 0..=2H. Shape: `[Nt + 1][2][2H + 1]`.
    pub(super) prefix: Vec<T>,
}

impl<T: Real> AftPlan<T> {
    /// The tables for `harmonics` and `settings`.
    ///
    /// # Panics
    /// If the time grid does not resolve the highest harmonic ([`AftSettings::validate`] makes sure that it does).
    #[must_use]
    pub fn new(harmonics: &HarmonicSet, settings: AftSettings) -> Self {
        let n_time = settings.n_time;
        assert!(
            n_time > 2 * harmonics.highest() && u32::try_from(n_time).is_ok(),
            "{n_time} points per period cannot carry harmonic {}",
            harmonics.highest()
        );
        let (m, orders) = (harmonics.n_coefficients(), harmonics.orders().to_vec());
        let weight: Vec<f64> = (0..m)
            .map(|j| if j == 0 { 1.0 } else { 2.0 } / n_time as f64)
            .collect();
        let circle = circle_points(n_time);
        let functions = BasisFunctions::new(&orders, &circle);
        let convert = |x: f64| T::from_f64(x);
        let value = |j: usize, i: usize| convert(functions.value(j, i));
        let mut cosines = Vec::new();
        let mut sines = Vec::new();
        for i in 0..=n_time / 2 {
            cosines.extend(cosine_rows(m).map(|j| value(j, i)));
            sines.extend(sine_rows(m).map(|j| value(j, i)));
        }
        let [cosine_weights, sine_weights] = half_weights(&functions, &weight);
        Self {
            settings,
            arch: pulp::Arch::new(),
            m,
            waves: padded_waves(&functions, m),
            basis: functions.values.iter().copied().map(convert).collect(),
            cosine_weights,
            sine_weights,
            cosines,
            sines,
            per_order: (0..=2 * harmonics.highest())
                .map(|k| convert(n_time as f64 / (TAU * k.max(1) as f64)))
                .collect(),
            prefix: prefix_sums(&circle, 2 * harmonics.highest() + 1),
            weight: weight.into_iter().map(convert).collect(),
            order_numbers: orders[1..].iter().map(|&k| convert(k as f64)).collect(),
            orders,
        }
    }

    /// The same tables for another instruction set, which must be one of this processor. It gives the same bits.
    #[must_use]
    pub fn with_arch(self, arch: pulp::Arch) -> Self {
        Self { arch, ..self }
    }

    /// Numbers in its tables that grow with time points and harmonics.
    #[must_use]
    pub fn n_tabulated(harmonics: &HarmonicSet, settings: AftSettings) -> usize {
        let (n, m) = (settings.n_time, harmonics.n_coefficients());
        let basis = n * m;
        let waves = 2 * n * m.next_multiple_of(CHUNK);
        let halves = 2 * (n / 2 + 1) * m;
        let prefix = (n + 1) * 2 * (2 * harmonics.highest() + 1);
        basis + waves + halves + prefix
    }

    /// Settings of the evaluation.
    #[must_use]
    pub fn settings(&self) -> AftSettings {
        self.settings
    }

    /// Number of coefficients of one displacement or force component.
    #[must_use]
    pub fn n_coefficients(&self) -> usize {
        self.m
    }

    /// Points per period.
    pub(crate) fn n_time(&self) -> usize {
        self.settings.n_time
    }

    /// Row b_i of the basis. Shape: `[coefficient]`.
    pub(super) fn row(&self, i: usize) -> &[T] {
        &self.basis[i * self.m..][..self.m]
    }

    /// Chunks of one displacement or force component.
    pub(super) fn n_chunks(&self) -> usize {
        self.m.div_ceil(CHUNK)
    }

    /// Rows b_i and b'_i, padded. Shape of each: `[chunk]`.
    pub(super) fn wave(&self, i: usize) -> (&[Chunk<T>], &[Chunk<T>]) {
        let n = self.n_chunks();
        self.waves[2 * n * i..][..2 * n].split_at(n)
    }

    /// Number of orders in the spectrum of a mask: 0 to 2H.
    pub(super) fn n_mask_orders(&self) -> usize {
        2 * self.orders[self.orders.len() - 1] + 1
    }

    /// Prefix sums before point i. Shape: `[2][2H + 1]`, cosines then sines.
    pub(super) fn prefix_row(&self, i: usize) -> &[T] {
        let width = 2 * self.n_mask_orders();
        &self.prefix[i * width..][..width]
    }
}

/// The functions 1, cos kθ and sin kθ of a harmonic set at the samples.
struct BasisFunctions {
    orders: Vec<usize>,
    /// Shape: `[time][coefficient]`.
    values: Vec<f64>,
}

impl BasisFunctions {
    fn new(orders: &[usize], (cos, sin): &(Vec<f64>, Vec<f64>)) -> Self {
        let n_time = cos.len();
        let mut values = Vec::with_capacity(n_time * (2 * orders.len() - 1));
        let mut turns = Turns::new(&orders[1..], n_time);
        for _ in 0..n_time {
            values.push(1.0);
            for &phase in &turns.phases {
                values.extend([cos[phase], sin[phase]]);
            }
            turns.advance();
        }
        let orders = orders.to_vec();
        Self { orders, values }
    }

    fn n_coefficients(&self) -> usize {
        2 * self.orders.len() - 1
    }

    fn n_time(&self) -> usize {
        self.values.len() / self.n_coefficients()
    }

    /// Function j at sample i.
    fn value(&self, j: usize, i: usize) -> f64 {
        self.values[i * self.n_coefficients() + j]
    }

    /// Its derivative by the phase.
    fn rate(&self, j: usize, i: usize) -> f64 {
        match j {
            0 => 0.0,
            _ if j % 2 == 1 => -(self.orders[j.div_ceil(2)] as f64) * self.value(j + 1, i),
            _ => self.orders[j / 2] as f64 * self.value(j - 1, i),
        }
    }
}

/// Phases of harmonics at one sample after the other, in n-th parts of a turn: order times sample, modulo n.
struct Turns<'a> {
    orders: &'a [usize],
    n_time: usize,
    phases: Vec<usize>,
}

impl<'a> Turns<'a> {
    /// At sample 0. Orders are below `n_time`.
    fn new(orders: &'a [usize], n_time: usize) -> Self {
        Self {
            orders,
            n_time,
            phases: vec![0; orders.len()],
        }
    }

    /// To the next sample.
    fn advance(&mut self) {
        for (phase, order) in self.phases.iter_mut().zip(self.orders) {
            *phase += order;
            if *phase >= self.n_time {
                *phase -= self.n_time;
            }
        }
    }
}

/// Numbers of the even functions: the mean and the cosines.
fn cosine_rows(m: usize) -> impl Iterator<Item = usize> {
    std::iter::once(0).chain((1..m).step_by(2))
}

/// Numbers of the odd functions.
fn sine_rows(m: usize) -> impl Iterator<Item = usize> {
    (2..m).step_by(2)
}

/// All m functions and their derivatives, padded to whole chunks. Shape: `[time][2][chunk]`.
fn padded_waves<T: Real>(functions: &BasisFunctions, m: usize) -> Vec<Chunk<T>> {
    let value = |j: usize, i: usize| functions.value(j, i);
    let rate = |j: usize, i: usize| functions.rate(j, i);
    let mut waves = Vec::new();
    for i in 0..functions.n_time() {
        for f in [&value as &dyn Fn(usize, usize) -> f64, &rate] {
            let padded = |j: usize| if j < m { T::from_f64(f(j, i)) } else { T::ZERO };
            waves.extend(
                (0..m)
                    .step_by(CHUNK)
                    .map(|first| std::array::from_fn(|l| padded(first + l))),
            );
        }
    }
    waves
}

/// Even and odd functions times their weights over the first half period, [`POINTS`] samples at a time.
fn half_weights<T: Real>(functions: &BasisFunctions, weight: &[f64]) -> [Vec<T>; 2] {
    let mut cosine_weights = Vec::new();
    let mut sine_weights = Vec::new();
    let half = 0..=functions.n_time() / 2;
    for first in half.clone().step_by(POINTS) {
        let points = first..(first + POINTS).min(half.end() + 1);
        let weighted = |j: usize| {
            let weight = weight[j];
            let value = move |i| T::from_f64(weight * functions.value(j, i));
            points.clone().map(value)
        };
        cosine_weights.extend(cosine_rows(weight.len()).flat_map(weighted));
        sine_weights.extend(sine_rows(weight.len()).flat_map(weighted));
    }
    [cosine_weights, sine_weights]
}

/// Cosines and sines of the n-th part turns.
fn circle_points(n: usize) -> (Vec<f64>, Vec<f64>) {
    crate::harmonics::phases(n)
        .into_iter()
        .map(|phase| (libm::cos(phase), libm::sin(phase)))
        .unzip()
}

/// Σ_{i' < i} cos(k θ_i') and sin(k θ_i') for k below `n_orders`, shape `[Nt + 1][2][n_orders]`, summed in double precision.
fn prefix_sums<T: Real>((cos, sin): &(Vec<f64>, Vec<f64>), n_orders: usize) -> Vec<T> {
    let n_time = cos.len();
    let orders: Vec<usize> = (0..n_orders).collect();
    let mut turns = Turns::new(&orders, n_time);
    let mut sums = vec![0.0; 2 * n_orders];
    let mut table = Vec::with_capacity((n_time + 1) * 2 * n_orders);
    for _ in 0..=n_time {
        table.extend(sums.iter().map(|&s| T::from_f64(s)));
        for (k, &phase) in turns.phases.iter().enumerate() {
            sums[k] += cos[phase];
            sums[n_orders + k] += sin[phase];
        }
        turns.advance();
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::settings::Laps;
    use super::*;
    use crate::contact::{Events, FrictionLaw};

    /// Seen to fail without the padding of the waves.
    #[test]
    fn tables_have_the_stated_size() {
        for (highest, n_time) in [(0, 8), (5, 128), (20, 256), (21, 300)] {
            let harmonics = HarmonicSet::up_to(highest);
            let settings = AftSettings {
                n_time,
                law: FrictionLaw::Box,
                events: Events::Located,
                laps: Laps::Periodic,
            };
            let plan = AftPlan::<f64>::new(&harmonics, settings);
            let tables = [
                plan.basis.len(),
                CHUNK * plan.waves.len(),
                plan.cosines.len() + plan.sines.len(),
                plan.cosine_weights.len() + plan.sine_weights.len(),
                plan.prefix.len(),
            ];
            let stated = AftPlan::<f64>::n_tabulated(&harmonics, settings);
            assert_eq!(tables.iter().sum::<usize>(), stated, "{highest}, {n_time}");
        }
    }
}
