//! What the samples say in numbers: quantiles, bounds, margins, ranges over the box, sensitivity, errors.
//!
//! A sample without a solution is counted and bounded, never dropped in silence. Judges nothing and knows no page. Start reading
//! in [`mod@summary`], which is `summary.json`; quantiles and bounds of all samples or by outer point are in
//! [`mod@population`].

pub(super) mod allowable;
pub mod amplification;
pub mod box_range;
pub mod control_variate;
pub mod correlation;
pub mod distribution;
pub mod epistemic;
pub mod error_budget;
pub mod margins;
pub mod modes;
pub mod outer_points;
pub(super) mod peak_error;
pub(super) mod peaks;
pub(super) mod performance;
pub mod population;
pub mod replicate_means;
pub mod sensitivity;
pub mod several_answers;
pub mod stability;
pub mod summary;
pub mod surrogate;

pub use box_range::Extreme;
pub use epistemic::EpistemicSummary;
pub use outer_points::outer_groups;
pub use population::{Bound, Exceeded, Quantiles};
pub use sensitivity::IndexResult;
pub use summary::Summary;
pub use surrogate::SurrogateResult;
