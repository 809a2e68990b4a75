//! The tutorial of the book shows what the program prints.

use std::path::Path;

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
