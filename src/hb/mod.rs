//! Harmonic balance.

pub mod settings;
pub mod solution;
pub mod status;

pub use settings::{AlertSettings, HbSettings, NewtonSettings, SliderAnchor};
pub use solution::{ContactFractions, CycleWork, Solution};
pub use status::Status;
