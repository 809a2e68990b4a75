//! The program, run as a user runs it.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

/// The program, run in `folder`.
pub(crate) fn microslip(folder: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}
