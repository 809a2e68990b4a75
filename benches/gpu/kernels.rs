//! The passes over contact states alone: rates, share of the roofline, batch sizes.

use super::roofline::Peak;
use super::states::batch;
use microslip::aft::{AftBatch, AftForces, AftPlan, AftScratch, AftSettings, Laps, Want, evaluate};
use microslip::contact::{Events, FrictionLaw};
use microslip::gpu::{Buffers, Device, Kernels, Precision, ScaledStates, ShaderKey};
use microslip::harmonics::HarmonicSet;
use std::time::Instant;

const HARMONICS: [usize; 4] = [1, 3, 5, 7];
const POINTS: [usize; 3] = [64, 128, 256];
/// Runs of which the fastest counts.
const RUNS: usize = 5;

/// Rates of a law, by harmonics and by the size of a batch.
pub(super) fn kernels(device: &Device, peak: &Peak, law: FrictionLaw) {
    let facts = &device.adapter;
    let states = if facts.is_hardware() { 32_768 } else { 1024 };
    rates(device, law, states, peak);
    batch_sizes(device, law, states);
}

/// Node-states per second, without and with derivatives.
fn rates(device: &Device, law: FrictionLaw, states: usize, peak: &Peak) {
    println!(
        "\n{law:?} law: thousand node-states per second, {states} states, f32; processor: one core, f64"
    );
    println!(
        "{:>2} {:>4} {:>10} {:>10} {:>10} {:>10} {:>9} {:>10}",
        "H", "Nt", "forces", "tangents", "with copy", "roofline", "cpu F", "cpu F+J"
    );
    for h in HARMONICS {
        for n_time in POINTS {
            let set = HarmonicSet::up_to(h);
            let case = Case::new(device, (law, &set, n_time), states);
            let (forces, _) = case.seconds(device, Want::Forces);
            let (tangents, wall) = case.seconds(device, Want::ForcesAndTangents);
            let least = case.least_seconds(peak);
            let few = batch(&set, 512);
            let on_core = plan(law, &set, n_time);
            let cpu = |want| 512.0 / processor_seconds(&on_core, &few, want) / 1e3;
            let rate = |seconds: f64| states as f64 / seconds / 1e3;
            println!(
                "{h:>2} {n_time:>4} {:>10.0} {:>10.0} {:>10.0} {:>9.1}% {:>9.0} {:>10.0}",
                rate(forces),
                rate(tangents),
                rate(wall),
                100.0 * least / tangents,
                cpu(Want::Forces),
                cpu(Want::ForcesAndTangents),
            );
        }
    }
}

/// Rate over the number of states in a batch.
fn batch_sizes(device: &Device, law: FrictionLaw, most: usize) {
    println!(
        "\nH = 5, Nt = 128, forces and tangents: states in a batch, thousand per second on the device, with copies"
    );
    let set = HarmonicSet::up_to(5);
    let mut states = 16;
    while states <= most {
        let case = Case::new(device, (law, &set, 128), states);
        let (on_device, wall) = case.seconds(device, Want::ForcesAndTangents);
        let rate = |seconds: f64| states as f64 / seconds / 1e3;
        println!("{states:>7} {:>9.1} {:>9.1}", rate(on_device), rate(wall));
        states *= 4;
    }
}

/// One shape with its states on the device.
struct Case {
    states: ScaledStates,
    kernels: Kernels,
    buffers: Buffers,
    law: FrictionLaw,
    h: usize,
    n_time: usize,
}

impl Case {
    fn new(
        device: &Device,
        (law, set, n_time): (FrictionLaw, &HarmonicSet, usize),
        n_states: usize,
    ) -> Self {
        let plan = plan(law, set, n_time);
        let shape = ShaderKey::of(&plan, Precision::F32).expect("both laws have a shader");
        let kernels = Kernels::new(device, shape).expect("it compiles");
        let buffers = kernels.buffers(device, n_states).expect("memory");
        let states = ScaledStates::new(&batch(set, n_states)).expect("finite");
        Self {
            states,
            kernels,
            buffers,
            law,
            h: set.highest(),
            n_time,
        }
    }

    /// Shortest time on the device, and with upload and read back.
    fn seconds(&self, device: &Device, want: Want) -> (f64, f64) {
        let mut best = (f64::INFINITY, f64::INFINITY);
        for _ in 0..=RUNS {
            let clock = Instant::now();
            let result = self
                .kernels
                .evaluate(device, &self.buffers, &[&self.states], want);
            let wall = clock.elapsed().as_secs_f64();
            let passes = result.expect("it runs").pass_seconds;
            let on_device = passes.map_or(wall, |passes| passes.iter().map(|(_, s)| s).sum());
            best = (best.0.min(on_device), best.1.min(wall));
        }
        best
    }

    /// Time that operations or bytes take at the peak, whichever is longer.
    fn least_seconds(&self, peak: &Peak) -> f64 {
        let (h, n_time) = (self.h as f64, self.n_time as f64);
        let m = 2.0 * h + 1.0;
        // signals and rates at the samples; box law: the scan of the march, rows of forces and of derivatives; circle law:
        // two laps of the march, and two of every column, the last one with its sums
        let transform = n_time * h * 3.0 * 10.0;
        let (rest, rows, blocks) = match self.law {
            FrictionLaw::Box => (n_time * 2.0 * 30.0 + 7.0 * m * m * 8.0, 14.0, 5.0),
            FrictionLaw::Circle => {
                let columns = 3.0 * m * n_time * (2.0 * 30.0 + 4.0 * m);
                (n_time * 2.0 * 30.0 + columns, 22.0, 7.0)
            }
        };
        // signals written once and read by every direction or lap of the march, tangents written
        let bytes = 4.0 * (rows * n_time + blocks * m * m + 12.0 * m);
        let n = self.states.n_states as f64;
        let flops = n * (transform + rest);
        (flops / peak.flops).max(n * bytes / peak.bytes)
    }
}

fn plan(law: FrictionLaw, set: &HarmonicSet, n_time: usize) -> AftPlan<f64> {
    let settings = AftSettings {
        n_time,
        law,
        events: Events::Located,
        laps: Laps::Periodic,
    };
    AftPlan::new(set, settings)
}

/// One core.
fn processor_seconds(plan: &AftPlan<f64>, batch: &AftBatch<f64>, want: Want) -> f64 {
    let (mut scratch, mut out) = (AftScratch::default(), AftForces::default());
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let clock = Instant::now();
        evaluate(plan, batch, want, &mut scratch, &mut out);
        best = best.min(clock.elapsed().as_secs_f64());
    }
    best
}
