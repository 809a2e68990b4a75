//! The passes over one batch: upload, dispatch, read back.

use super::adapter::Device;
use super::error::GpuError;
use super::readback::{Moving, RETURNED, read, u32s};
use super::scaled::{ScaledForces, ScaledStates};
use super::settings::Precision;
use super::shader::{Access, Pass, Reflection, ShaderKey};
use super::timer::{PassSeconds, Timer};
use crate::aft::Want;
use std::collections::BTreeMap;
use wgpu::BufferUsages as Usage;

/// Passes of a shape at most.
const MOST_PASSES: usize = 7;
/// Bytes of the timestamps of all passes.
const TIMER_BYTES: u64 = Timer::bytes(MOST_PASSES);

/// Compiled passes for one shape.
#[derive(Debug)]
pub struct Kernels {
    shape: ShaderKey,
    reflection: Reflection,
    layout: wgpu::BindGroupLayout,
    pipelines: Vec<wgpu::ComputePipeline>,
}

/// Buffers of one batch at a time.
#[derive(Debug)]
pub struct Buffers {
    capacity: usize,
    named: BTreeMap<String, wgpu::Buffer>,
    staging: wgpu::Buffer,
    tangent_staging: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    timer: Option<Timer>,
}

/// What one batch gave.
#[derive(Debug)]
pub struct BatchResult {
    /// One entry per part of the batch.
    pub parts: Vec<ScaledForces>,
    /// Time (s) of every pass on the device, where it can tell.
    pub pass_seconds: Option<PassSeconds>,
}

impl Buffers {
    /// States of the largest batch that they hold.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// The buffer that the shaders call `name`.
    pub(crate) fn buffer(&self, name: &str) -> &wgpu::Buffer {
        &self.named[name]
    }
}

impl Kernels {
    /// Compiles the passes for `shape`.
    ///
    /// # Errors
    /// [`GpuError::Shader`].
    pub fn new(device: &Device, shape: ShaderKey) -> Result<Self, GpuError> {
        let text = shape.text(device.adapter.is_hardware());
        let reflection = Reflection::of(&text)?;
        let entries: Vec<_> = (reflection.bindings.values())
            .map(|binding| wgpu::BindGroupLayoutEntry {
                binding: binding.number,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: match binding.access {
                        Access::Uniform => wgpu::BufferBindingType::Uniform,
                        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
                        Access::ReadWrite => wgpu::BufferBindingType::Storage { read_only: false },
                    },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let scope = Scope::new(device);
        let layout = (device.device).create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &entries,
        });
        let all = (device.device).create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = (device.device).create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipelines = (shape.passes().iter())
            .map(|pass| {
                (device.device).create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(pass.name),
                    layout: Some(&all),
                    module: &module,
                    entry_point: Some(pass.name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
            })
            .collect();
        scope.close(device, |message| GpuError::Shader { message })?;
        Ok(Self {
            shape,
            reflection,
            layout,
            pipelines,
        })
    }

    /// The shape that it was compiled for.
    #[must_use]
    pub fn shape(&self) -> &ShaderKey {
        &self.shape
    }

    /// States of the largest batch that the device's limits allow.
    #[must_use]
    pub fn most_states(&self, device: &Device) -> usize {
        let limits = device.limits();
        let largest = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let of = |b: &super::shader::Binding| b.element_bytes * b.per_state.unwrap_or(0);
        let widest = self.reflection.bindings.values().map(of).max().unwrap_or(1);
        let group = u64::from(self.reflection.group);
        let by_threads = group * u64::from(limits.max_compute_workgroups_per_dimension);
        let states = (largest / widest.max(1)).min(by_threads);
        usize::try_from(states / group * group).unwrap_or(usize::MAX)
    }

    /// Passes that `want` takes.
    fn passes(&self, want: Want) -> Vec<Pass> {
        let all = self.shape.passes().iter().copied();
        all.filter(|pass| !pass.only_tangents || want == Want::ForcesAndTangents)
            .collect()
    }

    /// Their names.
    pub(crate) fn pass_names(&self, want: Want) -> Vec<&'static str> {
        self.passes(want).iter().map(|pass| pass.name).collect()
    }

    /// Bytes of a buffer for `states` states.
    fn size(&self, name: &str, states: usize) -> u64 {
        let binding = self.reflection.bindings[name];
        let elements = match (binding.per_state, name) {
            (Some(per_state), _) => per_state * states as u64,
            (None, "circle") => 2 * u64::from(self.shape.n_time),
            (None, "orders") => self.shape.orders.len() as u64,
            (None, _) => 1,
        };
        binding.element_bytes * elements
    }

