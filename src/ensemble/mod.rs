//! Many samples: from inputs to outcomes to files.

pub mod atlas;
pub mod backend;
pub mod outcome;
pub mod runner;
mod sample;
pub mod store;

pub use runner::Ensemble;
