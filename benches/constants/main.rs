//! What a constant of the source changes in four small studies: `cargo bench --bench constants -- FILE`.
//!
//! The first call writes the peaks to FILE; a later one, of a program with another constant, prints how its peaks, their
//! routes and the work differ. `constants.sh` beside this file makes such programs.

#![expect(clippy::expect_used, reason = "a benchmark without its state fails")]

use microslip::ensemble::outcome::{LevelOutcome, SampleOutcome};
use microslip::study::{OutputFolder, RunSettings, Study, run};
use std::collections::BTreeMap;
use std::path::Path;

/// Name, friction law, samples, levels (N), lines of the solver.
const STUDIES: [(&str, &str, u32, &str, &str); 3] = [
    ("box law", "box", 64, "[1.0, 20.0, 100.0]", "alert = false"),
    ("circle law", "circle", 24, "[1.0, 20.0]", "alert = false"),
    (
        "with alert",
        "box",
        16,
        "[5.0, 20.0]",
        "alert = { threshold = 0.01, highest_harmonic = 34 }",
    ),
];

fn rig(name: &str, law: &str, samples: u32, levels: &str, solver: &str) -> String {
    format!(
        "name = \"{name}\"\nseed = 2026\nsamples = {samples}\nlevels = {levels}\n\
         model.kind = \"two-blade-strip\"\n\
         [contact]\nnormal_stiffness_n_per_um = 1000\ntangential_stiffness_n_per_um = 233\n\
         friction_coefficient = 0.6\nlaw = \"{law}\"\n\
         [inputs.stiffness_scale]\ndistribution = \"log-uniform\"\nlow = 0.1\nhigh = 10.0\n\
         [inputs.friction_coefficient]\ndistribution = \"uniform\"\nlow = 0.1\nhigh = 0.8\n\
         [solver]\nharmonics = 5\n{solver}\n[frequency]\nband_hz = [2605, 2635]\n\
         [output]\ncurve_samples = 0\n"
    )
}

/// A study with its name: those of the rig, and a model with two peaks in the band.
fn studies() -> Vec<(&'static str, Study)> {
    let of_rig = STUDIES.map(|(name, law, samples, levels, solver)| {
        let text = rig(name, law, samples, levels, solver);
        let study = Study::parse("rig.toml".as_ref(), &text).expect("a valid study");
        (name, study)
    });
    let path = Path::new("tests/reference/two-peaks-7dof/study.toml");
    let two_peaks = Study::read(path).expect("the reference study");
    of_rig
        .into_iter()
        .chain([("two peaks", two_peaks)])
        .collect()
}

fn solved(study: &Study) -> Vec<SampleOutcome> {
    let folder = tempfile::tempdir().expect("a folder");
    let output = OutputFolder::open(folder.path()).expect("a folder");
    let settings = RunSettings::default();
    let result = run(study, &output, &settings, |_progress| {}).expect("results");
    result.stored.outcomes
}

fn levels(outcomes: &[SampleOutcome]) -> impl Iterator<Item = &LevelOutcome> {
    outcomes.iter().flat_map(|outcome| &outcome.levels)
}

/// Routes, and statuses other than `converged`, with their numbers.
fn counts(outcomes: &[SampleOutcome]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for level in levels(outcomes) {
        let route = level.peak.and_then(|peak| peak.route);
        let name = route.map_or(level.status.name(), |route| route.name());
        *counts.entry(name).or_default() += 1;
    }
    let counts = counts.iter().map(|(name, n)| format!("{name} {n}"));
    counts.collect::<Vec<_>>().join(", ")
}

/// Largest relative differences of frequency and amplitude, and the number of levels whose status differs or whose amplitude
/// differs by more than 1e-6.
fn differences(before: &[SampleOutcome], after: &[SampleOutcome]) -> ([f64; 2], usize) {
    let (mut largest, mut others) = ([0.0_f64; 2], 0);
    for (a, b) in levels(before).zip(levels(after)) {
        let pair = a.peak.zip(b.peak);
        let differences = pair.map(|(a, b)| {
            [
                (b.frequency_hz / a.frequency_hz - 1.0).abs(),
                (b.amplitude_m / a.amplitude_m - 1.0).abs(),
            ]
        });
        let other = a.status != b.status || differences.is_some_and(|d| d[1] > 1e-6);
        others += usize::from(other);
        let found = differences.unwrap_or_default();
        (largest.iter_mut().zip(found)).for_each(|(most, d)| *most = most.max(d));
    }
    (largest, others)
}

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let file = arguments.next().expect("a file for the peaks");
    type Results = BTreeMap<String, Vec<SampleOutcome>>;
    let before = std::fs::read_to_string(&file).ok();
    let before: Option<Results> = before.map(|text| serde_json::from_str(&text).expect("peaks"));
    let mut results = Results::new();
    for (name, study) in studies() {
        let outcomes = solved(&study);
        let iterations: usize = levels(&outcomes)
            .map(|l| l.newton_iterations as usize)
            .sum();
        let factorizations: usize = levels(&outcomes).map(|l| l.factorizations as usize).sum();
        print!("{name}: {iterations} iterations, {factorizations} factorisations");
        if let Some(before) = before.as_ref().and_then(|results| results.get(name)) {
            let ([frequency, amplitude], others) = differences(before, &outcomes);
            print!("; differs by {frequency:.0e} (frequency), {amplitude:.0e} (amplitude)");
            print!("; {others} others of {}", levels(&outcomes).count());
        }
        println!("; {}", counts(&outcomes));
        results.insert(name.to_owned(), outcomes);
    }
    if before.is_none() {
        let text = serde_json::to_string(&results).expect("numbers");
        std::fs::write(&file, text).expect("a file");
    }
}
