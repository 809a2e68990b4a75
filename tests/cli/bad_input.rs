//! Bad input gives exit code 2 and one message that names file, line, key and rule.

use std::path::Path;
use std::process::Output;

use crate::{MASS, folder, microslip};

/// Exit code 2, nothing on stdout, and one line `error: …` that holds every fragment.
pub(super) fn assert_refused(what: &str, output: &Output, fragments: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{what}: {message}");
    assert_eq!(
        message.lines().count(),
        1,
        "{what}: one line expected: {message}"
    );
    assert!(message.starts_with("error: "), "{what}: {message}");
    for fragment in fragments {
        assert!(
            message.contains(fragment),
            "{what}: {fragment:?} is not in: {message}"
        );
    }
    assert!(output.stdout.is_empty(), "{what}: output before the error");
}

/// Cases of one file: what is replaced, by what, and what the message must name.
pub(super) fn refuse_all(file: &str, cases: &[(&str, &str, &[&str])]) {
    for (old, new, fragments) in cases {
        let folder = folder(file, old, new);
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        assert_refused(new, &output, fragments);
        assert!(
            String::from_utf8_lossy(&output.stderr).contains(file),
            "{new}: {file} not named"
        );
    }
}

#[test]
fn the_unchanged_study_is_accepted() {
    let folder = folder("study.toml", "two masses", "two masses");
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("degrees of freedom  2: x1, x2"), "{text}");
    // det(K − λM) = 0: 1.5 λ² − 2.3e6 λ + 7.6e11 = 0, λ = (2.3e6 ± √7.3e11)/3, f = √λ/2π.
    assert!(text.contains("110.479962 163.199157 Hz"), "{text}");
}

/// Seen to fail with the line counted from the value's end, and with a `BadSetting` that lost its section.
#[test]
fn bad_values_name_line_key_and_rule() {
    refuse_all(
        "study.toml",
        &[
            (
                "samples = 10",
                "samples = 0",
                &[":3: samples = 0: must be from 1"],
            ),
            ("samples = 10", "samples = -4", &[":3: samples: ", "-4"]),
            (
                "samples = 10",
                "samples = 1.5",
                &[":3: samples: ", "floating point"],
            ),
            ("seed = 7", "seed = -7", &[":2: seed: "]),
            (
                "\"two masses\"",
                "\"\"",
                &[":1: name = \"\": must not be empty"],
            ),
            ("[1.0, 2.0]", "[]", &[":4: levels = []: must not be empty"]),
            (
                "[1.0, 2.0]",
                "[1.0, 0.5]",
                &[":4: levels[1] = 0.5: must be greater"],
            ),
            (
                "[1.0, 2.0]",
                "[\n0.0]",
                &[":5: levels[0] = 0: must be a finite number > 0"],
            ),
            (
                "[1.0, 2.0]",
                "[inf]",
                &[":4: levels[0] = inf: must be a finite"],
            ),
            ("[1.0, 2.0]", "1.0", &[":4: levels: "]),
            (
                "0.01",
                "-0.01",
                &[":10: model.modal_damping_ratio = -0.01: must be"],
            ),
            (
                "0.01",
                "1.5",
                &[":10: model.modal_damping_ratio = 1.5: must be below 1"],
            ),
            (
                "k_n = 1e6",
                "k_n = -1e6",
                &[":21: model.contact[0].k_n = -1000000: must be"],
            ),
            (
                "k_n = 1e6",
                "k_n = nan",
                &[":21: model.contact[0].k_n = NaN: must be a finite"],
            ),
            (
                "mu = 0.3",
                "mu = -0.1",
                &[":22: model.contact[0].mu = -0.1: must be"],
            ),
            (
                "mu = 0.3",
                "mu = 0.3\ngap = -1e-6",
                &[":23: model.contact[0].gap"],
            ),
            (
                "mu = 0.3",
                "mu = 0.3\ngap = 0\nn_0 = 3",
                &[":23: model.contact[0].gap", "n_0"],
            ),
            (
                "law = \"box\"",
                "law = \"ball\"",
                &[":25: contact.law: ", "box", "circle"],
            ),
            (
                "low = 0.1",
                "low = 0.9",
                &[":30: inputs.friction_coefficient.high = 0.8: must be"],
            ),
            (
                "low = 0.1",
                "low = -0.1",
                &[":28: inputs.friction_coefficient", "negative"],
            ),
            (
                "low = 0.1",
                "low = nan",
                &[":29: inputs.friction_coefficient.low = NaN"],
            ),
            (
                "\"uniform\"",
                "\"log-uniform\"\nvalue = 3",
                &[":29: ", ".value = 3: must be absent"],
            ),
            (
                "\"uniform\"",
                "\"gauss\"",
                &[":28: inputs.friction_coefficient.distribution: ", "normal"],
            ),
            (
                "high = 0.8",
                "",
                &[":27: inputs.friction_coefficient.high = (absent): must be given"],
            ),
            (
                "high = 0.8",
                "high = 0.8\ntruncation = [0, 1]",
                &[":31: ", ".truncation = [0, 1]: must lie"],
            ),
            (
                "harmonics = 5",
                "harmonics = 0",
                &[":33: solver.harmonics = 0"],
            ),
            (
                "harmonics = 5",
                "harmonics = [1, 3]",
                &[":33: solver.harmonics = [1, 3]", "0 and 1"],
            ),
            (
                "harmonics = 5",
                "harmonics = \"x\"",
                &[":33: solver.harmonics: expected"],
            ),
            (
                "harmonics = 5",
                "tolerance = 0.0",
                &[":33: solver.tolerance = 0: must be"],
            ),
            (
                "harmonics = 5",
                "laps = 0",
                &[":33: solver.laps = 0: must be at least 1"],
            ),
            (
                "time_points = 128",
                "time_points = 20",
                &[":34: solver.time_points = 20: must be more"],
            ),
            (
                "time_points = 128",
                "alert = { threshold = -1.0 }",
                &[":34: solver.alert.threshold = -1"],
            ),
            (
                "time_points = 128",
                "alert = { highest_harmonic = 1000000000 }",
                &[
                    ":34: solver.alert.highest_harmonic = 1000000000: ",
                    "from 1 to 200",
                ],
            ),
            (
                "harmonics = 5",
                "harmonics = 1000000000",
                &[":33: solver.harmonics = 1000000000: ", "from 1 to 200"],
            ),
            (
                "time_points = 128",
                "time_points = 65536\nalert = { highest_harmonic = 200 }",
                &[
                    ":34: solver.time_points = 65536: times the highest",
                    "8388608",
                ],
            ),
            (
                "[100, 200]",
                "[200, 100]",
                &[":37: frequency.band_hz = [200, 100]: must be [low"],
            ),
            (
                "[100, 200]",
                "[100, 200]\npoints = 1",
                &[":38: frequency.points = 1: must be from 2"],
            ),
            (
                "[100, 200]",
                "[100, 200]\nsweep = \"upward\"",
                &[":38: frequency.sweep = upward: must be absent for a continuous"],
            ),
            ("[100, 200]", "[100]", &[":37: frequency.band_hz: "]),
            (
                "band_hz = [100, 200]",
                "",
                &[":36: frequency.band_hz = (absent): must be given"],
            ),
        ],
    );
}

