//! Newton iterations of many lanes on a device.

use super::program::{LanePlaces, Program, TILE, TOLD, Use, text};
use super::search::Told;
use super::system::{Lane, LaneSystem};
use crate::aft::{AftPlan, Want};
use crate::gpu::{Buffers, Device, Fault, GpuError, Kernels, Precision, Scope, Shape, read};
use crate::hb::equations::inverse::InverseJacobian;
use faer::c64;
use std::collections::BTreeMap;
use wgpu::BufferUsages as Usage;

/// Contact arrays that the passes over lanes bind, in the order of their numbers.
const CONTACT_ARRAYS: [&str; 6] = [
    "coefficients",
    "states",
    "deviations",
    "flags",
    "slots",
    "tangents",
];
/// Arrays of the lanes before those: which of them are written.
const WRITTEN: [bool; 7] = [false, false, false, false, false, true, true];
/// Of the contact arrays, those that are written.
const WRITTEN_CONTACT: usize = 2;
/// Bytes from the arguments of one pass to those of the next.
const JOB_BYTES: u64 = 256;

/// Compiled passes for one system and one way to evaluate contacts.
#[derive(Debug)]
pub struct LaneKernels {
    system: LaneSystem,
    contact: Kernels,
    fault: Option<Fault>,
    layout: wgpu::BindGroupLayout,
    pipelines: BTreeMap<&'static str, wgpu::ComputePipeline>,
}

/// Lanes on a device.
#[derive(Debug)]
pub struct LaneBatch<'k> {
    kernels: &'k LaneKernels,
    device: &'k Device,
    /// Column of each lane.
    columns: Vec<usize>,
    /// Columns in all, whole tiles.
    lanes: usize,
    contact: Buffers,
    numbers: wgpu::Buffer,
    steps: wgpu::Buffer,
    told: wgpu::Buffer,
    staging: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    uses: [Vec<Use>; 2],
    iterations: u64,
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

fn bytes(numbers: &[f32]) -> &[u8] {
    bytemuck::cast_slice(numbers)
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
        let shape = Shape::of(plan, Precision::F32).ok_or_else(|| GpuError::Shader {
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
        })
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

    /// Columns that `inverse_of` lanes take: each inverse has whole tiles of its own.
    fn columns(inverse_of: &[usize], inverses: usize) -> (Vec<usize>, Vec<u32>) {
        let (mut columns, mut of_tile) = (vec![0; inverse_of.len()], Vec::new());
        for inverse in 0..inverses {
            let mut next = of_tile.len() * TILE;
            for (column, of) in columns.iter_mut().zip(inverse_of) {
                if *of == inverse {
                    *column = next;
                    next += 1;
                }
            }
            of_tile.resize(
                next.div_ceil(TILE),
                u32::try_from(inverse).unwrap_or(u32::MAX),
            );
        }
        (columns, of_tile)
    }

    /// Brings lanes to the device, each with the number of its inverse among `inverses`.
    ///
    /// # Errors
    /// [`GpuError::Refused`] if the device has not the memory.
    pub fn begin<'k>(
        &'k self,
        device: &'k Device,
        lanes: &[(Lane, usize)],
        inverses: &[&InverseJacobian],
    ) -> Result<LaneBatch<'k>, GpuError> {
        let inverse_of: Vec<usize> = lanes.iter().map(|(_, inverse)| *inverse).collect();
        let (columns, of_tile) = Self::columns(&inverse_of, inverses.len());
        let width = of_tile.len() * TILE;
        let states = self.system.n_pairs * width;
        if matches!(self.fault, Some(Fault::RefuseAbove(most)) if states > most) {
            let message = "on purpose".to_owned();
            return Err(GpuError::Refused { states, message });
        }
        let scope = Scope::new(device);
        let contact = self.contact.buffers(device, states)?;
        self.contact.count(device, &contact, states);
        let program = Program::new(&self.system, width, self.fault);
        let uses = [program.to_contacts(), program.to_directions()];
        let rows = |of: fn(&Lane) -> &[f32]| in_columns(lanes, &columns, width, of);
        let matrices: Vec<f32> = inverses.iter().flat_map(|x| x.columns()).collect();
        let numbers = empty(
            device,
            LanePlaces::new(&self.system).end * width,
            Usage::STORAGE,
        );
        let point = [rows(|lane| &lane.point), rows(|lane| &lane.detuning)].concat();
        device.queue.write_buffer(&numbers, 0, bytes(&point));
        let arrays = [
            filled(device, bytes(&self.system.numbers)),
            filled(device, bytes(&matrices)),
            filled(device, bytemuck::cast_slice(&of_tile)),
            filled(device, bytes(&rows(|lane| &lane.own))),
            empty(device, width, Usage::STORAGE),
            numbers,
            empty(device, TOLD * width, Usage::STORAGE),
        ];
        let bind_group = self.bind_group(device, &uses, &arrays, &contact);
        let staging = empty(device, (self.system.size() + 1) * width, Usage::MAP_READ);
        scope.close(device, |message| GpuError::Refused { states, message })?;
        let [.., steps, numbers, told] = arrays;
        Ok(LaneBatch {
            kernels: self,
            device,
            columns,
            lanes: width,
            contact,
            numbers,
            steps,
            told,
            staging,
            bind_group,
            uses,
            iterations: 0,
        })
    }

    /// The passes' arguments and arrays.
    fn bind_group(
        &self,
        device: &Device,
        uses: &[Vec<Use>; 2],
        arrays: &[wgpu::Buffer],
        contact: &Buffers,
    ) -> wgpu::BindGroup {
        let jobs = self.jobs(device, uses);
        let of_contacts = CONTACT_ARRAYS.map(|name| contact.buffer(name));
        let all = arrays.iter().chain(of_contacts);
        let resources = all.map(wgpu::Buffer::as_entire_binding);
        let job = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &jobs,
            offset: 0,
            size: std::num::NonZeroU64::new(JOB_BYTES),
        });
        let entries: Vec<_> = (std::iter::once(job).chain(resources).zip(0..))
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let descriptor = wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layout,
            entries: &entries,
        };
        device.device.create_bind_group(&descriptor)
    }

    /// The arguments of all passes.
    fn jobs(&self, device: &Device, uses: &[Vec<Use>; 2]) -> wgpu::Buffer {
        let words = uses.iter().flatten().flat_map(|used| {
            let mut words = used.job.words().to_vec();
            words.resize(JOB_BYTES as usize / 4, 0);
            words
        });
        let words: Vec<u32> = words.collect();
        let jobs = empty(device, words.len(), Usage::UNIFORM);
        let bytes = bytemuck::cast_slice(&words);
        device.queue.write_buffer(&jobs, 0, bytes);
        jobs
    }
}

