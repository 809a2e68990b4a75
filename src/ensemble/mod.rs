//! Many samples: from inputs to outcomes to files.

mod applied;
pub mod atlas;
pub mod backend;
pub mod kept;
pub mod outcome;
pub mod runner;
mod sample;
pub mod store;

pub use runner::{Ensemble, Solved};
