//! Branches of solutions over the frequency: steps along them, and the way through a band.

pub mod branch_point;
pub mod continuation;
pub(in crate::hb) mod run_in;
pub mod stretch;
pub mod sweep;
