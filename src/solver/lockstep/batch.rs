//! Newton iterations of a batch of lanes on a device.

use super::arrays::{LaneArrays, empty};
use super::kernels::{CONTACT_ARRAYS, LaneKernels};
use super::program::{LanePlaces, Program, TILE, TOLD, Use};
use super::search::Told;
use super::system::Lane;
use crate::aft::Want;
use crate::gpu::{Device, Fault, GpuError, Scope, Timer, read};
use crate::hb::equations::inverse::InverseJacobian;
use faer::c64;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;
use wgpu::BufferUsages as Usage;

/// Bytes from the arguments of one pass to those of the next.
const JOB_BYTES: u64 = 256;
/// Rows that are brought together: so many numbers of a lane lie side by side in a line of a cache.
const ROWS_TOGETHER: usize = 16;

/// Lanes on a device.
#[derive(Debug)]
pub struct LaneBatch<'k> {
    pub(super) kernels: &'k LaneKernels,
    pub(super) device: &'k Device,
    pub(super) arrays: Arc<LaneArrays>,
    /// Column of each lane.
    columns: Vec<usize>,
    /// Columns in all, whole tiles.
    lanes: usize,
    bind_group: wgpu::BindGroup,
    pub(super) uses: Vec<Use>,
    /// Uses before the passes of the contacts.
    before_contacts: usize,
    iterations: u64,
}

impl LaneKernels {
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
        let (columns, of_tile) = columns_of(&inverse_of, inverses.len());
        let width = of_tile.len() * TILE;
        let states = self.system.n_pairs * width;
        let arrays = self.arrays(device, width, inverses.len())?;
        let scope = Scope::new(device);
        let program = Program::new(&self.system, width, self.fault);
        let mut uses = program.to_contacts();
        let before_contacts = uses.len();
        uses.extend(program.to_directions());
        let batch = LaneBatch {
            bind_group: self.bind_group(device, &uses, &arrays),
            kernels: self,
            device,
            arrays,
            columns,
            lanes: width,
            uses,
            before_contacts,
            iterations: 0,
        };
        batch.fill(lanes, inverses, &of_tile);
        scope.close(device, |message| GpuError::Refused { states, message })?;
        Ok(batch)
    }

    /// The passes' arguments and arrays.
    fn bind_group(&self, device: &Device, uses: &[Use], arrays: &LaneArrays) -> wgpu::BindGroup {
        let jobs = jobs(device, uses);
        let of_contacts = CONTACT_ARRAYS.map(|name| arrays.contact.buffer(name));
        let all = arrays.bound().into_iter().chain(of_contacts);
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
}