    /// Buffers for up to `states` states, rounded up to whole workgroups.
    ///
    /// # Errors
    /// [`GpuError::Refused`] if the device has not the memory.
    pub fn buffers(&self, device: &Device, states: usize) -> Result<Buffers, GpuError> {
        let capacity = states.next_multiple_of(self.reflection.group as usize);
        let scope = Scope::new(device);
        let create = |size: u64, usage: Usage| {
            (device.device).create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let named: BTreeMap<String, wgpu::Buffer> = (self.reflection.bindings.iter())
            .map(|(name, binding)| {
                let kind = match binding.access {
                    Access::Uniform => Usage::UNIFORM,
                    Access::Read | Access::ReadWrite => Usage::STORAGE,
                };
                let usage = kind | Usage::COPY_SRC | Usage::COPY_DST;
                (name.clone(), create(self.size(name, capacity), usage))
            })
            .collect();
        let returned: u64 = RETURNED.iter().map(|name| self.size(name, capacity)).sum();
        let staging = create(TIMER_BYTES + returned, Usage::MAP_READ | Usage::COPY_DST);
        let tangents = self.size("tangents", capacity);
        let tangent_staging = create(tangents, Usage::MAP_READ | Usage::COPY_DST);
        let entries: Vec<_> = (self.reflection.bindings.iter())
            .map(|(name, binding)| wgpu::BindGroupEntry {
                binding: binding.number,
                resource: named[name].as_entire_binding(),
            })
            .collect();
        let bind_group = (device.device).create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layout,
            entries: &entries,
        });
        let circle = self.bytes(&self.shape.circle());
        device.queue.write_buffer(&named["circle"], 0, &circle);
        let orders = bytemuck::cast_slice(&self.shape.orders);
        device.queue.write_buffer(&named["orders"], 0, orders);
        scope.close(device, |message| GpuError::Refused { states, message })?;
        Ok(Buffers {
            capacity,
            named,
            staging,
            tangent_staging,
            bind_group,
            timer: Timer::new(device, MOST_PASSES),
        })
    }

    /// Evaluates the states of all `parts` together.
    ///
    /// # Errors
    /// [`GpuError::Refused`] if the device refuses, [`GpuError::Lost`] if it is lost or hangs.
    pub fn evaluate(
        &self,
        device: &Device,
        buffers: &Buffers,
        parts: &[&ScaledStates],
        want: Want,
    ) -> Result<BatchResult, GpuError> {
        let n: usize = parts.iter().map(|part| part.n_states).sum();
        assert!(
            n <= buffers.capacity,
            "the buffers hold {} states",
            buffers.capacity
        );
        let scope = Scope::new(device);
        self.upload(device, buffers, parts, n);
        let commands = self.record(device, buffers, n, want);
        let submission = device.queue.submit([commands]);
        let read = self.read_batch(device, buffers, parts, n, want, submission);
        scope.close(device, |message| GpuError::Refused { states: n, message })?;
        read
    }

    fn upload(&self, device: &Device, buffers: &Buffers, parts: &[&ScaledStates], n: usize) {
        self.count(device, buffers, n);
        let named = &buffers.named;
        let rows = |values: fn(&ScaledStates) -> &[f64], n_rows: usize| {
            let mut all = Vec::with_capacity(n_rows * n);
            for row in 0..n_rows {
                for part in parts {
                    all.extend_from_slice(&values(part)[row * part.n_states..][..part.n_states]);
                }
            }
            self.bytes(&all)
        };
        let n_rows = 3 * (self.shape.n_coefficients() - 1);
        let coefficients = rows(|part| &part.coefficients, n_rows);
        device
            .queue
            .write_buffer(&named["coefficients"], 0, &coefficients);
        let constants = rows(|part| &part.constants, 4);
        device.queue.write_buffer(&named["states"], 0, &constants);
    }

    /// Says how many states the buffers hold.
    pub(crate) fn count(&self, device: &Device, buffers: &Buffers, n: usize) {
        let count = u32::try_from(n).unwrap_or(u32::MAX);
        let to = &buffers.named["batch"];
        device.queue.write_buffer(to, 0, &count.to_le_bytes());
    }

    /// The passes over the first `n` states that the buffers hold, timed from number 0 on where there is a `timer`.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &Buffers,
        n: usize,
        want: Want,
        timer: Option<&Timer>,
    ) {
        let groups = u32::try_from(n.div_ceil(self.reflection.group as usize)).unwrap_or(u32::MAX);
        encoder.clear_buffer(&buffers.named["flags"], 0, None);
        encoder.clear_buffer(&buffers.named["n_moving"], 0, None);
        for (i, (pass, pipeline)) in self.passes(want).iter().zip(&self.pipelines).enumerate() {
            let mut commands = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(pass.name),
                timestamp_writes: timer.map(|timer| timer.around(i)),
            });
            commands.set_pipeline(pipeline);
            commands.set_bind_group(0, &buffers.bind_group, &[]);
            commands.dispatch_workgroups(groups, (pass.rows)(&self.shape), 1);
        }
    }

    fn record(
        &self,
        device: &Device,
        buffers: &Buffers,
        n: usize,
        want: Want,
    ) -> wgpu::CommandBuffer {
        let passes = self.passes(want);
        let mut encoder = device.device.create_command_encoder(&Default::default());
        self.encode(&mut encoder, buffers, n, want, buffers.timer.as_ref());
        let mut offset = TIMER_BYTES;
        for name in RETURNED {
            let size = self.size(name, n);
            encoder.copy_buffer_to_buffer(&buffers.named[name], 0, &buffers.staging, offset, size);
            offset += size;
        }
        if let Some(timer) = &buffers.timer {
            timer.copy(&mut encoder, passes.len(), &buffers.staging);
        }
        encoder.finish()
    }

    fn read_batch(
        &self,
        device: &Device,
        buffers: &Buffers,
        parts: &[&ScaledStates],
        n: usize,
        want: Want,
        submission: wgpu::SubmissionIndex,
    ) -> Result<BatchResult, GpuError> {
        let returned: u64 = RETURNED.iter().map(|name| self.size(name, n)).sum();
        let bytes = read(device, &buffers.staging, TIMER_BYTES + returned, submission)?;
        let (ticks, mut rest) = bytes.split_at(TIMER_BYTES as usize);
        let mut take = |name: &str| {
            let size = self.size(name, n);
            let (head, tail) = rest.split_at(usize::try_from(size).unwrap_or(usize::MAX));
            rest = tail;
            head
        };
        let n_moving = u32s(take("n_moving"))[0] as usize;
        let flags = u32s(take("flags"));
        let slots = u32s(take("slots"));
        let deviations = self.numbers(take("deviations"));
        let names = self.pass_names(want);
        let pass_seconds = (buffers.timer.as_ref()).map(|timer| timer.seconds(&names, ticks));
        let tangents = match (want, n_moving) {
            (Want::Forces, _) | (_, 0) => Vec::new(),
            _ => self.read_tangents(device, buffers, n_moving)?,
        };
        let moving = Moving {
            flags,
            slots,
            deviations,
            tangents,
            group: self.reflection.group as usize,
            m: self.shape.n_coefficients(),
            blocks: self.shape.blocks(),
            with_tangents: want == Want::ForcesAndTangents,
        };
        let mut first = 0;
        let parts = (parts.iter())
            .map(|part| {
                let range = first..first + part.n_states;
                first = range.end;
                moving.part(range)
            })
            .collect();
        Ok(BatchResult {
            parts,
            pass_seconds,
        })
    }

    /// Tangents of the states that move, and of them alone.
    fn read_tangents(
        &self,
        device: &Device,
        buffers: &Buffers,
        n_moving: usize,
    ) -> Result<Vec<f64>, GpuError> {
        let slots = n_moving.next_multiple_of(self.reflection.group as usize);
        let size = self.size("tangents", slots);
        let mut encoder = device.device.create_command_encoder(&Default::default());
        let (from, to) = (&buffers.named["tangents"], &buffers.tangent_staging);
        encoder.copy_buffer_to_buffer(from, 0, to, 0, size);
        let submission = device.queue.submit([encoder.finish()]);
        Ok(self.numbers(&read(device, to, size, submission)?))
    }

    /// Numbers in the shape's precision.
    fn bytes(&self, values: &[f64]) -> Vec<u8> {
        let single = |x: &f64| *x as f32;
        match self.shape.precision {
            Precision::F32 => {
                bytemuck::cast_slice(&values.iter().map(single).collect::<Vec<_>>()).to_vec()
            }
            Precision::F64 => bytemuck::cast_slice(values).to_vec(),
        }
    }

    fn numbers(&self, bytes: &[u8]) -> Vec<f64> {
        match self.shape.precision {
            Precision::F32 => (bytes.as_chunks().0.iter())
                .map(|b| f64::from(f32::from_le_bytes(*b)))
                .collect(),
            Precision::F64 => (bytes.as_chunks().0.iter())
                .map(|b| f64::from_le_bytes(*b))
                .collect(),
        }
    }
}

