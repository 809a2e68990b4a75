//! Rows of a pick-freeze design: two independent points A and B, and A with one coordinate of B at a time.
//!
//! A and B are the two halves of ONE point in twice as many coordinates. Two points of one sequence in the coordinates
//! of the inputs alone depend on each other, and so would the indices (`statistics::sobol_index`).

use super::sobol::{MOST_DIMENSIONS, Sobol};
use super::stream::SCRAMBLE;

/// Places 0 and 1 of a row: A and B. Those from 2 on are mixed.
pub(super) const INDEPENDENT: u64 = 2;
/// Inputs at most: each takes two coordinates.
pub const MOST_INPUTS: usize = MOST_DIMENSIONS / 2;

/// Scrambled Sobol' points in rows of `inputs` + 2 samples.
#[derive(Debug, Clone, PartialEq)]
pub struct PickFreeze {
    inputs: usize,
    /// In 2 · `inputs` coordinates: those of A, then those of B.
    sequence: Sobol,
}

impl PickFreeze {
    /// A design of at most [`MOST_INPUTS`] inputs.
    #[must_use]
    pub fn new(inputs: usize) -> Self {
        Self {
            inputs,
            sequence: Sobol::new(2 * inputs),
        }
    }

    /// Samples per row.
    #[must_use]
    pub fn row(&self) -> u64 {
        self.inputs as u64 + INDEPENDENT
    }

    /// Place of sample `i` in its row: 0 = A, 1 = B, 2 + j = A with coordinate j of B.
    #[must_use]
    pub fn place(&self, i: u64) -> u64 {
        i % self.row()
    }

    /// Uniform numbers of sample `i`. Shape: `[inputs]`.
    #[must_use]
    pub fn point(&self, seed: u64, i: u64) -> Vec<f64> {
        let mut a = (self.sequence).scrambled(seed, 0, SCRAMBLE, i / self.row());
        let b = a.split_off(self.inputs);
        at_place(a, b, self.place(i))
    }
}

/// Point at a place of the row of A and B: A itself, B itself, then A with coordinate 0, 1, … of B.
///
/// Shape: `a` and `b` have one entry per input; `place` is less than their number + 2.
#[must_use]
pub fn at_place(mut a: Vec<f64>, b: Vec<f64>, place: u64) -> Vec<f64> {
    match place {
        0 => a,
        1 => b,
        mixed => {
            let j = (mixed - INDEPENDENT) as usize;
            a[j] = b[j];
            a
        }
    }
}

/// Whether the sample at a place of its row is a draw of its own, A or B, and not mixed from two.
pub(super) fn is_independent(place: u64) -> bool {
    place < INDEPENDENT
}
