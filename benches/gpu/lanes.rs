//! Peaks of samples of the default study, with and without lanes.

use microslip::contact::FrictionLaw;
use microslip::ensemble::atlas::Anchor;
use microslip::ensemble::backend::{BackendChoice, BackendSettings, OpenBackend};
use microslip::ensemble::outcome::{LevelOutcome, PeakRecord, SampleOutcome};
use microslip::ensemble::runner::{SolvedSample, Watch};
use microslip::ensemble::times::SampleTimes;
use microslip::gpu::{AdapterFacts, GpuSettings};
use microslip::harmonics::HarmonicSet;
use microslip::hb::StabilityScope;
use microslip::study::Study;
use microslip::study::prepared::PreparedStudy;
use std::sync::Mutex;
use std::time::Instant;

/// Highest harmonics of the lanes, and those on a software adapter.
const HARMONICS: [usize; 2] = [5, 8];
const FEW_HARMONICS: [usize; 1] = [3];
/// Samples before those that lanes serve (`ensemble::with_inverse`).
const ANCHORS: u64 = 244;
/// The first sample that is timed.
const FIRST_SAMPLE: u64 = 5000;

/// Peaks per second of samples behind the atlas, on the processor alone and with lanes, and how far their answers are apart.
pub(super) fn lanes(law: FrictionLaw, adapter: &AdapterFacts, samples: u64) {
    let harmonics: &[usize] = match adapter.is_hardware() {
        true => &HARMONICS,
        false => &FEW_HARMONICS,
    };
    println!(
        "\nlanes, {law:?} law, {samples} samples of the default study behind an atlas of {ANCHORS}, without alert and stability: peaks per second"
    );
    println!(
        "{:>2} {:>10} {:>10} {:>12} {:>8} {:>6} {:>10} {:>10}",
        "H", "processor", "gpu", "first call", "lanes", "lost", "frequency", "amplitude"
    );
    for &h in harmonics {
        let study = study_of_lanes(law, h);
        let prepared = study.prepared().expect("the default model");
        let anchors = prepared.ensemble(None).solved(ANCHORS, || {}).anchors;
        let cpu = OpenBackend::default();
        let (seconds_on_cpu, expected) = timed(&prepared, &cpu, &anchors, samples);
        let settings = BackendSettings {
            choice: BackendChoice::Gpu,
            gpu: GpuSettings {
                adapter: Some(adapter.index.to_string()),
                ..GpuSettings::default()
            },
        };
        let gpu = OpenBackend::open(&settings, &prepared.ensemble(None));
        // compiles
        let (first, _) = timed(&prepared, &gpu, &anchors, samples);
        let (seconds, found) = timed(&prepared, &gpu, &anchors, samples);
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

pub(super) fn study_of_lanes(law: FrictionLaw, highest: usize) -> Study {
    let mut study =
        Study::read("studies/two-blade-strip/study.toml".as_ref()).expect("the default study");
    study.solver.harmonics = HarmonicSet::up_to(highest);
    study.solver.aft.law = law;
    study.solver.alert = None;
    study.solver.stability = StabilityScope::Off;
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

/// Time (s) and outcomes in the order of the samples.
fn timed(
    prepared: &PreparedStudy<'_>,
    backend: &OpenBackend,
    anchors: &[Anchor],
    samples: u64,
) -> (f64, Vec<SampleOutcome>) {
    let ensemble = prepared.ensemble(backend.gpu());
    let indices: Vec<u64> = (FIRST_SAMPLE..FIRST_SAMPLE + samples).collect();
    let (kept, clock) = (Kept::default(), Instant::now());
    let solved = ensemble.solve_from(anchors, &indices, &kept);
    solved.expect("nobody stops it");
    let seconds = clock.elapsed().as_secs_f64();
    let mut outcomes = kept.0.into_inner().expect("no thread panicked");
    outcomes.sort_by_key(|outcome| outcome.index);
    (seconds, outcomes)
}
