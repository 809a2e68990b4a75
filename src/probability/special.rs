//! Special functions of probability: the normal, the beta and the binomial distribution, with the same bits on every machine.
//!
//! They use sums, products, quotients, roots and the crate `libm` alone, none of the functions of the C library, whose last
//! bits depend on the instruction set. [`beta_quantile`] always ends.
//!
//! ```
//! # use microslip_probability as microslip;
//! use microslip::special::{normal_cdf, normal_quantile};
//!
//! let z = normal_quantile(0.975);
//! assert!((z - 1.959_963_984_540_054).abs() < 1e-14);
//! assert!((normal_cdf(z) - 0.975).abs() < 1e-15);
//! ```

mod binomial;

pub use binomial::{Binomial, TIE};

use libm::{erfc, exp, fma, lgamma, log, log1p};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Φ(z): probability of a standard normal number ≤ z.
#[must_use]
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * erfc(-z * FRAC_1_SQRT_2)
}

/// φ(z): density of the standard normal distribution.
#[must_use]
pub fn normal_density(z: f64) -> f64 {
    exp(-0.5 * z * z) / (2.0 * PI).sqrt()
}

/// Φ⁻¹(p), 0 < p < 1; relative error about 1e-16.
///
/// Source: Wichura 1988, Algorithm AS 241 (PPND16), Applied Statistics 37, 477–484.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return q * ratio(&CENTRAL, 0.180_625 - q * q);
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let r = (-log(tail)).sqrt();
    let size = match r <= 5.0 {
        true => ratio(&NEAR, r - 1.6),
        false => ratio(&FAR, r - 5.0),
    };
    size.copysign(q)
}

/// Quotient of two polynomials at r; coefficients from the highest power on.
fn ratio([above, below]: &[[f64; 8]; 2], r: f64) -> f64 {
    let value = |c: &[f64; 8]| c.iter().fold(0.0, |sum, c| sum * r + c);
    value(above) / value(below)
}

const CENTRAL: [[f64; 8]; 2] = [
    [
        2_509.080_928_730_122_7,
        33_430.575_583_588_13,
        67_265.770_927_008_7,
        45_921.953_931_549_87,
        13_731.693_765_509_46,
        1_971.590_950_306_551_3,
        133.141_667_891_784_38,
        3.387_132_872_796_366_5,
    ],
    [
        5_226.495_278_852_854,
        28_729.085_735_721_943,
        39_307.895_800_092_71,
        21_213.794_301_586_597,
        5_394.196_021_424_751,
        687.187_007_492_057_9,
        42.313_330_701_600_91,
        1.0,
    ],
];
const NEAR: [[f64; 8]; 2] = [
    [
        0.000_774_545_014_278_341_4,
        0.022_723_844_989_269_184,
        0.241_780_725_177_450_6,
        1.270_458_252_452_368_4,
        3.647_848_324_763_204_5,
        5.769_497_221_460_691,
        4.630_337_846_156_546,
        1.423_437_110_749_683_5,
    ],
    [
        1.050_750_071_644_416_9e-09,
        0.000_547_593_808_499_534_5,
        0.015_198_666_563_616_457,
        0.148_103_976_427_480_08,
        0.689_767_334_985_1,
        1.676_384_830_183_803_8,
        2.053_191_626_637_759,
        1.0,
    ],
];
const FAR: [[f64; 8]; 2] = [
    [
        2.010_334_399_292_288_1e-07,
        2.711_555_568_743_487_6e-05,
        0.001_242_660_947_388_078_4,
        0.026_532_189_526_576_124,
        0.296_560_571_828_504_87,
        1.784_826_539_917_291_3,
        5.463_784_911_164_114,
        6.657_904_643_501_103,
    ],
    [
        2.044_263_103_389_939_7e-15,
        1.421_511_758_316_446e-07,
        1.846_318_317_510_054_8e-05,
        0.000_786_869_131_145_613_3,
        0.014_875_361_290_850_615,
        0.136_929_880_922_735_8,
        0.599_832_206_555_888,
        1.0,
    ],
];

/// Passes of the continued fraction at most; it takes up to a fifth of the square root of a + b.
const MOST_PASSES: u32 = 100_000;

/// I_x(a, b): probability of a number ≤ x under the beta distribution with exponents a, b > 0; the smaller one of it and
/// 1 − I_x is off by less than 1e-11 of itself for exponents up to 1e8.
#[must_use]
pub fn beta_cdf(a: f64, b: f64, x: f64) -> f64 {
    let [below, _] = beta_tails(a, b, x);
    below
}

