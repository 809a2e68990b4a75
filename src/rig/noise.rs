//! Random numbers of a rig: a stream for each purpose of each test, so that a change of one leaves the others as they are.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha20Rng;
use rand_distr::{Distribution, StandardNormal};

/// What a stream of random numbers is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Purpose {
    /// Scatter between specimens; the index is the specimen's.
    Specimen = 1,
    /// Pressure regulator.
    Regulator = 2,
    /// Offset and drifts of the instruments.
    Instruments = 3,
    /// Noise of the signals.
    Signals = 4,
    /// Errors of the resonances.
    Response = 5,
    /// Gains of the force cells.
    Gains = 6,
    /// Gain of the force cell of configuration b.
    ForceOfResponse = 7,
    /// Where the frequencies of a step-sine lie beside the resonance.
    Steps = 8,
}

/// A stream of numbers.
#[derive(Debug, Clone)]
pub struct Noise(ChaCha20Rng);

impl Noise {
    /// The stream of a purpose and an index. Key of the generator: the seed as 8 little-endian bytes, the word "rig", the
    /// purpose as a byte, zeros; nonce: the index. No stream of `sampling` has such a key.
    #[must_use]
    pub fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..11].copy_from_slice(b"rig");
        key[11] = purpose as u8;
        let mut generator = ChaCha20Rng::from_seed(key);
        generator.set_stream(index);
        Self(generator)
    }

    /// A standard normal number.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A number from 0 to below 1, evenly distributed.
    pub fn even(&mut self) -> f64 {
        self.0.random()
    }
}

#[cfg(test)]
mod unit_tests {
    use super::*;

    #[test]
    fn streams_differ_by_seed_purpose_and_index_and_repeat() {
        let first = |seed, purpose, index| Noise::new(seed, purpose, index).normal();
        let one = first(1, Purpose::Signals, 0);
        assert_eq!(one, first(1, Purpose::Signals, 0), "the same stream");
        let others = [
            first(2, Purpose::Signals, 0),
            first(1, Purpose::Regulator, 0),
            first(1, Purpose::Signals, 1),
        ];
        assert!(others.iter().all(|other| *other != one), "{others:?} {one}");
    }
}
