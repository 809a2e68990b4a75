//! Time that the passes of an iteration take on a device.

use super::arrays::empty;
use super::batch::LaneBatch;
use crate::gpu::{GpuError, Scope, Timer, read};
use std::collections::BTreeMap;
use wgpu::BufferUsages as Usage;

/// What one pass takes in an iteration, all its uses together.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PassTime {
    /// Number of uses.
    pub uses: usize,
    /// Time on the device (s).
    pub seconds: f64,
    /// Multiplications and additions of its products with matrices; 0 where it does something else.
    pub operations: f64,
}

impl LaneBatch<'_> {
    /// Times of the passes of one iteration, by name, those of the contacts included; none where the device has no timestamps. The
    /// lanes do what they did in the last iteration.
    ///
    /// # Errors
    /// What the device says.
    pub fn pass_times(&self) -> Result<Option<BTreeMap<&'static str, PassTime>>, GpuError> {
        let contact = &self.kernels.contact;
        let (states, want) = self.contacts();
        let of_contacts = contact.pass_names(want);
        let of_lanes: Vec<_> = self.uses.iter().map(|used| used.entry).collect();
        let timers = [&of_contacts, &of_lanes].map(|names| Timer::new(self.device, names.len()));
        let [Some(on_contacts), Some(on_lanes)] = timers else {
            return Ok(None);
        };
        let mut encoder = self
            .device
            .device
            .create_command_encoder(&Default::default());
        contact.encode(
            &mut encoder,
            &self.arrays.contact,
            states,
            want,
            Some(&on_contacts),
        );
        let bytes = self.timestamps(encoder, &on_contacts, of_contacts.len())?;
        let contact_times = on_contacts.seconds(&of_contacts, &bytes);
        let mut encoder = self
            .device
            .device
            .create_command_encoder(&Default::default());
        for number in 0..of_lanes.len() {
            self.encode(&mut encoder, number..number + 1, Some(&on_lanes));
        }
        let bytes = self.timestamps(encoder, &on_lanes, of_lanes.len())?;
        let lane_times = on_lanes.seconds(&of_lanes, &bytes);
        let operations = self.uses.iter().map(|used| used.operations());
        let of_contacts = contact_times.into_iter().map(|time| (time, 0.0));
        let mut times: BTreeMap<&'static str, PassTime> = BTreeMap::new();
        for ((name, seconds), operations) in
            of_contacts.chain(lane_times.into_iter().zip(operations))
        {
            let of_pass = times.entry(name).or_default();
            of_pass.uses += 1;
            of_pass.seconds += seconds;
            of_pass.operations += operations;
        }
        Ok(Some(times))
    }

    /// The timestamps of `passes` passes that `encoder` holds.
    fn timestamps(
        &self,
        mut encoder: wgpu::CommandEncoder,
        timer: &Timer,
        passes: usize,
    ) -> Result<Vec<u8>, GpuError> {
        let device = self.device;
        let scope = Scope::new(device);
        let bytes = Timer::bytes(passes);
        let staging = empty(device, passes * 4, Usage::MAP_READ);
        timer.copy(&mut encoder, passes, &staging);
        let submission = device.queue.submit([encoder.finish()]);
        let read = read(device, &staging, bytes, submission);
        scope.close(device, |message| GpuError::Refused { states: 0, message })?;
        read
    }
}
