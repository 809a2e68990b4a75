//! Functions of numbers uniform in (0, 1) whose moments, quantiles and Sobol' indices are known.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::TAU;

/// Random numbers of one repetition.
pub(crate) struct Numbers(ChaCha8Rng);

impl Numbers {
    pub(crate) fn of(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in (0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Standard normal (Box & Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }

    pub(crate) fn uniforms(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.uniform()).collect()
    }

    pub(crate) fn normals(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.normal()).collect()
    }

    /// Points of the unit cube.
    pub(crate) fn points(&mut self, n: usize, dimensions: usize) -> Vec<Vec<f64>> {
        (0..n).map(|_| self.uniforms(dimensions)).collect()
    }
}

/// Standard normal number at the probability u.
pub(crate) fn z(u: f64) -> f64 {
    Normal::standard().inverse_cdf(u)
}

/// A function with its Sobol' indices and its 90 % quantile.
#[derive(Clone, Copy)]
pub(crate) struct Function {
    pub(crate) name: &'static str,
    pub(crate) dimensions: usize,
    pub(crate) value: fn(&[f64]) -> f64,
    pub(crate) first: &'static [f64],
    pub(crate) total: &'static [f64],
    /// Value that it exceeds with the probability 0.1.
    pub(crate) q90: f64,
}

/// x₁ + x₂/2, and a third input that does not enter.
pub(crate) const SUM: Function = Function {
    name: "sum",
    dimensions: 3,
    value: |u| u[0] + u[1] / 2.0,
    first: &[0.8, 0.2, 0.0],
    total: &[0.8, 0.2, 0.0],
    // (3/2 − q)² = 1/10 beyond the kink at 1
    q90: 1.183_772_233_983_162,
};

/// One input alone.
pub(crate) const ONE: Function = Function {
    name: "one input",
    dimensions: 2,
    value: |u| u[0],
    first: &[1.0, 0.0],
    total: &[1.0, 0.0],
    q90: 0.9,
};

/// Ishigami & Homma 1990 with a = 7 and b = 0.1; the quantile by quadrature.
pub(crate) const ISHIGAMI: Function = Function {
    name: "Ishigami",
    dimensions: 3,
    value: |u| {
        let [a, b, c] = [u[0], u[1], u[2]].map(|u| TAU * (u - 0.5));
        a.sin() + 7.0 * b.sin().powi(2) + 0.1 * c.powi(4) * a.sin()
    },
    first: &[0.313_905_19, 0.442_411_14, 0.0],
    total: &[0.557_588_86, 0.442_411_14, 0.243_683_66],
    q90: 7.822_252_5,
};

/// exp(z₁ + z₂/2) of normal numbers: a lognormal result of lognormal inputs.
pub(crate) const LOGNORMAL: Function = Function {
    name: "lognormal",
    dimensions: 2,
    value: |u| (0.5 * (z(u[0]) + z(u[1]) / 2.0)).exp(),
    // (e^{s_j²} − 1)/(e^{s²} − 1) with s₁² = 1/4, s₂² = 1/16; totals times e to the other
    first: &[0.774_253_11, 0.175_811_85],
    total: &[0.824_188_15, 0.225_746_89],
    q90: 2.047_069_185,
};

/// A kink: |x₁ − 0.3| with a gain by x₂, as a contact that opens.
pub(crate) const KINK: Function = Function {
    name: "kink",
    dimensions: 2,
    value: |u| (1.0 + u[1]) * (u[0] - 0.3).abs(),
    first: &[0.895_712_96, 0.071_112_49],
    total: &[0.928_887_51, 0.104_287_04],
    q90: 0.905_355_936,
};

/// Products of |4 u − 2| + a over 1 + a with a = 0, 1, 4.5 (Sobol').
pub(crate) const G: Function = Function {
    name: "G",
    dimensions: 3,
    value: |u| {
        let factor = |(u, a): (&f64, f64)| ((4.0 * u - 2.0).abs() + a) / (1.0 + a);
        u.iter().zip([0.0, 1.0, 4.5]).map(factor).product()
    },
    first: &[0.724_069_15, 0.181_017_29, 0.023_936_17],
    total: &[0.793_051_86, 0.244_015_96, 0.034_574_47],
    q90: 1.978_568_7,
};
