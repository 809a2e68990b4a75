//! `microslip rig`, as a user runs it.

use crate::program::microslip;
use microslip::record::read_hysteresis;
use microslip::rig::Rig;
use serde_json::Value;
use std::path::Path;
use std::process::Output;

pub(crate) const RIG: &str = "name = \"small\"
seed = 5

[contact]
specimens = 2
friction_scatter_percent = 5

[loading]
kind = \"air\"

[excitation]
frequencies_hz = [50, 100]
cycles = 2
run_in_cycles = 1
samples_per_cycle = 100
";

pub(crate) fn run(folder: &Path, text: &str, options: &[&str]) -> Output {
    let path = folder.join("rig.toml");
    std::fs::write(&path, text).unwrap();
    let fixed = ["rig", "rig.toml", "--output", "out"];
    microslip(folder, &[&fixed, options].concat())
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Files are read back as they were made; `truth.json` has the specimens; one thread gives the same bytes as two. Seen to
/// fail with the first specimen in the truth of every test.
#[test]
fn writes_records_and_truth() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    for (folder, threads) in folders.iter().zip(["1", "2"]) {
        let output = run(folder.path(), RIG, &["--threads", threads]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{error}");
        let shown = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(shown.contains("4 tests of one blade and strip"), "{shown}");
    }
    let [first, second] = folders.each_ref().map(|folder| folder.path().join("out"));
    let rig = Rig::read(&folders[0].path().join("rig.toml")).unwrap();
    let stand = rig.stand().unwrap();
    let truth = json(&first.join("truth.json"));
    for index in 0..4 {
        let name = format!("test-{:04}.csv", index + 1);
        let [bytes, others] =
            [&first, &second].map(|folder| std::fs::read(folder.join(&name)).unwrap());
        assert_eq!(bytes, others, "{name}: one thread and two");
        let records = read_hysteresis(&[first.join(&name)]).unwrap();
        let made = rig.test(&stand, index).record;
        assert_eq!(records.len(), 1, "{name}");
        assert_eq!(records[0].record, made, "{name}");
        let even = records[0].record.conditions.even_area;
        assert_eq!(even, truth["even_area"].as_f64(), "{name}");
        assert_eq!(even, Some(stand.map.even_area()), "{name}");
        let specimen = &truth["tests"][index as usize]["specimen"];
        assert_eq!(specimen, index / 2, "{name}");
    }
    let friction = |i: usize| {
        truth["specimens"][i]["friction_coefficient"]
            .as_f64()
            .unwrap()
    };
    assert_eq!(friction(1), rig.specimen(1).friction_coefficient);
    assert!(friction(0) != friction(1), "specimens do not scatter");
    assert_eq!(truth["tests"][0]["slip"], "gross");
    let again = run(folders[0].path(), RIG, &[]);
    let error = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(error.contains("has content already"), "{error}");
}

/// What is replaced in the rig, by what, and part of the message.
const DAMAGES: &[(&str, &str, &str)] = &[
    (
        "seed = 5",
        "sead = 5",
        "rig.toml:2: sead: unknown key; known are name",
    ),
    ("specimens = 2", "specimen = 2", "rig.toml:5: contact"),
    (
        "specimens = 2",
        "specimens = 0",
        "rig.toml:5: contact.specimens = 0: must be from 1",
    ),
    (
        "\"air\"",
        "\"water\"",
        "rig.toml:9: loading.kind = water: must be \"air\" or \"punch\"",
    ),
    (
        "\"air\"",
        "\"air\"\nmargin_mm = 5",
        "rig.toml:10: loading.margin_mm = 5: must be below",
    ),
    (
        "\"air\"",
        "\"air\"\nholes = 30",
        "rig.toml:10: loading.holes = 30: must leave a film below 0.528282 of the inlet's absolute pressure (with hole_mm = 1, gap_mm = 0.1",
    ),
    (
        "\"air\"",
        "\"air\"\nhole_mm = 3",
        "loading.margin_mm = 1: must be at least half of hole_mm, 1.5",
    ),
    (
        "\"air\"",
        "\"air\"\nregulator_noise_percent = 300",
        "rig.toml:10: loading.regulator_noise_percent = 300: must be from 0 to 20",
    ),
    (
        "\"air\"",
        "\"air\"\ninlet_mpa = 0.2",
        "rig.toml:10: loading.inlet_mpa = 0.2: gives",
    ),
    ("\"air\"", "\"air\"\nweight_kg = 2", "rig.toml:10: loading"),
    (
        "[50, 100]",
        "[50, 0]",
        "rig.toml:12: excitation.frequencies_hz[1] = 0: must be from",
    ),
    (
        "[50, 100]",
        "[]",
        "rig.toml:12: excitation.frequencies_hz = []: must not be empty",
    ),
    (
        "cycles = 2\n",
        "cycles = 0\n",
        "rig.toml:13: excitation.cycles = 0: must be at least 1",
    ),
    (
        "= 100\n",
        "= 7\n",
        "rig.toml:15: excitation.samples_per_cycle = 7: must be at least 16: `identify` takes no fewer",
    ),
    (
        "= 100\n",
        "= 100\n[strip]\nstrip_mm = [10, 50]",
        "expected a list of 3 values",
    ),
    (
        "= 100\n",
        "= 100\n[strip]\ngap_mm = 11",
        "strip.gap_mm = 11: must be narrower",
    ),
    (
        "= 100\n",
        "= 100\n[support]\nk12_n_per_um = 200",
        "support.k12_n_per_um = 200: must be",
    ),
    (
        "= 100\n",
        "= 100\n[support]\nbox_mass_kg = 1e300",
        "rig.toml:17: support.box_mass_kg = 1e300: must be from 1e-6 to 1000",
    ),
    (
        "= 100\n",
        "= 100\n[force_cells]\nrange_n = -1",
        "force_cells.range_n = -1: must be",
    ),
    (
        "= 100\n",
        "= 100\n[vibrometer]\nnoise_um = -1",
        "vibrometer.noise_um = -1: must be",
    ),
    (
        "= 100\n",
        "= 100\n[response]\nstudy = \"none.toml\"",
        "rig.toml:17: response.study = \"none.toml\": must name a file: there is no",
    ),
    (
        "= 100\n",
        "= 100\n[response]\nstudy = \"none.toml\"\namplitude_deviation_percent = 90",
        "rig.toml:18: response.amplitude_deviation_percent = 90: must be from 0 to 10",
    ),
    (
        "= 100\n",
        "= 100\n[blade]\nforce_n = 0",
        "rig.toml:17: blade.force_n = 0: must be a finite number > 0",
    ),
    (
        "= 100\n",
        "= 100\n[blade]\ndamping_ratio = 0.6",
        "rig.toml:17: blade.damping_ratio = 0.6: must be from 0 to 0.5",
    ),
    (
        "= 100\n",
        "= 100\n[blade]\nsettling_cycles = 2000000",
        "rig.toml:17: blade.settling_cycles = 2000000: must be at most 1000000",
    ),
    (
        "= 100\n",
        "= 100\n[blade]\nforce = 1",
        "rig.toml:17: blade.force: unknown field `force`",
    ),
    (
        "= 100\n",
        "= 100\namplitude_um = 5\n[blade]",
        "rig.toml:16: excitation.amplitude_um = 5: must not be given with [blade]",
    ),
];

/// Tests that would take days are refused: too many, too many samples, too long a vibration of a blade. Seen to fail without the bounds of all tests
/// together: each key is within its own.
#[test]
fn tests_that_take_days_are_refused() {
    let many = RIG.replace("specimens = 2", "specimens = 10000");
    for (text, expected) in [
        (
            many.replace("cycles = 2\n", "cycles = 2\nrepetitions = 10\n"),
            "rig.toml:5: contact.specimens = 10000: must give at most 100000 tests, not 200000",
        ),
        (
            many.replace("cycles = 2\n", "cycles = 10000\n"),
            "rig.toml:13: excitation.cycles = 10000: gives 2.0e10 samples in all tests, must give at most 1e10",
        ),
        (
            format!("{RIG}[blade]\nsettling_cycles = 1000000\n").replace("[50, 100]", "[1, 2]"),
            "rig.toml:17: blade.settling_cycles = 1000000: gives 3.0e6 s of vibration in all tests, must give at most 1e5 s",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let output = run(folder.path(), &text, &[]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains(expected), "{error}");
        assert_eq!(output.status.code(), Some(2), "{error}");
    }
}

/// A sampling rate below twice the frequency of the box is told, unless the test is so slow that the box hardly moves. Seen to fail with the
/// sampling rate compared with the frequency of the test.
#[test]
fn a_rate_that_hides_the_box_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let warnings = |samples: &str, frequency: &str| {
        let text = RIG.replace("= 100\n", samples);
        let text = text.replace("[50, 100]", frequency);
        let rig = Rig::parse(&folder.path().join("rig.toml"), &text).unwrap();
        rig.warnings()
    };
    let told = warnings("= 64\n", "[100]");
    let expected = "excitation.samples_per_cycle = 64: at 100 Hz the sampling rate is below twice the 5033 Hz of the measuring box";
    assert!(told[0].starts_with(expected), "{told:?}");
    assert!(warnings("= 500\n", "[100]").is_empty(), "500 samples");
    assert!(warnings("= 64\n", "[5]").is_empty(), "5 Hz");
}

/// A blade shows frequencies from 1 Hz to 5 kHz. Seen to fail with a wider range.
#[test]
fn a_blade_is_not_shown_beyond_its_modes() {
    for (frequency, shown) in [("0.5", "0.5"), ("6000", "6000")] {
        let text = RIG.replacen("[50, 100]", &format!("[50, {frequency}]"), 1);
        let folder = tempfile::tempdir().unwrap();
        let output = run(folder.path(), &format!("{text}[blade]\n"), &[]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let expected =
            format!("rig.toml:12: excitation.frequencies_hz[1] = {shown}: must be from 1 to 5000");
        assert!(error.contains(&expected), "{error}");
        assert_eq!(output.status.code(), Some(2), "{error}");
    }
}

/// With a blade: natural frequencies, and amplitude and phase of the platform in each test, the same for one thread and two. Seen to fail
/// with the free frequencies for the stuck ones.
#[test]
fn a_blade_has_its_truth() {
    let text = format!("{RIG}[blade]\nforce_n = 5\nsettling_cycles = 10\n");
    let truths = ["1", "2"].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        let output = run(folder.path(), &text, &["--threads", threads]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{error}");
        let shown = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(shown.contains("test-0001.csv 50 Hz: platform "), "{shown}");
        json(&folder.path().join("out/truth.json"))
    });
    assert_eq!(truths[0], truths[1], "one thread and two");
    let listed = |name: &str| -> Vec<f64> {
        let all = truths[0]["blade"][name].as_array().unwrap();
        all.iter().map(|f| f.as_f64().unwrap()).collect()
    };
    let (free, stuck) = (listed("free_hz"), listed("stuck_hz"));
    let rises = |all: &[f64]| all.windows(2).all(|two| two[0] < two[1]);
    assert!(rises(&free) && rises(&stuck), "{free:?} {stuck:?}");
    assert!(stuck[0] > free[0], "the strip holds: {free:?} {stuck:?}");
    let platform = &truths[0]["tests"][0]["platform"];
    let amplitude = platform["amplitude_um"].as_f64().unwrap();
    assert!((0.001..1000.0).contains(&amplitude), "{platform}");
}

/// A rig that moves its contact far.
const FAR: &str = "name = \"far\"
[loading]
kind = \"air\"
[excitation]
amplitude_um = 8
";

/// The map that a rig writes gives the spread of the slip limits, and stands in the result with its hash. One that is not of this contact gives another
/// stiffness.
///
/// Seen to fail with the map left out of the files.
#[test]
fn the_map_of_a_rig_tells_its_stiffness() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), FAR, &[]);
    assert!(output.status.success(), "{output:?}");
    let test = std::fs::read_to_string(folder.path().join("out/test-0001.csv")).unwrap();
    let stated = test.lines().filter(|line| !line.contains("mean pressure"));
    let bare = folder.path().join("bare.csv");
    std::fs::write(&bare, stated.collect::<Vec<_>>().join("\n")).unwrap();
    let rows: Vec<String> = (1..=20)
        .map(|i| format!("{}", 0.1 * f64::from(i)))
        .collect();
    let uneven = format!("pressure [MPa]\n{}\n", rows.join("\n"));
    std::fs::write(folder.path().join("uneven.csv"), uneven).unwrap();
    let interval = |options: &[&str]| {
        let fixed = ["identify", "bare.csv"];
        let output = microslip(folder.path(), &[&fixed, options].concat());
        assert!(output.status.success(), "{output:?}");
        let found = json(&folder.path().join("identified/identified.json"));
        let k_t = &found["tests"][0]["estimate"]["tangential"]["stiffness_n_per_um"];
        let ends = ["lower", "upper"].map(|name| k_t[name].as_f64().unwrap());
        (ends, found)
    };
    let (without, found) = interval(&[]);
    assert_eq!(found["pressure_map"], Value::Null);
    let (other, _) = interval(&["--pressure-map", "uneven.csv"]);
    assert!(other[0] > without[1], "{other:?} {without:?}");
    let (with, found) = interval(&["--pressure-map", "out/pressure-map.csv"]);
    assert!((with[0]..=with[1]).contains(&233.0), "{with:?}");
    assert!(with != without, "{with:?}");
    let given = &found["pressure_map"];
    assert_eq!(given["cells"], 96, "{given}");
    assert_eq!(given["file"]["name"], "pressure-map.csv", "{given}");
    assert_eq!(found["files"][1], given["file"], "{}", found["files"]);
    let page = std::fs::read_to_string(folder.path().join("identified/report.html")).unwrap();
    let hash = given["file"]["blake3"].as_str().unwrap();
    assert!(page.contains("pressure-map.csv: 96 cells"), "no map");
    assert!(page.contains(hash), "no hash");
}

