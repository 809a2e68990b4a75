//! Draws from the posterior, by ensembles of walkers (crate `hammer-and-sample`).
//!
//! A chain is an ensemble of its own, a function of the posterior, the seed and its number: chains run on any number of threads and give
//! the same draws.

use super::posterior::{Posterior, log_prior};
use super::settings::CalibrationSettings;
use crate::sampling::stream::{CALIBRATION, uniform};
use crate::special::{normal_cdf, normal_quantile};
use hammer_and_sample::{DifferentialEvolution, MinChainLen, Mixture, Model, Move, Serial, sample};
use libm::log;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha20Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Draws after the warm-up.
#[derive(Debug, Clone, PartialEq)]
pub struct Chains {
    /// Positions; the walkers of a chain one after the other, from instant to instant. Shape: chains × draws × dimension.
    pub positions: Vec<Vec<Vec<f64>>>,
    /// Walkers of a chain. Their number divides half of the draws.
    pub walkers: usize,
    /// Share of the proposed moves that were taken.
    pub acceptance: f64,
}

/// Draws of the prior among which the start of a walker is chosen.
const CANDIDATES: u64 = 250;
/// Largest distance of a start from the median of the prior, in standard deviations: farther out a surrogate may mean nothing.
const FARTHEST_START: f64 = 2.0;
/// Fewest walkers of a chain; twice as many as unknowns where these are more.
const FEWEST_WALKERS: usize = 20;
/// Moves of a walker between two draws that are kept, per unknown.
const MOVES: usize = 10;
/// Shares of the moves: along a difference with the best length for a normal posterior, along the whole difference, anywhere in the prior.
const SHARES: [usize; 3] = [7, 2, 1];
/// Scatter of the length of a move, relative.
const SCATTER: f64 = 1e-5;

impl Chains {
    /// Draws from `posterior`: as many of each chain as asked for, rounded up to whole instants of all walkers in both halves.
    ///
    /// # Errors
    /// If the density is finite nowhere that chains could start.
    pub fn draw(posterior: &Posterior<'_>, settings: &CalibrationSettings) -> Result<Self, String> {
        let walkers = FEWEST_WALKERS.max(2 * posterior.dimension());
        let starts = starts(posterior, settings.seed, settings.chains * walkers);
        if starts.len() < settings.chains * walkers {
            return Err("the density of the posterior is finite almost nowhere".to_owned());
        }
        let chains = starts.par_chunks(walkers).enumerate();
        let all = chains.map(|(number, starts)| {
            let mut ensemble = Ensemble::start(posterior, settings.seed, number as u64, starts);
            for _ in 0..settings.warm_up.div_ceil(walkers) {
                ensemble.advance();
            }
            ensemble.accepted = 0;
            let instants = 2 * settings.draws.div_ceil(2 * walkers);
            let draws = (0..instants).flat_map(|_| ensemble.advance().to_vec());
            (draws.collect(), ensemble.accepted)
        });
        let all: Vec<(Vec<Vec<f64>>, usize)> = all.collect();
        let (positions, accepted): (Vec<_>, Vec<usize>) = all.into_iter().unzip();
        let draws: usize = positions.iter().map(Vec::len).sum();
        let moves = draws * MOVES * posterior.dimension();
        Ok(Self {
            positions,
            walkers,
            acceptance: accepted.iter().sum::<usize>() as f64 / moves as f64,
        })
    }

    /// One number of each draw, as diagnostics of chains want it: walker after walker, so that what follows another is the next draw of
    /// the same walker; the first half of the time before the second. Shape: chains × draws.
    pub fn each(&self, number: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
        let of_chain = |chain: &Vec<Vec<f64>>| {
            let halves = chain.chunks(chain.len() / 2);
            let of_half = |half: &[Vec<f64>]| {
                let walker = |w: usize| half.iter().skip(w).step_by(self.walkers);
                let all = (0..self.walkers).flat_map(walker);
                all.map(|position| number(position)).collect::<Vec<f64>>()
            };
            halves.flat_map(of_half).collect()
        };
        self.positions.iter().map(of_chain).collect()
    }

    /// Draws of all chains, one chain after the other.
    pub fn all(&self) -> impl Iterator<Item = &[f64]> {
        self.positions.iter().flatten().map(Vec::as_slice)
    }
}

