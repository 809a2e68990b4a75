//! Bad input gives exit code 2 and one message that names file, line, key and rule.

use std::path::Path;
use std::process::Output;

use crate::{STUDY, folder, microslip};

pub(crate) mod cases;
pub(crate) mod disk_cases;
mod files;
mod measurements;
pub(crate) mod program_cases;
pub(crate) mod rig_cases;

use cases::REFUSED;
use disk_cases::{DISK, DISK_BEYOND_SCHEMA, DISK_FILES, DISK_REFUSED};
use program_cases::BEYOND_SCHEMA;
use rig_cases::{RIG, RIG_BEYOND_SCHEMA, RIG_REFUSED};

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

/// Contacts so stiff that the structure is lost beside them: no command but `inspect` goes on. Seen to fail with the message without file and line.
#[test]
fn a_model_that_nothing_can_solve_is_refused_at_its_line() {
    let folder = folder("study.toml", "k_t1 = 2e5", "k_t1 = 1e25");
    // in units of its own no stiffness is unusual
    let study = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&study).unwrap();
    std::fs::write(&study, text.replace("band_hz", "band_rad_s")).unwrap();
    for command in ["run", "solve"] {
        let output = microslip(folder.path(), &[command, "study.toml"]);
        let rule = "study.toml:6: model: the structure with all contacts stuck can move as a rigid body, or its own";
        assert_refused(command, &output, &[rule]);
    }
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

/// Ends of a band are shown as they are written, though they are kept in rad/s. Seen to fail with "499.99999999999994 to 540".
#[test]
fn the_ends_of_a_band_are_shown_without_round_off() {
    let folder = folder("study.toml", "band_hz = [100, 200]", "band_hz = [500, 540]");
    let arguments = ["run", "study.toml", "--output", "results", "--quiet"];
    let output = microslip(folder.path(), &arguments);
    let expected = "the band 500 Hz to 540 Hz holds no natural frequency";
    assert_refused("band", &output, &[expected]);
}

/// Seen to fail with the line counted from the value's end, with a `BadSetting` that lost its section, without the
/// limits of numbers and lists, and with "no free node" in place of the contact nodes that no mesh resolves.
#[test]
fn bad_studies_name_line_key_and_rule() {
    refuse_all("study.toml", REFUSED);
    refuse_all("study.toml", BEYOND_SCHEMA);
    for (old, new, fragments) in RIG_REFUSED.iter().chain(RIG_BEYOND_SCHEMA) {
        let folder = tempfile::tempdir().unwrap();
        assert!(RIG.contains(old), "{old}");
        std::fs::write(folder.path().join("study.toml"), RIG.replacen(old, new, 1)).unwrap();
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        assert_refused(new, &output, fragments);
    }
}