/// Catches what the device says of the calls of this thread. Where nobody closes it the last scope must end first, as the fields do.
pub(crate) struct Scope {
    internal: wgpu::ErrorScopeGuard,
    validation: wgpu::ErrorScopeGuard,
    memory: wgpu::ErrorScopeGuard,
}

impl Scope {
    pub(crate) fn new(device: &Device) -> Self {
        let push = |filter| device.device.push_error_scope(filter);
        let memory = push(wgpu::ErrorFilter::OutOfMemory);
        let validation = push(wgpu::ErrorFilter::Validation);
        let internal = push(wgpu::ErrorFilter::Internal);
        Self {
            internal,
            validation,
            memory,
        }
    }

    /// The first error, as `refusal` puts it. A lost device reports errors of every kind, and is no refusal.
    pub(crate) fn close(
        self,
        device: &Device,
        refusal: impl FnOnce(String) -> GpuError,
    ) -> Result<(), GpuError> {
        let errors = [self.internal, self.validation, self.memory]
            .map(|scope| pollster::block_on(scope.pop()));
        if device.is_lost() {
            let message = "reset while it computed".to_owned();
            return Err(GpuError::Lost { message });
        }
        match errors.into_iter().flatten().next() {
            Some(error) => Err(refusal(error.to_string())),
            None => Ok(()),
        }
    }
}
