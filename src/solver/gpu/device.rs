//! An open, tested device, and what becomes of it during a run.

use super::adapter::Device;
use super::audit::chosen;
use super::error::GpuError;
use super::report::{AdapterFacts, GpuReport};
use super::self_test::self_test;
use super::settings::{Fault, GpuSettings, Precision};
use super::tally::{Tally, lock};
use std::sync::{Arc, Mutex};

/// Times that a lost device is opened again.
const REOPENINGS: usize = 1;

/// An open, tested device. Share it between the threads of a run.
#[derive(Debug)]
pub struct Gpu {
    adapter: AdapterFacts,
    holder: Mutex<Holder>,
    tally: Tally,
    settings: GpuSettings,
}

/// The device, or why there is none any more.
#[derive(Debug)]
struct Holder {
    device: Result<Arc<Device>, GpuError>,
    reopened: usize,
}

impl Gpu {
    /// Opens and tests the adapter.
    ///
    /// # Errors
    /// [`GpuError`] if there is none, it lacks something, or it fails the self-test.
    pub fn open(settings: GpuSettings) -> Result<Self, GpuError> {
        let device = open(&settings)?;
        Ok(Self {
            adapter: device.adapter.clone(),
            tally: Tally::new(&device.adapter),
            holder: Mutex::new(Holder {
                device: Ok(Arc::new(device)),
                reopened: 0,
            }),
            settings,
        })
    }

    /// The device, or why there is none any more.
    pub(crate) fn device(&self) -> Result<Arc<Device>, GpuError> {
        lock(&self.holder).device.clone()
    }

    /// What lanes on `device` failed by, noted; a lost device is opened again, once, and after that stays away.
    pub(crate) fn failed(&self, device: &Arc<Device>, error: GpuError) -> GpuError {
        match &error {
            GpuError::Lost { .. } => self.reopen(device, &error),
            GpuError::Refused { .. } => self.tally.halved(&error),
            _ => self.tally.note(format!("lanes: {error}")),
        }
        error
    }

    fn reopen(&self, lost: &Arc<Device>, why: &GpuError) {
        let mut holder = lock(&self.holder);
        let is_same = |device: &Arc<Device>| Arc::ptr_eq(device, lost);
        if !holder.device.as_ref().is_ok_and(is_same) {
            // another thread was faster
            return;
        }
        lost.destroy();
        holder.device = match holder.reopened < REOPENINGS {
            true => open(&self.settings).map(Arc::new),
            false => Err(why.clone()),
        };
        holder.reopened += 1;
        self.tally.note(match &holder.device {
            Ok(_) => format!("{why}; it was opened again"),
            Err(error) => format!("{why}; the processor does the rest ({error})"),
        });
    }

    /// Failure on purpose.
    pub(crate) fn fault(&self) -> Option<Fault> {
        self.settings.fault
    }

    /// Counts lanes, and those of them that the processor takes over.
    pub(crate) fn lanes(&self, lanes: usize, lost: usize) {
        self.tally.lanes(lanes, lost);
    }

    /// Whether the processor searches the peak of these `inputs` again, without the device.
    #[must_use]
    pub fn compares(&self, inputs: &[f64]) -> bool {
        chosen(inputs, self.settings.audit)
    }

    /// Records one comparison of a peak that was searched from a lane with the same peak searched without: the relative `differences` of
    /// frequency and amplitude, and whether they are `beyond` the limit, so that the peak searched without takes its place.
    pub fn compared(&self, differences: [f64; 2], beyond: bool) {
        self.tally.compared(differences, beyond);
    }

    /// The adapter.
    #[must_use]
    pub fn adapter(&self) -> &AdapterFacts {
        &self.adapter
    }

    /// What the device has done so far.
    #[must_use]
    pub fn report(&self) -> GpuReport {
        self.tally.report()
    }
}

/// Opens the adapter of the settings and tests it.
fn open(settings: &GpuSettings) -> Result<Device, GpuError> {
    let device = Device::open(
        settings.adapter.as_deref(),
        settings.local_rank,
        Precision::F32,
    )?;
    self_test(&device, settings)?;
    Ok(device)
}
