//! The search for the worst case between the outer points, on a function whose worst case lies where none of them is.

use microslip::ensemble::store::read_samples;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

use super::bad_input::assert_refused;
use super::test_functions::{UNIFORM, study};
use super::{change, microslip, succeed};

pub(crate) const INTERVAL: &str =
    "kind = \"epistemic\"\nlower = 0.001\nupper = 0.999\nscale = \"linear\"";
/// The 95 % quantile of u is 0.95; at outer point 3, x = 0.323, it is 1.42, and 6.95 at x = 0.37.
pub(crate) const CRITERION: &str = r#"
[[criteria]]
name = "amplitude"
quantity = "amplitude-um"
limit = 1.43
"#;

/// A study with 100 samples at each of the corners, the centre and `points` more.
fn write(points: u64, samples: u64, epistemic: &str) -> TempDir {
    let more = format!("[epistemic]\npoints = {points}\n{epistemic}\n{CRITERION}");
    let inputs = [INTERVAL, UNIFORM];
    study(
        "narrow-worst-case",
        &inputs,
        "monte-carlo",
        samples * (3 + points),
        &more,
    )
}

/// The only criterion of the report.
fn criterion(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("results/report.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["criteria"][0].clone()
}

fn run(folder: &Path, threads: &str) -> Value {
    let arguments = ["run", "study.toml", "--quiet", "--threads", threads];
    succeed(folder, &arguments);
    criterion(folder)
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join("results").join(name)).unwrap()
}

/// Where no input is random one sample of a point decides it: a box of two fixed values and one interval is judged with one each, and a
/// study without any interval with one at all. Seen to fail (UNDECIDED, 59 samples needed) with every study taken for a random one.
#[test]
fn one_sample_decides_a_point_where_no_input_is_random() {
    let fixed = |value: f64| format!("distribution = \"fixed\"\nvalue = {value}");
    let half = fixed(0.5);
    let inputs = [INTERVAL, &half];
    let more = format!("[epistemic]\npoints = 8\n{CRITERION}");
    let folder = study("narrow-worst-case", &inputs, "monte-carlo", 11, &more);
    let found = run(folder.path(), "2");
    assert_eq!(found["judgement"], "FAIL");
    let sentence = found["sentence"].as_str().unwrap();
    let start = "No input is random: the amplitude is ";
    assert!(sentence.starts_with(start), "{sentence}");
    assert!(
        sentence.contains("passes at ") && !sentence.contains("undecided"),
        "{sentence}"
    );
    for (x, judgement) in [(0.9, "PASS"), (0.37, "FAIL")] {
        let value = fixed(x);
        let inputs = [&value[..], &half];
        let folder = study("narrow-worst-case", &inputs, "monte-carlo", 1, CRITERION);
        let found = run(folder.path(), "1");
        assert_eq!(found["judgement"], judgement, "{found}");
        let page = std::fs::read_to_string(folder.path().join("results/report.html")).unwrap();
        let condition = "No input is random: the samples do not scatter. Inputs: stiffness_scale (fixed: value ";
        assert!(page.contains(condition));
        assert!(!page.contains("samples needed") && !page.contains("59 needed"));
    }
}

/// Without a search the number of outer points decides the verdict: none of 3 sees the worst case, one of 5 its flank, one
/// of 11 itself. With a search it fails whatever they are, at the place of the worst case, and says where it passes. Seen to
/// fail (PASS) with the further points left out where results are read.
#[test]
fn a_worst_case_between_the_points_is_found() {
    for (points, blind) in [(0, "PASS"), (2, "UNDECIDED"), (8, "FAIL")] {
        let folder = write(points, 100, "search = 0");
        assert_eq!(run(folder.path(), "2")["judgement"], blind, "{points}");
        let table = folder.path().join("results/further_points.parquet");
        assert!(!table.exists());
        let folder = write(points, 100, "");
        let found = run(folder.path(), "2");
        assert_eq!(found["judgement"], "FAIL", "{points}");
        let sentence = found["sentence"].as_str().unwrap();
        assert!(
            sentence.contains("fails at ") && sentence.contains("passes at "),
            "{sentence}"
        );
        for point in found["levels"][0]["over_box"]["points"].as_array().unwrap() {
            let x = point["values"][0].as_f64().unwrap();
            let quantile = 0.95 + 6.0 * (-((x - 0.37_f64) / 0.03).powi(2)).exp();
            let (estimate, judgement) = (point["estimate"].as_f64().unwrap(), &point["judgement"]);
            assert!(
                (estimate - quantile).abs() < 0.1,
                "{estimate} at {x}, not {quantile}"
            );
            assert!(quantile < 1.6 || judgement == "FAIL", "{point}");
            assert!(quantile > 1.3 || judgement == "PASS", "{point}");
        }
    }
}

