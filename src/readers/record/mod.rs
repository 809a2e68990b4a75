//! Measurements of a friction contact: signals over time, read from files and written to them.
//!
//! Knows no estimate and no rig: `identify` reads what `rig` or a laboratory has written. Start reading at [`read_hysteresis`]:
//! each format is a file of `format` that gives the signals of tests in SI units, and `checks` holds the rules of all formats.
//! Sizes that a file states are checked before memory is taken for them.

pub mod pressure_map;
pub mod quantity;
pub mod read;
pub mod response;
pub mod signals;
pub mod write;

mod channels;
mod checks;
mod condition;
mod format;
mod table;

pub use pressure_map::{PressureCell, PressureMap, read_pressure_map, write_pressure_map};
pub use quantity::Quantity;
pub use read::{TestInFile, read_hysteresis, read_tests};
pub use response::{ResponsePoint, ResponseRecord, read_response, write_response};
pub use signals::{HysteresisRecord, TestConditions};
pub use write::{quantised, write_hysteresis};
