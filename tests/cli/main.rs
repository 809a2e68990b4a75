//! The command line, run as a user runs it.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its files fails"
)]

mod bad_input;
mod branch_maximum;
mod compare;
mod control_variate;
mod curves;
#[path = "../common/described.rs"]
mod described;
mod designs;
mod disk;
mod disk_page;
mod export;
mod extend;
#[path = "../common/function_case.rs"]
mod function_case;
mod identified;
mod initial_traction;
mod inputs;
mod inspect;
mod log;
mod long_runs;
mod mistuned;
mod mistuned_ring;
mod modes;
mod output_schemas;
mod preloads;
#[path = "../common/program.rs"]
mod program;
mod refused_output;
mod report;
mod reweight;
mod run;
mod schema;
mod serve;
mod shell;
mod small_models;
mod solve;
mod stability;
mod stick_limit;
mod stopping;
mod strip;
mod test_functions;
mod tutorial;
mod worst_case;

use program::microslip;
use serde_json::Value;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder with the matrices of a case of `tests/reference`, and the text of its study.
fn reference_study(case: &str) -> (TempDir, String) {
    let source = Path::new("tests/reference").join(case);
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&source).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|of| of == "mtx") {
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    let study = std::fs::read_to_string(source.join("study.toml")).unwrap();
    (folder, study)
}

const STUDY: &str = r#"name = "two masses"
seed = 7
samples = 10
levels = [1.0, 2.0]

[model]
kind = "matrices"
mass = "mass.mtx"
stiffness = "stiffness.mtx"
modal_damping_ratio = 0.01
dof_names = ["x1", "x2"]
static_force = { x2 = 5.0 }
cosine_force = { x1 = 1.0 }
responses = ["x1"]

[[model.contact]]
name = "c1"
t1 = { x1 = 1.0 }
n = { x2 = 1.0 }
k_t1 = 2e5
k_n = 1e6
mu = 0.3

[contact]
law = "box"

[inputs.friction_coefficient]
distribution = "uniform"
low = 0.1
high = 0.8

[solver]
harmonics = 5
time_points = 128

[frequency]
band_hz = [100, 200]

[output]
"#;

const MASS: &str = "%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n1 1 1.0\n2 2 1.5\n";
const STIFFNESS: &str = "%%MatrixMarket matrix array real general\n2 2\n1e6\n-2e5\n-2e5\n8e5\n";

/// The study `text` without response curves, which take three quarters of its time.
fn without_curves(text: &str) -> String {
    assert!(text.contains("[output]\n"), "the study has no output");
    text.replacen("[output]\n", "[output]\ncurve_samples = 0\n", 1)
}

/// Standard output of a command that succeeds.
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = microslip(folder, arguments);
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// Files of a folder with their paths inside it.
type Files = Vec<(PathBuf, Vec<u8>)>;

fn files(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut found = Files::new();
    for path in paths {
        let name = PathBuf::from(path.file_name().unwrap());
        match path.is_dir() {
            true => found.extend((files(&path).into_iter()).map(|(of, all)| (name.join(of), all))),
            false => found.push((name, std::fs::read(&path).unwrap())),
        }
    }
    found
}

/// Writes the files into a folder.
fn write(files: &Files, folder: &Path) {
    for (path, bytes) in files {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// Replaces `old` by `new` in the study of `folder`.
fn change(folder: &Path, old: &str, new: &str) {
    let path = folder.join("study.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(old), "the study has no {old:?}");
    std::fs::write(path, text.replacen(old, new, 1)).unwrap();
}

/// The tables, the report and all but the wall time of the summary in `output` are those of `whole`.
fn assert_same_files(folder: &Path, output: &str) {
    let read = |of: &str, name: &str| std::fs::read(folder.join(of).join(name)).unwrap();
    for name in [
        "samples.parquet",
        "curves.parquet",
        "atlas.parquet",
        "report.json",
    ] {
        assert!(read(output, name) == read("whole", name), "{name} differs");
    }
    let summary = |of: &str| {
        let mut json: Value = serde_json::from_slice(&read(of, "summary.json")).unwrap();
        json.as_object_mut().unwrap().remove("wall_time_s").unwrap();
        json
    };
    assert_eq!(summary(output), summary("whole"), "summary.json");
}

/// Asks a process to end, as a scheduler does.
fn terminate(child: &std::process::Child) {
    let kill = format!("kill -TERM {}", child.id());
    let sent = std::process::Command::new("sh")
        .args(["-c", &kill])
        .status();
    assert!(sent.unwrap().success(), "no signal was sent");
}

/// A folder with the study and its matrices, `old` replaced by `new` in `file`.
fn folder(file: &str, old: &str, new: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("study.toml", STUDY),
        ("mass.mtx", MASS),
        ("stiffness.mtx", STIFFNESS),
    ] {
        let text = if name == file {
            assert!(text.contains(old), "{file} has no {old:?}");
            text.replacen(old, new, 1)
        } else {
            text.to_owned()
        };
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}
