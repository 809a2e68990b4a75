//! `reweight`: the samples of a run under other distributions.

use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use super::bad_input::assert_refused;
use super::{folder, microslip, without_curves};

fn with_prior(folder: &Path, prior: &str) -> Output {
    std::fs::write(folder.join("prior.toml"), prior).unwrap();
    microslip(folder, &["reweight", "results", "--prior", "prior.toml"])
}

/// A folder with the study of two masses and so many samples, without curves, and what follows it.
fn study(samples: u64, more: &str) -> TempDir {
    let folder = folder(
        "study.toml",
        "samples = 10",
        &format!("samples = {samples}"),
    );
    let path = folder.path().join("study.toml");
    let text = without_curves(&std::fs::read_to_string(&path).unwrap());
    std::fs::write(path, text + more).unwrap();
    folder
}

fn uniform(low: f64, high: f64) -> String {
    format!(
        "[inputs.friction_coefficient]\ndistribution = \"uniform\"\nlow = {low}\nhigh = {high}\n"
    )
}

fn reweighted(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("results/reweighted.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The old distribution changes nothing; a part of it leaves the samples inside, each with the same weight. Seen to fail
/// with the densities exchanged, and with levels without their unit.
#[test]
fn weights_are_those_of_the_densities() {
    let study = study(120, "");
    let path = study.path();
    let output = microslip(path, &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let output = with_prior(path, &uniform(0.1, 0.8));
    assert!(output.status.success(), "{output:?}");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("120 samples count for 120.0"), "{table}");
    assert!(
        table.contains("level 1 units of the harmonic force\n"),
        "{table}"
    );
    for level in reweighted(path)["levels"].as_array().unwrap() {
        for quantile in level["points"][0]["amplitude_m"].as_array().unwrap() {
            let [new, old] = ["reweighted", "sampled"].map(|key| &quantile[key]["estimate"]);
            assert_eq!(new, old);
        }
    }
    let samples = microslip::ensemble::store::read_samples(&path.join("results/samples.parquet"));
    let samples = samples.unwrap().outcomes;
    let output = with_prior(path, &uniform(0.3, 0.5));
    assert!(output.status.success(), "{output:?}");
    let found = reweighted(path);
    let inside = samples
        .iter()
        .filter(|o| (0.3..=0.5).contains(&o.inputs[0]));
    let mut amplitudes: Vec<f64> = inside
        .map(|o| o.levels[1].peak.unwrap().amplitude_m)
        .collect();
    amplitudes.sort_by(f64::total_cmp);
    let effective = found["weights"][0]["effective_samples"].as_f64().unwrap();
    assert!(
        (effective - amplitudes.len() as f64).abs() < 1e-9,
        "{effective}"
    );
    let median = &found["levels"][1]["points"][0]["amplitude_m"][1]["reweighted"]["estimate"];
    assert_eq!(median, amplitudes[amplitudes.len().div_ceil(2) - 1]);
    assert_eq!(
        found["inputs"][0]["reweighted"],
        "uniform: low 0.3, high 0.5"
    );
}

/// Outer points are weighted apart. Seen to fail with one group of all samples.
#[test]
fn outer_points_are_weighted_apart() {
    let box_of = "[inputs.stiffness_scale]\nkind = \"epistemic\"\nlower = 0.5\nupper = 2\n[epistemic]\npoints = 1\n";
    let study = study(160, box_of);
    let path = study.path();
    let output = microslip(path, &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let output = with_prior(path, &uniform(0.1, 0.8));
    assert!(output.status.success(), "{output:?}");
    let found = reweighted(path);
    assert_eq!(found["weights"].as_array().unwrap().len(), 4);
    assert_eq!(
        found["weights"][3]["effective_samples"]
            .as_f64()
            .unwrap()
            .round(),
        40.0
    );
    let interval = "[inputs.stiffness_scale]\ndistribution = \"uniform\"\nlow = 1\nhigh = 2\n";
    assert_refused(
        "box",
        &with_prior(path, interval),
        &["must be an input that the study draws"],
    );
}

/// A normal distribution cut off at both ends, around the upper one.
fn cut(standard_deviation: f64) -> String {
    format!(
        "[inputs.friction_coefficient]\ndistribution = \"normal\"\nmean = 0.8\nstandard_deviation = {standard_deviation}\ntruncation = [0.1, 0.8]\n"
    )
}

/// Priors, and what their messages must name.
fn refused_priors() -> [(String, &'static [&'static str]); 11] {
    let normal = "[inputs.friction_coefficient]\ndistribution = \"normal\"\nmean = 0.4\nstandard_deviation = 0.1\n";
    [
        (
            uniform(0.1, 0.9),
            &[
                "prior.toml:1: inputs.friction_coefficient: must lie in the sampled range 0.1 .. 0.8, not 0.1 .. 0.9",
            ],
        ),
        (
            normal.to_owned(),
            &[
                "inputs.friction_coefficient",
                "must not give negative values",
            ],
        ),
        (
            format!("{normal}truncation = [0.0, 0.8]\n"),
            &["sampled range 0.1 .. 0.8, not 0 .. 0.8"],
        ),
        (
            cut(0.001),
            &[
                "must lie where the samples are",
                "% of it are outside of their values",
            ],
        ),
        (
            uniform(0.40, 0.45),
            &["results: 120 samples count for", "must be at least 20"],
        ),
        (
            uniform(0.5, 0.2),
            &["prior.toml:4: inputs.friction_coefficient.high"],
        ),
        (
            String::new(),
            &["prior.toml:1: inputs: must hold the new distribution"],
        ),
        (
            "[inputs.damping_scale]\ndistribution = \"uniform\"\nlow = 1\nhigh = 2\n".to_owned(),
            &["inputs.damping_scale: must be an input that the study draws"],
        ),
        (
            "[inputs.friction_coefficient]\ndistribution = \"fixed\"\nvalue = 0.3\n".to_owned(),
            &["must have a density"],
        ),
        (
            "[inputs.friction_coefficient]\nkind = \"epistemic\"\nlower = 0.2\nupper = 0.3\n"
                .to_owned(),
            &["must be a distribution"],
        ),
        (
            format!("seed = 3\n{}", uniform(0.1, 0.8)),
            &["prior.toml:1: seed: unknown key; known are inputs"],
        ),
    ]
}

/// Line, key and rule for a bad file; the folder for what the samples do not give. Seen to fail without the check of the
/// range.
#[test]
fn priors_that_the_samples_do_not_reach_are_refused() {
    let study = study(120, "");
    let path = study.path();
    assert_refused(
        "nothing",
        &with_prior(path, &uniform(0.1, 0.8)),
        &["results/run.json"],
    );
    let output = microslip(path, &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    for (prior, fragments) in refused_priors() {
        assert_refused(&prior, &with_prior(path, &prior), fragments);
    }
    assert!(!path.join("results/reweighted.json").exists());
    std::fs::remove_file(path.join("prior.toml")).unwrap();
    let output = microslip(path, &["reweight", "results", "--prior", "prior.toml"]);
    assert_refused("absent", &output, &["prior.toml: "]);
}