/// Where nothing worse is found a PASS says at how many points, how many of these the search has chosen, and that this proves
/// nothing between them; every further point has the random numbers of the others. Seen to fail with those of the next sample
/// at further points.
#[test]
fn a_pass_says_what_was_searched() {
    let folder = write(0, 100, "");
    change(folder.path(), "limit = 1.43", "limit = 8.0");
    let facts = microslip(folder.path(), &["inspect", "study.toml"]).stdout;
    let facts = String::from_utf8(facts).unwrap();
    assert!(facts.contains("worst-case search   up to 900 samples more"));
    let found = run(folder.path(), "2");
    assert_eq!(found["judgement"], "PASS");
    let points = found["levels"][0]["over_box"]["points"].as_array().unwrap();
    // 9 points at most, of which the centre is known
    assert_eq!(points.len(), 11);
    let words =
        "Searched for the worst case: 8 of the 11 points; what lies between them is not proved.";
    let sentence = found["sentence"].as_str().unwrap();
    assert!(sentence.contains(words), "{sentence}");
    let page = String::from_utf8(bytes(folder.path(), "report.html")).unwrap();
    assert!(page.contains("PASS at 11 points") && page.contains("from number 3 on"));
    let read = |name: &str| read_samples(&folder.path().join("results").join(name)).unwrap();
    let design = read("samples.parquet").outcomes;
    let further = read("further_points.parquet").outcomes;
    assert_eq!((design.len(), further.len()), (300, 800));
    for (k, sample) in further.iter().enumerate() {
        let twin = &design[3 * (k % 100)];
        assert_eq!(sample.inputs[1].to_bits(), twin.inputs[1].to_bits());
        assert_eq!(sample.index, 300 + k as u64);
        assert_eq!(sample.group.outer, Some(3 + k as u32 / 100));
    }
}

/// The same further points with one thread and with three, in an extended run and in the whole one, and `report` gives the
/// same from them. Seen to fail with the further points of the smaller run kept.
#[test]
fn further_points_are_those_of_the_whole_run() {
    let [whole, folder] = [100, 50].map(|samples| write(0, samples, ""));
    for (folder, threads) in [(&whole, "1"), (&folder, "3")] {
        change(folder.path(), "[output]", "[output]\narrow = true");
        run(folder.path(), threads);
    }
    let arguments = ["extend", "results", "--samples", "300", "--quiet"];
    succeed(folder.path(), &arguments);
    let assert_same = |names: &[&str]| {
        for name in names {
            let same = bytes(folder.path(), name) == bytes(whole.path(), name);
            assert!(same, "{name} differs");
        }
    };
    let tables = ["samples.parquet", "further_points.parquet"];
    assert_same(&tables);
    assert_same(&["further_points.arrow", "report.json"]);
    succeed(folder.path(), &["report", "results"]);
    assert_same(&["report.json"]);
}

/// Two searches meet other points, which no comparison pairs; a table of further points that was changed is no result of the
/// run; and a run without a search leaves none of an older one. Seen to fail with the further points in the comparison, with
/// the table missing in `run.json`, and with the old table kept.
#[test]
fn further_points_are_part_of_the_results() {
    let folder = write(0, 50, "");
    run(folder.path(), "2");
    change(folder.path(), "points = 0", "points = 0\nsearch = 20");
    let arguments = ["run", "study.toml", "--quiet", "--output", "more"];
    succeed(folder.path(), &arguments);
    let arguments = ["compare", "results", "more", "--output", "compared"];
    succeed(folder.path(), &arguments);
    let table = folder.path().join("results/further_points.parquet");
    std::fs::copy(folder.path().join("more/further_points.parquet"), &table).unwrap();
    let extended = microslip(folder.path(), &["extend", "results", "--samples", "300"]);
    let words = [
        "further_points.parquet",
        "is not the file that the run wrote",
    ];
    assert_refused("extend", &extended, &words);
    change(folder.path(), "search = 20", "search = 0");
    run(folder.path(), "2");
    assert!(!table.exists());
}

/// One mass between two stuck contacts whose stiffness is an interval: its resonance rises from 326 to 478 Hz, across engine order 8 at 346.67 to
/// 347.07 Hz (2600 to 2603 1/min) where the stiffness is 0.747 times the nominal one. No point of the box lies there. Seen to fail with the
/// program before: PASS, 0.339 % away, without a word that points lie on both sides.
#[test]
fn a_resonance_on_both_sides_of_an_engine_order_crosses_it() {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("mass.mtx", "0.4"), ("stiffness.mtx", "1.6e6")] {
        let text = format!("%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 {value}\n");
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let study = r#"
name = "one mass"
seed = 5
samples = 660
levels = [1.0]
[model]
kind = "matrices"
mass = "mass.mtx"
stiffness = "stiffness.mtx"
modal_damping_ratio = 0.005
dof_names = ["x"]
cosine_force = { x = 1.0 }
[[model.contact]]
name = "one"
t1 = { x = 1.0 }
k_t1 = 4e5
mu = 0.5
n_0 = 1e8
[inputs.stiffness_scale]
kind = "epistemic"
lower = 0.2
upper = 5.0
[inputs.excitation_scale]
distribution = "normal"
mean = 1.0
standard_deviation = 0.1
truncation = [0.5, 1.5]
[frequency]
band_hz = [250, 520]
[output]
curve_samples = 0
[operation]
speed_rpm = [2600, 2603]
engine_orders = [8]
[[criteria]]
name = "margin"
quantity = "frequency-margin-percent"
limit = 0.1
"#;
    for search in ["", "\n[epistemic]\nsearch = 0\n"] {
        std::fs::write(folder.path().join("study.toml"), format!("{study}{search}")).unwrap();
        let found = run(folder.path(), "2");
        assert_ne!(found["judgement"], "PASS", "{search}: {found}");
        let estimate = found["levels"][0]["estimate"].as_f64().unwrap();
        assert!(estimate < 0.1, "{estimate} %");
        std::fs::remove_dir_all(folder.path().join("results")).unwrap();
    }
}
