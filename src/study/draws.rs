//! Samples of a run as draws of another distribution that is known by its draws alone, such as a posterior.
//!
//! Draws have no density that is written down. In the normal scores z = Φ⁻¹(F(x)) of the distributions F that the run drew from, its
//! samples are standard normal, and a posterior is close to normal. There the density is a sum of normal kernels of the draws' own
//! covariance S, at m + √(1 − h²) (z − m) with the covariance h² S, so that mean and covariance stay those of the draws (West, J. R.
//! Stat. Soc. B 55 (1993) 409-422); h = (4 / (n (d + 2)))^(1 / (d + 4)) (Silverman 1986).

use crate::sampling::Distribution;
use crate::special::normal_quantile;
use libm::{exp, log, pow};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Draws that are used at most, the first ones: more change the density less than its own error.
pub(super) const MOST_DRAWS: usize = 4000;
/// Fewest draws: fewer show no distribution.
pub(super) const LEAST_DRAWS: usize = 100;
/// Distance of distribution functions that the kernels may have, beside what the samples scatter.
const KERNELS: f64 = 0.1;
/// Distance of the distribution function of n draws from its own, over 1/√n, that one case in a hundred exceeds (Kolmogorov).
const KOLMOGOROV: f64 = 1.63;

/// Density of draws over that of the samples' own distributions.
pub(super) struct DrawsDensity {
    /// Kernels' places, in whitened coordinates. Shape: draws of d.
    kernels: Vec<DVector<f64>>,
    mean: DVector<f64>,
    root: DMatrix<f64>,
    width: f64,
}

impl DrawsDensity {
    /// The density of `draws` where the samples have the distributions `laws`. Shape: draws × d, d.
    ///
    /// # Errors
    /// The column and the rule that it breaks; no column where they go together.
    pub(super) fn of(
        draws: &[Vec<f64>],
        laws: &[&Distribution],
    ) -> Result<Self, (Option<usize>, String)> {
        let mut scores = Vec::new();
        for draw in draws {
            let mut z = DVector::zeros(laws.len());
            for (j, (value, law)) in draw.iter().zip(laws).enumerate() {
                z[j] = score(law, *value).ok_or_else(|| {
                    let [low, high] = law.support();
                    let rule = format!(
                        "the value {value} must lie inside the sampled range {low} .. {high}"
                    );
                    (Some(j), rule)
                })?;
            }
            scores.push(z);
        }
        let (n, d) = (scores.len() as f64, laws.len() as f64);
        let mean = scores.iter().sum::<DVector<f64>>() / n;
        let away: Vec<DVector<f64>> = scores.iter().map(|z| z - &mean).collect();
        let covariance = away.iter().map(|z| z * z.transpose()).sum::<DMatrix<f64>>() / n;
        let rule =
            "the draws must scatter in every input, and no input be a function of the others";
        let root = covariance.cholesky().ok_or((None, rule.to_owned()))?.l();
        let width = pow(4.0 / (n * (d + 2.0)), 1.0 / (d + 4.0));
        let drawn_in = (1.0 - width * width).sqrt();
        let whitened = away.iter().filter_map(|z| root.solve_lower_triangular(z));
        Ok(Self {
            kernels: whitened.map(|w| w * drawn_in).collect(),
            mean,
            root,
            width,
        })
    }

    /// New over old density, but for a common factor, of each sample; 0 at an end of its distribution. Shape: samples × d.
    pub(super) fn ratios(&self, samples: &[Vec<f64>], laws: &[&Distribution]) -> Vec<f64> {
        let one = |values: &Vec<f64>| {
            let scores = values.iter().zip(laws).map(|(v, law)| score(law, *v));
            let scores: Option<Vec<f64>> = scores.collect();
            scores.map_or(0.0, |z| self.ratio(&DVector::from_vec(z)))
        };
        samples.par_iter().map(one).collect()
    }

