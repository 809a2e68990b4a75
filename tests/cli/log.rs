//! What commands say of their work: JSON lines for programs, and where the time went.

use serde_json::Value;

use super::{folder, microslip};
use crate::function_case::case;

/// The lines of a text as JSON.
fn lines(text: &[u8]) -> Vec<Value> {
    let text = String::from_utf8_lossy(text);
    let line = |line: &str| serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}"));
    text.lines().map(line).collect()
}

/// Seen to fail with warnings as plain lines, and with a refusal as a plain line.
#[test]
fn every_line_of_the_log_is_json() {
    let folder = folder("study.toml", "samples = 10", "samples = 40");
    let path = folder.path();
    let output = microslip(path, &["run", "study.toml", "--log", "json"]);
    assert!(output.status.success(), "{output:?}");
    let log = lines(&output.stderr);
    let events: Vec<&str> = log.iter().map(|l| l["event"].as_str().unwrap()).collect();
    assert_eq!(events[0], "started");
    assert_eq!(*events.last().unwrap(), "finished");
    assert!(events.iter().filter(|e| **e == "progress").count() >= 10);
    let progress = log.iter().rfind(|l| l["event"] == "progress").unwrap();
    assert_eq!(
        (&progress["done"], &progress["total"]),
        (&40.into(), &40.into())
    );
    let end = log.last().unwrap();
    assert_eq!(end["samples"], 40);
    let of_samples = &end["thread_seconds_of_samples"];
    assert!(of_samples["peaks"].as_f64().unwrap() > 0.0, "{end}");
    assert!(end["seconds_of_stages"]["report"].as_f64().unwrap() > 0.0);
    assert!(
        log.iter()
            .all(|l| l["time"].as_str().unwrap().ends_with('Z'))
    );

    let text = std::fs::read_to_string(path.join("study.toml")).unwrap();
    std::fs::write(path.join("study.toml"), text.replace("seed", "sead")).unwrap();
    let refused = microslip(path, &["run", "study.toml", "--log", "json"]);
    assert_eq!(refused.status.code(), Some(2));
    let log = lines(&refused.stderr);
    assert_eq!(log.len(), 1);
    assert_eq!(log[0]["event"], "error");
    assert!(log[0]["message"].as_str().unwrap().contains("sead"));
}

/// Warnings are no part of what `inspect` shows. Seen to fail with warnings as plain text on the standard output, and no end.
#[test]
fn inspect_warns_in_the_log() {
    let folder = folder("study.toml", "mu = 0.3", "mu = 3.0");
    let output = microslip(folder.path(), &["inspect", "study.toml", "--log", "json"]);
    assert!(output.status.success(), "{output:?}");
    let log = lines(&output.stderr);
    let events: Vec<&str> = log.iter().map(|l| l["event"].as_str().unwrap()).collect();
    assert_eq!(events, ["warning", "finished"]);
    let message = log[0]["message"].as_str().unwrap();
    assert!(message.contains("model.contact[0].mu = 3"), "{message}");
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(shown.contains("degrees of freedom"), "{shown}");
    assert!(!shown.contains("is unusual"), "{shown}");
}

/// Seen to fail with progress as the last line.
#[test]
fn solve_logs_its_end() {
    let folder = folder(
        "study.toml",
        "[100, 200]",
        "[100, 200]\nvalues_hz = [150, 160]",
    );
    let output = microslip(folder.path(), &["solve", "study.toml", "--log", "json"]);
    assert!(output.status.success(), "{output:?}");
    let log = lines(&output.stderr);
    let end = log.last().unwrap();
    assert_eq!(end["event"], "finished");
    assert_eq!(end["levels"].as_array().unwrap().len(), 2, "{end}");
    let level = &end["levels"][1];
    assert_eq!((&level["points"], &level["solved"]), (&2.into(), &2.into()));
    assert!(
        end["folder"].as_str().unwrap().ends_with("results"),
        "{end}"
    );
}

