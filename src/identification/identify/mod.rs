//! Contact parameters from measured hysteresis loops, as distributions for a study.
//!
//! A record is cut into cycles, the steady ones are averaged (`cycles`), and the mean loop (`one_loop`) gives the parameters of a
//! test ([`one_test`]); all tests together give their distribution over contacts ([`pooling`]), which a study reads ([`read`]). What is
//! found, of a test and of all, stands in [`found`].

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