/// A damaged map is one message with exit code 2, and a result does not replace a map. Seen to fail with the map left out of the inputs that
/// are not replaced.
#[test]
fn a_damaged_map_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(run(folder.path(), RIG, &[]).status.success());
    let out = folder.path().join("out");
    std::fs::write(out.join("loops.csv"), "pressure [MPa]\n1\n2\n3\n-4\n").unwrap();
    for (options, expected) in [
        (
            &[][..],
            "error: out/loops.csv:5: pressure = -4 MPa: must be from 0 to",
        ),
        (
            &["--output", "out"],
            "error: out/loops.csv: is an input of this command",
        ),
    ] {
        let fixed = [
            "identify",
            "out/test-0001.csv",
            "--pressure-map",
            "out/loops.csv",
        ];
        let output = microslip(folder.path(), &[&fixed, options].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.starts_with(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert_eq!(output.status.code(), Some(2), "{error}");
    }
}

/// Every wrong key or value is refused with file, line, key and rule, and exit code 2.
#[test]
fn bad_files_are_refused() {
    for &(from, to, expected) in DAMAGES {
        let text = RIG.replacen(from, to, 1);
        assert_ne!(text, RIG, "{from} is not in the rig");
        let folder = tempfile::tempdir().unwrap();
        let output = run(folder.path(), &text, &[]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains(expected), "{to}: {error}");
        assert_eq!(output.status.code(), Some(2), "{to}: {error}");
        assert!(
            !folder.path().join("out").exists(),
            "{to}: a folder was left behind"
        );
    }
}

/// The log ends with what was made. Seen to fail with progress as the last line.
#[test]
fn the_log_ends_with_the_tests() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), RIG, &["--log", "json"]);
    assert!(output.status.success(), "{output:?}");
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    let end: Value = serde_json::from_str(log.lines().last().unwrap()).unwrap();
    assert_eq!(end["event"], "finished", "{log}");
    assert_eq!(end["tests"], 4, "{log}");
}

/// What an instrument cannot measure is a warning, also of a run that says nothing else. Seen to fail with a warning that is part of the summary.
#[test]
fn an_instrument_at_the_end_of_its_range_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let shown = RIG.replace("samples_per_cycle = 100", "samples_per_cycle = 250");
    let text = format!("{shown}\n[vibrometer]\nsensitivity_um_per_v = 0.1\n");
    let output = run(folder.path(), &text, &["--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(
        said,
        "warning: in 4 tests an instrument was at the end of its range\n"
    );
    assert!(output.stdout.is_empty(), "{output:?}");
}

/// The shipped rigs are valid.
#[test]
fn shipped_rigs_are_valid() {
    for name in [
        "air",
        "punch",
        "around-resonance",
        "two-blades",
        "two-blades-air",
        "two-blades-punch",
    ] {
        let path = format!("studies/rig-to-margin/{name}.toml");
        Rig::read(Path::new(&path)).unwrap();
    }
}
