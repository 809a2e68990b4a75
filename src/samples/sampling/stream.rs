//! Counter-based uniform numbers: u is a pure function of (seed, sample, dimension).
//!
//! Contract (a change of it changes every study): the `ChaCha20` block function with a 64-bit nonce [Bernstein
//! 2008]; key = the seed as 8 little-endian bytes followed by 24 zero bytes; nonce = the sample's index; the
//! number x of dimension j is the little-endian 64-bit word j of the key stream; u = (⌊x / 2¹²⌋ + ½) / 2⁵².
//!
//! Dimensions below 2¹⁶ are those of the inputs in a Monte Carlo design; the ones above are taken in blocks of 2¹⁶ by
//! what other designs need. These are the place within a stratum of a Latin hypercube, the keys that scramble Sobol' points,
//! those of the outer points of a nested design, the points at which a surrogate is evaluated, starts of Markov chains, and fields that an input
//! numbers.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha20Rng;

/// Uniform number of one sample and dimension, in the open interval (0, 1), with 52 random bits.
#[must_use]
pub fn uniform(seed: u64, sample: u64, dimension: u32) -> f64 {
    unit(word(seed, sample, dimension) >> (64 - BITS))
}

/// Bits of a uniform number. 52 and not 53, because (2⁵³ − ½) / 2⁵³ rounds to 1.
pub(super) const BITS: u32 = 52;

/// First dimension of the numbers that place a sample of a Latin hypercube within its stratum.
pub(super) const JITTER: u32 = 1 << 16;
/// First dimension of the keys that scramble a sequence of points; the sample is the replicate.
pub(super) const SCRAMBLE: u32 = 2 << 16;
/// The same for the outer points of a nested design.
pub(super) const OUTER: u32 = 3 << 16;
/// First dimension of the points at which a surrogate is evaluated.
pub const SURROGATE: u32 = 4 << 16;
/// First dimension of the places where the chains of a calibration may start; the sample is the place.
pub const CALIBRATION: u32 = 5 << 16;
/// First dimension of the initial tractions of a contact pair, the sample; the seed are the bits of the input.
pub const INITIAL_TRACTION: u32 = 6 << 16;

/// Middle of cell `x` of the 2⁵² cells of (0, 1).
pub(super) fn unit(x: u64) -> f64 {
    (x as f64 + 0.5) / (1_u64 << BITS) as f64
}

/// 64 random bits of one sample and dimension.
pub(super) fn word(seed: u64, sample: u64, dimension: u32) -> u64 {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    let mut generator = ChaCha20Rng::from_seed(key);
    generator.set_stream(sample);
    generator.set_word_pos(2 * u128::from(dimension));
    generator.next_u64()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Key 0, nonce 0: the key stream starts 76 b8 e0 ad a0 f1 3d 90 40 5d 6a e5 53 86 bd 28 (RFC 8439, A.1, vector 1).
    ///
    /// Seen to fail with `dimension` instead of `2 * dimension` as the word position.
    #[test]
    fn known_answers_of_the_published_key_stream() {
        let expected = |x: u64| ((x >> 12) as f64 + 0.5) / 2_f64.powi(52);
        assert_eq!(uniform(0, 0, 0), expected(0x903d_f1a0_ade0_b876));
        assert_eq!(uniform(0, 0, 1), expected(0x28bd_8653_e56a_5d40));
    }

    /// Computed apart, from the published description of the cipher in exact integers.
    ///
    /// Seen to fail with the seed as the nonce.
    #[test]
    fn known_answers_of_seed_sample_and_dimension() {
        assert_eq!(uniform(1, 0, 0), 0.574_492_268_609_940_2);
        assert_eq!(uniform(1, 1, 0), 0.197_760_153_563_706_7);
        assert_eq!(uniform(20_260, 7, 3), 0.385_012_414_076_606_6);
        assert_eq!(uniform(5, 1 << 40, 11), 0.028_014_949_497_195_185);
    }

    #[test]
    fn open_interval_at_both_ends() {
        let end = |x: u64| ((x >> 12) as f64 + 0.5) / (1_u64 << 52) as f64;
        assert!(end(0) > 0.0);
        assert!(end(u64::MAX) < 1.0);
    }
}
