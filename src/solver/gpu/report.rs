//! What is known of an adapter, and what it did in a run.

/// What is known of an adapter without opening it.
#[derive(
    Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct AdapterFacts {
    /// Place in the list of adapters, 0-based.
    pub index: usize,
    /// Name.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: String,
    /// Programming interface, such as `vulkan`.
    pub interface: String,
    /// Driver and version.
    pub driver: String,
    /// PCI address, where the interface tells.
    pub pci: String,
    /// Largest buffer that a pass can bind (bytes).
    pub largest_binding: u64,
    /// Whether shaders may compute in double precision.
    pub f64: bool,
    /// Whether passes can be timed.
    pub timestamps: bool,
}

impl AdapterFacts {
    /// Whether it is a piece of hardware made for this; software that plays a GPU is slower than the processor's own code.
    #[must_use]
    pub fn is_hardware(&self) -> bool {
        matches!(self.kind.as_str(), "discrete" | "integrated" | "virtual")
    }

    /// Whether `wanted` names it: its index, its PCI address, or a part of its name (case does not matter).
    #[cfg(feature = "gpu")]
    pub(super) fn is_called(&self, wanted: &str) -> bool {
        let name = self.name.to_lowercase();
        self.index.to_string() == wanted
            || (!self.pci.is_empty() && self.pci.eq_ignore_ascii_case(wanted))
            || (wanted.parse::<usize>().is_err() && name.contains(&wanted.to_lowercase()))
    }
}

/// The device's part in a run, for summary and report.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct GpuReport {
    /// The adapter.
    pub adapter: AdapterFacts,
    /// Predicted peaks that it was given to improve (lanes).
    #[serde(default)]
    pub lanes: u64,
    /// Of these, those that it could not improve.
    #[serde(default)]
    pub lanes_lost: u64,
    /// Peaks that the processor searched again without the device.
    #[serde(default)]
    pub peaks_compared: u64,
    /// Largest relative difference of a frequency between both searches.
    #[serde(default)]
    pub largest_frequency_difference: f64,
    /// Largest relative difference of an amplitude between both searches.
    #[serde(default)]
    pub largest_amplitude_difference: f64,
    /// Peaks beyond the limit; those searched without the device took their place.
    #[serde(default)]
    pub peaks_beyond_limit: u64,
    /// Batches that it refused and that were halved.
    pub halved: u64,
    /// What failed.
    pub notes: Vec<String>,
}
