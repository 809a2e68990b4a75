//! From staging buffers to the answers of a batch's parts.

use super::adapter::Device;
use super::error::GpuError;
use super::scaled::ScaledForces;
use crate::aft::TangentBlock;
use std::time::Duration;

/// Flags of a state, as the shaders set them.
const MOVED: u32 = 1;
/// A device that takes longer than this for one batch hangs; the first one waits for the driver's compiler.
const PATIENCE: Duration = Duration::from_secs(120);
/// The same for a software adapter, which shares the processor with whatever else runs there.
const SOFTWARE_PATIENCE: Duration = Duration::from_secs(1200);

/// Buffers that come back whole, in the order of the staging buffer.
pub(super) const RETURNED: [&str; 4] = ["n_moving", "flags", "slots", "deviations"];

/// A whole batch, read back.
pub(super) struct Moving {
    pub flags: Vec<u32>,
    pub slots: Vec<u32>,
    /// Shape: `[3][m][state]`.
    pub deviations: Vec<f64>,
    /// Shape: `[slot / group][block of blocks][m][m][slot % group]`.
    pub tangents: Vec<f64>,
    pub group: usize,
    pub m: usize,
    pub blocks: &'static [TangentBlock],
    pub with_tangents: bool,
}

impl Moving {
    /// The states of one part.
    pub(super) fn part(&self, range: std::ops::Range<usize>) -> ScaledForces {
        let n = self.flags.len();
        let mut out = ScaledForces {
            blocks: self.blocks,
            ..ScaledForces::default()
        };
        for row in self.deviations.chunks_exact(n) {
            out.deviations.extend_from_slice(&row[range.clone()]);
        }
        for state in range.clone() {
            let (flag, slot) = (self.flags[state], self.slots[state] as usize);
            let mut forces = self.deviations[state..].iter().step_by(n);
            let tangent = || self.tangent(slot);
            let moves = flag == MOVED;
            let good = forces.all(|f| f.is_finite())
                && (flag == 0
                    || moves && (!self.with_tangents || tangent().all(|x| x.is_finite())));
            if !good {
                out.undecided.push(state - range.start);
            }
            out.slots.push((good && moves).then_some(out.n_moving));
            if good && moves {
                out.n_moving += 1;
                if self.with_tangents {
                    out.tangents.extend(tangent());
                }
            }
        }
        out
    }

    /// Entries of the tangent at `slot`.
    fn tangent(&self, slot: usize) -> impl Iterator<Item = &f64> {
        let size = self.blocks.len() * self.m * self.m;
        let first = slot / self.group * size * self.group + slot % self.group;
        self.tangents[first..].iter().step_by(self.group).take(size)
    }
}

pub(super) fn u32s(bytes: &[u8]) -> Vec<u32> {
    bytes
        .as_chunks()
        .0
        .iter()
        .map(|b| u32::from_le_bytes(*b))
        .collect()
}

/// Waits for a submission and copies the first `size` bytes of a staging buffer.
pub(crate) fn read(
    device: &Device,
    staging: &wgpu::Buffer,
    size: u64,
    submission: wgpu::SubmissionIndex,
) -> Result<Vec<u8>, GpuError> {
    let lost = |message: String| GpuError::Lost { message };
    let slice = staging.slice(..size);
    let (sender, receiver) = std::sync::mpsc::channel();
    slice.map_async(wgpu::MapMode::Read, move |result| {
        // the receiver is gone only if this function has given up
        let _ = sender.send(result);
    });
    let patience = match device.adapter.is_hardware() {
        true => PATIENCE,
        false => SOFTWARE_PATIENCE,
    };
    let wait = wgpu::PollType::Wait {
        submission_index: Some(submission),
        timeout: Some(patience),
    };
    device
        .device
        .poll(wait)
        .map_err(|error| lost(error.to_string()))?;
    match receiver.recv_timeout(patience) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(lost(error.to_string())),
        Err(error) => return Err(lost(error.to_string())),
    }
    let view = slice
        .get_mapped_range()
        .map_err(|error| lost(error.to_string()))?;
    let bytes = view.to_vec();
    drop(view);
    staging.unmap();
    Ok(bytes)
}
