//! Contact parameters from measured hysteresis loops, as distributions for a study.

pub mod identified;
pub mod read;

pub use identified::{ContactParameter, Identified, IdentifiedInput};
