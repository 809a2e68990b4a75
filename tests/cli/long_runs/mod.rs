//! Runs that end before their time, and go on.

mod damage;
mod faults;
mod interruption;
mod other_runs;
mod shares;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::Mutex;

use super::{Files, assert_same_files, change, files, folder, microslip, write};
use assert_cmd::cargo::CommandCargoExt;
use tempfile::TempDir;

/// A folder with the study of two masses and so many samples, of which a fifth have curves.
fn study(samples: u64) -> TempDir {
    let folder = folder(
        "study.toml",
        "samples = 10",
        &format!("samples = {samples}"),
    );
    change(
        folder.path(),
        "[output]\n",
        &format!("[output]\ncurve_samples = {}\n", samples / 5),
    );
    folder
}

/// The same, solved without a disturbance into `whole`: once for all tests, each of which has a copy.
fn solved(samples: u64) -> TempDir {
    static SOLVED: Mutex<BTreeMap<u64, Files>> = Mutex::new(BTreeMap::new());
    let mut solved = SOLVED.lock().unwrap();
    let files = solved.entry(samples).or_insert_with(|| {
        let study = study(samples);
        run(study.path(), "whole", &["--quiet"]);
        files(study.path())
    });
    let copy = tempfile::tempdir().unwrap();
    write(files, copy.path());
    copy
}

/// Waits until a run has written a part.
fn wait_for_a_part(folder: &Path, output: &str) {
    let whole = |name: &String| name.ends_with(".samples.parquet");
    while !parts(folder, output).iter().any(whole) {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// Runs the study to its end into `output`; returns what it said.
fn run(folder: &Path, output: &str, more: &[&str]) -> String {
    let arguments = [&["run", "study.toml", "--output", output][..], more].concat();
    let result = microslip(folder, &arguments);
    let message = String::from_utf8_lossy(&result.stderr).into_owned();
    assert!(result.status.success(), "{message}");
    message + &String::from_utf8_lossy(&result.stdout)
}

/// Starts a run that writes what it solves `every` so often.
fn start(folder: &Path, output: &str, every: &str, more: &[&str]) -> Child {
    let arguments = ["run", "study.toml", "--quiet", "--flush-every", every];
    std::process::Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(folder)
        .args(arguments)
        .args(["--output", output])
        .args(more)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Exit code of a process that was started, and what it said.
fn ended(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), said)
}

/// Fails with exit code 2 and one line that has `fragment`, after the warning that results of another study would be replaced, if any.
fn refused(folder: &Path, arguments: &[&str], fragment: &str) {
    let output = microslip(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    let is_error = |line: &&str| !line.starts_with("warning: replaces the results in ");
    assert_eq!(message.lines().filter(is_error).count(), 1, "{message}");
    let found = message.contains(fragment);
    assert!(found, "{fragment:?} is not in: {message}");
}

/// The results are those of `whole`, and nothing else is left beside them.
fn assert_same_results(folder: &Path, output: &str) {
    assert_same_files(folder, output);
    let left = ["parts", ".unfinished", ".placing"].map(|name| folder.join(output).join(name));
    assert!(left.iter().all(|path| !path.exists()), "something is left");
    let verified = microslip(folder, &["verify", output]);
    assert!(verified.status.success(), "{verified:?}");
}

/// Names of the files in the parts of `output`, in order.
fn parts(folder: &Path, output: &str) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder.join(output).join("parts")) else {
        return Vec::new();
    };
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.unwrap().file_name().to_string_lossy().into_owned()
    };
    let mut names: Vec<String> = entries.map(name).collect();
    names.sort();
    names
}

/// Changes the bytes of a file.
fn change_bytes(path: &Path, how: impl Fn(&mut Vec<u8>)) {
    let mut bytes = std::fs::read(path).unwrap();
    how(&mut bytes);
    std::fs::write(path, bytes).unwrap();
}

/// Damages the first file of the parts of `output` whose name ends so, and tells its name.
fn damage(folder: &Path, output: &str, end: &str, how: impl Fn(&mut Vec<u8>)) -> String {
    let names = parts(folder, output);
    let name = names.into_iter().find(|name| name.ends_with(end)).unwrap();
    change_bytes(&folder.join(output).join("parts").join(&name), how);
    name
}

/// Starts a run and ends it by force when it has written so many parts at least.
fn killed_after(folder: &Path, output: &str, n_parts: usize) {
    let mut child = start(folder, output, "20ms", &[]);
    let written = || {
        let names = parts(folder, output);
        names
            .iter()
            .filter(|name| name.ends_with(".samples.parquet"))
            .count()
    };
    while written() < n_parts {
        let ended = child.try_wait().unwrap();
        assert!(ended.is_none(), "the run ended before it was killed");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
}
