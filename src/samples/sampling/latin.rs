//! Latin hypercube: every input takes one value from each of n strata of equal probability.
//!
//! The strata are the ranks of Monte Carlo numbers (Stein 1987), put in an order that gives their normal scores the
//! wanted correlation (Iman & Conover 1982): where none is wanted, the chance correlations go. Every sample depends on
//! the number of samples, so a hypercube cannot grow.

use super::correlation::cholesky;
use super::stream::{JITTER, uniform};
use crate::special::normal_quantile;

/// Times that the correlation is corrected.
const PASSES: usize = 3;

/// Strata of every sample and input.
#[derive(Debug, Clone, PartialEq)]
pub struct LatinHypercube {
    /// Shape: inputs × samples.
    strata: Vec<Vec<u32>>,
    dimensions: Vec<u32>,
}

impl LatinHypercube {
    /// A hypercube of `samples` points in the inputs with these dimensions of the stream.
    ///
    /// `correlation` is that of the normal scores (shape: inputs square, positive definite). `None` if there are no more
    /// samples than inputs, or chance has made two columns dependent: then the correlation cannot be controlled.
    #[must_use]
    pub fn new(
        seed: u64,
        samples: u32,
        dimensions: &[u32],
        correlation: &[Vec<f64>],
    ) -> Option<Self> {
        let mut strata: Vec<Vec<u32>> = dimensions
            .iter()
            .map(|&dimension| {
                let numbers: Vec<f64> = (0..samples)
                    .map(|i| uniform(seed, u64::from(i), dimension))
                    .collect();
                ranks(&numbers)
            })
            .collect();
        let wanted = cholesky(correlation).ok()?;
        // taking ranks moves the correlation a little: again from there
        for _ in 0..PASSES {
            let scores: Vec<Vec<f64>> = strata.iter().map(|column| normal_scores(column)).collect();
            let found = cholesky(&correlations(&scores)).ok()?;
            let columns = reordered(&scores, &found, &wanted);
            strata = columns.iter().map(|column| ranks(column)).collect();
        }
        Some(Self {
            strata,
            dimensions: dimensions.to_vec(),
        })
    }

    /// Uniform numbers of sample `i`, below the number of samples, in (0, 1). Shape: `[inputs]`.
    #[must_use]
    pub fn point(&self, seed: u64, i: u64) -> Vec<f64> {
        let place = usize::try_from(i).unwrap_or(usize::MAX);
        (self.strata.iter().zip(&self.dimensions))
            .map(|(strata, dimension)| {
                let within = uniform(seed, i, JITTER + dimension);
                let u = (f64::from(strata[place]) + within) / strata.len() as f64;
                u.min(1.0 - 0.5 * f64::EPSILON)
            })
            .collect()
    }
}

/// Rank of every value, 0-based; equal values by their places.
fn ranks(values: &[f64]) -> Vec<u32> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
    let mut ranks = vec![0; values.len()];
    (0..).zip(order).for_each(|(rank, i)| ranks[i] = rank);
    ranks
}

/// Φ⁻¹ of the middle of each stratum (van der Waerden's scores).
fn normal_scores(strata: &[u32]) -> Vec<f64> {
    let n = strata.len() as f64;
    strata
        .iter()
        .map(|&stratum| normal_quantile((f64::from(stratum) + 0.5) / n))
        .collect()
}

/// Correlations of columns with mean 0 and equal variances.
fn correlations(scores: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    scores
        .iter()
        .map(|a| {
            let of_a = product(a, a);
            scores.iter().map(|b| product(a, b) / of_a).collect()
        })
        .collect()
}

/// The columns S (P Q⁻¹)ᵀ with the correlation P Pᵀ, from S with the correlation Q Qᵀ.
fn reordered(scores: &[Vec<f64>], found: &[Vec<f64>], wanted: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (inputs, samples) = (scores.len(), scores.first().map_or(0, Vec::len));
    let mut columns = vec![vec![0.0; samples]; inputs];
    for i in 0..samples {
        // independent scores by forward substitution
        let mut free = vec![0.0; inputs];
        for j in 0..inputs {
            let known: f64 = (0..j).map(|k| found[j][k] * free[k]).sum();
            free[j] = (scores[j][i] - known) / found[j][j];
        }
        for (column, row) in columns.iter_mut().zip(wanted) {
            column[i] = row.iter().zip(&free).map(|(p, x)| p * x).sum();
        }
    }
    columns
}
