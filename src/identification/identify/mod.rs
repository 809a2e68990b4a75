//! Contact parameters from measured hysteresis loops, as distributions for a study.
//!
//! A record is cut into cycles, the steady ones are averaged, and the mean loop gives the parameters of a test ([`result`]); all tests
//! together give their distribution over contacts ([`pooled_result`]), which a study reads ([`identified`]).

mod branch;
mod cycle;
mod equations;
mod figure;
mod frequency;
mod golden;
mod half;
mod hierarchical;
pub mod identification;
pub mod identified;
mod joint;
mod knee;
mod loop_estimate;
mod loop_shape;
mod mean_loop;
mod misfit;
mod normal;
pub mod page;
pub mod parameter;
mod plateau;
pub mod pooled;
pub mod pooled_result;
pub mod read;
pub mod result;
mod run_in;
mod scatter;
mod series;
pub mod settings;
mod slope;
mod smooth_motion;
pub mod test_estimate;
mod test_notes;
mod trend;
pub mod uncertain;
pub mod write;

pub use identification::{IdentifyError, identify, identify_files};
pub use identified::{Identified, IdentifiedInput};
pub use parameter::ContactParameter;
pub use pooled::pool;
pub use pooled_result::Pooled;
pub use result::{TestResult, TestStatus};
pub use settings::IdentifySettings;
pub use test_estimate::identify_test;
pub use uncertain::Uncertain;
pub use write::write;