/// A buffer for so many numbers.
fn empty(device: &Device, numbers: usize, usage: Usage) -> wgpu::Buffer {
    let copied = match usage {
        Usage::MAP_READ => Usage::COPY_DST,
        _ => Usage::COPY_DST | Usage::COPY_SRC,
    };
    device.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 4 * numbers as u64,
        usage: usage | copied,
        mapped_at_creation: false,
    })
}

fn filled(device: &Device, data: &[u8]) -> wgpu::Buffer {
    let buffer = empty(device, data.len() / 4, Usage::STORAGE);
    device.queue.write_buffer(&buffer, 0, data);
    buffer
}

/// Rows of all lanes, lanes fastest. Columns without a lane have the numbers of the lane before.
fn in_columns(
    lanes: &[(Lane, usize)],
    columns: &[usize],
    width: usize,
    of: fn(&Lane) -> &[f32],
) -> Vec<f32> {
    let mut lane_of = vec![None; width];
    for (lane, column) in lanes.iter().zip(columns) {
        lane_of[*column] = Some(&lane.0);
    }
    let mut before = None;
    for lane in &mut lane_of {
        before = lane.or(before);
        *lane = before;
    }
    let rows: Vec<&[f32]> = lane_of.into_iter().flatten().map(of).collect();
    let n = rows.first().map_or(0, |row| row.len());
    (0..n)
        .flat_map(|i| rows.iter().map(move |row| row[i]))
        .collect()
}

