//! The circle law: one slider for both directions of slip, and its steady cycle.

mod between;
mod cells;
pub(super) mod course;
mod kink;
pub(super) mod lap;
mod lap_march;
pub(super) mod located;
pub(super) mod march;
mod node;
pub(super) mod sensitivity;
pub(super) mod slip;
pub(super) mod steady_cycle;
pub(super) mod tangent;
mod transition;
