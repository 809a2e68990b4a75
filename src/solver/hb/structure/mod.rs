//! The linear structure: coordinates, symmetry, modes, response at one frequency.

pub mod compliance;
mod condensed;
pub mod fold;
pub mod linear;
pub mod mistuned;
pub mod resonance;
mod ring;
pub(in crate::hb) mod springs;
pub mod waves;
