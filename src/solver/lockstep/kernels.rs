//! Compiled passes of the Newton iterations of lanes, and how many lanes a device takes.

use super::arrays::LaneArrays;
use super::program::{LanePlaces, Program, TILE, text};
use super::system::LaneSystem;
use crate::aft::AftPlan;
use crate::gpu::{Device, Fault, GpuError, Kernels, Precision, Scope, ShaderKey};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Contact arrays that the passes over lanes bind, in the order of their numbers.
pub(super) const CONTACT_ARRAYS: [&str; 6] = [
    "coefficients",
    "states",
    "deviations",
    "flags",
    "slots",
    "tangents",
];
/// For each array of the lanes ([`LaneArrays::bound`]), which are bound before [`CONTACT_ARRAYS`]: whether the passes write it.
const WRITTEN: [bool; 7] = [false, false, false, false, false, true, true];
/// Number of contact arrays that the passes write: the first ones.
const WRITTEN_CONTACT: usize = 2;

/// Compiled passes for one system and one way to evaluate contacts.
#[derive(Debug)]
pub struct LaneKernels {
    pub(super) system: LaneSystem,
    pub(super) contact: Kernels,
    pub(super) fault: Option<Fault>,
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) pipelines: BTreeMap<&'static str, wgpu::ComputePipeline>,
    /// Arrays of the last batch: what a new one costs, memory that is set to zero, is as long as several iterations.
    arrays: Mutex<Option<Arc<LaneArrays>>>,
}

/// Arguments of a pass, arrays of the lanes, arrays of the contact passes.
fn layout(device: &Device) -> wgpu::BindGroupLayout {
    let storage = |written: bool| wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage {
            read_only: !written,
        },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let contact_arrays = (0..CONTACT_ARRAYS.len()).map(|i| storage(i < WRITTEN_CONTACT));
    let job = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: true,
        min_binding_size: None,
    };
    let arrays = WRITTEN.into_iter().map(storage).chain(contact_arrays);
    let entries: Vec<_> = (std::iter::once(job).chain(arrays).zip(0..))
        .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    };
    device.device.create_bind_group_layout(&descriptor)
}

impl LaneKernels {
    /// Passes over lanes that a test can let fail.
    pub const PASSES: [&'static str; 11] = Program::PASSES;

    /// Compiles the passes for contacts that `plan` evaluates.
    ///
    /// # Errors
    /// [`GpuError::Shader`], also where there is no shader of the law.
    pub fn new(
        device: &Device,
        system: LaneSystem,
        plan: &AftPlan<f64>,
        fault: Option<Fault>,
    ) -> Result<Self, GpuError> {
        let shape = ShaderKey::of(plan, Precision::F32).ok_or_else(|| GpuError::Shader {
            message: "there is none of this law".to_owned(),
        })?;
        if !device.adapter.is_hardware() && !shape.suits_software() {
            let message = "the loops are too long for a software adapter".to_owned();
            return Err(GpuError::Shader { message });
        }
        let text = text(&system, shape.blocks());
        let contact = Kernels::new(device, shape)?;
        let scope = Scope::new(device);
        let on = &device.device;
        let layout = layout(device);
        let all = on.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = on.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline = |entry| {
            on.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&all),
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let pipelines = Program::PASSES.into_iter().chain([Program::SPOILED]);
        let pipelines = pipelines.map(|entry| (entry, pipeline(entry))).collect();
        scope.close(device, |message| GpuError::Shader { message })?;
        Ok(Self {
            system,
            contact,
            fault,
            layout,
            pipelines,
            arrays: Mutex::default(),
        })
    }

    /// Whether they were compiled for this `system` and contacts that `plan` evaluates.
    pub(super) fn are_of(&self, system: &LaneSystem, plan: &AftPlan<f64>) -> bool {
        self.system == *system
            && ShaderKey::of(plan, Precision::F32).as_ref() == Some(self.contact.shape())
    }

    /// Lanes of the largest batch that the limits of `device` allow.
    #[must_use]
    pub fn most_lanes(&self, device: &Device) -> usize {
        let limits = device.limits();
        let largest = (limits.max_storage_buffer_binding_size).min(limits.max_buffer_size);
        let rows = LanePlaces::new(&self.system)
            .end
            .max(self.system.own_rows());
        let by_numbers = usize::try_from(largest / 4).unwrap_or(usize::MAX) / rows;
        let by_states = self.contact.most_states(device) / self.system.n_pairs;
        by_numbers.min(by_states) / TILE * TILE
    }

    /// Inverses that one batch can hold.
    #[must_use]
    pub fn most_inverses(&self, device: &Device) -> usize {
        let limits = device.limits();
        let largest = (limits.max_storage_buffer_binding_size).min(limits.max_buffer_size);
        let size = self.system.size();
        usize::try_from(largest / 4).unwrap_or(usize::MAX) / (size * size)
    }

    /// Arrays for `columns` columns and `inverses` inverses: those of the last batch where it has ended and they suffice.
    ///
    /// # Errors
    /// [`GpuError::Refused`] if the device has not the memory.
    pub(super) fn arrays(
        &self,
        device: &Device,
        columns: usize,
        inverses: usize,
    ) -> Result<Arc<LaneArrays>, GpuError> {
        let mut last = self.arrays.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(arrays) = last.as_ref()
            && Arc::strong_count(arrays) == 1
            && arrays.have_room(columns, inverses)
        {
            return Ok(Arc::clone(arrays));
        }
        // their memory first
        *last = None;
        // batches differ by a few tiles; half of what the device can bind is taken at most, so that twice as much is there
        let columns = columns.next_power_of_two();
        let (system, contact) = (&self.system, &self.contact);
        let new = LaneArrays::new(device, system, contact, columns, inverses, self.fault)?;
        let new = Arc::new(new);
        *last = Some(Arc::clone(&new));
        Ok(new)
    }
}
