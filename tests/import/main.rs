//! Models of other programs: files that the tests write by the rules of each format, whole and damaged.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its files fails"
)]

mod abaqus;
mod ansys;
mod calculix;
mod calculix_blade;
mod chain;
mod command;
#[path = "../common/damage.rs"]
mod damage;
mod fuzz;
#[path = "../common/mat_file.rs"]
mod mat_file;
mod matlab;
mod nastran;
mod numpy;
mod op4;
mod pairs;
#[path = "../common/program.rs"]
mod program;
mod reduce;
#[path = "../common/mutation.rs"]
mod shared_mutation;
mod tutorial;
mod warnings;

use std::path::Path;

use program::microslip;

/// Exit code 2 and one message with all fragments; nothing is written.
fn assert_refused(folder: &Path, arguments: &[&str], fragments: &[&str]) {
    let output = microslip(folder, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    for fragment in fragments {
        assert!(
            message.contains(fragment),
            "{arguments:?}: {message} lacks {fragment:?}"
        );
    }
    assert!(!folder.join("model").exists(), "{arguments:?}: written");
}
