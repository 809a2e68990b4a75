//! What `inspect` shows.

use std::process::Output;

use super::{folder, microslip};

fn shown(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Two spaces at least are between the name of an input and its distribution. Seen to fail without the width of the longest name:
/// `tangential_stiffness_scalelog-uniform`.
#[test]
fn long_names_stand_apart_from_their_distributions() {
    let folder = folder(
        "study.toml",
        "[inputs.friction_coefficient]",
        "[inputs.tangential_stiffness_scale]",
    );
    let text = shown(&microslip(folder.path(), &["inspect", "study.toml"]));
    let line = "  tangential_stiffness_scale  uniform: low 0.1, high 0.8";
    assert!(text.contains(line), "{text}");
}

/// It shows what it was asked for. Seen to fail with warnings on the standard output.
#[test]
fn quiet_leaves_what_was_asked_for() {
    let folder = folder("study.toml", "mu = 0.3", "mu = 3.0");
    let output = microslip(folder.path(), &["inspect", "study.toml", "--quiet"]);
    let text = shown(&output);
    assert!(text.contains("degrees of freedom  2: x1, x2"), "{text}");
    let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        warnings.starts_with("warning: study.toml:22:"),
        "{warnings}"
    );
    assert!(!text.contains("warning"), "{text}");
}
