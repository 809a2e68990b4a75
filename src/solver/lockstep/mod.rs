//! Peaks of many samples at once on a device.
//!
//! A *lane* is one peak of one sample. All lanes do the same Newton iterations in single precision, in the modes of the free structure
//! that all samples share ([`system`]); a lane's linear systems are preconditioned by the inverse Jacobian of an anchor that its tile
//! of lanes shares, so that nothing is factorised. A lane that has come close to its peak is the start of a search in double
//! precision on the processor ([`search`]).
//!
//! Passes of an iteration: moved, scaled (states of the contact passes of [`crate::gpu`], which follow), rate and loaded (contact
//! forces), product (loads on the modes), divided_residual (motion of the modes), product (motion at the contacts), preconditioned, begun.
//! Then each round, for one direction of the correction and one of the tangent, does rate, product, divided, product, preconditioned and
//! advanced. At the end come rate, product and responded, and 64 bytes of each lane are read back.
//!
//! A study with `--backend gpu` runs lanes; `cargo bench --bench gpu -- lanes` runs them beside the searches of the processor.

#![cfg_attr(
    not(feature = "gpu"),
    expect(dead_code, reason = "a device alone runs the lanes")
)]

pub mod search;
pub mod system;

#[cfg(not(feature = "gpu"))]
mod absent;
#[cfg(feature = "gpu")]
mod arrays;
#[cfg(feature = "gpu")]
pub mod batch;
#[cfg(feature = "gpu")]
pub mod kernels;
#[cfg(feature = "gpu")]
mod lanes;
#[cfg(feature = "gpu")]
pub mod profile;
#[cfg(feature = "gpu")]
mod program;

#[cfg(not(feature = "gpu"))]
pub use absent::LaneDevice;
#[cfg(feature = "gpu")]
pub use lanes::LaneDevice;