/// The arguments of all passes.
fn jobs(device: &Device, uses: &[Use]) -> wgpu::Buffer {
    let words = uses.iter().flat_map(|used| {
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

/// Columns that `inverse_of` lanes take: each inverse has whole tiles of its own.
fn columns_of(inverse_of: &[usize], inverses: usize) -> (Vec<usize>, Vec<u32>) {
    let (mut columns, mut of_tile) = (vec![0; inverse_of.len()], Vec::new());
    for inverse in 0..inverses {
        let mut next = of_tile.len() * TILE;
        for (column, of) in columns.iter_mut().zip(inverse_of) {
            if *of == inverse {
                *column = next;
                next += 1;
            }
        }
        let number = u32::try_from(inverse).unwrap_or(u32::MAX);
        of_tile.resize(next.div_ceil(TILE), number);
    }
    (columns, of_tile)
}

/// The rows of all `columns` as one array, columns fastest.
fn in_columns(columns: &[&Lane], of: fn(&Lane) -> &[f32]) -> Vec<f32> {
    let rows: Vec<&[f32]> = columns.iter().copied().map(of).collect();
    let (n, width) = (rows.first().map_or(0, |row| row.len()), rows.len());
    let mut all = vec![0.0; n * width];
    let together = all.par_chunks_mut(ROWS_TOGETHER * width).enumerate();
    together.for_each(|(chunk, out)| {
        for (column, row) in rows.iter().enumerate() {
            let numbers = &row[chunk * ROWS_TOGETHER..];
            for (out, number) in out.chunks_exact_mut(width).zip(numbers) {
                out[column] = *number;
            }
        }
    });
    all
}

fn bytes(numbers: &[f32]) -> &[u8] {
    bytemuck::cast_slice(numbers)
}

impl LaneBatch<'_> {
    /// Writes what the device is to know of the lanes, and the inverses that their tiles share.
    fn fill(&self, lanes: &[(Lane, usize)], inverses: &[&InverseJacobian], of_tile: &[u32]) {
        let mut lane_of = vec![None; self.lanes];
        for (lane, column) in lanes.iter().zip(&self.columns) {
            lane_of[*column] = Some(&lane.0);
        }
        // a column without a lane gets the numbers of the lane before it
        let mut before = None;
        let columns = lane_of.into_iter().filter_map(|lane| {
            before = lane.or(before);
            before
        });
        let columns: Vec<&Lane> = columns.collect();
        let size = self.kernels.system.size();
        let mut matrices = vec![0.0; inverses.len() * size * size];
        let of_matrices = matrices.par_chunks_mut(size * size).zip(inverses);
        of_matrices.for_each(|(matrix, inverse)| inverse.columns(matrix));
        let (point, own) = rayon::join(
            || {
                let point = in_columns(&columns, |lane| &lane.point);
                let detuning = in_columns(&columns, |lane| &lane.detuning);
                // correction and tangent of the iteration before, of which there is none
                let before = vec![0.0; 2 * size * self.lanes];
                [point, detuning, before].concat()
            },
            || in_columns(&columns, |lane| &lane.own),
        );
        let (queue, arrays) = (&self.device.queue, &self.arrays);
        queue.write_buffer(&arrays.numbers, 0, bytes(&point));
        queue.write_buffer(&arrays.own, 0, bytes(&own));
        queue.write_buffer(&arrays.inverses, 0, bytes(&matrices));
        queue.write_buffer(&arrays.inverse_of, 0, bytemuck::cast_slice(of_tile));
        let (states, _) = self.contacts();
        (self.kernels.contact).count(self.device, &arrays.contact, states);
    }

    /// One iteration: lanes go along their last correction, and by a step of the frequency (rad/s) along their tangent; then
    /// they solve for the next ones. A lane without a step stays where it is.
    ///
    /// # Errors
    /// What the device says.
    pub fn step(&mut self, steps: &[Option<f64>]) -> Result<Vec<Told>, GpuError> {
        let mut all = vec![f32::NAN; self.lanes];
        for (column, step) in self.columns.iter().zip(steps) {
            let step = step.map_or(f32::NAN, |step| step as f32);
            all[*column] = step;
        }
        let device = self.device;
        if self.kernels.fault == Some(Fault::LoseDeviceInIteration(self.iterations)) {
            device.destroy();
        }
        self.iterations += 1;
        let scope = Scope::new(device);
        device
            .queue
            .write_buffer(&self.arrays.steps, 0, bytes(&all));
        let mut encoder = device.device.create_command_encoder(&Default::default());
        self.encode(&mut encoder, 0..self.before_contacts, None);
        let contact = &self.kernels.contact;
        let (states, want) = self.contacts();
        contact.encode(&mut encoder, &self.arrays.contact, states, want, None);
        self.encode(&mut encoder, self.before_contacts..self.uses.len(), None);
        let size = 4 * (TOLD * self.lanes) as u64;
        encoder.copy_buffer_to_buffer(&self.arrays.told, 0, &self.arrays.staging, 0, size);
        let submission = device.queue.submit([encoder.finish()]);
        let told = read(device, &self.arrays.staging, size, submission);
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

    /// Number of contact states, and what is wanted of them.
    pub(super) fn contacts(&self) -> (usize, Want) {
        let states = self.kernels.system.n_pairs * self.lanes;
        (states, Want::ForcesAndTangents)
    }

    /// The uses of these numbers in one pass, timed as the first of them where there is a `timer`.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        numbers: Range<usize>,
        timer: Option<&Timer>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: timer.map(|timer| timer.around(numbers.start)),
        });
        for number in numbers {
            let used = &self.uses[number];
            let offset = u32::try_from(number as u64 * JOB_BYTES).unwrap_or(u32::MAX);
            pass.set_pipeline(&self.kernels.pipelines[used.entry]);
            pass.set_bind_group(0, &self.bind_group, &[offset]);
            let [x, y, z] = used.groups.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
            pass.dispatch_workgroups(x, y, z);
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
        let numbers = self.copied(&self.arrays.staging, 0, size + 1)?;
        let of = |&column: &usize| {
            let row = |i: usize| f64::from(numbers[i * self.lanes + column]);
            let r = (0..size).map(row).collect();
            (r, self.kernels.system.reference + row(size))
        };
        Ok(self.columns.par_iter().map(of).collect())
    }

    /// Rows of the arrays of the lanes.
    fn copied(&self, to: &wgpu::Buffer, place: usize, rows: usize) -> Result<Vec<f32>, GpuError> {
        let device = self.device;
        let scope = Scope::new(device);
        let [from, size] = [place, rows].map(|rows| 4 * (rows * self.lanes) as u64);
        let mut encoder = device.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.arrays.numbers, from, to, 0, size);
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
