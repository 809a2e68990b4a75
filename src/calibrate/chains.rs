//! Draws from the posterior: chains of the no-U-turn sampler of the crate `nuts-rs` (Hoffman & Gelman, J. Mach. Learn. Res. 15 (2014)
//! 1593–1623), with its adaptation of step and mass matrix during the warm-up.
//!
//! Chain c is a function of the posterior, the seed and c: chains run on any number of threads and give the same draws.

use std::collections::HashMap;

use super::posterior::Posterior;
use super::settings::CalibrationSettings;
use crate::sampling::stream::{CALIBRATION, uniform};
use crate::special::normal_quantile;
use nuts_rs::{
    Chain, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings,
};
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

/// The density as the sampler asks for it.
struct Density<'a>(&'a Posterior<'a>);

/// A density that is no number.
#[derive(Debug, thiserror::Error)]
#[error("the density is not finite")]
struct NotFinite;

impl LogpError for NotFinite {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl HasDims for Density<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        let dimension = self.0.dimension() as u64;
        HashMap::from([("unconstrained_parameter".to_owned(), dimension)])
    }
}

impl CpuLogpFunc for Density<'_> {
    type LogpError = NotFinite;
    type FlowParameters = ();
    type ExpandedVector = ();

    fn dim(&self) -> usize {
        self.0.dimension()
    }

    fn logp(&mut self, position: &[f64], gradient: &mut [f64]) -> Result<f64, NotFinite> {
        let density = self.0.log_density(position, gradient);
        let finite = density.is_finite() && gradient.iter().all(|g| g.is_finite());
        finite.then_some(density).ok_or(NotFinite)
    }

    fn expand_vector<R: rand::Rng + ?Sized>(
        &mut self,
        _: &mut R,
        _: &[f64],
    ) -> Result<(), CpuMathError> {
        Ok(())
    }
}

impl Chains {
    /// Draws from `posterior`.
    ///
    /// # Errors
    /// Why the sampler cannot go on, in its words.
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
    let mut generator = ChaCha20Rng::from_seed(key);
    generator.set_stream(chain);
    let mut of_sampler = DiagNutsSettings::default();
    of_sampler.num_tune = settings.warm_up as u64;
    of_sampler.num_draws = settings.draws as u64;
    let math = CpuMath::new(Density(posterior));
    let mut sampler = of_sampler.new_chain(chain, math, &mut generator);
    let in_words = |error: String| format!("chain {chain} cannot go on: {error}");
    let start = start(posterior, settings.seed, chain);
    sampler
        .set_position(&start)
        .map_err(|error| in_words(error.to_string()))?;
    let (mut positions, mut divergences) = (Vec::new(), 0);
    for i in 0..settings.warm_up + settings.draws {
        let drawn = sampler.draw();
        let (position, progress) = drawn.map_err(|error| in_words(error.to_string()))?;
        if i >= settings.warm_up {
            positions.push(position.to_vec());
            divergences += usize::from(progress.diverging);
        }
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
