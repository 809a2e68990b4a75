//! Microslip: uncertainty quantification of the forced response of friction-damped turbine blades.
//!
//! A study from code: two blades with a friction damper from one's own matrices, 100 samples of an uncertain contact, and the
//! envelope of the resonance frequency.
//!
//! ```
//! use microslip::study::{OutputFolder, RunSettings, Study, run};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let folder = folder.path();
//!
//! let study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! let results = OutputFolder::open(folder)?;
//! let found = run(&study, &results, &RunSettings::default(), |_progress| {})?;
//! for level in &found.summary.levels {
//!     let [low, median, high] = [0, 1, 2].map(|i| level.frequency_hz.quantiles[i].estimate);
//!     println!("level {}: {low:.1} .. {median:.1} .. {high:.1} Hz", level.level);
//!     assert!(level.failed == 0 && low < median && median < high);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! `study` composes all other modules; [`hb`] is where one sample is solved, [`ensemble`] where many are, [`statistics`] and
//! [`report`] what is made of them. The modules, from the ground up, and what each may import stand in
//! `ARCHITECTURE.md`; `tests/architecture.rs` keeps that table true. Numbers are in SI units.

pub mod calibrate;
pub mod error;
pub mod report;
pub mod rig;
pub mod serve;
pub mod study;

pub use error::Error;

#[doc(inline)]
pub use microslip_base::{file, setting, units};
#[doc(inline)]
pub use microslip_identification::identify;
use microslip_pages::page;
#[doc(inline)]
pub use microslip_probability::{special, statistics};
#[doc(inline)]
pub use microslip_readers::{import, record};
#[doc(inline)]
pub use microslip_samples::{ensemble, sampling};
#[doc(inline)]
pub use microslip_solver::{aft, contact, fe, gpu, harmonics, hb, linalg, lockstep, model};
