//! Bad measurements, rigs and responses: the commands that read them name file, line and rule.

use std::path::Path;

use super::assert_refused;
use crate::function_case::case;
use crate::microslip;

const LOOP: &str = "time [s],relative displacement [um],tangential force [N],normal force [N]\n";
const RIG: &str = "name = \"small\"\nseed = 5\n\n[loading]\nkind = \"air\"\n";

/// A table of so many samples of a loop, of which `old` is replaced by `new`.
fn table(samples: usize, old: &str, new: &str) -> String {
    let row = |i: usize| format!("{},{},{},100\n", i as f64 / 128.0, i % 7, i % 5);
    let text = format!("{LOOP}{}", (0..samples).map(row).collect::<String>());
    assert!(text.contains(old), "{old}");
    text.replacen(old, new, 1)
}

fn refused(folder: &Path, file: &str, text: &str, arguments: &[&str], fragments: &[&str]) {
    std::fs::write(folder.join(file), text).unwrap();
    let output = microslip(folder, arguments);
    assert_refused(text.lines().last().unwrap_or(file), &output, fragments);
    // a folder may be opened before the work, so that one that cannot be written costs none
    let written = std::fs::read_dir(folder.join("out")).map_or(0, Iterator::count);
    assert_eq!(written, 0, "{arguments:?}: something was written");
}

#[test]
fn bad_loops_name_line_column_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let identify = ["identify", "loops.csv", "--output", "out"];
    for (old, new, expected) in [
        (
            "normal force [N]",
            "normal force",
            "loops.csv:1: normal force: has no unit",
        ),
        (
            "[um]",
            "[lbf]",
            "loops.csv:1: relative displacement [lbf]: must be in a unit of length",
        ),
        (
            ",normal force [N]",
            "",
            "loops.csv:1: must have a column normal force [N]",
        ),
        (
            "0,0,0,100",
            "0,0,none,100",
            "loops.csv:2: tangential force = none: must be a number",
        ),
    ] {
        let text = table(200, old, new);
        refused(folder.path(), "loops.csv", &text, &identify, &[expected]);
    }
    let text = table(200, "0,0,0,100", "0,0,0,100");
    let fragment = &["no test can be used: loops.csv:2: loops "];
    refused(folder.path(), "loops.csv", &text, &identify, fragment);
    for (option, value, expected) in [
        ("--confidence", "2", "confidence = 2: must be from 0.5"),
        // seen to fail with the program before, which took -5 for an option
        (
            "--series-stiffness-n-per-um",
            "-5",
            "series_stiffness_n_per_um = -5: must be a finite number > 0",
        ),
        (
            "--force-error-percent",
            "-1",
            "force_error_percent = -1: must be a finite number >= 0",
        ),
    ] {
        let more = [&identify[..], &[option, value]].concat();
        refused(folder.path(), "loops.csv", &text, &more, &[expected]);
    }
    let missing = ["identify", "none.csv", "--output", "out"];
    refused(folder.path(), "loops.csv", &text, &missing, &["none.csv: "]);
}

/// Ten cycles of an elastic-Coulomb loop, 64 samples each, under 100 N: time, u (um), T and N of each sample.
fn good_loop() -> Vec<[f64; 4]> {
    let (mut slider, mut rows) = (0.0_f64, Vec::new());
    for i in 0..640 {
        let turns = f64::from(i) / 64.0;
        let u = 10.0 * (std::f64::consts::TAU * turns).sin();
        slider = slider.clamp(u - 2.5, u + 2.5);
        rows.push([turns, u, 20.0 * (u - slider), 100.0]);
    }
    rows
}

fn written(before: &str, rows: &[[f64; 4]]) -> String {
    let row = |row: &[f64; 4]| row.map(|value| value.to_string()).join(",");
    let rows: Vec<String> = rows.iter().map(row).collect();
    format!("{before}{LOOP}{}\n", rows.join("\n"))
}

