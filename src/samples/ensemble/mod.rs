//! Many samples: from inputs to outcomes to files. An example stands at `microslip::study`.

mod applied;
pub mod arrow;
pub mod atlas;
pub mod backend;
pub mod columns;
mod followed_modes;
pub mod further_points;
mod initial_tractions;
mod inverses;
mod lanes;
pub mod memory;
mod mistuned;
pub mod mistuned_disk;
mod mode_search;
pub mod one_at_a_time;
pub mod outcome;
pub mod parts;
pub mod program;
pub mod runner;
mod sample;
pub mod shared;
pub mod stop;
pub mod store;
pub mod strips;
pub mod table;
#[cfg(feature = "test-functions")]
pub mod test_function;
pub mod times;
mod with_inverse;

pub use mistuned_disk::MistunedDisk;
pub use runner::{Known, Solved, SolvedSample};
pub use shared::{Ensemble, SampleSolver};
pub use strips::Strips;
