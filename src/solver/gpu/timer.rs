//! Time that passes take on a device, by its own timestamps.

use super::adapter::Device;
use wgpu::BufferUsages as Usage;

/// Bytes of the timestamps at both ends of a pass.
const PASS_BYTES: u64 = 16;

/// Time (s) on the device by pass.
pub type PassSeconds = Vec<(&'static str, f64)>;

/// Timestamps at both ends of every pass.
#[derive(Debug)]
pub(crate) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Length of a tick (s).
    tick: f64,
}

impl Timer {
    /// A timer of up to `passes` passes; none on a device without timestamps.
    pub(crate) fn new(device: &Device, passes: usize) -> Option<Self> {
        let on = &device.device;
        device.adapter.timestamps.then(|| Self {
            queries: on.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2 * passes as u32,
            }),
            resolved: on.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: Self::bytes(passes),
                usage: Usage::QUERY_RESOLVE | Usage::COPY_SRC,
                mapped_at_creation: false,
            }),
            tick: f64::from(device.queue.get_timestamp_period()) * 1e-9,
        })
    }

    /// Bytes of the timestamps of `passes` passes.
    pub(crate) const fn bytes(passes: usize) -> u64 {
        PASS_BYTES * passes as u64
    }

    /// What the description of a pass says to be timed as number `pass`.
    pub(crate) fn around(&self, pass: usize) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pass as u32),
            end_of_pass_write_index: Some(2 * pass as u32 + 1),
        }
    }

    /// Brings the timestamps of the first `passes` passes to the beginning of `staging`.
    pub(crate) fn copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: usize,
        staging: &wgpu::Buffer,
    ) {
        encoder.resolve_query_set(&self.queries, 0..2 * passes as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, staging, 0, Self::bytes(passes));
    }

    /// Times of the passes called `names`, from their timestamps.
    pub(crate) fn seconds<'n>(
        &self,
        names: impl IntoIterator<Item = &'n &'static str>,
        bytes: &[u8],
    ) -> PassSeconds {
        let (ticks, _) = bytes.as_chunks::<8>();
        (names.into_iter().zip(ticks.chunks_exact(2)))
            .map(|(name, ends)| {
                let [start, end] = [ends[0], ends[1]].map(u64::from_le_bytes);
                (*name, end.saturating_sub(start) as f64 * self.tick)
            })
            .collect()
    }
}
