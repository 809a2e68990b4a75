//! `run` from study file to results.

use std::path::Path;

use super::{folder, microslip};
use microslip::ensemble::store::read_samples;

/// Runs the study of the folder into `output` and returns the bytes of its samples.
fn samples(study: &Path, output: &str, threads: &str) -> Vec<u8> {
    let path = study.join("study.toml");
    let out = study.join(output);
    let arguments = [
        "run",
        path.to_str().unwrap(),
        "--output",
        out.to_str().unwrap(),
        "--threads",
        threads,
        "--quiet",
    ];
    let result = microslip(study, &arguments);
    assert!(
        result.status.success(),
        "{}",
        String::from_utf8_lossy(&result.stderr)
    );
    for name in [
        "curves.parquet",
        "run.json",
        "summary.json",
        "report.json",
        "report.html",
    ] {
        assert!(out.join(name).is_file(), "{name} is missing");
    }
    std::fs::read(out.join("samples.parquet")).unwrap()
}

/// Seen to fail with the outcomes collected in the order in which the threads end.
#[test]
fn the_number_of_threads_changes_no_bit() {
    let study = folder("study.toml", "samples = 10", "samples = 40");
    let one = samples(study.path(), "one", "1");
    let two = samples(study.path(), "two", "2");
    assert!(one == two, "1 and 2 threads differ");
}

/// Seen to fail with the seed left out of the stream's key.
#[test]
fn another_seed_gives_other_samples() {
    let first = folder("study.toml", "seed = 7", "seed = 7");
    let second = folder("study.toml", "seed = 7", "seed = 8");
    assert!(samples(first.path(), "out", "1") != samples(second.path(), "out", "1"));
    let again = folder("study.toml", "seed = 7", "seed = 7");
    assert!(samples(first.path(), "out", "1") == samples(again.path(), "out", "2"));
}

/// More samples leave the first ones as they are: sample i depends on the seed and i alone. Seen to fail with
/// generations that depend on the number of samples.
#[test]
fn a_sample_does_not_depend_on_the_others() {
    let few = folder("study.toml", "samples = 10", "samples = 21");
    let many = folder("study.toml", "samples = 10", "samples = 37");
    let read = |study: &Path| {
        samples(study, "out", "2");
        read_samples(&study.join("out/samples.parquet")).unwrap()
    };
    let (few, many) = (read(few.path()), read(many.path()));
    for (a, b) in few.outcomes.iter().zip(&many.outcomes) {
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
    assert_eq!((few.outcomes.len(), many.outcomes.len()), (21, 37));
}

/// The rig is solved on half of its contacts unless told otherwise, with the same peaks. Seen to fail with the key
/// ignored.
#[test]
fn the_mirror_can_be_switched_off() {
    let default = std::fs::read_to_string("studies/two-blade-strip/study.toml").unwrap();
    let short = default
        .replace("samples = 200", "samples = 1")
        .replace("[contact]", "contact_nodes = [2, 3]\n[contact]")
        .replace("levels = [0.1, 5.0, 20.0]", "levels = [0.1, 5.0]")
        .replace("harmonics = 5", "harmonics = 3")
        .replace("curve_samples = 30", "curve_samples = 0");
    let peaks = |mirror: &str| {
        let folder = tempfile::tempdir().unwrap();
        let text = short.replace("[solver]", &format!("[solver]\n{mirror}"));
        std::fs::write(folder.path().join("study.toml"), text).unwrap();
        samples(folder.path(), "out", "2");
        let stored = read_samples(&folder.path().join("out/samples.parquet")).unwrap();
        let levels = stored.outcomes[0].levels.iter();
        let peaks = levels.map(|l| l.peak.unwrap()).collect::<Vec<_>>();
        (stored.metadata["folded"].clone(), peaks)
    };
    let (folded, half) = peaks("");
    let (whole_folded, whole) = peaks("mirror = false");
    assert_eq!((folded.as_str(), whole_folded.as_str()), ("true", "false"));
    for (a, b) in half.iter().zip(&whole) {
        assert!((a.frequency_hz / b.frequency_hz - 1.0).abs() < 1e-6);
        assert!((a.amplitude_m / b.amplitude_m - 1.0).abs() < 1e-6);
    }
}

/// A GPU that is not there leaves the work to the processor: the same bits, with a warning and a note in the summary.
#[test]
fn an_absent_gpu_changes_no_bit() {
    let study = folder("study.toml", "samples = 10", "samples = 9");
    let expected = samples(study.path(), "cpu", "2");
    let path = study.path().join("study.toml");
    let out = study.path().join("gpu");
    let (path, out) = (path.to_str().unwrap(), out.to_str().unwrap());
    let arguments = ["run", path, "--output", out, "--quiet"];
    let backend = ["--backend", "gpu", "--adapter", "no such adapter"];
    let result = microslip(study.path(), &[&arguments[..], &backend].concat());
    let message = String::from_utf8_lossy(&result.stderr);
    assert!(result.status.success(), "{message}");
    assert!(message.contains("no such adapter"), "{message}");
    let summary = std::fs::read_to_string(Path::new(out).join("summary.json")).unwrap();
    assert!(summary.contains("no such adapter"), "the summary says why");
    let found = std::fs::read(Path::new(out).join("samples.parquet")).unwrap();
    assert!(found == expected, "the same bits");
}

/// Every adapter, or none, is listed; whether there is one does not change the exit code.
#[test]
fn devices_are_listed() {
    let result = microslip(Path::new("."), &["devices"]);
    assert!(result.status.success());
    let text = String::from_utf8_lossy(&result.stdout);
    assert!(
        text.contains("self-test") || text.contains("no adapter"),
        "{text}"
    );
}
