//! Contact parameters from measured hysteresis loops, as distributions for a study.
//!
//! A record is cut into cycles, the steady ones are averaged (`cycles`), and the mean loop (`one_loop`) gives the parameters of a
//! test ([`one_test`]); all tests together give their distribution over contacts ([`pooling`]), which a study reads ([`read`]). What is
//! found, of a test and of all, stands in [`found`].
//!
//! ```
//! # mod microslip {
//! #     pub use microslip_identification::identify;
//! #     pub use microslip_readers::record;
//! # }
//! use microslip::identify::{IdentifySettings, identify_test};
//! use microslip::record::HysteresisRecord;
//!
//! // ten cycles of an elastic-Coulomb contact: friction coefficient 0.5, 40 N/um, 100 N, 8 um at 50 Hz
//! let mut record = HysteresisRecord::empty("loops".to_owned());
//! let (mut before, mut force) = (0.0, 0.0_f64);
//! for i in 0..2000 {
//!     let cycles = f64::from(i) / 200.0;
//!     let displacement = 8e-6 * (std::f64::consts::TAU * cycles).sin();
//!     force = (force + 40e6 * (displacement - before)).clamp(-50.0, 50.0);
//!     before = displacement;
//!     record.time.push(cycles / 50.0);
//!     record.displacement.push(displacement);
//!     record.tangential_force.push(force);
//!     record.normal_force.push(100.0);
//! }
//! let found = identify_test(&record, &IdentifySettings::default());
//! let estimate = found.estimate.expect("loops that slip");
//! let friction = estimate.friction.expect("slip").coefficient;
//! let stiffness = estimate.tangential.stiffness_n_per_um;
//! assert!((friction.value - 0.5).abs() < 1e-6 && (stiffness.value - 40.0).abs() < 0.01);
//! ```

mod cycles;
pub mod found;
mod golden;
pub mod identification;
mod one_loop;
pub mod one_test;
pub mod page;
pub mod pooling;
pub mod read;
pub mod settings;
pub mod write;

pub use found::identified::{Identified, IdentifiedInput};
pub use found::parameter::ContactParameter;
pub use found::pooled_result::Pooled;
pub use found::result::{TestResult, TestStatus};
pub use found::uncertain::Uncertain;
pub use identification::{IdentifyError, identify, identify_files};
pub use one_loop::slip_limits::KnownPressure;
pub use one_test::test_estimate::{identify_pressed_test, identify_test};
pub use pooling::pooled::pool;
pub use settings::IdentifySettings;
pub use write::write;