/// Every kind of bad loop: no loop, N <= 0, less than a period, no number, T and N exchanged. (A missing unit is above.)
///
/// Seen to fail without the line of the test in the messages on a whole test.
#[test]
fn every_kind_of_bad_loop_is_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let identify = ["identify", "loops.csv", "--output", "out"];
    let with = |change: fn(usize, [f64; 4]) -> [f64; 4]| {
        let rows: Vec<[f64; 4]> = (good_loop().into_iter().enumerate())
            .map(|(i, row)| change(i, row))
            .collect();
        written("", &rows)
    };
    let cases = [
        (
            with(|i, [t, _, f, n]| [t, (i * i * 7919 % 1013) as f64, f, n]),
            "loops.csv:2: loops is no hysteresis loop: ",
        ),
        (
            with(|_, [t, u, f, n]| [t, u, f, -n]),
            "loops.csv:2: normal force is negative: must be positive in compression",
        ),
        (
            with(|i, [t, u, f, n]| [t, u, f, if i < 40 { n } else { 0.0 }]),
            "loops.csv:42: normal force is <= 0 in 94 % of the samples: must be positive",
        ),
        (
            written("# frequency [Hz] = 1\n", &good_loop()[..40]),
            "loops.csv:3: loops is shorter than one period",
        ),
        (
            with(|i, [t, u, f, n]| [t, u, if i == 4 { f64::NAN } else { f }, n]),
            "loops.csv:6: tangential force = NaN: must be a",
        ),
        (
            with(|_, [t, u, f, n]| [t, u, n, f]),
            "loops.csv:2: normal force changes its sign and tangential force does not: are the two exchanged?",
        ),
    ];
    for (text, expected) in &cases {
        refused(folder.path(), "loops.csv", text, &identify, &[expected]);
    }
    let good = written("", &good_loop());
    std::fs::write(folder.path().join("loops.csv"), good).unwrap();
    let output = microslip(folder.path(), &identify);
    assert_eq!(output.status.code(), Some(0), "the good loop: {output:?}");
}

#[test]
fn bad_rigs_name_line_key_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let rig = ["rig", "rig.toml", "--output", "out"];
    for (old, new, expected) in [
        ("seed = 5", "sead = 5", "rig.toml:2: sead: unknown key"),
        (
            "\"air\"",
            "\"steam\"",
            "rig.toml:5: loading.kind = steam: must be",
        ),
        (
            "kind = \"air\"",
            "kind = \"air\"\ngap_mm = 0",
            "rig.toml:6: loading.gap_mm = 0: must be",
        ),
    ] {
        let text = RIG.replacen(old, new, 1);
        refused(folder.path(), "rig.toml", &text, &rig, &[expected]);
    }
}

#[test]
fn bad_responses_name_line_column_and_rule() {
    let folder = case();
    // nothing is solved: a usual load brings no warning beside the error
    let study = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&study).unwrap();
    let load = "mean = 150\nstandard_deviation = 5\ntruncation = [100, 200]";
    assert!(text.contains(load), "{text}");
    let usual = "mean = 1.5\nstandard_deviation = 0.05\ntruncation = [1, 2]";
    std::fs::write(&study, text.replace(load, usual)).unwrap();
    let good = std::fs::read_to_string(folder.path().join("response.csv")).unwrap();
    let calibrate = ["calibrate", "study.toml", "--measured", "response.csv"];
    let calibrate = [&calibrate[..], &["--output", "out", "--quiet"]].concat();
    for (old, new, expected) in [
        (
            "level [N]",
            "level [mm]",
            "response.csv:1: level [mm]: must be in a unit of force: N, mN, kN, or -",
        ),
        ("level [N]", "level", "response.csv:1: level: has no unit"),
        (
            "\n1,",
            "\nlow,",
            "response.csv:2: level = low: must be a number",
        ),
        (
            "\n1,",
            "\n3,",
            "response.csv:2: level = 3: must be one of the levels",
        ),
    ] {
        let text = good.replacen(old, new, 1);
        assert_ne!(text, good, "{old}");
        refused(
            folder.path(),
            "response.csv",
            &text,
            &calibrate,
            &[expected],
        );
    }
}

/// A level that is a factor on a model's own forces has no unit. Seen to fail with `[-]` refused.
#[test]
fn a_level_without_a_unit_is_taken() {
    let folder = case();
    let path = folder.path().join("response.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("level [N]", "level [-]", 1)).unwrap();
    let calibrate = [
        "calibrate",
        "study.toml",
        "--measured",
        "response.csv",
        "--output",
    ];
    let calibrate = [&calibrate[..], &["calibrated", "--draws", "100", "--quiet"]].concat();
    let output = microslip(folder.path(), &calibrate);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}
