//! An open device that drafts contact forces, with the threads that serve it.

use super::adapter::Device;
use super::audit::{chosen, decide, differences};
use super::error::GpuError;
use super::queue::{self, Lane, Queue};
use super::report::{AdapterFacts, GpuReport};
use super::scaled::ScaledStates;
use super::settings::{Fault, GpuSettings};
use super::shader::Shape;
use crate::aft::{AftBatch, AftForces, AftPlan, AftScratch, Drafts, Want, evaluate};
use std::cell::Cell;
use std::sync::Arc;
use std::thread::JoinHandle;

/// Largest difference of a force, over the state's largest force, that an audit accepts.
const AUDIT_LIMIT: f64 = 1e-3;
/// Threads that serve the device: one prepares and reads while the other's batch computes.
const LANES: usize = 2;

/// An open, tested device with its queue. Share it between the threads of a run.
pub struct Gpu {
    adapter: AdapterFacts,
    queue: Arc<Queue>,
    lanes: Vec<JoinHandle<()>>,
    settings: GpuSettings,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gpu")
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl Gpu {
    /// Opens and tests the adapter.
    ///
    /// # Errors
    /// [`GpuError`] if there is none, it lacks something, or it fails the self-test.
    pub fn open(settings: GpuSettings) -> Result<Self, GpuError> {
        let device = queue::open(&settings)?;
        let adapter = device.adapter.clone();
        let queue = Arc::new(Queue::new(device, settings.clone()));
        let lane = |_| {
            let queue = Arc::clone(&queue);
            std::thread::spawn(move || Lane::default().serve(&queue))
        };
        let lanes = (0..LANES).map(lane).collect();
        Ok(Self {
            adapter,
            queue,
            lanes,
            settings,
        })
    }

    /// Repeats a draft on the processor, whose result takes its place where they differ too much.
    fn audit(&self, plan: &AftPlan<f64>, batch: &AftBatch<f64>, out: &mut AftForces<f64>) {
        let mut exact = AftForces::default();
        let scratch = &mut AftScratch::default();
        evaluate(plan, batch, Want::ForcesAndTangents, scratch, &mut exact);
        let found = differences(batch, out, &exact);
        let beyond = found[0].is_nan() || found[0] > AUDIT_LIMIT;
        self.queue.tally.audit(found, beyond);
        if beyond {
            *out = exact;
            let message = "audited forces beyond the limit; the processor's took their place";
            self.queue.tally.note(message.to_owned());
        }
    }

    /// A sample begins on this thread; it waits while others have their turn. Ends when dropped.
    #[must_use]
    pub fn turn(&self) -> Turn<'_> {
        self.queue.begin();
        HAS_TURN.set(true);
        Turn { queue: &self.queue }
    }

    /// The device, or why there is none any more.
    pub(crate) fn device(&self) -> Result<Arc<Device>, GpuError> {
        self.queue.device()
    }

    /// What lanes on `device` failed by, noted; a lost device is opened again.
    pub(crate) fn failed(&self, device: &Arc<Device>, error: GpuError) -> GpuError {
        match &error {
            GpuError::Lost { .. } => self.queue.reopen(device, &error),
            _ => self.queue.tally.note(format!("lanes: {error}")),
        }
        error
    }

    /// Failure on purpose.
    pub(crate) fn fault(&self) -> Option<Fault> {
        self.settings.fault
    }

    /// Counts lanes, and those of them that the processor takes over.
    pub(crate) fn lanes(&self, lanes: usize, lost: usize) {
        self.queue.tally.lanes(lanes, lost);
    }

    /// Whether the processor searches the peak of these `inputs` again, without the device.
    #[must_use]
    pub fn compares(&self, inputs: &[f64]) -> bool {
        chosen(inputs, self.settings.audit)
    }

    /// Compares a peak that was searched from a lane with the same peak searched without.
    pub fn compared(&self, differences: [f64; 2], beyond: bool) {
        self.queue.tally.compared(differences, beyond);
    }

    /// Ends the device as a driver reset would; for tests.
    pub fn lose_device(&self) {
        self.queue.lose_device();
    }

    /// The adapter.
    #[must_use]
    pub fn adapter(&self) -> &AdapterFacts {
        &self.adapter
    }

    /// What the device has done so far.
    #[must_use]
    pub fn report(&self) -> GpuReport {
        self.queue.tally.report()
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        self.queue.close();
        for lane in self.lanes.drain(..) {
            // a lane that panicked has nothing more to say
            let _ = lane.join();
        }
    }
}

thread_local! {
    /// Whether this thread computes a sample of a run.
    static HAS_TURN: Cell<bool> = const { Cell::new(false) };
}

impl Drafts for Gpu {
    fn draft(&self, plan: &AftPlan<f64>, batch: &AftBatch<f64>, out: &mut AftForces<f64>) -> bool {
        let Some(shape) = Shape::of(plan, self.settings.precision) else {
            return false;
        };
        if !self.adapter.is_hardware() && !shape.suits_software() {
            return false;
        }
        let Some(states) = ScaledStates::new(batch) else {
            return false;
        };
        let Some(forces) = self.queue.ask(shape, states.clone(), HAS_TURN.get()) else {
            return false;
        };
        states.unscale(plan, batch, &forces, out);
        decide(plan, batch, &forces.undecided, out);
        if self.settings.fault == Some(Fault::WrongDrafts) {
            out.forces.iter_mut().for_each(|force| *force *= 1.01);
        }
        if chosen(&batch.displacement, self.settings.audit) {
            self.audit(plan, batch, out);
        }
        true
    }
}

/// The right of a sample to compute on the processor.
#[derive(Debug)]
pub struct Turn<'a> {
    queue: &'a Queue,
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        HAS_TURN.set(false);
        self.queue.end();
    }
}
