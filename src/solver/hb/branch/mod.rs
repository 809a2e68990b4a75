//! Branches of solutions over the frequency: steps along a branch, and sweeps through a band.

pub mod branch_point;
pub mod branch_segment;
pub mod continuation;
pub mod sweep;
pub(in crate::hb) mod sweep_start;
