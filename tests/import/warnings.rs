//! What `import` warns of, and that it then does what the warning says.

use std::path::Path;

use zip::CompressionMethod;

use crate::chain::{dof, lower, mass, stiffness, write};
use crate::numpy::savez;
use crate::{abaqus, assert_refused, microslip};

/// Imports files of a folder into `model`; what was said on stderr.
fn warned(folder: &Path, files: &str) -> String {
    let command = format!("import {files} --units SI --quiet --output model");
    let output = microslip(folder, &command.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{files}: {said}");
    said
}

/// A table with a sine force alone takes the place of the file's cosine force, as the warning says.
///
/// Seen to fail with the program before: the study had `cosine_force = "cosine_force.mtx"`.
#[test]
fn a_sine_force_takes_the_place_of_the_force_of_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("model.npz"), savez(CompressionMethod::Stored)).unwrap();
    write(path, "sine.csv", "dof,sine\n2,2.0\n");
    let said = warned(path, "model.npz --forces sine.csv");
    let warning =
        "the harmonic force of the files is not used: --excite or --forces states another";
    assert!(said.contains(warning), "{said}");
    let study = std::fs::read_to_string(path.join("model/study.toml")).unwrap();
    assert!(study.contains("sine_force = { \"2\" = 2.0 }"), "{study}");
    assert!(!study.contains("cosine_force"), "{study}");
    assert!(!path.join("model/cosine_force.mtx").exists());
}

/// A chain of three masses with springs of 3333.4 N/m or 3333.6 N/m, with four digits: twice a spring is rounded up, and holds the
/// chain; or it is rounded down, and the stiffness has a negative eigenvalue.
///
/// Seen to fail with the program before: no warning, and "7.7e4 times what rounding to 4 digits allows", though it allowed nothing.
#[test]
fn few_digits_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(path, "M.mtx", &abaqus_diagonal(1.0));
    write(path, "K.mtx", &springs("3.333e3"));
    let said = warned(path, "K.mtx M.mtx");
    let warning = "K.mtx: K has 4 digits: frequencies of the free structure and its rigid-body modes may be lost to rounding; write more";
    assert!(said.contains(warning), "{said}");
    std::fs::remove_dir_all(path.join("model")).unwrap();
    write(path, "K.mtx", &springs("3.334e3"));
    let command = "import K.mtx M.mtx --units SI --output model";
    let rule = "and its numbers, of 4 digits, are taken as exact, since they have fewer than 6";
    assert_refused(
        path,
        &command.split(' ').collect::<Vec<_>>(),
        &[rule, "the file must state more digits"],
    );
}

/// Three masses, as Abaqus writes them.
fn abaqus_diagonal(value: f64) -> String {
    let lines = (1..=3).map(|node| format!("{node},1,{node},1,{value:.6}\n"));
    lines.collect()
}

/// Two equal springs between three masses; the middle one is held by 6667 N/m.
fn springs(k: &str) -> String {
    format!("1,1,1,1,{k}\n2,1,1,1,-{k}\n2,1,2,1,6.667e3\n3,1,2,1,-{k}\n3,1,3,1,{k}\n")
}

/// A spring to the ground drowns the others in round-off where it is stiff enough; at 1e16 N/m it does no harm.
///
/// Seen to fail with the program before, which said nothing.
#[test]
fn a_spring_that_is_too_stiff_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(path, "M.mtx", &abaqus::matrix(mass, true, false));
    for (ground, harmful) in [(1e16, false), (1e22, true), (1e36, true)] {
        let lines = lower(stiffness).into_iter().map(|(row, column, value)| {
            let ((a, i), (b, j)) = (dof(row), dof(column));
            let held = if (row, column) == (0, 0) { ground } else { 0.0 };
            format!("{a},{i},{b},{j},{:.15e}\n", value + held)
        });
        write(path, "K.mtx", &lines.collect::<String>());
        let said = warned(path, "K.mtx M.mtx");
        let named = said.contains("degree of freedom 11.1: round-off of its stiffness is");
        let advice = said.contains("leave degrees of freedom that are held out of the matrices");
        assert_eq!((named, advice), (harmful, harmful), "{ground}: {said}");
        std::fs::remove_dir_all(path.join("model")).unwrap();
    }
}
