//! The linear structure: coordinates, symmetry, modes, response at one frequency.

pub mod compliance;
mod condensed;
pub mod fold;
pub mod linear;
pub mod resonance;
pub(in crate::hb) mod springs;
pub mod waves;