/// Probabilities of a number ≤ x and of one > x under the beta distribution: the smaller one keeps its digits.
fn beta_tails(a: f64, b: f64, x: f64) -> [f64; 2] {
    if x <= 0.0 || x >= 1.0 {
        let below = f64::from(u8::from(x >= 1.0));
        return [below, 1.0 - below];
    }
    let excess = excess(a, b, x);
    let power = exp(ln_power(a, b, x));
    // the fraction converges fast on the side of x where the mean is not
    match x < (a + 1.0) / (a + b + 2.0) {
        true => {
            let below = power / denominator([a, b], [x, 1.0 - x], -excess);
            [below, 1.0 - below]
        }
        false => {
            let above = power / denominator([b, a], [1.0 - x, x], excess);
            [1.0 - above, above]
        }
    }
}

/// Density of the beta distribution at x in (0, 1).
#[must_use]
pub fn beta_density(a: f64, b: f64, x: f64) -> f64 {
    exp(ln_power(a, b, x)) / (x * (1.0 - x))
}

/// The x with I_x(a, b) = p, to the last bit that [`beta_cdf`] can tell apart; 0 < p < 1.
///
/// Bisection over the floating-point numbers between 0 and 1 in their order: 62 steps.
#[must_use]
pub fn beta_quantile(a: f64, b: f64, p: f64) -> f64 {
    let (mut below, mut above) = (0_u64, 1.0_f64.to_bits());
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        match beta_cdf(a, b, f64::from_bits(middle)) < p {
            true => below = middle,
            false => above = middle,
        }
    }
    f64::from_bits(above)
}

/// x (a + b) − a = b − (1 − x) (a + b), off by a rounding error of the smaller exponent at most: the difference is a
/// millionth of its terms where the exponents are large.
fn excess(a: f64, b: f64, x: f64) -> f64 {
    match x < 0.5 {
        true => fma(x, a + b, -a),
        false => -fma(1.0 - x, a + b, -b),
    }
}

/// ln(xᵃ (1 − x)ᵇ / B(a, b)), written so that large terms cancel before they are rounded: with s = a + b,
/// a ln(x s / a) + b ln((1 − x) s / b) + ½ ln(a b / 2π s) + Δ(s) − Δ(a) − Δ(b).
fn ln_power(a: f64, b: f64, x: f64) -> f64 {
    let s = a + b;
    let excess = excess(a, b, x);
    let ln_ratio = |excess: f64, of: f64, ratio: f64| match excess.abs() < 0.5 * of {
        true => log1p(excess / of),
        false => log(ratio),
    };
    a * ln_ratio(excess, a, x * s / a)
        + b * ln_ratio(-excess, b, (1.0 - x) * s / b)
        + 0.5 * log(a * b / (2.0 * PI * s))
        + stirling_error(s)
        - stirling_error(a)
        - stirling_error(b)
}

/// Δ(a) = ln Γ(a) − (a − ½) ln a + a − ½ ln 2π.
fn stirling_error(a: f64) -> f64 {
    if a < 16.0 {
        return lgamma(a) - (a - 0.5) * log(a) + a - 0.5 * log(2.0 * PI);
    }
    let r = 1.0 / (a * a);
    let series = [
        1.0 / 1188.0,
        -1.0 / 1680.0,
        1.0 / 1260.0,
        -1.0 / 360.0,
        1.0 / 12.0,
    ];
    series.iter().fold(0.0, |sum, c| sum * r + c) / a
}

