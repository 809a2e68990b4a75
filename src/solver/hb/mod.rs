//! Multi-harmonic balance with coupled static and dynamic equations.
//!
//! A [`LinearModel`] (once per study) and contact parameters (once per sample) make a [`Problem`]; a [`Balance`] is
//! that problem on a harmonic set. Start reading at `equations`, then `newton`, `peak`.
//!
//! The peaks of two lumped blades and their damper at a small and a large excitation level:
//!
//! ```
//! use microslip::contact::FrictionLaw;
//! use microslip::hb::peak::{search::PeakSettings, track::track_peaks};
//! use microslip::hb::structure::resonance::Band;
//! use microslip::hb::{LinearModel, Problem, Status};
//! use microslip::study::Study;
//! use microslip::units::{hz_to_rad_s, rad_s_to_hz};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # std::env::set_current_dir("../..")?; // to the root of the project
//! let mut study = Study::read("studies/own-matrices/study.toml".as_ref())?;
//! study.solver.alert = None; // keep to the harmonics of the study
//! let model = study.build_model()?;
//! let linear = LinearModel::new(&model.reduced)?;
//! let problem = Problem::new(&linear, model.contacts, 1.0, study.solver.anchor)?;
//! let band = Band { low: hz_to_rad_s(300.0), high: hz_to_rad_s(400.0) };
//! let search = PeakSettings { band, frequency_tolerance: 1e-9 };
//! for peak in track_peaks(&problem, &study.solver, search, &study.levels)? {
//!     assert_eq!(peak.status, Status::Converged);
//!     let solution = peak.solution.expect("converged");
//!     println!("{:.2} Hz, {:.2e} m", rad_s_to_hz(solution.omega), solution.amplitude(0));
//! }
//! # Ok(())
//! # }
//! ```

pub mod branch;
pub mod equations;
pub mod error;
pub mod newton;
pub mod peak;
pub mod response;
pub mod route;
pub mod settings;
pub mod solution;
pub mod stability;
pub mod status;
pub mod structure;

pub use equations::balance::Balance;
pub use equations::effort::WorkCount;
pub use equations::problem::Problem;
pub use error::ProblemError;
pub use route::PeakRoute;
pub use settings::{AlertSettings, HbSettings, NewtonSettings, SliderAnchor, StabilityScope};
pub use solution::{ContactFractions, CycleWork, Solution};
pub use stability::Stability;
pub use status::Status;
pub use structure::linear::LinearModel;
