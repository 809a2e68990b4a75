//! Why a device cannot do it.

/// Why the GPU cannot do it. The processor can.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter, or none that was asked for.
    #[error("{message}")]
    NoAdapter {
        /// What was looked for and what is there.
        message: String,
    },
    /// The adapter lacks a feature or a limit.
    #[error("adapter {name} has no {lacks}")]
    Lacks {
        /// Adapter.
        name: String,
        /// Feature or limit.
        lacks: String,
    },
    /// A shader text is not valid.
    #[error("shader: {message}")]
    Shader {
        /// What naga says.
        message: String,
    },
    /// Memory, or a limit, does not suffice for a batch.
    #[error("a batch was refused: {message}")]
    Refused {
        /// States of the batch.
        states: usize,
        /// What the device says.
        message: String,
    },
    /// The device is lost, or does not answer.
    #[error("the device is lost: {message}")]
    Lost {
        /// What the driver says.
        message: String,
    },
    /// The device computes wrongly.
    #[error("self-test failed: {message}")]
    SelfTest {
        /// How far it is off.
        message: String,
    },
}
