//! `strip_thickness_mm` and the loads of the contact pressure, from study file to results.

use microslip::ensemble::outcome::{LevelOutcome, SampleOutcome};
use microslip::ensemble::store::read_samples;
use std::path::Path;

use super::bad_input::assert_refused;
use super::microslip;

/// Small, with as many modes of the strip at any thickness: none.
const RIG: &str = r#"name = "rig"
SAMPLES
levels = [20.0]
[model]
kind = "two-blade-strip"
contact_nodes = [2, 3]
blade_element_mm = [15, 25, 25]
strip_cut_off_hz = 1
STRIP
[contact]
law = "box"
[solver]
harmonics = 1
alert = false
[frequency]
band_hz = [2600, 3100]
[output]
curve_samples = 0
"#;

/// A study with other lines for the strip (in `[model]`) and further sections.
fn study(samples: &str, strip: &str, more: &str) -> String {
    let head = RIG.replace("SAMPLES", samples).replace("STRIP", strip);
    format!("{head}{more}")
}

fn write(folder: &Path, study: &str) {
    std::fs::write(folder.join("study.toml"), study).unwrap();
}

fn outcomes(folder: &Path, study: &str) -> Vec<SampleOutcome> {
    write(folder, study);
    let output = microslip(folder, &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let path = folder.join("results/samples.parquet");
    read_samples(&path).unwrap().outcomes
}

/// Frequency and amplitude of the peaks at the first level.
fn peaks(folder: &Path, study: &str) -> Vec<[f64; 2]> {
    let peak = |level: &LevelOutcome| level.peak.unwrap();
    let found = outcomes(folder, study).into_iter();
    let found = found.map(|outcome| peak(&outcome.levels[0]));
    found.map(|p| [p.frequency_hz, p.amplitude_m]).collect()
}

fn close(a: [f64; 2], b: [f64; 2]) -> bool {
    (0..2).all(|k| (a[k] - b[k]).abs() <= 1e-9 * b[k])
}

const INPUT: &str =
    "[inputs.strip_thickness_mm]\ndistribution = \"uniform\"\nlow = 0.3\nhigh = 0.6\n";
const FIXED: &str = "[inputs.strip_thickness_mm]\ndistribution = \"fixed\"\nvalue = 0.5\n";
const FIELD: &str =
    "[pressure_field]\nstandard_deviation = 0.1\ncorrelation_length_mm = 10\nmodes = 2\n";

/// A sample with a strip of 0.5 mm is the study of that strip and its larger load, folded, with a factor on its load, and
/// whole with the loads of a punch and of a field on it.
/// Seen to fail with the nominal strip in every sample, and with the load of the nominal strip.
#[test]
fn a_thickness_is_the_study_of_that_strip() {
    let folder = tempfile::tempdir().unwrap();
    let factors = "[inputs.static_load_scale]\ndistribution = \"fixed\"\nvalue = 0.9\n\
                   [inputs.damping_scale]\ndistribution = \"fixed\"\nvalue = 1.5\n";
    let edge = "[inputs.edge_pressure]\ndistribution = \"fixed\"\nvalue = 0.7\n";
    let nominal = peaks(folder.path(), &study("", "", ""));
    for more in [
        String::new(),
        factors.to_owned(),
        edge.to_owned(),
        [factors, edge, FIELD].concat(),
    ] {
        let own = peaks(folder.path(), &study("", "", &format!("{FIXED}{more}")));
        let strip = "strip_mm = [10, 50, 0.5]\ncentrifugal_load_n = 225";
        let built = peaks(folder.path(), &study("", strip, &more));
        println!("{own:?} {built:?} {nominal:?}");
        assert!(close(own[0], built[0]), "{more}: {own:?}, not {built:?}");
        assert!(!close(own[0], nominal[0]), "{more}: {own:?}");
        let light = "strip_mm = [10, 50, 0.5]";
        let light = peaks(folder.path(), &study("", light, &more));
        assert!(!close(own[0], light[0]), "{more}: {own:?}");
    }
}

/// Random thicknesses with a pressure field: the same bytes for any number of threads, and extended as at once.
/// Seen to fail with a thickness that depends on the number of threads by 1e-9.
#[test]
fn random_thicknesses_are_reproducible() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let run = |samples: u64, arguments: &[&str]| {
        let samples = format!("samples = {samples}");
        write(path, &study(&samples, "", &format!("{INPUT}{FIELD}")));
        let output = microslip(
            path,
            &[&["run", "study.toml", "--quiet"], arguments].concat(),
        );
        assert!(output.status.success(), "{output:?}");
    };
    run(10, &["--threads", "1", "--output", "one"]);
    run(10, &["--threads", "2", "--output", "two"]);
    run(3, &["--output", "extended"]);
    let more = ["extend", "extended", "--samples", "10", "--quiet"];
    let output = microslip(path, &more);
    assert!(output.status.success(), "{output:?}");
    for name in ["samples.parquet", "atlas.parquet"] {
        let read = |of: &str| std::fs::read(path.join(of).join(name)).unwrap();
        assert!(read("one") == read("two"), "{name} differs between threads");
        assert!(read("one") == read("extended"), "{name} of the extension");
    }
    let stored = read_samples(&path.join("one/samples.parquet")).unwrap();
    let thickness = |outcome: &SampleOutcome| outcome.inputs[0];
    assert!(
        stored
            .outcomes
            .iter()
            .all(|o| (0.3..0.6).contains(&thickness(o)))
    );
}

