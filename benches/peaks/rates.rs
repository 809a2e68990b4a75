//! Peaks per second of processor time: over the box of the default study, with more harmonics, with more contact pairs.

use crate::clock::processor_time;
use crate::rig::{LEVELS, Rig, design, settings};
use microslip::ensemble::Ensemble;
use microslip::ensemble::outcome::{LevelOutcome, SampleOutcome};

fn rank(sorted: &[u32], share: f64) -> u32 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

/// One line on the work and the fate of the peaks.
pub(crate) fn describe(name: &str, peaks: &[&LevelOutcome]) {
    let mut factors: Vec<u32> = peaks.iter().map(|p| p.factorizations).collect();
    factors.sort_unstable();
    let failed = peaks.iter().filter(|p| !p.status.has_solution()).count();
    println!(
        "{name}: factorisations mean {:.2}, median {}, 95 % {}, most {}; {failed} of {} not solved",
        f64::from(factors.iter().sum::<u32>()) / factors.len() as f64,
        rank(&factors, 0.5),
        rank(&factors, 0.95),
        rank(&factors, 1.0),
        peaks.len()
    );
}

/// Runs the first samples, prints their rate, work and fate, and returns them with the rate.
pub(crate) fn measured(
    name: &str,
    ensemble: &Ensemble<'_>,
    samples: u64,
) -> (f64, Vec<SampleOutcome>) {
    let (seconds, outcomes) = processor_time(|| ensemble.run(samples, || {}));
    let peaks: Vec<&LevelOutcome> = outcomes.iter().flat_map(|o| &o.levels).collect();
    let rate = peaks.len() as f64 / seconds;
    println!(
        "{name}, {samples} samples x {} levels: {rate:.2} peaks per processor second",
        ensemble.levels.len()
    );
    describe("all", &peaks);
    (rate, outcomes)
}

pub(crate) fn study() {
    let rig = Rig::new([5, 3]);
    let (design, settings) = (design(2026), settings(5, None));
    let ensemble = rig.ensemble(&design, &LEVELS, &settings);
    for samples in [64, 256, 1024] {
        let (_, outcomes) = measured("H = 5", &ensemble, samples);
        if samples == 1024 {
            for (i, level) in LEVELS.iter().enumerate() {
                let peaks: Vec<_> = outcomes.iter().map(|o| &o.levels[i]).collect();
                describe(&format!("{level} N"), &peaks);
            }
        }
    }
}

pub(crate) fn harmonics() {
    let rig = Rig::new([5, 3]);
    let design = design(11);
    let levels = [1.0, 5.0, 20.0, 100.0];
    for samples in [32, 64, 256] {
        let times = [5, 9, 13, 21].map(|highest| {
            let settings = settings(highest, None);
            let ensemble = rig.ensemble(&design, &levels, &settings);
            let (rate, _) = measured(&format!("H = {highest}"), &ensemble, samples);
            (highest as f64, 1.0 / rate)
        });
        print_growth("H", times);
    }
}

/// The default structure with finer and finer contact grids, and how the time per peak grows with their pairs.
pub(crate) fn pairs() {
    let (design, settings) = (design(2026), settings(5, None));
    let levels = [1.0, 20.0, 100.0];
    let times = [[2, 3], [5, 3], [4, 7], [6, 8]].map(|grid| {
        let rig = Rig::new(grid);
        let ensemble = rig.ensemble(&design, &levels, &settings);
        let pairs = (2 * grid[0] * grid[1]) as f64;
        let (rate, _) = measured(&format!("{pairs} pairs"), &ensemble, 64);
        (pairs, 1.0 / rate)
    });
    print_growth("pairs", times);
}

/// How the time per peak grows with a number, from its first to its last value.
fn print_growth(name: &str, times: [(f64, f64); 4]) {
    let [(few, short), .., (many, long)] = times;
    let growth = (long / short).ln() / (many / few).ln();
    println!("from {few} to {many} the time per peak grows as {name}^{growth:.2}");
}
