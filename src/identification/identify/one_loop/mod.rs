//! Numbers of one loop: its halves, stick branches with their knee, plateaus, normal stiffness, energy and misfit.
//!
//! Start reading in `loop_shape`, which finds where a branch and a plateau are; `loop_estimate` takes the numbers there.

pub(super) mod branch;
pub(super) mod figure;
pub(super) mod half;
mod knee;
pub(super) mod loop_estimate;
pub(super) mod loop_shape;
pub(super) mod misfit;
mod normal;
mod plateau;
pub(super) mod slip_limits;
mod slope;
mod start;
mod weak_part;
