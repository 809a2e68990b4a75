//! Contact parameters from measured hysteresis loops, as distributions for a study.
//!
//! A record is cut into cycles, the steady ones are averaged, and the mean loop gives the parameters of a test ([`result`]); all tests
//! together give their distribution over contacts ([`pooled_result`]), which a study reads ([`identified`]).

pub mod identified;
pub mod page;
pub mod pooled_result;
pub mod result;
pub mod settings;
pub mod uncertain;

pub use identified::{ContactParameter, Identified, IdentifiedInput};
pub use pooled_result::Pooled;
pub use result::TestResult;
pub use settings::IdentifySettings;
pub use uncertain::Uncertain;
