//! Contact states on a GPU: drafts of the forces and tangents that steer Newton's method.
//!
//! A draft is rounded to the shaders' precision; what decides a result is evaluated by the processor in double precision
//! ([`crate::hb`] asks for it below a residual). Start reading at [`Gpu`]; the shaders are in `shaders/`. Whatever the
//! device fails to do the processor does: no sample is lost by it.

mod adapter;
mod kernels;
mod queue;
mod readback;
mod scaled;
mod self_test;
mod shader;
mod tally;

pub use adapter::{AdapterFacts, Device, adapters};
pub use kernels::{BatchResult, Buffers, Kernels};
pub use readback::PassSeconds;
pub use scaled::{ScaledForces, ScaledStates};
pub use self_test::{examined, self_test};
pub use shader::{Access, Binding, Precision, Reflection, Shape};
pub use tally::GpuReport;

use crate::aft::{
    AftBatch, AftForces, AftPlan, AftScratch, Block, Drafts, Tangent, Want, evaluate,
};
use crate::contact::{Events, FrictionLaw};
use queue::{Lane, Queue};
use std::cell::Cell;
use std::sync::Arc;
use std::thread::JoinHandle;

/// Largest difference of a force, over the state's largest force, that an audit accepts.
const AUDIT_LIMIT: f64 = 1e-3;
/// Threads that serve the device: one prepares and reads while the other's batch computes.
const LANES: usize = 2;

/// Why the GPU cannot do it. The processor can.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter, or none that was asked for.
    #[error("{message}")]
    NoAdapter {
        /// What was looked for and what is there.
        message: String,
    },
    /// The adapter lacks a feature or a limit.
    #[error("adapter {name} has no {lacks}")]
    Lacks {
        /// Adapter.
        name: String,
        /// Feature or limit.
        lacks: String,
    },
    /// A shader text is not valid.
    #[error("shader: {message}")]
    Shader {
        /// What naga says.
        message: String,
    },
    /// Memory, or a limit, does not suffice for a batch.
    #[error("a batch was refused: {message}")]
    Refused {
        /// States of the batch.
        states: usize,
        /// What the device says.
        message: String,
    },
    /// The device is lost, or does not answer.
    #[error("the device is lost: {message}")]
    Lost {
        /// What the driver says.
        message: String,
    },
    /// The device computes wrongly.
    #[error("self-test failed: {message}")]
    SelfTest {
        /// How far it is off.
        message: String,
    },
}

/// A failure on purpose, for tests of what follows from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The device is lost once, before batch number `.0`.
    LoseDeviceAfter(u64),
    /// Batches of more states are refused.
    RefuseAbove(usize),
    /// The self-test finds a wrong force.
    WrongSelfTest,
    /// Every draft has a wrong force.
    WrongDrafts,
}

/// How the device is used.
#[derive(Debug, Clone, PartialEq)]
pub struct GpuSettings {
    /// Adapter by index, PCI address or part of its name; `None` = the first that is hardware.
    pub adapter: Option<String>,
    /// Numbers of the shaders.
    pub precision: Precision,
    /// Share of the evaluations that the processor repeats, 0 to 1.
    pub audit: f64,
    /// Samples that compute on the processor at the same time.
    pub turns: usize,
    /// Law and events whose shaders the self-test examines.
    pub law: FrictionLaw,
    /// See above.
    pub events: Events,
    /// Failure on purpose.
    pub fault: Option<Fault>,
}

