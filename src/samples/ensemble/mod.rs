//! Many samples: from inputs to outcomes to files.
//!
//! The first samples of a study, solved without writing a file:
//!
//! ```
//! use microslip::study::Study;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # std::env::set_current_dir("../..")?; // to the root of the project
//! let mut study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! study.solver.alert = None; // keep to the harmonics of the study
//! let prepared = study.prepared()?;
//! let mut ensemble = prepared.ensemble(None);
//! ensemble.curve_samples = 0;
//! let outcomes = ensemble.run(2, || {});
//! for outcome in &outcomes {
//!     let peak = outcome.levels[0].peak.expect("a peak");
//!     println!("{:?}: {:.2} Hz by {:?}", outcome.inputs, peak.frequency_hz, peak.route);
//! }
//! assert!(outcomes.iter().all(|outcome| outcome.levels[0].around.curve().is_empty()));
//! // the nominal model has its curve whatever the samples have
//! assert!(!ensemble.nominal().levels[0].around.curve().is_empty());
//! # Ok(())
//! # }
//! ```

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
pub mod mistuned;
mod mode_search;
pub mod one_at_a_time;
pub mod outcome;
pub mod parts;
pub mod program;
pub mod runner;
mod sample;
pub mod stop;
pub mod store;
pub mod strips;
pub mod table;
#[cfg(feature = "test-functions")]
pub mod test_function;
pub mod times;
mod with_inverse;

pub use mistuned::MistunedDisk;
pub use runner::{Ensemble, Known, SampleSolver, Solved, SolvedSample};
pub use strips::Strips;
