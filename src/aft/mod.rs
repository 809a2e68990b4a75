//! Alternating frequency–time evaluation of contact forces on a batch of harmonic states.

mod backend;
mod batch;
mod breakpoints;
mod circle;
mod circle_tangent;
mod course;
mod evaluate;
pub mod gpu;
mod lap;
mod located;
mod located_circle;
mod march;
mod motions;
mod plan;
mod roots;
mod sensitivity;
pub mod settings;
mod slip;
mod steady;
mod tangent;

pub use backend::{Accuracy, Backend};
pub use batch::{AftBatch, AftForces, Block, Periodicity, StateSummary, Tangent, Want};
pub use evaluate::evaluate;
pub use plan::AftPlan;
pub use settings::{AftSettings, Laps};
