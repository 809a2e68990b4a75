//! The GPU backend: node-states per second against the processor, share of the adapter's roofline, batch sizes, and peaks of
//! samples of the default study with and without lanes in one run.
//!
//!     cargo bench --bench gpu                          # the first GPU that is hardware
//!     cargo bench --bench gpu -- --adapter llvmpipe    # another adapter, software too
//!     cargo bench --bench gpu -- lanes --samples 1000  # one section, kernels or lanes; samples of the lanes (64)
//!
//! Roofline: operations and bytes of the passes, counted from the shapes of the shaders (a lower bound: root searches and
//! what the caches miss are left out), over the rates of two small kernels measured in the same run, fused
//! multiply-adds on registers and a copy. Times on the device are its own timestamps where it has them.
#![allow(clippy::expect_used, reason = "a benchmark that cannot be set up ends")]

mod states;

use microslip::aft::{AftBatch, AftForces, AftPlan, AftScratch, AftSettings, Laps, Want, evaluate};
use microslip::contact::{Events, FrictionLaw};
use microslip::ensemble::atlas::Anchor;
use microslip::ensemble::backend::{BackendChoice, BackendSettings, OpenBackend};
use microslip::ensemble::outcome::{LevelOutcome, PeakRecord, SampleOutcome};
use microslip::ensemble::runner::{SolvedSample, Watch};
use microslip::ensemble::times::SampleTimes;
use microslip::gpu::{Buffers, Device, GpuSettings, Kernels, Precision, ScaledStates, Shape};
use microslip::harmonics::HarmonicSet;
use microslip::study::Study;
use microslip::study::prepared::PreparedStudy;
use states::batch;
use std::sync::Mutex;
use std::time::Instant;

const HARMONICS: [usize; 4] = [1, 3, 5, 7];
const POINTS: [usize; 3] = [64, 128, 256];
const LAWS: [FrictionLaw; 2] = [FrictionLaw::Box, FrictionLaw::Circle];
/// Highest harmonics of the lanes.
const LANE_HARMONICS: [usize; 2] = [3, 5];
/// Samples before those that lanes serve (`ensemble::with_inverse`).
const ANCHORS: u64 = 244;
/// The first sample that is timed.
const FIRST_SAMPLE: u64 = 5000;
/// Runs of which the fastest counts.
const RUNS: usize = 5;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|a| a == name)?;
        arguments.get(at + 1).cloned()
    };
    let adapter = value("--adapter");
    let samples = value("--samples")
        .and_then(|n| n.parse().ok())
        .unwrap_or(64);
    let device = match Device::open(adapter.as_deref(), 0, Precision::F32) {
        Ok(device) => device,
        Err(error) => {
            println!("nothing to measure: {error}");
            return;
        }
    };
    let facts = &device.adapter;
    println!(
        "{} ({}, {}, {})",
        facts.name, facts.kind, facts.interface, facts.driver
    );
    let named = |section: &str| arguments.iter().any(|a| a == section);
    let asked = |section: &str| named(section) || !["kernels", "lanes"].iter().any(|s| named(s));
    if asked("kernels") {
        kernels(&device);
    }
    drop(device);
    if asked("lanes") {
        for law in LAWS {
            lanes(law, adapter.clone(), samples);
        }
    }
}