    fn ratio(&self, z: &DVector<f64>) -> f64 {
        let Some(w) = self.root.solve_lower_triangular(&(z - &self.mean)) else {
            return 0.0;
        };
        let far = 0.5 / (self.width * self.width);
        let density: f64 = (self.kernels.iter())
            .map(|kernel| exp(-far * (&w - kernel).norm_squared()))
            .sum();
        match density > 0.0 {
            true => exp(log(density) + 0.5 * z.norm_squared()),
            false => 0.0,
        }
    }
}

/// Normal score of a value; none at the ends of its distribution.
fn score(law: &Distribution, value: f64) -> Option<f64> {
    let u = law.cdf(value);
    (u > 0.0 && u < 1.0).then(|| normal_quantile(u))
}

/// Largest difference of the distribution functions of weighted samples and of draws. Weights add up to 1.
pub(super) fn distance(samples: &[f64], weights: &[f64], draws: &[f64]) -> f64 {
    let each = 1.0 / draws.len() as f64;
    let of_samples = samples.iter().zip(weights).map(|(x, w)| (*x, *w));
    let mut steps: Vec<(f64, f64)> = of_samples
        .chain(draws.iter().map(|x| (*x, -each)))
        .collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut sum, mut largest) = (0.0_f64, 0.0_f64);
    for equal in steps.chunk_by(|a, b| a.0 == b.0) {
        sum += equal.iter().map(|(_, step)| step).sum::<f64>();
        largest = largest.max(sum.abs());
    }
    largest
}

/// Distance from which on weighted samples do not stand for the draws.
pub(super) fn largest_distance(effective_samples: f64) -> f64 {
    KERNELS + KOLMOGOROV / effective_samples.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Shape;

    /// Draws of a known normal posterior of two correlated scores: the ratio is that of the densities.
    #[test]
    fn the_ratio_is_that_of_normal_densities() {
        let law = |mean, standard_deviation| {
            let shape = Shape::Normal {
                mean,
                standard_deviation,
            };
            Distribution::new(shape, None).unwrap()
        };
        let (laws, standard) = ([law(5.0, 2.0), law(-1.0, 0.5)], law(0.0, 1.0));
        let laws = [&laws[0], &laws[1]];
        // an even cover of the square by the fractional parts of multiples (Roberts' sequence)
        let places = (1..=4000)
            .map(|k| [0.754_877_666, 0.569_840_291].map(|a: f64| (a * f64::from(k)).fract()));
        let (m, s, rho) = ([0.8, -0.5], [0.5, 0.4], 0.6_f64);
        let draws: Vec<Vec<f64>> = places
            .map(|u| {
                let e = u.map(|u| standard.quantile(u));
                let z = [
                    m[0] + s[0] * e[0],
                    m[1] + s[1] * (rho * e[0] + (1.0 - rho * rho).sqrt() * e[1]),
                ];
                vec![5.0 + 2.0 * z[0], -1.0 + 0.5 * z[1]]
            })
            .collect();
        let found = DrawsDensity::of(&draws, &laws).unwrap();
        let log_ratio = |z: [f64; 2]| {
            let e = [0, 1].map(|j| (z[j] - m[j]) / s[j]);
            let inside = e[0] * e[0] - 2.0 * rho * e[0] * e[1] + e[1] * e[1];
            0.5 * (z[0] * z[0] + z[1] * z[1]) - 0.5 * inside / (1.0 - rho * rho)
        };
        let points = [[0.8, -0.5], [1.2, -0.2], [0.3, -0.9], [1.3, -0.6]];
        let values: Vec<Vec<f64>> = points
            .iter()
            .map(|z| vec![5.0 + 2.0 * z[0], -1.0 + 0.5 * z[1]])
            .collect();
        let ratios = found.ratios(&values, &laws);
        for (point, ratio) in points.iter().zip(&ratios) {
            let error = log(ratio / ratios[0]) - (log_ratio(*point) - log_ratio(points[0]));
            assert!(error.abs() < 0.1, "{point:?}: {error}");
        }
    }

    #[test]
    fn distances_are_those_of_the_distribution_functions() {
        let found = distance(&[1.0, 2.0, 3.0], &[0.5, 0.25, 0.25], &[2.0, 3.0]);
        assert!((found - 0.5).abs() < 1e-12, "{found}");
    }
}
