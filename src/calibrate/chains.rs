//! Draws from the posterior, by chains of the no-U-turn sampler (`nuts`).
//!
//! Chain c is a function of the posterior, the seed and c: chains run on any number of threads and give the same draws.

use super::nuts::Chain;
use super::posterior::Posterior;
use super::settings::CalibrationSettings;
use crate::sampling::stream::{CALIBRATION, uniform};
use crate::special::normal_quantile;
use rand::SeedableRng;
use rand_chacha::ChaCha20Rng;
use rayon::prelude::*;

/// Draws after the warm-up.
#[derive(Debug, Clone, PartialEq)]
pub struct Chains {
    /// Positions. Shape: chains × draws × dimension.
    pub positions: Vec<Vec<Vec<f64>>>,
    /// Draws whose path left the region where its steps are accurate.
    pub divergences: usize,
}

/// Largest distance of a start from the median of the prior, in standard deviations: farther out a surrogate may mean nothing.
const FARTHEST_START: f64 = 2.0;

impl Chains {
    /// Draws from `posterior`.
    ///
    /// # Errors
    /// If the density is not finite where a chain starts.
    pub fn draw(posterior: &Posterior<'_>, settings: &CalibrationSettings) -> Result<Self, String> {
        let chains = 0..settings.chains as u64;
        let all = chains
            .into_par_iter()
            .map(|chain| one(posterior, settings, chain));
        let all: Vec<_> = all.collect::<Result<_, _>>()?;
        let (positions, divergences): (Vec<_>, Vec<usize>) = all.into_iter().unzip();
        Ok(Self {
            positions,
            divergences: divergences.iter().sum(),
        })
    }

    /// One number of each draw. Shape: chains × draws.
    pub fn each(&self, number: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
        let chain = |chain: &Vec<Vec<f64>>| chain.iter().map(|p| number(p)).collect();
        self.positions.iter().map(chain).collect()
    }

    /// Draws of all chains, one chain after the other.
    pub fn all(&self) -> impl Iterator<Item = &[f64]> {
        self.positions.iter().flatten().map(Vec::as_slice)
    }
}

/// Positions of one chain, and its divergences.
fn one(
    posterior: &Posterior<'_>,
    settings: &CalibrationSettings,
    chain: u64,
) -> Result<(Vec<Vec<f64>>, usize), String> {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&settings.seed.to_le_bytes());
    // apart from the numbers of samples, which have the rest of the key 0
    key[8] = 1;
    let mut generator = ChaCha20Rng::from_seed(key);
    generator.set_stream(chain);
    let density =
        |position: &[f64], gradient: &mut [f64]| posterior.log_density(position, gradient);
    let start = start(posterior, settings.seed, chain);
    let sampler = Chain::start(&density, start, generator);
    let mut sampler = sampler.ok_or_else(|| {
        format!("the density of the posterior is not finite where chain {chain} starts")
    })?;
    sampler.warm_up(settings.warm_up);
    let (mut positions, mut divergences) = (Vec::new(), 0);
    for _ in 0..settings.draws {
        let (position, diverged) = sampler.draw();
        positions.push(position.to_vec());
        divergences += usize::from(diverged);
    }
    Ok((positions, divergences))
}

/// A draw of the prior, so that chains begin farther apart than they end; standard deviations begin at their scales.
fn start(posterior: &Posterior<'_>, seed: u64, chain: u64) -> Vec<f64> {
    let scores = (CALIBRATION..).take(posterior.scores()).map(|dimension| {
        let z = normal_quantile(uniform(seed, chain, dimension));
        z.clamp(-FARTHEST_START, FARTHEST_START)
    });
    let mut start: Vec<f64> = scores.collect();
    start.resize(posterior.dimension(), 0.0);
    start
}
