//! Harmonic balance.

pub mod status;

pub use status::Status;
