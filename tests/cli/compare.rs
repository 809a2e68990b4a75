//! `compare`: designs on common random numbers, from stored results.

use std::path::Path;

use serde_json::Value;

use super::bad_input::assert_refused;
use super::{STUDY, folder, microslip, without_curves};
use microslip::ensemble::outcome::LevelOutcome;
use microslip::ensemble::store::{StoredSamples, read_samples};

const STIFFNESS: &str =
    "[inputs.stiffness_scale]\ndistribution = \"log-uniform\"\nlow = 0.5\nhigh = 2\n";

/// Runs `text` as the study `name` of the folder into a folder of that name.
fn run(folder: &Path, name: &str, text: &str) {
    let file = format!("{name}.toml");
    std::fs::write(folder.join(&file), without_curves(text)).unwrap();
    let output = microslip(folder, &["run", &file, "--quiet", "--output", name]);
    assert!(output.status.success(), "{output:?}");
}

fn read(folder: &Path, name: &str) -> StoredSamples {
    read_samples(&folder.join(name).join("samples.parquet")).unwrap()
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The counts and the median are those of the stored samples, pair by pair. Seen to fail with the samples of the second
/// design shifted by one, and with two shares of the resamples where no sample failed.
#[test]
fn pairs_are_those_of_the_stored_samples() {
    let study = folder("study.toml", "two masses", "two masses");
    let path = study.path();
    let text = format!(
        "{}{STIFFNESS}",
        STUDY.replace("samples = 10", "samples = 40")
    );
    run(path, "a", &text);
    run(path, "b", &text.replace("x2 = 5.0", "x2 = 8.0"));
    let output = microslip(path, &["compare", "a", "b", "--output", "out"]);
    assert!(output.status.success(), "{output:?}");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    for words in [
        "A  a (two masses)",
        "level 2",
        "A - B: median",
        "P(B better)",
        "% quantile",
        "of the resamples\n",
    ] {
        assert!(table.contains(words), "{words:?} is not in {table}");
    }
    assert!(
        !table.contains("surely"),
        "two numbers that are one: {table}"
    );
    let (a, b) = (read(path, "a"), read(path, "b"));
    let found = json(&path.join("out/comparison.json"));
    for i in 0..2 {
        // amplitudes of the pairs of which both are to be trusted
        let levels = |of: &StoredSamples| -> Vec<LevelOutcome> {
            of.outcomes.iter().map(|o| o.levels[i].clone()).collect()
        };
        let pairs = levels(&a).into_iter().zip(levels(&b));
        let trusted = pairs.filter(|(a, b)| a.status.is_trusted() && b.status.is_trusted());
        let amplitude = |of: LevelOutcome| of.peak.unwrap().amplitude_m;
        let mut differences: Vec<f64> = trusted.map(|(a, b)| amplitude(a) - amplitude(b)).collect();
        let pair = &found["levels"][i]["quantities"][1]["pairs"][0];
        let better = differences.iter().filter(|d| **d < 0.0).count();
        assert_eq!(pair["a_better"]["yes"], better, "level {i}");
        assert_eq!(pair["a_better"]["unknown"], 40 - differences.len());
        differences.sort_by(f64::total_cmp);
        let median = differences[differences.len().div_ceil(2) - 1];
        assert_eq!(pair["median_difference"]["estimate"], median);
        let ranking = &found["levels"][i]["quantities"][1]["rankings"][0];
        assert_eq!(ranking["quantile"], 0.95);
    }
    let page = std::fs::read_to_string(path.join("out/comparison.html")).unwrap();
    assert!(page.contains("Designs A, B compared") && !page.contains("NaN"));
    let first = std::fs::read(path.join("out/comparison.json")).unwrap();
    let output = microslip(path, &["compare", "a", "b", "--output", "out", "--quiet"]);
    assert!(
        output.status.success() && output.stdout.is_empty(),
        "{output:?}"
    );
    assert!(first == std::fs::read(path.join("out/comparison.json")).unwrap());
}

/// An input with another distribution belongs to the design and is named; the other inputs pair to the bit. A design is
/// never better than itself. Seen to fail with the names of all inputs.
#[test]
fn a_distribution_may_be_the_design() {
    let study = folder("study.toml", "two masses", "two masses");
    let path = study.path();
    let text = format!("{STUDY}{STIFFNESS}");
    run(path, "a", &text);
    run(path, "b", &text.replace("low = 0.1", "low = 0.5"));
    run(path, "again", &text);
    let output = microslip(path, &["compare", "a", "b", "again"]);
    assert!(output.status.success(), "{output:?}");
    let found = json(&path.join("comparison/comparison.json"));
    assert_eq!(
        found["design_inputs"],
        serde_json::json!(["friction_coefficient"])
    );
    let pairs = found["levels"][0]["quantities"][0]["pairs"]
        .as_array()
        .unwrap()
        .clone();
    assert_eq!(pairs.len(), 3);
    let itself = pairs.iter().find(|p| p["a"] == 0 && p["b"] == 2).unwrap();
    assert_eq!(
        (&itself["a_better"]["yes"], &itself["b_better"]["yes"]),
        (&0.into(), &0.into())
    );
    assert_eq!(itself["median_difference"]["estimate"], 0.0);
}

/// Every outer point is compared apart. Seen to fail with all samples in one group.
#[test]
fn outer_points_are_compared_apart() {
    let study = folder("study.toml", "two masses", "two masses");
    let path = study.path();
    let box_of = "[inputs.stiffness_scale]\nkind = \"epistemic\"\nlower = 0.5\nupper = 2\n[epistemic]\npoints = 1\n";
    let text = format!("{}{box_of}", STUDY.replace("samples = 10", "samples = 20"));
    run(path, "a", &text);
    run(path, "b", &text.replace("x2 = 5.0", "x2 = 8.0"));
    let output = microslip(path, &["compare", "a", "b"]);
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("at outer point 3"));
    let found = json(&path.join("comparison/comparison.json"));
    let quantity = &found["levels"][1]["quantities"][1];
    let pairs = quantity["pairs"].as_array().unwrap();
    assert_eq!(
        (pairs.len(), quantity["rankings"].as_array().unwrap().len()),
        (4, 4)
    );
    for pair in pairs {
        let count = |key: &str| pair["a_better"][key].as_u64().unwrap();
        assert_eq!(count("yes") + count("no") + count("unknown"), 5);
    }
}

