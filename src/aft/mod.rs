//! Alternating frequency–time evaluation of contact forces on a batch of harmonic states.

pub mod settings;

pub use settings::{AftSettings, Laps};