impl LaneBatch<'_> {
    /// One iteration: lanes go along their last correction, and by a step of the frequency (rad/s) along their tangent; then
    /// they solve for the next ones. A lane without a step stays where it is.
    ///
    /// # Errors
    /// What the device says.
    pub fn step(&mut self, steps: &[Option<f64>]) -> Result<Vec<Told>, GpuError> {
        let mut all = vec![f32::NAN; self.lanes];
        for (column, step) in self.columns.iter().zip(steps) {
            #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
            let step = step.map_or(f32::NAN, |step| step as f32);
            all[*column] = step;
        }
        let device = self.device;
        if self.kernels.fault == Some(Fault::LoseDeviceInIteration(self.iterations)) {
            device.destroy();
        }
        self.iterations += 1;
        let scope = Scope::new(device);
        device.queue.write_buffer(&self.steps, 0, bytes(&all));
        let mut encoder = device.device.create_command_encoder(&Default::default());
        let mut number = 0;
        self.encode(&mut encoder, 0, &mut number);
        let states = self.kernels.system.n_pairs * self.lanes;
        let contact = &self.kernels.contact;
        contact.encode(&mut encoder, &self.contact, states, Want::ForcesAndTangents);
        self.encode(&mut encoder, 1, &mut number);
        let size = 4 * (TOLD * self.lanes) as u64;
        encoder.copy_buffer_to_buffer(&self.told, 0, &self.staging, 0, size);
        let submission = device.queue.submit([encoder.finish()]);
        let told = read(device, &self.staging, size, submission);
        scope.close(device, |message| GpuError::Refused { states, message })?;
        let told = numbers(&told?);
        let row = |i: usize, column: usize| f64::from(told[i * self.lanes + column]);
        let of = |&column: &usize| {
            let row = |i| row(i, column);
            Told {
                size: row(0),
                right: [row(1), row(2)],
                left: [row(3), row(4)],
                // x_c − i x_s
                response: c64::new(row(5), -row(6)),
                by_correction: c64::new(row(7), -row(8)),
                by_tangent: c64::new(row(9), -row(10)),
                undecided: row(11) != 0.0,
                omega: self.kernels.system.reference + row(12),
            }
        };
        Ok(self.columns.iter().map(of).collect())
    }

    fn encode(&self, encoder: &mut wgpu::CommandEncoder, part: usize, number: &mut u64) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for used in &self.uses[part] {
            let offset = u32::try_from(*number * JOB_BYTES).unwrap_or(u32::MAX);
            pass.set_pipeline(&self.kernels.pipelines[used.entry]);
            pass.set_bind_group(0, &self.bind_group, &[offset]);
            let [x, y, z] = used.groups.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
            pass.dispatch_workgroups(x, y, z);
            *number += 1;
        }
    }

    /// Correction and tangent of the last iteration.
    ///
    /// # Errors
    /// What the device says.
    pub fn solutions(&self) -> Result<Vec<[Vec<f64>; 2]>, GpuError> {
        let size = self.kernels.system.size();
        let place = LanePlaces::new(&self.kernels.system).solution;
        let rows = 2 * size;
        let staging = empty(self.device, rows * self.lanes, Usage::MAP_READ);
        let numbers = self.copied(&staging, place, rows)?;
        let of = |&column: &usize| {
            [column, column + self.lanes].map(|column| {
                let entry = |i: usize| f64::from(numbers[2 * i * self.lanes + column]);
                (0..size).map(entry).collect()
            })
        };
        Ok(self.columns.iter().map(of).collect())
    }

    /// Displacements and frequencies (rad/s) of the lanes.
    ///
    /// # Errors
    /// What the device says.
    pub fn points(&self) -> Result<Vec<(Vec<f64>, f64)>, GpuError> {
        let size = self.kernels.system.size();
        let numbers = self.copied(&self.staging, 0, size + 1)?;
        let of = |&column: &usize| {
            let row = |i: usize| f64::from(numbers[i * self.lanes + column]);
            let r = (0..size).map(row).collect();
            (r, self.kernels.system.reference + row(size))
        };
        Ok(self.columns.iter().map(of).collect())
    }

    /// Rows of the arrays of the lanes.
    fn copied(&self, to: &wgpu::Buffer, place: usize, rows: usize) -> Result<Vec<f32>, GpuError> {
        let device = self.device;
        let scope = Scope::new(device);
        let [from, size] = [place, rows].map(|rows| 4 * (rows * self.lanes) as u64);
        let mut encoder = device.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.numbers, from, to, 0, size);
        let submission = device.queue.submit([encoder.finish()]);
        let read = read(device, to, size, submission);
        scope.close(device, |message| GpuError::Refused { states: 0, message })?;
        Ok(numbers(&read?))
    }
}

fn numbers(bytes: &[u8]) -> Vec<f32> {
    let words = bytes.as_chunks().0.iter();
    words.map(|b| f32::from_le_bytes(*b)).collect()
}