#[test]
fn unknown_keys_missing_keys_and_bad_syntax_name_their_line() {
    refuse_all(
        "study.toml",
        &[
            ("seed = 7", "sed = 7", &[":2: sed: unknown key", "seed"]),
            (
                "mu = 0.3",
                "mue = 0.3",
                &[":22: model.contact[0].mue: unknown field `mue`"],
            ),
            (
                "law = \"box\"",
                "lav = \"box\"",
                &[":25: contact.lav: unknown field"],
            ),
            ("mass = \"mass.mtx\"", "", &["model: missing field `mass`"]),
            ("kind = \"matrices\"", "", &["model.kind: must be given"]),
            (
                "\"matrices\"",
                "\"disk\"",
                &[":7: model.kind = disk: must be \"two-blade-strip\""],
            ),
            (
                "\"matrices\"",
                "3",
                &[":7: model.kind: invalid type: integer `3`"],
            ),
            ("name = \"two masses\"", "", &[":1: name: must be given"]),
            (
                "[inputs.friction_coefficient]",
                "[inputs.friction]",
                &[":27: inputs.friction: unknown input"],
            ),
            (
                "seed = 7",
                "seed = 7\nseed = 8",
                &[":3: not valid TOML: duplicate key"],
            ),
            ("samples = 10", "samples = ", &[":3: not valid TOML: "]),
            ("[frequency]", "[frequency", &[":36: not valid TOML: "]),
            (
                "law = \"box\"",
                "share = \"equal\"",
                &[":25: contact.share", "[[model.contact]]"],
            ),
        ],
    );
}

