//! Adapters of this machine, and an open device on one of them. Headless: nothing here knows a window.

use super::GpuError;
use super::shader::Precision;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use wgpu::{DeviceType, Features, Limits};

/// Buffers that one pass binds; an adapter must offer as many.
const STORAGE_BUFFERS: u32 = 16;
/// Share of the device's memory (%) from which creating a buffer fails instead of losing the device.
const MEMORY_THRESHOLD: u8 = 90;

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
    fn of(index: usize, adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let features = adapter.features();
        Self {
            index,
            kind: String::from(match info.device_type {
                DeviceType::DiscreteGpu => "discrete",
                DeviceType::IntegratedGpu => "integrated",
                DeviceType::VirtualGpu => "virtual",
                DeviceType::Cpu => "software",
                DeviceType::Other => "other",
            }),
            interface: info.backend.to_str().to_owned(),
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
            name: info.name,
            pci: info.device_pci_bus_id,
            largest_binding: adapter.limits().max_storage_buffer_binding_size,
            f64: features.contains(Features::SHADER_F64),
            timestamps: features.contains(Features::TIMESTAMP_QUERY),
        }
    }

    /// Whether it is a piece of hardware made for this; software that plays a GPU is slower than the processor's own code.
    #[must_use]
    pub fn is_hardware(&self) -> bool {
        matches!(self.kind.as_str(), "discrete" | "integrated" | "virtual")
    }

    /// Whether `wanted` names it: its index, its PCI address, or a part of its name (case does not matter).
    fn is_called(&self, wanted: &str) -> bool {
        let name = self.name.to_lowercase();
        self.index.to_string() == wanted
            || (!self.pci.is_empty() && self.pci.eq_ignore_ascii_case(wanted))
            || (wanted.parse::<usize>().is_err() && name.contains(&wanted.to_lowercase()))
    }
}

/// Every adapter of this machine; none without a driver.
#[must_use]
pub fn adapters() -> Vec<AdapterFacts> {
    let (_, all) = enumerate();
    (all.iter().enumerate())
        .map(|(index, adapter)| AdapterFacts::of(index, adapter))
        .collect()
}

fn enumerate() -> (wgpu::Instance, Vec<wgpu::Adapter>) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        flags: wgpu::InstanceFlags::empty(),
        memory_budget_thresholds: wgpu::MemoryBudgetThresholds {
            for_resource_creation: Some(MEMORY_THRESHOLD),
            for_device_loss: None,
        },
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    (instance, found)
}

/// An open device. Dropped, it waits for its work.
#[derive(Debug)]
pub struct Device {
    /// The adapter it is on.
    pub adapter: AdapterFacts,
    /// The device itself.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    lost: Arc<AtomicBool>,
}

impl Device {
    /// Opens the adapter that `wanted` names by index, PCI address or part of its name; without `wanted` the first
    /// discrete one, else the first other piece of hardware, never one that is software.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::Lacks`], [`GpuError::Lost`] if it cannot be opened.
    pub fn open(wanted: Option<&str>, precision: Precision) -> Result<Self, GpuError> {
        let (_instance, all) = enumerate();
        let facts: Vec<_> = (all.iter().enumerate())
            .map(|(index, adapter)| AdapterFacts::of(index, adapter))
            .collect();
        let chosen = match wanted {
            Some(wanted) => facts.iter().find(|f| f.is_called(wanted)),
            None => (facts.iter().find(|f| f.kind == "discrete"))
                .or_else(|| facts.iter().find(|f| f.is_hardware())),
        };
        let chosen = chosen.ok_or_else(|| no_adapter(wanted, &facts))?;
        Self::on(&all[chosen.index], chosen.clone(), precision)
    }

    fn on(
        adapter: &wgpu::Adapter,
        facts: AdapterFacts,
        precision: Precision,
    ) -> Result<Self, GpuError> {
        let lacks = |lacks: &str| GpuError::Lacks {
            name: facts.name.clone(),
            lacks: lacks.to_owned(),
        };
        if precision == Precision::F64 && !facts.f64 {
            return Err(lacks("double precision in shaders"));
        }
        let limits = adapter.limits();
        if limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
            return Err(lacks("16 storage buffers per pass"));
        }
        let mut features = Features::empty();
        features.set(Features::SHADER_F64, precision == Precision::F64);
        features.set(Features::TIMESTAMP_QUERY, facts.timestamps);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("microslip"),
            required_features: features,
            required_limits: Limits { ..limits },
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| {
                GpuError::Lost {
                    message: error.to_string(),
                }
            })?;
        let lost = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, _| flag.store(true, Ordering::SeqCst));
        // Errors outside a scope would panic; a device that reports one is not trusted any more.
        let flag = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |_| flag.store(true, Ordering::SeqCst)));
        Ok(Self {
            adapter: facts,
            device,
            queue,
            lost,
        })
    }

    /// Whether nothing that it returns is to be believed any more.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::SeqCst)
    }

    /// Ends the device as a driver reset would.
    pub fn destroy(&self) {
        // first, so that whoever meets an error of the dead device knows it for what it is
        self.lost.store(true, Ordering::SeqCst);
        self.device.destroy();
    }

    /// Limits of the adapter.
    #[must_use]
    pub fn limits(&self) -> Limits {
        self.device.limits()
    }
}

fn no_adapter(wanted: Option<&str>, facts: &[AdapterFacts]) -> GpuError {
    let names: Vec<String> = (facts.iter())
        .map(|f| format!("{}: {} ({})", f.index, f.name, f.kind))
        .collect();
    let there = match names.as_slice() {
        [] => "this machine has none".to_owned(),
        names => format!("there are {}", names.join("; ")),
    };
    GpuError::NoAdapter {
        message: match wanted {
            Some(wanted) => format!("no adapter is called {wanted}; {there}"),
            None => format!("no GPU: {there}"),
        },
    }
}
