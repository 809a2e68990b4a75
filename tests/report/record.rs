//! A report needs no solver: the files of a run are enough, to the last byte.

use crate::synthetic::SyntheticStudy;
use microslip::ensemble::outcome::{CurvePoint, MaybeReal};
use microslip::report::run::require_unchanged;
use microslip::report::{self, ReportError};
use std::path::Path;

const FILES: [&str; 3] = ["summary.json", "report.json", "report.html"];

fn texts(folder: &Path) -> Vec<String> {
    let read = |name: &&str| std::fs::read_to_string(folder.join(name)).unwrap();
    FILES.iter().map(read).collect()
}

/// What no sample of the synthetic study has: failures of every kind and numbers that are not finite.
fn spoil(study: &mut SyntheticStudy) {
    study.fail_level(6);
    study.outcomes[3].levels[0].peak = None;
    if let Some(peak) = &mut study.outcomes[4].levels[0].peak {
        peak.frequency_hz = f64::NAN;
    }
    if let Some(peak) = &mut study.outcomes[5].levels[0].peak {
        peak.amplitude_m = f64::INFINITY;
    }
    if let Some(peak) = &mut study.outcomes[6].levels[0].peak {
        peak.work_input_j = f64::NAN;
        peak.truncation_error = MaybeReal::NONE;
    }
    study.outcomes[7].levels[1].around.curve_mut()[2] = CurvePoint {
        frequency_hz: f64::NAN,
        amplitude_m: 1.0,
        unstable: None,
    };
    if let Some(nominal) = &mut study.record.nominal {
        nominal.levels[2].peak = None;
        if let Some(peak) = &mut nominal.levels[3].peak {
            peak.residual = f64::NAN;
        }
    }
    study.record.free.frequency_hz = None;
}

/// Seen to fail with the curves not read back, and with JSON numbers read to the last digit but one.
#[test]
fn stored_files_give_the_same_report() {
    for spoiled in [false, true] {
        let mut study = SyntheticStudy::new(60);
        if spoiled {
            spoil(&mut study);
        }
        let (stored, direct) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        study.store(stored.path());
        report::render(stored.path()).unwrap();
        report::write(direct.path(), &study.input()).unwrap();
        for (name, (a, b)) in FILES
            .iter()
            .zip(texts(stored.path()).iter().zip(texts(direct.path())))
        {
            assert!(*a == b, "{name} differs (spoiled: {spoiled})");
        }
        let first = texts(stored.path());
        report::render(stored.path()).unwrap();
        assert!(first == texts(stored.path()), "a second rendering differs");
    }
}

/// Seen to fail without the comparison of the hashes.
#[test]
fn a_changed_table_is_named() {
    let mut study = SyntheticStudy::new(40);
    let folder = tempfile::tempdir().unwrap();
    study.store(folder.path());
    study.outcomes[0].inputs[0] = 3.0;
    let tables = study.record.tables.clone();
    study.store(folder.path());
    study.record.tables = tables;
    study.record.write(folder.path()).unwrap();
    report::render(folder.path()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("samples.parquet is not the file that the run wrote"));
    assert!(!page.contains("curves.parquet is not the file"));
}

/// Seen to fail with the path left out of the error.
#[test]
fn missing_and_broken_files_are_named() {
    for name in ["run.json", "samples.parquet", "curves.parquet"] {
        let folder = tempfile::tempdir().unwrap();
        SyntheticStudy::new(5).store(folder.path());
        std::fs::write(folder.path().join(name), "{\"broken\": 1").unwrap();
        let error = report::render(folder.path()).unwrap_err();
        assert!(matches!(error, ReportError::File(_)), "{error}");
        assert!(error.to_string().contains(name), "{error}");
        std::fs::remove_file(folder.path().join(name)).unwrap();
        let error = report::render(folder.path()).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}

/// The samples of one run with the record of another are refused. Seen to fail without the check of the shape.
#[test]
fn a_record_of_another_run_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut study = SyntheticStudy::new(5);
    study.store(folder.path());
    study.record.levels.pop();
    study.record.write(folder.path()).unwrap();
    assert!(report::render(folder.path()).is_err());
}

/// One digit of `run.json`: the report names the file, and what computes from it refuses.
///
/// Seen to fail without the hash in the second line.
#[test]
fn a_changed_record_is_named() {
    let folder = tempfile::tempdir().unwrap();
    SyntheticStudy::new(40).store(folder.path());
    require_unchanged(folder.path()).unwrap();
    let path = folder.path().join("run.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let changed = text.replacen("\"curve_samples\": ", "\"curve_samples\": 1", 1);
    assert_ne!(text, changed, "no such number");
    std::fs::write(&path, changed).unwrap();
    let error = require_unchanged(folder.path()).unwrap_err().to_string();
    let expected = "run.json: is not the file that the run wrote";
    assert!(error.ends_with(expected), "{error}");
    report::render(folder.path()).unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("run.json is not the file that the run wrote"));
}

/// The hash is of the bytes that were written, and standard tools can tell: `tail -n +3 run.json | b3sum`.
#[test]
fn the_hash_of_a_record_is_of_the_lines_below_it() {
    let folder = tempfile::tempdir().unwrap();
    SyntheticStudy::new(5).store(folder.path());
    let text = std::fs::read_to_string(folder.path().join("run.json")).unwrap();
    let (head, body) = text.split_at(text.match_indices('\n').nth(1).unwrap().0 + 1);
    let hash = microslip::file::FileRecord::of("", body.as_bytes()).blake3;
    assert_eq!(
        head,
        format!("{{\n  \"blake3_of_the_lines_below\": \"{hash}\",\n")
    );
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(json["provenance"].is_object(), "one JSON value");
}
