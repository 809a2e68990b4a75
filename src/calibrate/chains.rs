//! Draws from the posterior, by chains of the no-U-turn sampler (`nuts`).
//!
//! Chain c is a function of the posterior, the seed and c: chains run on any number of threads and give the same draws.

use super::nuts::Chain;
use super::posterior::Posterior;
use super::settings::CalibrationSettings;
use crate::sampling::stream::{CALIBRATION, uniform};
use crate::special::normal_quantile;
use libm::log;
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

/// Draws of the prior among which the starts are chosen.
const CANDIDATES: u64 = 20_000;
/// Largest distance of a start from the median of the prior, in standard deviations: farther out a surrogate may mean nothing.
const FARTHEST_START: f64 = 2.0;

impl Chains {
    /// Draws from `posterior`.
    ///
    /// # Errors
    /// If the density is finite nowhere that chains could start.
    pub fn draw(posterior: &Posterior<'_>, settings: &CalibrationSettings) -> Result<Self, String> {
        let starts = starts(posterior, settings);
        if starts.len() < settings.chains {
            return Err("the density of the posterior is finite almost nowhere".to_owned());
        }
        let chains = (starts.into_par_iter()).enumerate();
        let all = chains.map(|(chain, start)| one(posterior, settings, chain, start));
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
    chain: usize,
    start: Vec<f64>,
) -> Result<(Vec<Vec<f64>>, usize), String> {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&settings.seed.to_le_bytes());
    // apart from the numbers of samples, which have the rest of the key 0
    key[8] = 1;
    let mut generator = ChaCha20Rng::from_seed(key);
    generator.set_stream(chain as u64);
    let density =
        |position: &[f64], gradient: &mut [f64]| posterior.log_density(position, gradient);
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

/// Where chains start: draws of the prior, taken without replacement by their likelihood. So a mode of the posterior has chains by its weight,
/// not by the region from which a path falls into it. Standard deviations begin at their scales.
///
/// Source: Efraimidis & Spirakis 2006, Inf. Process. Lett. 97, 181–185, in logarithms.
fn starts(posterior: &Posterior<'_>, settings: &CalibrationSettings) -> Vec<Vec<f64>> {
    let scores = posterior.scores();
    let draw = |index: u64| {
        let number = |dimension| uniform(settings.seed, index, dimension);
        let z =
            |dimension| normal_quantile(number(dimension)).clamp(-FARTHEST_START, FARTHEST_START);
        let mut start: Vec<f64> = (CALIBRATION..).take(scores).map(z).collect();
        let prior = -0.5 * start.iter().map(|z| z * z).sum::<f64>();
        start.resize(posterior.dimension(), 0.0);
        let mut gradient = vec![0.0; start.len()];
        let likelihood = posterior.log_density(&start, &mut gradient) - prior;
        let drawn = CALIBRATION + scores as u32;
        (likelihood - log(-log(number(drawn))), start)
    };
    let mut drawn: Vec<(f64, Vec<f64>)> = (0..CANDIDATES).into_par_iter().map(draw).collect();
    drawn.retain(|(key, _)| key.is_finite());
    drawn.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let taken = drawn.into_iter().take(settings.chains);
    taken.map(|(_, start)| start).collect()
}
