//! Contact parameters from measured hysteresis loops, as distributions for a study.

pub mod identified;

pub use identified::{Identified, IdentifiedInput};
