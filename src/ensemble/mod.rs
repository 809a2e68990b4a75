//! Many samples: from inputs to outcomes to files.

mod applied;
pub mod arrow;
pub mod atlas;
pub mod backend;
pub mod columns;
pub mod further_points;
mod mode_search;
pub mod one_at_a_time;
pub mod outcome;
pub mod resume;
pub mod runner;
mod sample;
pub mod store;
pub mod strips;
pub mod table;
#[cfg(feature = "test-functions")]
pub mod test_function;

pub use runner::{Ensemble, SampleSolver, Solved};
pub use strips::Strips;
