//! Measurements of a friction contact: signals over time, read from files and written to them.
//!
//! Knows no estimate and no rig: `identify` reads what `rig` or a laboratory has written.

pub mod signals;

pub use signals::{HysteresisRecord, TestConditions};