/// One message that names both folders and what differs. Seen to fail with the check of the values left out.
#[test]
fn what_cannot_be_paired_is_refused() {
    let study = folder("study.toml", "two masses", "two masses");
    let path = study.path();
    let text = format!("{STUDY}{STIFFNESS}");
    run(path, "a", &text);
    let refuse = |other: &str, fragments: &[&str]| {
        let output = microslip(path, &["compare", "a", other]);
        assert_refused(other, &output, fragments);
    };
    let cases = [
        ("seed", "seed = 7", "seed = 8", "its seed is 8, there 7"),
        (
            "few",
            "samples = 10",
            "samples = 9",
            "its design of the samples is monte-carlo, 9 samples, there monte-carlo, 10 samples; `microslip extend few --samples 10` adds the missing samples",
        ),
        (
            "levels",
            "[1.0, 2.0]",
            "[1.0, 2.5]",
            "its list of levels is [1.0, 2.5], there [1.0, 2.0]",
        ),
        (
            "inputs",
            STIFFNESS,
            "",
            "its list of random inputs is friction_coefficient, there stiffness_scale, ",
        ),
    ];
    for (name, old, new, fragment) in cases {
        run(path, name, &text.replace(old, new));
        refuse(
            name,
            &[&format!("{name}: cannot be compared with a: {fragment}")],
        );
    }
    let pairs = "[correlation]\npairs = [{ inputs = [\"stiffness_scale\", \"friction_coefficient\"], value = 0.5 }]\n";
    run(path, "correlated", &format!("{text}{pairs}"));
    let design = "its design of the samples is monte-carlo, 10 samples, correlated";
    refuse("correlated", &[design]);
    // so close that both designs read the same
    run(path, "a", &format!("{text}{pairs}"));
    let close = pairs.replace("0.5", "0.50001");
    run(path, "correlated", &format!("{text}{close}"));
    let rule = "although its distribution is the same";
    refuse("correlated", &["has another", rule]);
    std::fs::copy(
        path.join("seed/samples.parquet"),
        path.join("a/samples.parquet"),
    )
    .unwrap();
    refuse(
        "correlated",
        &["samples.parquet is not the file that the run wrote"],
    );
    refuse("nowhere", &["nowhere/run.json"]);
    let output = microslip(path, &["compare", "a"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
}

/// One design, solved on 3 and on 7 harmonics: what the harmonics change is no difference of designs, and engine orders of their own are named.
/// Seen to fail with the program before: each is better in half of the samples.
#[test]
fn numerical_errors_are_no_difference() {
    let study = folder("study.toml", "two masses", "two masses");
    let path = study.path();
    let operation = "\n[operation]\nspeed_rpm = [1000, 1100]\nengine_orders = [4]\n";
    let text = format!(
        "{}{operation}",
        STUDY.replace("[1.0, 2.0]", "[3.0]").replace(
            "harmonics = 5",
            "harmonics = 3\nalert = { threshold = 0.5 }"
        )
    );
    run(path, "a", &text);
    let more = text.replace("harmonics = 3", "harmonics = 7");
    run(
        path,
        "b",
        &more.replace("engine_orders = [4]", "engine_orders = [5]"),
    );
    let output = microslip(path, &["compare", "a", "b", "--output", "out"]);
    assert!(output.status.success(), "{output:?}");
    let amplitudes = |of: &str| -> Vec<f64> {
        let outcomes = read(path, of).outcomes.into_iter();
        outcomes
            .map(|o| o.levels[0].peak.expect("a peak").amplitude_m)
            .collect()
    };
    let [a, b] = ["a", "b"].map(amplitudes);
    let apart = a.iter().zip(&b).map(|(a, b)| (a / b - 1.0).abs());
    assert!(
        apart.fold(0.0, f64::max) > 1e-5,
        "more than the tolerance of a peak"
    );
    let found = json(&path.join("out/comparison.json"));
    let amplitude = &found["levels"][0]["quantities"][1];
    assert_eq!(amplitude["quantity"], "amplitude_m");
    for side in ["a_better", "b_better"] {
        assert_eq!(amplitude["pairs"][0][side]["yes"], 0, "{amplitude}");
    }
    assert_eq!(amplitude["rankings"][0]["surely"], 0.0);
    assert_eq!(amplitude["rankings"][0]["possibly"], 1.0);
    let page = std::fs::read_to_string(path.join("out/comparison.html")).unwrap();
    assert!(page.contains("different engine orders"));
}
