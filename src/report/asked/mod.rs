//! What the study file asks of a report: requirements, stopping rule, surrogate, control variate, bands.
//!
//! Settings that check themselves; knows no sample and no result. Start reading in [`mod@requirement`].

pub mod bands;
pub mod control_variate;
pub mod requirement;
pub mod stopping;
pub mod surrogate;

pub use bands::Bands;
pub use control_variate::ControlVariateSettings;
pub use requirement::{Criterion, MarginBase, Operation, RequiredQuantity, Requirements, Stress};
pub use stopping::{Stopping, StoppingTable};
pub use surrogate::SurrogateSettings;
