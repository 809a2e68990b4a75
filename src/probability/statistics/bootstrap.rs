//! Resampling with counter-based random numbers: replicate r is a function of the seed and r alone.

use super::observed::Sorted;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Settings of a resampling interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Bootstrap {
    /// Seed of the replicates.
    pub seed: u64,
    /// Number of replicates; a few hundred for 95 %.
    pub replicates: u32,
    /// Confidence of the interval, in (0, 1).
    pub confidence: f64,
}

impl Bootstrap {
    /// The generator of one replicate: `ChaCha8` with the seed as key and the replicate as nonce.
    fn generator(&self, replicate: u32) -> ChaCha8Rng {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(u64::from(replicate));
        generator
    }

    /// n indices below n, drawn with replacement.
    #[must_use]
    pub fn resample(&self, replicate: u32, n: usize) -> Vec<usize> {
        let mut generator = self.generator(replicate);
        (0..n).map(|_| below(&mut generator, n)).collect()
    }

    /// The numbers below n in random order.
    #[must_use]
    pub fn permutation(&self, replicate: u32, n: usize) -> Vec<usize> {
        let mut generator = self.generator(replicate);
        let mut indices: Vec<usize> = (0..n).collect();
        for i in 0..n {
            let j = i + below(&mut generator, n - i);
            indices.swap(i, j);
        }
        indices
    }

    /// Interval between the (1 ∓ confidence)/2 quantiles of the replicates of a statistic; `None` if one is not finite.
    pub(super) fn percentiles(&self, statistic: impl Fn(u32) -> f64) -> Option<(f64, f64)> {
        let values = Sorted::finite((0..self.replicates).map(statistic));
        let n = values.values().len();
        if n == 0 || n < self.replicates as usize {
            return None;
        }
        let tail = (1.0 - self.confidence) / 2.0;
        // Position p (n + 1), as for order statistics of an independent further replicate.
        let rank = ((tail * (n + 1) as f64).round() as usize).clamp(1, n);
        let [lower, upper] = [rank, n + 1 - rank].map(|rank| values.order_statistic(rank));
        Some((lower?, upper?))
    }
}

/// A number below n by the high word of a 64-bit product; no rejection, so one draw per number.
fn below(generator: &mut ChaCha8Rng, n: usize) -> usize {
    ((u128::from(generator.next_u64()) * n as u128) >> 64) as usize
}