/// A disk by one sector is inspected by nodal diameter; what cannot be one is refused with the rule. Seen to fail with a study without
/// `[operation]` taken, and with initial tractions.
#[test]
fn bad_disks_name_line_key_and_rule() {
    let inspect = |study: &str| {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in DISK_FILES.into_iter().chain([("study.toml", study)]) {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        let export = microslip(folder.path(), &["export", "study.toml", "--output", "out"]);
        (output, export)
    };
    let (output, export) = inspect(DISK);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8_lossy(&output.stdout);
    for fragment in [
        "degrees of freedom  4: left.x, blade.x, strip.x, strip.z",
        "engine order 3: nodal diameter 3",
        "nodal diameter 6",
    ] {
        assert!(text.contains(fragment), "{fragment}: {text}");
    }
    // springs 1e6 to the blade, 1e6 to the ground and 2e6 to each neighbour, which moves against it:
    // (10e6 - λ)(1e6 - 0.4 λ) = 1e12
    let root = 1.06e13_f64.sqrt();
    let out_of_phase = [(5e6 - root) / 0.8].map(|l: f64| l.sqrt() / std::f64::consts::TAU);
    let line = text.lines().find(|line| line.contains("nodal diameter 6"));
    for hertz in out_of_phase {
        let digits = format!("{hertz:.6}");
        assert!(line.unwrap().contains(&digits), "{digits}: {line:?}");
    }
    assert_refused(
        "export",
        &export,
        &["model.kind = \"cyclic\"", "nodal diameter"],
    );
    for (old, new, fragments) in DISK_REFUSED.iter().chain(DISK_BEYOND_SCHEMA) {
        assert!(DISK.contains(old), "{old}");
        let (output, _) = inspect(&DISK.replacen(old, new, 1));
        assert_refused(new, &output, fragments);
    }
}

/// What is replaced in the study of these tests, by what, and the warning.
const UNUSUAL: [(&str, &str, &str); 7] = [
    (
        "mu = 0.3",
        "mu = 3.0",
        "study.toml:22: model.contact[0].mu = 3: is unusual: usual is 0.05 to 1.5",
    ),
    (
        "high = 0.8",
        "high = 5.0",
        "study.toml:27: inputs.friction_coefficient = 4.9",
    ),
    (
        "harmonics = 5",
        "tolerance = 1e-4",
        "study.toml:33: solver.tolerance = 1e-4: is unusual",
    ),
    (
        "time_points = 128",
        "alert = { threshold = 0.9 }",
        "study.toml:34: solver.alert.threshold = 0.9: is unusual: usual is 1e-4 to 0.1",
    ),
    (
        "k_n = 1e6",
        "k_n = 2e12",
        "study.toml:21: model.contact[0].k_n = 2e12: is unusual: usual is 100 to 1e12",
    ),
    (
        "[frequency]",
        "[operation]\nspeed_rpm = [50, 60]\nengine_orders = [2]\n[frequency]",
        "study.toml:37: operation.speed_rpm = 50: is unusual: usual is 100 to 2e5",
    ),
    (
        "[frequency]",
        "[stress]\nmodal_stress_mpa_per_um = 12\nmean_stress_mpa = 0.18\nendurance_limit_mpa = 0.35\n\
             ultimate_strength_mpa = 0.9\n[frequency]",
        "study.toml:39: stress.endurance_limit_mpa = 0.35: is unusual: usual is 10 to 10000",
    ),
];

/// Values that may be meant are computed, with file, line, key and the usual range. Seen to fail without `Study::warnings`, and
/// without those of the requirements.
#[test]
fn unusual_values_are_warned_of() {
    for (old, new, expected) in UNUSUAL {
        let folder = folder("study.toml", old, new);
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            text.contains(&format!("warning: {expected}")),
            "{new}: {text}"
        );
        let shorter = ("[100, 200]", "[100, 200]\nvalues_hz = [150]");
        let study = STUDY
            .replacen(old, new, 1)
            .replacen(shorter.0, shorter.1, 1);
        std::fs::write(folder.path().join("study.toml"), study).unwrap();
        let output = microslip(folder.path(), &["solve", "study.toml", "--quiet"]);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            text.contains(&format!("warning: {expected}")),
            "{new}: {text}"
        );
    }
    let usual = folder("study.toml", "two masses", "two masses");
    let output = microslip(usual.path(), &["inspect", "study.toml"]);
    assert!(
        !String::from_utf8_lossy(&output.stderr).contains("warning"),
        "{output:?}"
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

/// Seen to fail (killed after a minute) with as many threads as the environment asks for.
#[test]
fn the_environment_starts_no_more_threads() {
    let folder = folder("study.toml", "samples = 10", "samples = 2");
    let output = assert_cmd::Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(folder.path())
        .env("RAYON_NUM_THREADS", "100000000")
        .args(["run", "study.toml", "--quiet"])
        .timeout(std::time::Duration::from_secs(60))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

/// Mesa's layer for the choice of a device prints `error: XDG_RUNTIME_DIR` on a machine without a window system, though nothing
/// is wrong. Seen to fail with the layer left on.
#[test]
fn looking_for_devices_prints_no_error() {
    let folder = folder("study.toml", "samples = 10", "samples = 2");
    let commands: [&[&str]; 2] = [
        &["devices"],
        &["run", "study.toml", "--backend", "auto", "--quiet"],
    ];
    for arguments in commands {
        let output = std::process::Command::new(assert_cmd::cargo::cargo_bin("microslip"))
            .current_dir(folder.path())
            .env_remove("XDG_RUNTIME_DIR")
            .args(arguments)
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
        assert!(!message.contains("error"), "{arguments:?}: {message}");
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
        &["run", "s.toml", "--threads", "1000000"],
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

/// The study file of the page "Your own model" works.
#[test]
fn the_example_of_the_book_is_accepted() {
    let page = std::fs::read_to_string("docs/src/own-model.md").unwrap();
    let example = page.split("```toml\n").nth(1).unwrap();
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
