//! Sobol' points with nested uniform scrambling, addressed by their index.
//!
//! Order and direction numbers are those of Joe & Kuo 2008 in Gray code order, as in `SciPy`. The scrambling is Owen's
//! (Owen 1998). Bit b of a coordinate is flipped by a hash of the replicate's key, the dimension and the b bits above it.
//! So every prefix of 2ᵐ points keeps one point in each of its elementary intervals, and every point alone is uniform.

use super::joe_kuo::DIRECTIONS;
use super::stream::{BITS, unit, word};

/// Coordinates that a point can have at most.
pub const MOST_DIMENSIONS: usize = DIRECTIONS.len();

/// Direction numbers of the first so many dimensions.
#[derive(Debug, Clone, PartialEq)]
pub struct Sobol {
    /// v_k as integers below 2⁵². Shape: dimensions of `[BITS]`.
    directions: Vec<[u64; BITS as usize]>,
}

impl Sobol {
    /// The sequence in `dimensions` coordinates, at most [`MOST_DIMENSIONS`].
    #[must_use]
    pub fn new(dimensions: usize) -> Self {
        let directions = DIRECTIONS[..dimensions]
            .iter()
            .map(|(polynomial, start)| direction_numbers(*polynomial, start))
            .collect();
        Self { directions }
    }

    /// Coordinate `dimension` of point `index` (below 2⁵²), not scrambled: in [0, 1), point 0 is 0.
    #[must_use]
    pub fn plain(&self, index: u64, dimension: usize) -> f64 {
        self.digits(index, dimension) as f64 / (1_u64 << BITS) as f64
    }

    /// Coordinates of point `index` (below 2⁵²), scrambled by the keys that `seed`, `replicate` and `block`, the first of
    /// their dimensions in the stream, give. In the open interval (0, 1); shape `[dimensions]`.
    #[must_use]
    pub fn scrambled(&self, seed: u64, replicate: u64, block: u32, index: u64) -> Vec<f64> {
        (0..self.directions.len())
            .zip(block..)
            .map(|(dimension, place)| {
                let key = word(seed, replicate, place);
                unit(scramble(self.digits(index, dimension), key))
            })
            .collect()
    }

    /// The first 52 binary digits of a coordinate, as an integer.
    fn digits(&self, index: u64, dimension: usize) -> u64 {
        let gray = index ^ (index >> 1);
        let numbers = self.directions[dimension].iter().enumerate();
        numbers
            .filter(|(k, _)| gray >> k & 1 == 1)
            .fold(0, |x, (_, v)| x ^ v)
    }
}

/// v_k = m_k 2^(52 − k), with m_k by the recurrence of the primitive polynomial (Bratley & Fox 1988, eq. 2).
fn direction_numbers(polynomial: u64, start: &[u64]) -> [u64; BITS as usize] {
    let degree = polynomial.ilog2() as usize;
    let mut m = [1; BITS as usize];
    m[..start.len()].copy_from_slice(start);
    for k in start.len()..if degree == 0 { 0 } else { BITS as usize } {
        m[k] = m[k - degree] ^ (m[k - degree] << degree);
        for i in (1..degree).filter(|i| polynomial >> (degree - i) & 1 == 1) {
            m[k] ^= m[k - i] << i;
        }
    }
    let mut v = [0; BITS as usize];
    for (k, (v, m)) in v.iter_mut().zip(m).enumerate() {
        *v = m << (BITS as usize - 1 - k);
    }
    v
}

/// Nested uniform scrambling of 52 digits: each is flipped by a hash of those above it.
fn scramble(digits: u64, key: u64) -> u64 {
    (0..BITS).fold(0, |done, depth| {
        let above = digits >> (BITS - depth);
        // the leading 1 tells nodes of different depths apart
        let node = (1 << depth) | above;
        let flip = mix(key ^ mix(node)) & 1;
        let digit = digits >> (BITS - 1 - depth) & 1;
        done << 1 | (digit ^ flip)
    })
}

/// Output of `SplitMix64` (Steele, Lea & Flood 2014) at counter `x`: a bijection with full avalanche.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