#[test]
fn tables_that_do_not_fit_the_model_name_their_line() {
    refuse_all(
        "study.toml",
        &[
            (
                "t1 = { x1 = 1.0 }",
                "t1 = { x3 = 1.0 }",
                &[":18: model.contact[0].t1.x3 = 1: must name a degree"],
            ),
            (
                "cosine_force = { x1",
                "cosine_force = { y",
                &[":13: model.cosine_force.y"],
            ),
            (
                "{ x1 = 1.0 }\nresp",
                "{ x1 = 0.0 }\nresp",
                &[":13: model.cosine_force", "zero"],
            ),
            (
                "responses = [\"x1\"]",
                "responses = [\"x9\"]",
                &[":14: model.responses[0].x9", "degree"],
            ),
            (
                "responses = [\"x1\"]",
                "responses = []",
                &[":14: model.responses = []"],
            ),
            (
                "[\"x1\", \"x2\"]",
                "[\"x1\"]",
                &[":11: model.dof_names = 1 names: must be 2"],
            ),
            (
                "[\"x1\", \"x2\"]",
                "[\"x1\", \"x1\"]",
                &[":11: model.dof_names = x1: must not be given twice"],
            ),
            (
                "k_t1 = 2e5",
                "",
                &[":16: model.contact[0].k_t1 = (absent): must be given"],
            ),
            (
                "modal_damping_ratio = 0.01",
                "",
                &[":6: model.damping = (absent): must be given"],
            ),
        ],
    );
}

/// Seen to fail with the number of modes not limited, and with the key of the other component.
#[test]
fn cut_offs_name_their_line_and_keep_the_modes_below() {
    let study = "name = \"rig\"\nlevels = [1.0]\n\n[model]\nkind = \"two-blade-strip\"\nblade_cut_off_hz = 2e4\n\n\
                 [frequency]\nband_hz = [2605, 2635]\n";
    let inspect = |line: &str| {
        let folder = tempfile::tempdir().unwrap();
        let text = study.replace("blade_cut_off_hz = 2e4", line);
        std::fs::write(folder.path().join("study.toml"), text).unwrap();
        microslip(folder.path(), &["inspect", "study.toml"])
    };
    let refused: [(&str, &[&str]); 5] = [
        (
            "blade_cut_off_hz = 1e9\nblade_element_mm = [15, 25, 25]",
            &[
                ":6: model.blade_cut_off_hz = 1000000000: must leave at most 200",
                "one more is at",
            ],
        ),
        (
            "strip_cut_off_hz = 1e9\nstrip_element_mm = 4",
            &[":6: model.strip_cut_off_hz = 1000000000: must leave at most 200"],
        ),
        (
            "blade_cut_off_hz = 0",
            &[":6: model.blade_cut_off_hz = 0: must be a finite number > 0"],
        ),
        (
            "strip_cut_off_hz = nan",
            &[":6: model.strip_cut_off_hz = NaN: must be a finite number > 0"],
        ),
        ("blade_modes = 20", &[":6: ", "unknown field `blade_modes`"]),
    ];
    for (line, fragments) in refused {
        assert_refused(line, &inspect(line), fragments);
    }
    let output = inspect("blade_cut_off_hz = 2e4\nstrip_cut_off_hz = 1");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("blade fixed modes   12 below 20000 Hz; the first one left out is at 209"),
        "{text}"
    );
    assert!(
        text.contains("strip fixed modes   0 below 1 Hz; the first one left out is at 439"),
        "{text}"
    );
}

/// Seen to fail with the definiteness checks taken out of `checked`.
#[test]
fn bad_matrices_name_file_and_rule() {
    refuse_all(
        "stiffness.mtx",
        &[
            (
                "%%MatrixMarket",
                "%MatrixMarket",
                &[":1: must start with a Matrix Market header"],
            ),
            (
                "real general",
                "real hermitean",
                &[":1: must start with a Matrix Market header"],
            ),
            ("real general", "complex general", &["stiffness.mtx"]),
            ("2 2\n", "3 3\n", &["9 entries required"]),
            (
                "2 2\n",
                "2 2000000000000000000\n",
                &[":2: size 2000000000000000000: must be"],
            ),
            ("2 2\n", "1 4\n", &["is 1 x 4: must be square"]),
            (
                "-2e5\n-2e5",
                "-2e5\n-3e5",
                &["must be symmetric: entries (2, 1) = -200000 and (1, 2)"],
            ),
            (
                "8e5",
                "NaN",
                &["entry (2, 2) = NaN: must be a finite number"],
            ),
            ("8e5", "-8e5", &["must be positive semidefinite"]),
            (
                "8e5",
                "eight",
                &[":6: is not a line of a Matrix Market file"],
            ),
        ],
    );
    let folder = folder("mass.mtx", "2 2 2\n1 1 1.0\n2 2 1.5", "1 1 1\n1 1 1.0");
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    assert_refused(
        "sizes",
        &output,
        &["stiffness.mtx: is 2 x 2: must be 1 x 1, the size of mass.mtx"],
    );
    refuse_all(
        "mass.mtx",
        &[
            (
                "2 2 1.5",
                "2 2 0.0",
                &["must be positive definite, but diagonal entry 2 is 0"],
            ),
            ("2 2 1.5", "2 3 1.5", &["mass.mtx"]),
            ("2 2 1.5", "0 2 1.5", &["indices must start at 1"]),
            (MASS, "", &["the file is empty"]),
        ],
    );
}

