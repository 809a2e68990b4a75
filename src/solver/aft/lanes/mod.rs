//! A few states at a time, as lanes of vectors: samples, motions as bits, sums over motions.

pub(super) mod lane;
pub(super) mod masks;
pub(super) mod motions;
pub(super) mod sample;
pub(super) mod workspace;