/// A strip that numbers cannot reduce is a sample with a status, like any other that fails.
/// Seen to fail with the nominal strip in its place.
#[test]
fn a_strip_without_a_model_is_a_failed_sample() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("rows.csv"),
        "strip_thickness_mm\n1e-3\n0.4\n",
    )
    .unwrap();
    let file = "[design]\nkind = \"file\"\npath = \"rows.csv\"\n";
    let found = outcomes(folder.path(), &study("", "", file));
    let status = |i: usize| found[i].levels[0].status.name();
    assert_eq!([status(0), status(1)], ["non-finite", "converged"]);
    assert!(found[0].levels[0].peak.is_none() && found[1].levels[0].peak.is_some());
}

/// Whether `inspect` and `run` refuse a study.
fn refuse_in(folder: &Path, study: &str, expected: &str) {
    write(folder, study);
    for command in ["inspect", "run"] {
        let output = microslip(folder, &[command, "study.toml"]);
        assert_refused(study, &output, &[expected]);
    }
}

/// Pressures that do not go together, and more modes than nodes.
#[test]
fn impossible_pressures_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |study: &str, expected: &str| refuse_in(folder.path(), study, expected);
    let edge = "[inputs.edge_pressure]\nkind = \"epistemic\"\nlower = 0\nupper = 1\n";
    let weights = "pressure_weights = [1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0]";
    refused(
        &study("", weights, &format!("{edge}{FIELD}")),
        ":19: inputs.edge_pressure = (given): must be absent: the deviations of [pressure_field]",
    );
    refused(
        &study("", "", &edge.replace("upper = 1", "upper = 2")),
        ":22: inputs.edge_pressure.upper = 2: must be at most 1: 1 is the pressure of a rigid punch",
    );
    refused(
        &study("", "", &FIELD.replace("modes = 2", "modes = 7")),
        ":22: pressure_field.modes = 7: must be from 1 to 5",
    );
}

/// Thicknesses that are none.
/// Seen to fail with the values of a file not looked at.
#[test]
fn impossible_strips_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |study: &str, expected: &str| refuse_in(folder.path(), study, expected);
    let thick = "must not be thicker than the neck is high";
    let length = "must be from 0.001 to 10000";
    let key = "inputs.strip_thickness_mm";
    for (old, new, expected) in [
        (
            "high = 0.6",
            "high = 19",
            format!(":19: {key} = 19: {thick}"),
        ),
        (
            "low = 0.3",
            "low = 0.0",
            format!(":19: {key} = 0: {length}"),
        ),
        (
            "\"uniform\"\nlow = 0.3\nhigh = 0.6",
            "\"lognormal\"\nmedian = 0.4\nlog_standard_deviation = 0.1",
            format!(":19: {key} = 0: {length}"),
        ),
        (
            "low = 0.3",
            "low = -0.3",
            format!(":20: {key}.distribution = uniform on (-0.3, ...): must not give negative"),
        ),
        (
            "distribution = \"uniform\"\nlow = 0.3\nhigh = 0.6",
            "kind = \"epistemic\"\nlower = 0.3\nupper = 30",
            format!(":19: {key} = 30: {thick}"),
        ),
    ] {
        assert!(INPUT.contains(old));
        refused(&study("", "", &INPUT.replace(old, new)), &expected);
    }
    std::fs::write(
        folder.path().join("rows.csv"),
        "strip_thickness_mm\n0.4\n25\n",
    )
    .unwrap();
    let file = "[design]\nkind = \"file\"\npath = \"rows.csv\"\n";
    refused(&study("", "", file), &format!("{key} = 25: {thick}"));
    // a study on matrices has no strip
    let matrices = super::folder("study.toml", "[solver]", &format!("{INPUT}[solver]"));
    let output = microslip(matrices.path(), &["inspect", "study.toml"]);
    let rule = ":32: inputs.strip_thickness_mm = (given): must be absent: a model of kind \"matrices\" has no strip";
    assert_refused("matrices", &output, &[rule]);
}
