//! Measurements of a friction contact: signals over time, read from files and written to them.
//!
//! Knows no estimate and no rig: `identify` reads what `rig` or a laboratory has written. Start reading at [`read_hysteresis`]:
//! each format is a file of `format` that gives the signals of tests in SI units, and `checks` holds the rules of all formats.
//! Sizes that a file states are checked before memory is taken for them.
//!
//! ```
//! # use microslip_readers as microslip;
//! use microslip::record::{HysteresisRecord, TestConditions, read_hysteresis, write_hysteresis};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//!
//! let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / 200.0;
//! let test = HysteresisRecord {
//!     time: (0..1000).map(|i| f64::from(i) * 5e-5).collect(),
//!     displacement: (0..1000).map(|i| 4e-6 * angle(i).sin()).collect(), // m
//!     tangential_force: (0..1000).map(|i| 30e6 * 4e-6 * angle(i).sin()).collect(), // N: it sticks
//!     normal_force: vec![400.0; 1000],
//!     conditions: TestConditions {
//!         frequency_hz: Some(100.0),
//!         ..TestConditions::default()
//!     },
//!     ..HysteresisRecord::empty("stuck".to_owned())
//! };
//! let path = folder.path().join("stuck.csv");
//! write_hysteresis(&path, std::slice::from_ref(&test), &["a spring of 30 N/µm"])?;
//! let read = read_hysteresis(&[path])?;
//! assert_eq!(read[0].record, test); // to the last bit
//! # Ok(())
//! # }
//! ```

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
