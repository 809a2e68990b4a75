//! Alternating frequency–time evaluation of contact forces on a batch of harmonic states.

mod backend;
mod batch;
mod box_law;
mod circle_law;
mod evaluate;
mod forces;
mod lanes;
mod plan;
pub mod settings;
mod signals;
mod vector;

pub use backend::{Accuracy, Backend, Drafts};
pub use batch::{AftBatch, Want};
pub use evaluate::{AftScratch, evaluate};
pub use forces::{AftForces, Block, Periodicity, StateSummary, Tangent};
pub use plan::AftPlan;
pub use settings::{AftSettings, Laps};
