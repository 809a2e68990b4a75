//! Multi-harmonic balance with coupled static and dynamic equations.
//!
//! A [`LinearModel`] (once per study) and contact parameters (once per sample) make a [`Problem`]; a [`Balance`] is
//! that problem on a harmonic set. Start reading at `balance` (the equations), then `newton`, `peak`.

pub mod alert;
pub mod balance;
pub mod branch_point;
pub mod budget;
pub mod compliance;
pub mod continuation;
pub mod curve;
pub mod error;
pub mod fold;
pub mod forced_response;
mod iterate;
pub mod jacobian;
pub mod ladder;
pub mod linear;
pub mod maxima;
pub mod newton;
pub mod peak;
pub mod predicted;
pub mod problem;
pub mod refine;
pub mod resonance;
pub mod rest;
mod run_in;
pub mod settings;
pub mod solution;
mod springs;
mod stations;
pub mod status;
pub mod sweep;
pub mod track;
pub mod values;

pub use balance::Balance;
pub use error::ProblemError;
pub use linear::LinearModel;
pub use problem::Problem;
pub use settings::{AlertSettings, HbSettings, NewtonSettings, SliderAnchor};
pub use solution::{ContactFractions, CycleWork, Solution};
pub use status::Status;