/// The continued fraction β₁ + α₂/(β₂ + α₃/(β₃ + ...)) with I_x(a, b) = xᵃ yᵇ / B(a, b) divided by it, y = 1 − x and
/// λ = a − (a + b) x.
///
/// Its terms are positive up to the n-th, n the next whole number from b on, and α is 0 there if b is whole: no digits cancel.
/// Source: routine BFRAC of Didonato & Morris 1992, Algorithm 708, ACM Transactions on Mathematical Software 18, 360–373, the
/// even part of 8.17.22 of the Digital Library of Mathematical Functions; here by the modified Lentz method.
fn denominator([a, b]: [f64; 2], [x, y]: [f64; 2], lambda: f64) -> f64 {
    let away = |v: f64| if v.abs() < 1e-300 { 1e-300 } else { v };
    let mut value = away(a * (1.0 + lambda) / (a + 1.0));
    let (mut c, mut d) = (value, 0.0);
    for n in 1..MOST_PASSES {
        let n = f64::from(n);
        let (s, w) = (a + 2.0 * n - 1.0, n * (b - n) * x);
        let alpha = (a + n - 1.0) / s * ((a + b + n - 1.0) / s) * (w * x);
        let beta = n + w / s + (a + n) / (s + 2.0) * (1.0 + lambda + n * (1.0 + y));
        d = 1.0 / away(beta + alpha * d);
        c = away(beta + alpha / c);
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published (Abramowitz & Stegun 1964, table 26.5) and by 40 digits of arithmetic.
    #[test]
    fn normal_quantiles() {
        let cases = [
            (0.5, 0.0),
            (0.975, 1.959_963_984_540_054),
            (0.999, 3.090_232_306_167_813_5),
            (1e-10, -6.361_340_902_404_056),
            (1e-20, -9.262_340_089_798_408),
        ];
        for (p, expected) in cases {
            let z = normal_quantile(p);
            assert!((z - expected).abs() < 1e-13, "{p}: {z}, not {expected}");
            assert!((normal_cdf(z) / p - 1.0).abs() < 1e-13, "{p}: {z}");
        }
    }

    /// Quantiles by bisection on the incomplete beta integral with 40 digits (mpmath 1.3).
    ///
    /// Seen to fail with the quantile function of `statrs` 0.19: it never ends for (2, 3e7), and is off by 5.7e-4 at
    /// (2, 1e6).
    #[test]
    #[expect(
        clippy::excessive_precision,
        reason = "the digits of the source, rounded by the compiler"
    )]
    fn beta_quantiles_over_all_exponents() {
        let cases = [
            (2.0, 3e7, 0.5, 5.594_489_716_989_123_7e-8),
            (2.0, 3e7, 1e-6, 4.716_268_792_882_114e-11),
            (2.0, 1e6, 0.5, 1.678_344_742_421_799_3e-6),
            (2.0, 1e6, 0.999, 9.233_366_231_963_476e-6),
            (5.0, 1e6, 0.01, 1.279_102_703_835_55e-6),
            (300.0, 1e6, 0.3, 2.905_954_831_779_617_3e-4),
            (0.01, 2.0, 0.5, 2.916_507_216_283_071_4e-31),
            (0.5, 0.5, 0.1, 2.447_174_185_242_321_7e-2),
            (2.0, 5.0, 0.9, 0.510_316_306_551_491_7),
            (1e6, 2.0, 0.25, 0.999_997_307_371_442_6),
            (100.0, 0.02, 0.01, 0.994_399_400_633_941_4),
        ];
        for (a, b, p, expected) in cases {
            let x = beta_quantile(a, b, p);
            let error = (x / expected - 1.0).abs();
            assert!(error < 1e-11, "({a}, {b}), {p}: {x}, not {expected}");
        }
    }

    /// Both tails by the power series of the smaller exponent with 45 digits (mpmath 1.4).
    ///
    /// Seen to fail with the continued fraction 8.17.22 of the Digital Library of Mathematical Functions: 5.8e-10
    /// off at (3.2e7, 25.05), and with x (a + b) − a for x near 1, too: 7.8e-10 off there.
    #[test]
    fn beta_tails_over_all_exponents() {
        let cases = [
            (
                0.3,
                7e7,
                1e-9,
                [0.493_827_311_014_530_5, 0.506_172_688_985_469_5],
            ),
            (
                25.05,
                3.2e7,
                8.7e-7,
                [0.727_100_715_519_509_5, 0.272_899_284_480_490_5],
            ),
            (
                1.2e7,
                0.83,
                0.999_999_86,
                [0.140_718_212_530_189_7, 0.859_281_787_469_810_3],
            ),
            (
                3.2e7,
                25.05,
                0.999_998_7,
                [0.002_281_863_343_658_236, 0.997_718_136_656_341_8],
            ),
            (
                538.9,
                0.04,
                0.998_5,
                [0.012_657_103_485_459_257, 0.987_342_896_514_540_7],
            ),
            (
                1234.5,
                9.9e7,
                1.3e-5,
                [0.931_023_037_006_844_2, 0.068_976_962_993_155_76],
            ),
            (
                0.02,
                0.05,
                0.7,
                [0.726_061_341_798_717_3, 0.273_938_658_201_282_7],
            ),
        ];
        for (a, b, x, exact) in cases {
            for (found, exact) in beta_tails(a, b, x).into_iter().zip(exact) {
                let error = (found / exact - 1.0).abs();
                assert!(error < 1e-12, "({a}, {b}), {x}: {found}, not {exact}");
            }
        }
    }

    /// Equal exponents are symmetric about 1/2, also where the distribution is narrow; large ones are nearly normal.
    ///
    /// Seen to fail with ½ ln(2π) in place of ½ ln(a b / 2π s).
    #[test]
    fn narrow_beta_distributions_are_symmetric_and_nearly_normal() {
        for a in [0.01, 1.0, 40.0, 1e4, 1e6] {
            assert!((beta_cdf(a, a, 0.5) - 0.5).abs() < 1e-12, "{a}");
            let [x, y] = [0.1, 0.9].map(|p| beta_quantile(a, a, p));
            assert!((x + y - 1.0).abs() < 1e-12, "{a}: {x}, {y}");
        }
        let x = beta_quantile(1e6, 1e6, 0.975);
        let normal = 0.5 + normal_quantile(0.975) / (8e6_f64 + 4.0).sqrt();
        assert!((x - normal).abs() < 1e-9, "{x}, not {normal}");
    }
}
