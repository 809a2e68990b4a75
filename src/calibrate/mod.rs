//! Inputs of a study from measured forced responses: their posterior distribution.
//!
//! The prior is what the study states of its inputs. Solved samples shape a surrogate of frequency and amplitude at each measured
//! level ([`surrogate`]), whose error enters the likelihood ([`posterior`]). Ensembles of walkers draw from the posterior ([`chains`]);
//! some of the draws are solved, and where the surrogate is worse there than it was taken for, they shape it, too ([`calibration`]).
//! Start reading at [`calibrate()`].
//!
//! ```no_run
//! use microslip::calibrate::{CalibrationSettings, calibrate};
//! use microslip::study::{OutputFolder, Study};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let study = Study::read("studies/rig-to-margin/two-blades.toml".as_ref())?;
//! let measured = "measured-response.csv".as_ref();
//! let found = calibrate(study, measured, &CalibrationSettings::default(), |stage| println!("{stage:?}"))?;
//! found.write(&OutputFolder::open("posterior".as_ref())?)?;
//! # Ok(())
//! # }
//! ```

pub mod calibration;
pub mod chains;
mod check;
pub mod found;
pub mod observation;
pub mod page;
pub mod posterior;
pub mod predictive;
pub mod prior;
pub mod settings;
mod summary;
pub mod surrogate;
mod warnings;
pub mod write;

pub use calibration::{CalibrationStage, calibrate};
pub use chains::Chains;
pub use found::{Calibrated, CalibratedInput, Calibration};
pub use observation::{Observations, ObservedQuantity};
pub use posterior::Posterior;
pub use prior::Prior;
pub use settings::CalibrationSettings;
pub use surrogate::Surrogates;