/// Walkers that propose moves along the differences between others: such moves have the posterior's shape, however narrow it is in some
/// direction. Every fifth goes the whole difference, so that walkers change between combinations of inputs that both have weight, and
/// every tenth anywhere in the prior, so that they find such a combination where none of them began.
///
/// Source: ter Braak 2006, Stat. Comput. 16, 239–249; Nelson, Ford & Payne 2014, Astrophys. J. Suppl. 210, 11.
struct Ensemble<'a> {
    posterior: &'a Posterior<'a>,
    moves: Mixture<usize, (DifferentialEvolution, DifferentialEvolution, PriorDraw)>,
    positions: Vec<Vec<f64>>,
    generators: Vec<ChaCha20Rng>,
    accepted: usize,
}

impl<'a> Ensemble<'a> {
    fn start(posterior: &'a Posterior<'a>, seed: u64, chain: u64, starts: &[Vec<f64>]) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        // apart from the numbers of samples, which have the rest of the key 0
        key[8] = 1;
        key[16..24].copy_from_slice(&chain.to_le_bytes());
        let generator = |walker: u64| {
            let mut generator = ChaCha20Rng::from_seed(key);
            generator.set_stream(walker);
            generator
        };
        let [of_best, of_whole, of_prior] = SHARES;
        let best = 2.38 / (2.0 * posterior.dimension() as f64).sqrt();
        let local = DifferentialEvolution::new(best, SCATTER);
        let whole = DifferentialEvolution::new(1.0, SCATTER);
        Self {
            posterior,
            moves: Mixture::from(((local, of_best), (whole, of_whole), (PriorDraw, of_prior))),
            positions: starts.to_vec(),
            generators: (0..starts.len() as u64).map(generator).collect(),
            accepted: 0,
        }
    }

    /// Moves all walkers until their next draws are nearly independent of the last; these.
    fn advance(&mut self) -> &[Vec<f64>] {
        let walkers = self.positions.len();
        let moves = walkers * MOVES * self.posterior.dimension();
        let places = self.positions.drain(..).zip(&mut self.generators);
        let moves = MinChainLen(moves);
        let (mut passed, accepted) = sample(self.posterior, &self.moves, places, moves, Serial);
        self.accepted += accepted;
        self.positions = passed.split_off(passed.len() - walkers);
        &self.positions
    }
}

/// A move to a draw of the prior, wherever the walker is.
///
/// Source: independence chain of Tierney 1994, Ann. Stat. 22, 1701–1762.
struct PriorDraw;

impl Move<Vec<f64>> for PriorDraw {
    fn propose<'a, O, R>(&self, this: &'a Vec<f64>, _: O, random: &mut R) -> (Vec<f64>, f64)
    where
        O: FnMut(&mut R) -> &'a Vec<f64>,
        R: Rng,
    {
        let new: Vec<f64> = this.iter().map(|_| StandardNormal.sample(random)).collect();
        let correction = log_prior(this) - log_prior(&new);
        (new, correction)
    }
}

impl Model for Posterior<'_> {
    type Params = Vec<f64>;

    fn log_prob(&self, position: &Vec<f64>) -> f64 {
        self.log_density(position)
    }
}

/// Where `wanted` walkers start: draws of the prior, taken without replacement by their likelihood. So a mode of the posterior has
/// walkers by its weight, not by the region from which a walker falls into it.
///
/// Source: Efraimidis & Spirakis 2006, Inf. Process. Lett. 97, 181–185, in logarithms.
fn starts(posterior: &Posterior<'_>, seed: u64, wanted: usize) -> Vec<Vec<f64>> {
    let unknowns = posterior.dimension();
    // no two walkers may have a coordinate in common: moves along differences would never change it
    let [low, high] = [-FARTHEST_START, FARTHEST_START].map(normal_cdf);
    let draw = |index: u64| {
        let number = |dimension| uniform(seed, index, dimension);
        let z = |dimension| normal_quantile(low + (high - low) * number(dimension));
        let start: Vec<f64> = (CALIBRATION..).take(unknowns).map(z).collect();
        let likelihood = posterior.log_density(&start) - log_prior(&start);
        let drawn = CALIBRATION + unknowns as u32;
        (likelihood - log(-log(number(drawn))), start)
    };
    let candidates = CANDIDATES * wanted as u64;
    let mut drawn: Vec<(f64, Vec<f64>)> = (0..candidates).into_par_iter().map(draw).collect();
    drawn.retain(|(key, _)| key.is_finite());
    drawn.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let taken = drawn.into_iter().take(wanted);
    taken.map(|(_, start)| start).collect()
}
