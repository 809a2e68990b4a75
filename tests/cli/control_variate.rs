//! The control variate of a study: its samples and further ones on few harmonics.

use microslip::ensemble::store::{StoredSamples, read_samples};
use microslip::study::{Study, inspect};
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

use super::bad_input::refuse_all;
use super::{folder, microslip};

/// Limits of the amplitude between the samples of both levels.
const WANTED: &str = "[control_variate]\nsamples = 80\n\n[[criteria]]\nname = \"amplitude\"\nquantity = \"amplitude-um\"\nlimit = 200\n\n[output]";

fn run(folder: &TempDir, arguments: &[&str]) {
    let arguments = [&["run", "study.toml", "--quiet"], arguments].concat();
    let output = microslip(folder.path(), &arguments);
    assert!(output.status.success(), "{output:?}");
}

fn with_control(samples: &str) -> TempDir {
    let folder = folder("study.toml", "[output]", WANTED);
    let path = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("samples = 10", samples, 1)).unwrap();
    folder
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join("results").join(name)).unwrap()
}

/// The control has the inputs of the study's samples, on harmonic 1 alone, and more; the study's own samples are those without
/// it. The same bits for any number of threads. Seen to fail with the control on the harmonics of the study.
#[test]
fn a_run_has_its_control() {
    let folder_of_run = with_control("samples = 30");
    run(&folder_of_run, &["--threads", "1"]);
    let results = folder_of_run.path().join("results");
    let own = read_samples(&results.join("samples.parquet")).unwrap();
    let control = read_samples(&results.join("control_variate.parquet")).unwrap();
    assert_eq!((own.outcomes.len(), control.outcomes.len()), (30, 80));
    for (own, control) in own.outcomes.iter().zip(&control.outcomes) {
        assert_eq!(own.inputs, control.inputs);
    }
    let highest = |o: &microslip::ensemble::outcome::SampleOutcome| {
        o.levels[0].peak.map(|peak| peak.highest_harmonic)
    };
    assert!(control.outcomes.iter().all(|o| highest(o) == Some(1)));
    let report: Value =
        serde_json::from_slice(&bytes(folder_of_run.path(), "report.json")).unwrap();
    let of_level = &report["levels"][0]["control_variate"];
    assert_eq!(of_level["further"], 50);
    assert!(
        of_level["amplitude_m"]["correlation"].as_f64().unwrap() > 0.5,
        "{of_level}"
    );
    assert_eq!(of_level["exceedances"].as_array().unwrap().len(), 1);
    let again = with_control("samples = 30");
    run(&again, &["--threads", "2"]);
    for name in ["samples.parquet", "control_variate.parquet", "report.json"] {
        assert_eq!(
            bytes(folder_of_run.path(), name),
            bytes(again.path(), name),
            "{name}"
        );
    }
    let without = folder("study.toml", "samples = 10", "samples = 30");
    run(&without, &[]);
    let plain = read_samples(&without.path().join("results/samples.parquet")).unwrap();
    let debug = |samples: &StoredSamples| format!("{:?}", samples.outcomes);
    assert_eq!(debug(&plain), debug(&own));
    assert!(
        !without
            .path()
            .join("results/control_variate.parquet")
            .exists()
    );
}

/// The time that `inspect` states grows with the samples of the control, each far cheaper than one of the study. Seen to fail with
/// the time of the study alone.
#[test]
fn inspect_counts_the_control() {
    let stated = |folder: &TempDir| {
        let study = Study::read(&folder.path().join("study.toml")).unwrap();
        inspect(&study).unwrap().processor_time_s
    };
    let alone = stated(&folder("study.toml", "samples = 10", "samples = 30"));
    let control = |samples: u64| {
        let folder = with_control("samples = 30");
        let path = folder.path().join("study.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        let text = text.replacen("samples = 80", &format!("samples = {samples}"), 1);
        std::fs::write(&path, text).unwrap();
        stated(&folder) - alone
    };
    let [few, more, most] = [80, 40_000, 80_000].map(control);
    assert!(0.0 < few && few < alone, "{few} s beside {alone} s");
    // the first samples cost more than those that start from others
    let further = (most - more) / 40_000.0;
    assert!(further < few / 80.0, "{further} s each");
    assert!(further > 0.1 * few / 80.0, "{further} s each");
}

/// The table belongs to the results: a changed one is noticed, and a run without it removes it.
#[test]
fn the_table_belongs_to_the_results() {
    let folder = with_control("samples = 20");
    run(&folder, &[]);
    let results = folder.path().join("results");
    let table = results.join("control_variate.parquet");
    std::fs::copy(results.join("samples.parquet"), &table).unwrap();
    let verified = microslip(folder.path(), &["verify", "results"]);
    assert_eq!(verified.status.code(), Some(2), "{verified:?}");
    let path = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(
        &path,
        text.replacen("[control_variate]\nsamples = 80\n", "", 1),
    )
    .unwrap();
    std::fs::remove_file(results.join("run.json")).unwrap();
    run(&folder, &[]);
    assert!(!table.exists(), "the table of an older run is still there");
}

/// Seen to fail without the check of the design, and with "must be from 1 to 0" for a study on one harmonic.
#[test]
fn what_cannot_be_a_control_is_refused() {
    let wanted = |text: &str| format!("[control_variate]\n{text}\n[output]");
    let harmonics = wanted("harmonics = 5");
    let few = wanted("samples = 19");
    let latin = format!("[design]\nkind = \"latin-hypercube\"\n{}", wanted(""));
    refuse_all(
        "study.toml",
        &[
            (
                "[output]",
                &harmonics,
                &["control_variate.harmonics = 5", "must be from 1 to 4"],
            ),
            (
                "[solver]\nharmonics = 5",
                "[control_variate]\n[solver]\nharmonics = 1",
                &[
                    "control_variate.harmonics = 1: no number fits",
                    "`solver.harmonics` must be 2 or more",
                ],
            ),
            (
                "[output]",
                &few,
                &["control_variate.samples = 19", "must be from 20"],
            ),
            (
                "[output]",
                &latin,
                &["control_variate = (table)", "must be absent", "monte-carlo"],
            ),
        ],
    );
}
