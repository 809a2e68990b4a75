//! Multi-harmonic balance with coupled static and dynamic equations.
//!
//! A [`LinearModel`] (once per study) and contact parameters (once per sample) make a [`Problem`]; a [`Balance`] is
//! that problem on a harmonic set. Start reading at `equations`, then `newton`, `peak`.
//! An example stands at `microslip::study`.

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