/// The passes alone.
fn kernels(device: &Device) {
    let facts = &device.adapter;
    let states = if facts.is_hardware() { 32_768 } else { 1024 };
    let peak = Peak::of(device);
    println!(
        "peak: {:.0} Gflop/s, copy {:.1} GB/s (read and written)",
        peak.flops / 1e9,
        peak.bytes / 1e9
    );
    for law in LAWS {
        rates(device, law, states, &peak);
        batch_sizes(device, law, states);
    }
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

/// Peaks per second of samples behind the atlas, on the processor alone and with lanes, and how far their answers are apart.
fn lanes(law: FrictionLaw, adapter: Option<String>, samples: u64) {
    println!(
        "\nlanes, {law:?} law, {samples} samples of the default study behind an atlas of {ANCHORS}, without an alert: peaks per second"
    );
    println!(
        "{:>2} {:>10} {:>10} {:>12} {:>8} {:>6} {:>10} {:>10}",
        "H", "processor", "gpu", "first call", "lanes", "lost", "frequency", "amplitude"
    );
    for h in LANE_HARMONICS {
        let study = study_of_lanes(law, h);
        let prepared = study.prepared().expect("the default model");
        let anchors = prepared.ensemble(None).solved(ANCHORS, || {}).anchors;
        let cpu = OpenBackend::default();
        let (_, seconds_on_cpu, expected) = timed(&prepared, &cpu, &anchors, samples);
        let settings = BackendSettings {
            choice: BackendChoice::Gpu,
            gpu: GpuSettings {
                adapter: adapter.clone(),
                ..GpuSettings::default()
            },
        };
        let gpu = OpenBackend::open(&settings, &prepared.ensemble(None));
        // the first call compiles
        let (first, seconds, found) = timed(&prepared, &gpu, &anchors, samples);
        let Some(report) = gpu.report().gpu else {
            println!(
                "{h:>2} no lanes: {}",
                gpu.report().reason.unwrap_or_default()
            );
            continue;
        };
        let [frequency, amplitude] = differences(&found, &expected);
        let peaks = expected.iter().map(|o| o.levels.len()).sum::<usize>() as f64;
        println!(
            "{h:>2} {:>10.1} {:>10.1} {:>10.1} s {:>8} {:>6} {frequency:>10.1e} {amplitude:>10.1e}",
            peaks / seconds_on_cpu,
            peaks / seconds,
            first,
            report.lanes,
            report.lanes_lost,
        );
        report.notes.iter().for_each(|note| println!("   {note}"));
    }
}

fn study_of_lanes(law: FrictionLaw, highest: usize) -> Study {
    let mut study =
        Study::read("studies/two-blade-strip/study.toml".as_ref()).expect("the default study");
    study.solver.harmonics = HarmonicSet::up_to(highest);
    study.solver.aft.law = law;
    study.solver.alert = None;
    study.output.curve_samples = 0;
    study
}

/// Largest relative differences of frequency and amplitude. Statuses must be equal.
fn differences(found: &[SampleOutcome], expected: &[SampleOutcome]) -> [f64; 2] {
    let pairs = || {
        let levels = found.iter().flat_map(|o| &o.levels);
        levels.zip(expected.iter().flat_map(|o| &o.levels))
    };
    let unequal = pairs().filter(|(a, b)| a.status != b.status).count();
    if unequal > 0 {
        println!("   {unequal} statuses differ");
    }
    let largest = |of: fn(&PeakRecord) -> f64| {
        let difference = |(a, b): (&LevelOutcome, &LevelOutcome)| {
            Some((of(a.peak.as_ref()?) / of(b.peak.as_ref()?) - 1.0).abs())
        };
        pairs().filter_map(difference).fold(0.0, f64::max)
    };
    [largest(|p| p.frequency_hz), largest(|p| p.amplitude_m)]
}

/// Outcomes as they come.
#[derive(Default)]
struct Kept(Mutex<Vec<SampleOutcome>>);

impl Watch for Kept {
    fn solved(&self, sample: SolvedSample, _: SampleTimes) {
        self.0
            .lock()
            .expect("no thread panicked")
            .push(sample.outcome);
    }

    fn stops(&self) -> bool {
        false
    }
}

/// Times (s) of the first of two calls and of the second, and its outcomes in the order of the samples.
fn timed(
    prepared: &PreparedStudy<'_>,
    backend: &OpenBackend,
    anchors: &[Anchor],
    samples: u64,
) -> (f64, f64, Vec<SampleOutcome>) {
    let ensemble = prepared.ensemble(backend.gpu());
    let indices: Vec<u64> = (FIRST_SAMPLE..FIRST_SAMPLE + samples).collect();
    let call = || {
        let (kept, clock) = (Kept::default(), Instant::now());
        let solved = ensemble.solve_from(anchors, &indices, &kept);
        solved.expect("nobody stops it");
        let seconds = clock.elapsed().as_secs_f64();
        (seconds, kept.0.into_inner().expect("no thread panicked"))
    };
    let ((first, _), (second, mut outcomes)) = (call(), call());
    outcomes.sort_by_key(|outcome| outcome.index);
    (first, second, outcomes)
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
        let shape = Shape::of(&plan, Precision::F32).expect("both laws have a shader");
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

/// What the adapter does at best.
struct Peak {
    /// Operations per second, f32.
    flops: f64,
    /// Bytes per second, read and written.
    bytes: f64,
}

/// Steps of the multiply-add kernel per thread; eight operands, two operations each.
const STEPS: u32 = 4096;

impl Peak {
    fn of(device: &Device) -> Self {
        let threads: u32 = if device.adapter.is_hardware() {
            1 << 20
        } else {
            1 << 12
        };
        let words: u32 = if device.adapter.is_hardware() {
            1 << 23
        } else {
            1 << 22
        };
        let adds = format!(
            "@group(0) @binding(0) var<storage, read_write> x: array<vec4<f32>>;
             @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
               var a = x[id.x]; var b = a + vec4(1.0); let c = vec4(0.999);
               for (var i = 0u; i < {STEPS}u; i++) {{ a = fma(a, c, b); b = fma(b, c, a); }}
               x[id.x] = a + b; }}"
        );
        let copies = "@group(0) @binding(0) var<storage, read_write> x: array<vec4<f32>>;
             @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
               x[id.x] = x[id.x] + vec4(1.0); }";
        let seconds = best_seconds(device, &adds, threads, u64::from(threads) * 16);
        let copied = best_seconds(device, copies, words / 4, u64::from(words) * 4);
        Self {
            flops: f64::from(threads) * f64::from(STEPS) * 16.0 / seconds,
            bytes: f64::from(words) * 8.0 / copied,
        }
    }
}

/// Shortest time of a kernel over one buffer.
fn best_seconds(device: &Device, text: &str, threads: u32, bytes: u64) -> f64 {
    let gpu = &device.device;
    let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let buffer = gpu.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: buffer.as_entire_binding(),
        }],
    });
    let groups = threads / 64;
    assert!(groups <= 65_535, "the groups that one dimension has");
    let mut best = f64::INFINITY;
    for _ in 0..=RUNS {
        let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups, 1, 1);
        }
        let clock = Instant::now();
        device.queue.submit([encoder.finish()]);
        gpu.poll(wgpu::PollType::wait_indefinitely())
            .expect("the device answers");
        best = best.min(clock.elapsed().as_secs_f64());
    }
    best
}
