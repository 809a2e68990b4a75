//! From a record to one loop: frequency, cuts, run-in, spikes, and the mean of the steady cycles with its scatter.
//!
//! Start reading in `cycle`; `mean_loop` is the type that all that follows works on.

pub(super) mod cycle;
mod equations;
mod force_resonance;
mod frequency;
pub(super) mod mean_loop;
mod run_in;
pub(super) mod scatter;
mod smooth_motion;