impl Default for GpuSettings {
    fn default() -> Self {
        Self {
            adapter: None,
            precision: Precision::F32,
            audit: 0.01,
            turns: 1,
            law: FrictionLaw::Box,
            events: Events::Located,
            fault: None,
        }
    }
}

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
        if chosen(batch, self.settings.audit) {
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

/// Forces and tangents of the states that the device did not decide.
fn decide(plan: &AftPlan<f64>, batch: &AftBatch<f64>, states: &[usize], out: &mut AftForces<f64>) {
    if states.is_empty() {
        return;
    }
    let n = batch.n_states;
    let rows = batch.displacement.chunks_exact(n);
    let few = AftBatch {
        n_states: states.len(),
        displacement: rows
            .flat_map(|row| states.iter().map(|&i| row[i]))
            .collect(),
        parameters: states.iter().map(|&i| batch.parameters[i]).collect(),
    };
    let mut decided = AftForces::default();
    let scratch = &mut AftScratch::default();
    evaluate(plan, &few, Want::ForcesAndTangents, scratch, &mut decided);
    let rows = decided.forces.chunks_exact(states.len());
    for (row, values) in out.forces.chunks_exact_mut(n).zip(rows) {
        states.iter().zip(values).for_each(|(&i, &f)| row[i] = f);
    }
    let size = Block::COUNT * plan.n_coefficients() * plan.n_coefficients();
    for (k, &i) in states.iter().enumerate() {
        out.summaries[i] = decided.summaries[k];
        out.tangents[i] = match decided.tangents[k] {
            Tangent::Stuck => Tangent::Stuck,
            Tangent::Blocks(from) => {
                let offset = out.blocks.len();
                out.blocks
                    .extend_from_slice(&decided.blocks[from..][..size]);
                Tangent::Blocks(offset)
            }
        };
    }
}

/// Whether a share of all batches holds this one: by a hash of its numbers, so that neither time nor the order of samples
/// decides (FNV-1a over words, finished by a multiplication that spreads the last ones).
fn chosen(batch: &AftBatch<f64>, share: f64) -> bool {
    let mix = |hash: u64, x: &f64| (hash ^ x.to_bits()).wrapping_mul(0x0100_0000_01b3);
    let hash = batch.displacement.iter().fold(0xcbf2_9ce4_8422_2325, mix);
    let spread = (hash ^ (hash >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((spread >> 11) as f64) < share * (1u64 << 53) as f64
}

/// Largest differences of forces, over the state's largest force that its motion could cause, and of derivatives, over
/// its largest stiffness.
fn differences(batch: &AftBatch<f64>, found: &AftForces<f64>, exact: &AftForces<f64>) -> [f64; 2] {
    let (n, m) = (exact.n_states, exact.n_coefficients);
    let mut out = [0.0f64; 2];
    let worse = |most: f64, x: f64| if x <= most { most } else { x };
    for (i, p) in batch.parameters.iter().enumerate() {
        let k = [p.k_t[0], p.k_t[1], p.k_n];
        let column = |x: &[f64], row: usize| x[row * n + i];
        let rows = 0..3 * m;
        let scale = (rows.clone())
            .map(|row| (k[row / m] * column(&batch.displacement, row)).abs())
            .fold(p.n_0.abs(), f64::max);
        for row in rows {
            let difference = column(&found.forces, row) - column(&exact.forces, row);
            out[0] = worse(out[0], difference.abs() / scale.max(f64::MIN_POSITIVE));
        }
        let stiffness = k.into_iter().fold(f64::MIN_POSITIVE, f64::max);
        out[1] = worse(out[1], tangent_difference(i, (found, exact), k) / stiffness);
    }
    out
}

/// Largest difference of the entries of the tangents of one state.
fn tangent_difference(
    i: usize,
    (found, exact): (&AftForces<f64>, &AftForces<f64>),
    k: [f64; 3],
) -> f64 {
    let m = exact.n_coefficients;
    let entry = |of: &AftForces<f64>, block: Block, a: usize, b: usize| match of.tangents[i] {
        Tangent::Blocks(offset) => of.block(offset, block)[a * m + b],
        Tangent::Stuck if a == b && block.row_component() == block.column_component() => {
            k[block.row_component()]
        }
        Tangent::Stuck => 0.0,
    };
    let mut most = 0.0f64;
    for block in Block::ALL {
        for (a, b) in (0..m).flat_map(|a| (0..m).map(move |b| (a, b))) {
            most = most.max((entry(found, block, a, b) - entry(exact, block, a, b)).abs());
        }
    }
    most
}
