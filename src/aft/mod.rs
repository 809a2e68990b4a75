//! Alternating frequency–time evaluation of contact forces on a batch of harmonic states.

mod backend;
mod batch;
mod breakpoints;
mod circle;
mod circle_tangent;
mod evaluate;
pub mod gpu;
mod located;
mod march;
mod plan;
pub mod settings;
mod tangent;

pub use backend::{Accuracy, Backend};
pub use batch::{AftBatch, AftForces, Block, Periodicity, StateSummary, Tangent, Want};
pub use evaluate::evaluate;
pub use plan::AftPlan;
pub use settings::{AftSettings, Laps};