/// Seen to fail with the stages as plain lines, and without an end.
#[test]
fn calibrate_logs_its_stages_and_its_end() {
    let folder = case();
    let files = ["--measured", "response.csv", "--output", "calibrated"];
    let arguments = [
        &["calibrate", "study.toml"],
        &files[..],
        &["--draws", "100", "--log", "json"],
    ];
    let output = microslip(folder.path(), &arguments.concat());
    assert!(output.status.success(), "{output:?}");
    let log = lines(&output.stderr);
    let of = |event: &str| -> Vec<&Value> { log.iter().filter(|l| l["event"] == event).collect() };
    let stages = of("stage");
    assert_eq!(
        (&stages[0]["stage"], &stages[0]["samples"]),
        (&"samples".into(), &48.into())
    );
    assert_eq!(
        (&stages[1]["stage"], &stages[1]["round"]),
        (&"chains".into(), &1.into())
    );
    let end = log.last().unwrap();
    assert_eq!(end["event"], "finished");
    assert!(
        end["folder"].as_str().unwrap().ends_with("calibrated"),
        "{end}"
    );
    let rounds = of("stage")
        .iter()
        .filter(|l| l["stage"] == "chains")
        .count();
    assert_eq!(end["rounds"], rounds);
    assert!(end["misfit_probability"].as_f64().unwrap() > 0.0, "{end}");

    let refused = microslip(
        folder.path(),
        &[&arguments.concat()[..], &["--chains", "1"]].concat(),
    );
    assert_eq!(refused.status.code(), Some(2));
    let log = lines(&refused.stderr);
    let message = log.last().unwrap()["message"].as_str().unwrap();
    assert!(message.contains("--chains = 1"), "{message}");
}

/// A calibration keeps nothing on the way: stopped, it says so in its last line and ends with exit code 3, as a run does. Seen to fail with
/// the program before, which the signal killed.
#[cfg(unix)]
#[test]
fn a_stopped_calibration_says_so() {
    use assert_cmd::cargo::CommandCargoExt;
    use std::io::{BufRead, BufReader, Read};
    let folder = case();
    let mut child = std::process::Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(folder.path())
        .args(["calibrate", "study.toml", "--measured", "response.csv"])
        .args(["--output", "calibrated", "--draws", "100000"])
        .args(["--log", "json"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut log = String::new();
    // the first stage has begun
    said.read_line(&mut log).unwrap();
    crate::terminate(&child);
    let status = child.wait().unwrap();
    said.read_to_string(&mut log).unwrap();
    assert_eq!(status.code(), Some(3), "{log}");
    let last = lines(log.as_bytes()).pop().unwrap();
    assert_eq!(last["event"], "stopped", "{log}");
    let message = last["message"].as_str().unwrap();
    assert!(message.contains("begins anew"), "{message}");
}

/// Seen to fail with the time of the curves counted among the peaks.
#[test]
fn the_profile_says_where_the_time_went() {
    let folder = folder("study.toml", "[output]\n", "[output]\ncurve_samples = 10\n");
    let profile = |text: &[u8]| -> Vec<(String, f64)> {
        let text = String::from_utf8_lossy(text).into_owned();
        let (_, table) = text
            .split_once("wall time of this process by stage:\n")
            .unwrap();
        let rows = table.lines().filter_map(|line| line.strip_suffix(" s"));
        rows.map(|row| {
            let (name, seconds) = row.trim().rsplit_once(' ').unwrap();
            (name.trim().to_owned(), seconds.parse().unwrap())
        })
        .collect()
    };
    let arguments = ["run", "study.toml", "--profile", "--threads", "1"];
    let first = profile(&microslip(folder.path(), &arguments).stdout);
    let names: Vec<&str> = first.iter().map(|(name, _)| name.as_str()).collect();
    let stages = ["model", "samples", "tables", "report"];
    let times = ["peaks", "larger harmonic sets", "stability", "curves"];
    assert_eq!(names, [&stages[..], &times[..]].concat());
    let of = |name: &str| first.iter().find(|(of, _)| of == name).unwrap().1;
    let sum: f64 = times.iter().map(|name| of(name)).sum();
    assert!(sum <= 1.05 * of("samples") + 0.02, "{first:?}");
    assert!(of("curves") > 0.0, "{first:?}");
    // whole results: only the report is made
    let again = profile(&microslip(folder.path(), &arguments).stdout);
    assert_eq!(again[0].0, "report");
}

/// Seen to fail with an `extend` that says it where it is quiet alone.
#[test]
fn extend_says_where_the_time_went() {
    let folder = folder("study.toml", "samples = 10", "samples = 2");
    let output = microslip(folder.path(), &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let more = ["extend", "results", "--samples", "4", "--profile"];
    let output = microslip(folder.path(), &more);
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    for words in ["wall time of this process by stage:", "Newton iterations:"] {
        assert!(shown.contains(words), "{words}: {output:?}");
    }
}
