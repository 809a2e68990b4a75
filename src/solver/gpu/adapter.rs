//! Adapters of this machine, and an open device on one of them. Headless: nothing here knows a window.

use super::choice::chosen;
use super::error::GpuError;
use super::report::AdapterFacts;
use super::settings::Precision;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use wgpu::{DeviceType, Features, Limits};

/// Buffers that one pass binds; an adapter must offer as many.
const STORAGE_BUFFERS: u32 = 16;
/// Share of the device's memory (%) from which creating a buffer fails instead of losing the device.
const MEMORY_THRESHOLD: u8 = 90;

/// What is known of `adapter`.
fn facts(index: usize, adapter: &wgpu::Adapter) -> AdapterFacts {
    let info = adapter.get_info();
    let features = adapter.features();
    AdapterFacts {
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

/// Every adapter of this machine; none without a driver.
#[must_use]
pub fn adapters() -> Vec<AdapterFacts> {
    (enumerate().iter().enumerate())
        .map(|(index, adapter)| facts(index, adapter))
        .collect()
}

fn enumerate() -> Vec<wgpu::Adapter> {
    // one for the whole process: NVIDIA's driver may end a process in which several threads make and drop instances at once
    // (https://github.com/gfx-rs/wgpu/issues/5930)
    static INSTANCE: LazyLock<wgpu::Instance> = LazyLock::new(|| {
        wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::PRIMARY,
            flags: wgpu::InstanceFlags::empty(),
            memory_budget_thresholds: wgpu::MemoryBudgetThresholds {
                for_resource_creation: Some(MEMORY_THRESHOLD),
                for_device_loss: None,
            },
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        })
    });
    pollster::block_on(INSTANCE.enumerate_adapters(wgpu::Backends::PRIMARY))
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
    /// Opens the adapter that `wanted` names by index, PCI address or part of its name; without `wanted` a
    /// discrete one, else another piece of hardware, never one that is software. Of several it is that number `local_rank`.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::Lacks`], [`GpuError::Lost`] if it cannot be opened.
    pub fn open(
        wanted: Option<&str>,
        local_rank: u64,
        precision: Precision,
    ) -> Result<Self, GpuError> {
        let all = enumerate();
        let all_facts: Vec<_> = (all.iter().enumerate())
            .map(|(index, adapter)| facts(index, adapter))
            .collect();
        let chosen = chosen(wanted, local_rank, &all_facts);
        let chosen = chosen.ok_or_else(|| no_adapter(wanted, &all_facts))?;
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
