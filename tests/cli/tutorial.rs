//! The tutorial of the book shows what the program prints.

use std::path::Path;

use serde_json::Value;

use super::microslip;

/// Lines of `inspect` and `solve` for the study of the tutorial, but for the estimates of memory and time.
///
/// Seen to fail with another friction coefficient in the study.
#[test]
fn the_tutorial_shows_what_the_program_prints() {
    let page = std::fs::read_to_string("docs/src/tutorial.md").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let study = "studies/own-matrices/study.toml";
    let mut missing = Vec::new();
    for arguments in [
        vec!["inspect", study],
        vec!["solve", study, "--output", out],
    ] {
        let output = microslip(Path::new("."), &arguments);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let text = String::from_utf8(output.stdout).unwrap();
        let estimates = [
            "memory",
            "processor time",
            "pilot",
            "wall time",
            "curve.csv",
        ];
        let lines = (text.lines()).filter(|line| !estimates.iter().any(|e| line.starts_with(e)));
        missing.extend(
            lines
                .filter(|line| !page.contains(*line))
                .map(str::to_owned),
        );
    }
    assert!(
        missing.is_empty(),
        "not on the page:\n{}",
        missing.join("\n")
    );
}

/// Verdicts of the results in `folder`, each with its sentence.
fn verdicts(folder: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    let words = |of: &Value, key: &str| of[key].as_str().unwrap().to_owned();
    let criteria = report["criteria"].as_array().unwrap().iter();
    criteria
        .map(|one| format!("{}. {}", words(one, "judgement"), words(one, "sentence")))
        .collect()
}

/// Lines of `run`, and the verdicts as they change while the hints of the page are followed. Seen to fail with the page before, which had a
/// sentence that the program does not print.
#[test]
fn the_tutorial_shows_the_verdicts() {
    let page = std::fs::read_to_string("docs/src/tutorial.md").unwrap();
    let lines = page.lines().map(|line| line.trim_start_matches("> "));
    let page_words = lines.collect::<Vec<_>>().join(" ");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let study = "studies/own-matrices/study.toml";
    let run = microslip(Path::new("."), &["run", study, "--output", out]);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let text = String::from_utf8(run.stdout).unwrap();
    for line in text.lines().filter(|line| line.starts_with("level ")) {
        assert!(page.contains(line), "not on the page: {line}");
    }
    let first = verdicts(folder.path());
    assert_eq!(first.len(), 2, "{first:?}");
    let mut all = first;
    for samples in ["198", "400"] {
        let command = format!("microslip extend results --samples {samples}");
        assert!(page.contains(&command), "not on the page: {command}");
        let extend = ["extend", out, "--samples", samples, "--quiet"];
        let extended = microslip(Path::new("."), &extend);
        assert_eq!(extended.status.code(), Some(0), "{extended:?}");
        all.push(verdicts(folder.path()).remove(1));
    }
    for verdict in &all {
        assert!(page_words.contains(verdict), "not on the page: {verdict}");
    }
}
