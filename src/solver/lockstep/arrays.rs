//! Arrays of lanes on a device.

use super::program::{LanePlaces, TOLD};
use super::system::LaneSystem;
use crate::gpu::{Buffers, Device, Fault, GpuError, Kernels, Scope};
use wgpu::BufferUsages as Usage;

/// Arrays that one batch after the other uses. Each is at least as long as its batch needs.
#[derive(Debug)]
pub(super) struct LaneArrays {
    /// Columns and inverses that they can hold.
    columns: usize,
    inverses_at_most: usize,
    /// Those of the contact passes.
    pub contact: Buffers,
    /// What all lanes share.
    pub shared: wgpu::Buffer,
    /// Inverse Jacobians, and that of each tile of lanes.
    pub inverses: wgpu::Buffer,
    pub inverse_of: wgpu::Buffer,
    /// What a lane does not change.
    pub own: wgpu::Buffer,
    /// Steps of the frequency.
    pub steps: wgpu::Buffer,
    /// What the passes compute ([`LanePlaces`]).
    pub numbers: wgpu::Buffer,
    /// What comes back.
    pub told: wgpu::Buffer,
    /// Where it is read.
    pub staging: wgpu::Buffer,
}

impl LaneArrays {
    /// Arrays for `columns` columns, whole tiles, and `inverses` inverses; `fault` may refuse them.
    ///
    /// # Errors
    /// [`GpuError::Refused`] if the device has not the memory.
    pub(super) fn new(
        device: &Device,
        system: &LaneSystem,
        contact: &Kernels,
        columns: usize,
        inverses: usize,
        fault: Option<Fault>,
    ) -> Result<Self, GpuError> {
        let size = system.size();
        let states = system.n_pairs * columns;
        let scope = Scope::new(device);
        if matches!(fault, Some(Fault::RefuseAbove(most)) if states > most) {
            let message = "on purpose".to_owned();
            return Err(GpuError::Refused { states, message });
        }
        let storage = |numbers| empty(device, numbers, Usage::STORAGE);
        let arrays = Self {
            columns,
            inverses_at_most: inverses,
            contact: contact.buffers(device, states)?,
            shared: storage(system.numbers.len()),
            inverses: storage(inverses * size * size),
            inverse_of: storage(columns),
            own: storage(system.own_rows() * columns),
            steps: storage(columns),
            numbers: storage(LanePlaces::new(system).end * columns),
            told: storage(TOLD * columns),
            staging: empty(device, (size + 1) * columns, Usage::MAP_READ),
        };
        let shared = bytemuck::cast_slice(&system.numbers);
        device.queue.write_buffer(&arrays.shared, 0, shared);
        scope.close(device, |message| GpuError::Refused { states, message })?;
        Ok(arrays)
    }

    /// Whether a batch of `columns` columns with `inverses` inverses fits in.
    pub(super) fn have_room(&self, columns: usize, inverses: usize) -> bool {
        columns <= self.columns && inverses <= self.inverses_at_most
    }

    /// Those that the passes over lanes bind before the arrays of the contacts, in the order of their numbers.
    pub(super) fn bound(&self) -> [&wgpu::Buffer; 7] {
        [
            &self.shared,
            &self.inverses,
            &self.inverse_of,
            &self.own,
            &self.steps,
            &self.numbers,
            &self.told,
        ]
    }
}

/// A buffer for so many numbers.
pub(super) fn empty(device: &Device, numbers: usize, usage: Usage) -> wgpu::Buffer {
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