#[test]
fn missing_files_are_named() {
    let folder = folder("study.toml", "stiffness.mtx", "stiff.mtx");
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    assert_refused("missing matrix", &output, &["stiff.mtx: No such file"]);
    let output = microslip(folder.path(), &["run", "studi.toml"]);
    assert_refused("missing study", &output, &["studi.toml: No such file"]);
    let output = microslip(folder.path(), &["inspect", "."]);
    assert_refused("a folder as study", &output, &[".: Is a directory"]);
    std::fs::write(folder.path().join("binary.toml"), [0xff, 0xfe, 0x00]).unwrap();
    let output = microslip(folder.path(), &["inspect", "binary.toml"]);
    assert_refused("binary study", &output, &["binary.toml: ", "UTF-8"]);
}

/// Tests may run as root, whom no permission stops: so the folder lies below a regular file.
#[test]
fn unwritable_folders_are_refused_before_any_work() {
    let folder = folder("study.toml", "two masses", "two masses");
    for command in ["run", "solve"] {
        let output = microslip(
            folder.path(),
            &[command, "study.toml", "--output", "mass.mtx/results"],
        );
        assert_refused(command, &output, &["mass.mtx/results: ", "Not a directory"]);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_standard_output_is_an_error() {
    let folder = folder("study.toml", "two masses", "two masses");
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let status = std::process::Command::new(assert_cmd::cargo::cargo_bin("microslip"))
        .current_dir(folder.path())
        .args(["inspect", "study.toml"])
        .stdout(full)
        .output()
        .unwrap();
    assert_refused("full disk", &status, &["standard output: No space left"]);
}

#[test]
fn wrong_arguments_exit_with_2_and_help_with_0() {
    let here = Path::new(".");
    for arguments in [
        &["walk"][..],
        &["run"],
        &["run", "s.toml", "--threads", "0"],
        &["inspect", "a", "b"],
    ] {
        let output = microslip(here, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            message.matches("error: ").count(),
            1,
            "{arguments:?}: {message}"
        );
    }
    let output = microslip(here, &["--help"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&output.stdout).contains("microslip run study.toml"));
}

/// Seen to fail with results written straight to their own names.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_old_results_as_they_were() {
    let folder = folder("study.toml", "[100, 200]", "[100, 200]\npoints = 3");
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("solution.json"), "old").unwrap();
    // A limit on the size of files stands for the full disk.
    let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" solve study.toml --output out --quiet";
    let output = std::process::Command::new("sh")
        .current_dir(folder.path())
        .args(["-c", script])
        .arg(assert_cmd::cargo::cargo_bin("microslip"))
        .output()
        .unwrap();
    assert_refused("full disk", &output, &["out/solution.json: File too large"]);
    let names: Vec<_> = std::fs::read_dir(&out).unwrap().collect();
    assert_eq!(names.len(), 1, "{names:?}");
    assert_eq!(std::fs::read(out.join("solution.json")).unwrap(), b"old");
}

/// The study file under "Your own model" in the README works.
#[test]
fn the_example_of_the_readme_is_accepted() {
    let readme = std::fs::read_to_string("README.md").unwrap();
    let example = readme.split("```toml\n").nth(1).unwrap();
    let example = example.split("```").next().unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), example).unwrap();
    let coupled =
        "%%MatrixMarket matrix coordinate integer symmetric\n3 3 4\n1 1 2\n2 1 -1\n2 2 2\n3 3 1\n";
    for name in ["mass", "stiffness", "damping", "retention"] {
        std::fs::write(folder.path().join(format!("{name}.mtx")), coupled).unwrap();
    }
    let output = microslip(folder.path(), &["solve", "study.toml"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let summary = String::from_utf8_lossy(&output.stdout);
    assert!(summary.contains("3 of 3 points solved"), "{summary}");
}
