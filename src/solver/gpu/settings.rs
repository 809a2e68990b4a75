//! How a device is used.

use crate::contact::{Events, FrictionLaw};

/// Floating-point numbers of the shaders.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Default,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single, on every adapter.
    #[default]
    F32,
    /// Double, where the adapter has `SHADER_F64`.
    F64,
}

impl Precision {
    /// Name in WGSL and on the command line.
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
    /// The device is lost once, before batch number `.0`.
    LoseDeviceAfter(u64),
    /// Batches of more states are refused.
    RefuseAbove(usize),
    /// The self-test finds a wrong force.
    WrongSelfTest,
    /// Every draft has a wrong force.
    WrongDrafts,
    /// This pass over lanes has wrong results.
    WrongPass(&'static str),
    /// This pass over lanes has results that are no numbers.
    NoNumbers(&'static str),
    /// The device is lost once, before iteration number `.0` of the lanes of a batch.
    LoseDeviceInIteration(u64),
}

/// How the device is used.
#[derive(Debug, Clone, PartialEq)]
pub struct GpuSettings {
    /// Adapter by index, PCI address or part of its name; `None` = one that is hardware.
    pub adapter: Option<String>,
    /// Number of this process among those of its node: where several adapters fit, each process takes one.
    pub local_rank: u64,
    /// Numbers of the shaders.
    pub precision: Precision,
    /// Share of the evaluations that the processor repeats, 0 to 1.
    pub audit: f64,
    /// Samples that compute on the processor at the same time.
    pub turns: usize,
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
            precision: Precision::F32,
            audit: 0.01,
            turns: 1,
            law: FrictionLaw::Box,
            events: Events::Located,
            fault: None,
        }
    }
}
