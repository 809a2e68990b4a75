//! Microslip: uncertainty quantification of the forced response of friction-damped turbine blades.
//!
//! The rooms, from the ground floor up, and what each may import stand in `ARCHITECTURE.md`;
//! `tests/architecture.rs` keeps that table true.

pub mod aft;
pub mod contact;
pub mod ensemble;
pub mod error;
pub mod fe;
pub mod file;
pub mod gpu;
pub mod harmonics;
pub mod hb;
pub mod linalg;
pub mod model;
pub mod report;
pub mod sampling;
pub mod setting;
pub mod special;
pub mod statistics;
pub mod study;
pub mod units;

pub use error::Error;
