//! All tests together: the distribution over contacts by a hierarchical model, trends, and the joint distribution for a study.

mod hierarchical;
pub(super) mod joint;
pub mod pooled;
mod trend;
