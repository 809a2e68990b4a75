//! How a device is used.

use crate::contact::{Events, FrictionLaw};

/// Floating-point numbers of the shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Precision {
    /// Single, on every adapter.
    F32,
    /// Double, where the adapter has `SHADER_F64`.
    F64,
}

impl Precision {
    /// Name in WGSL.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// Rounding error of 1.
    #[cfg(feature = "gpu")]
    pub(super) fn epsilon(self) -> f64 {
        match self {
            Self::F32 => f64::from(f32::EPSILON),
            Self::F64 => f64::EPSILON,
        }
    }
}

/// A failure on purpose, for tests of what follows from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Batches of more contact states are refused.
    RefuseAbove(usize),
    /// The self-test finds a wrong force.
    WrongSelfTest,
    /// This pass over lanes has wrong results.
    WrongPass(&'static str),
    /// This pass over lanes has results that are no numbers.
    NoNumbers(&'static str),
    /// The device is lost before iteration number `.0` of the lanes of each batch.
    LoseDeviceInIteration(u64),
}

/// How the device is used.
#[derive(Debug, Clone, PartialEq)]
pub struct GpuSettings {
    /// Adapter by index, PCI address or part of its name; `None` = one that is hardware.
    pub adapter: Option<String>,
    /// Number of this process among those of its node: where several adapters fit, each process takes one.
    pub local_rank: u64,
    /// Share of the peaks that the processor searches again without the device, 0 to 1.
    pub audit: f64,
    /// Law and events whose shaders the self-test examines.
    pub law: FrictionLaw,
    /// See above.
    pub events: Events,
    /// Failure on purpose.
    pub fault: Option<Fault>,
}

impl Default for GpuSettings {
    fn default() -> Self {
        Self {
            adapter: None,
            local_rank: 0,
            audit: 0.01,
            law: FrictionLaw::Box,
            events: Events::Located,
            fault: None,
        }
    }
}
