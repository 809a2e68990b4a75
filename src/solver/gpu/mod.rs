//! Contact states on a GPU: forces and tangents, rounded to the shaders' precision.
//!
//! They serve the lanes of [`crate::lockstep`], which lead the processor to a peak and decide no result. Start reading at [`Gpu`]; the
//! shaders are in `shaders/`. Whatever the device fails to do the processor does: no sample is lost by it. A build without the feature `gpu` has no device, and
//! says so where one is asked for.
//!
//! ```
//! # use microslip_solver as microslip;
//! use microslip::gpu::{adapters, examined};
//!
//! // none without a driver: then a study runs on the processor
//! for (index, adapter) in adapters().iter().enumerate() {
//!     println!("{}: {}", adapter.name, examined(index));
//! }
//! ```
//!
//! Passes of the box law: transform (signals at the samples) → box_march (breakpoints and sliders) → spectra_of_runs → forces →
//! tangents_of_moving. Passes of the circle law with located events: transform → gap_roots → circle_march (steady cycle) → forces →
//! circle_steps (derivatives of slip for all columns) → circle_located_tangents (of steady cycles) → circle_anchored_tangents (of laps from
//! the anchor); with events decided at the samples: transform → circle_march → forces → circle_sampled_tangents.

mod error;
mod report;
mod settings;

#[cfg(not(feature = "gpu"))]
mod absent;
#[cfg(feature = "gpu")]
mod adapter;
#[cfg(feature = "gpu")]
mod audit;
#[cfg(feature = "gpu")]
mod choice;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
mod kernels;
#[cfg(feature = "gpu")]
mod readback;
#[cfg(feature = "gpu")]
mod scaled;
#[cfg(feature = "gpu")]
mod self_test;
#[cfg(feature = "gpu")]
mod shader;
#[cfg(feature = "gpu")]
mod tally;
#[cfg(feature = "gpu")]
mod timer;

pub use error::GpuError;
pub use report::{AdapterFacts, GpuReport};
pub use settings::{Fault, GpuSettings, Precision};

#[cfg(not(feature = "gpu"))]
pub use absent::{Gpu, adapters, examined};
#[cfg(feature = "gpu")]
pub use {
    adapter::{Device, adapters},
    device::Gpu,
    kernels::{BatchResult, Buffers, Kernels},
    scaled::{ScaledForces, ScaledStates},
    self_test::{examined, self_test},
    shader::{Access, Binding, Reflection, ShaderKey},
    timer::PassSeconds,
};
#[cfg(feature = "gpu")]
pub(crate) use {kernels::Scope, readback::read, timer::Timer};
