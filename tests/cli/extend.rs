//! `extend`: more samples for the results of a run.

use std::path::Path;
use std::process::Output;

use super::{assert_same_files, folder, microslip, succeed};

/// Writes the study with so many samples, curves of 14 of them, and more lines.
fn study(folder: &Path, samples: u64, more: &str) {
    let text = super::STUDY.replace("samples = 10", &format!("samples = {samples}"));
    let text = text.replace("[output]\n", "[output]\ncurve_samples = 14\n");
    std::fs::write(folder.join("study.toml"), format!("{text}\n{more}")).unwrap();
}

/// In two steps, across generations of the atlas and in the middle of one, with curves in both parts.
/// Seen to fail with the real part of a kept response halved, and for pick-freeze with the place of a sample in its row
/// not read back.
#[test]
fn an_extended_run_is_the_whole_run() {
    let study_folder = folder("study.toml", "samples = 10", "samples = 10");
    let path = study_folder.path();
    let designs = [
        ("monte-carlo", "", [11, 19, 38]),
        (
            "sobol",
            "[design]\nkind = \"sobol\"\nreplicates = 3",
            [6, 12, 48],
        ),
        (
            "pick-freeze",
            "[design]\nkind = \"pick-freeze\"",
            [6, 12, 48],
        ),
    ];
    for (what, more, [few, some, many]) in designs {
        study(path, few, more);
        let run = ["run", "study.toml", "--quiet", "--output"];
        succeed(path, &[&run[..], &["extended"]].concat());
        for (n, threads) in [(some, "1"), (many, "2")] {
            let n = n.to_string();
            let arguments = ["extend", "extended", "--samples", &n, "--threads", threads];
            let text = succeed(path, &arguments);
            assert_eq!(
                text.contains("mean of 3 replicates"),
                what == "sobol",
                "{text}"
            );
        }
        study(path, many, more);
        succeed(path, &[&run[..], &["whole"]].concat());
        println!("{what}");
        assert_same_files(path, "extended");
    }
}

/// Arrow files never stay those of other samples: where a study or a report asked for them an extension writes them
/// anew, and nowhere else. Seen to fail with Arrow files that are written only where the study asks, and with ones that are
/// always written.
#[test]
fn arrow_files_follow_the_samples() {
    let study_folder = folder("study.toml", "samples = 10", "samples = 3");
    let path = study_folder.path();
    let read = |name: &str| std::fs::read(path.join("results").join(name)).ok();
    let bytes = || ["samples.arrow", "curves.arrow"].map(read);
    succeed(path, &["run", "study.toml", "--quiet"]);
    assert!(bytes() == [None, None], "nobody asked for Arrow files");
    let text = succeed(path, &["report", "results", "--arrow"]);
    assert!(text.contains("samples.arrow, curves.arrow"), "{text}");
    let few = bytes();
    assert!(few.iter().all(Option::is_some), "both tables");
    succeed(path, &["extend", "results", "--samples", "5", "--quiet"]);
    let more = bytes();
    assert!(more[0] != few[0] && more[1] != few[1], "stale Arrow files");
    study(path, 5, "arrow = true");
    std::fs::remove_dir_all(path.join("results")).unwrap();
    succeed(path, &["run", "study.toml", "--quiet"]);
    assert!(bytes() == more, "the study's key gives other files");
}

fn refused(output: &Output, fragment: &str) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(
        message.contains(fragment),
        "{fragment:?} is not in: {message}"
    );
}

/// Seen to fail with every design said to grow, and with a number of samples that is refused as one of the study file.
#[test]
fn what_cannot_be_extended_is_refused() {
    let study_folder = folder("study.toml", "samples = 10", "samples = 10");
    let path = study_folder.path();
    let extend = |n: &str| microslip(path, &["extend", "results", "--samples", n, "--quiet"]);
    refused(&extend("20"), "results: holds no atlas.parquet");
    let run = ["run", "study.toml", "--quiet"];
    succeed(path, &run);
    refused(&extend("10"), "--samples 10: must be more than the 10");
    let rule = "results: --samples 1000000000000: must be at most 100000000";
    refused(&extend("1000000000000"), rule);
    let stiffness = path.join("stiffness.mtx");
    let text = std::fs::read_to_string(&stiffness).unwrap();
    std::fs::write(&stiffness, text.replace("8e5", "8.1e5")).unwrap();
    refused(
        &extend("20"),
        "results: are results of another content of stiffness.mtx: `run` anew",
    );
    std::fs::write(&stiffness, text).unwrap();
    study(path, 8, "[design]\nkind = \"sobol\"");
    succeed(path, &run);
    refused(
        &extend("12"),
        ": samples = 12: must be a power of two: 8 or 16",
    );
    study(path, 6, "[design]\nkind = \"pick-freeze\"");
    succeed(path, &run);
    refused(
        &extend("9"),
        ": samples = 9: must be a power of two times 3 (2 and one per input): 6 or 12",
    );
    study(path, 8, "[design]\nkind = \"latin-hypercube\"");
    succeed(path, &run);
    refused(&extend("16"), "\"latin-hypercube\" cannot be extended");
    study(path, 8, "[design]\nkind = \"file\"\npath = \"x.csv\"");
    let values: String = (1..20)
        .map(|i| format!("{}\n", 0.05 * f64::from(i)))
        .collect();
    let csv = format!("stiffness_scale\n{values}");
    std::fs::write(path.join("x.csv"), &csv).unwrap();
    succeed(path, &run);
    std::fs::write(path.join("x.csv"), csv.replacen("0.1\n", "0.11\n", 1)).unwrap();
    refused(&extend("12"), "results of another content of x.csv");
}

/// Tables, anchors and record that the run did not write are refused by whatever computes from them.
///
/// Seen to fail without the hash of `atlas.parquet`, in `extend` and `reweight` without any look at the hashes, and with a `report`
/// that says nothing.
#[test]
fn changed_files_are_refused() {
    let study_folder = folder("study.toml", "two masses", "two masses");
    let path = study_folder.path();
    for (seed, output) in [("8", "other"), ("7", "results"), ("7", "same")] {
        let text = super::STUDY.replace("seed = 7", &format!("seed = {seed}"));
        let text = text.replace("samples = 10", "samples = 4") + "curve_samples = 1\n";
        std::fs::write(path.join("study.toml"), text).unwrap();
        succeed(path, &["run", "study.toml", "--quiet", "--output", output]);
    }
    std::fs::write(path.join("prior.toml"), PRIOR).unwrap();
    let run_json = std::fs::read_to_string(path.join("results/run.json")).unwrap();
    let edited = run_json.replacen("\"curve_samples\": 1", "\"curve_samples\": 2", 1);
    assert_ne!(run_json, edited, "no such number");
    std::fs::write(path.join("other/run.json"), edited).unwrap();
    for name in [
        "samples.parquet",
        "curves.parquet",
        "atlas.parquet",
        "run.json",
    ] {
        let file = path.join("results").join(name);
        let own = std::fs::read(&file).unwrap();
        std::fs::copy(path.join("other").join(name), &file).unwrap();
        let expected = format!("results/{name}: is not the file that the run wrote");
        refused(
            &microslip(path, &["extend", "results", "--samples", "6"]),
            &expected,
        );
        let reweight = ["reweight", "results", "--prior", "prior.toml"];
        refused(&microslip(path, &reweight), &expected);
        let expected = format!("{name} is not the file that the run wrote");
        refused(&microslip(path, &["compare", "same", "results"]), &expected);
        // a report is made from what there is, and says so
        let output = microslip(path, &["report", "results", "--quiet"]);
        let message = String::from_utf8_lossy(&output.stderr);
        let expected = format!("warning: results/{name}: is not the file that the run wrote");
        assert!(message.contains(&expected), "{name}: {message}");
        std::fs::write(&file, own).unwrap();
    }
    succeed(path, &["compare", "same", "results"]);
    refused(
        &microslip(path, &["compare", "results", "./results"]),
        "./results: is given twice",
    );
    succeed(path, &["extend", "results", "--samples", "6", "--quiet"]);
}

const PRIOR: &str =
    "[inputs.friction_coefficient]\ndistribution = \"uniform\"\nlow = 0.1\nhigh = 0.7\n";

/// The results and the study can move together, wherever the results lie. Seen to fail with the absolute path that
/// `atlas.parquet` held where the results lay outside of the study's folder.
#[test]
fn results_beside_the_study_move_with_it() {
    let root = tempfile::tempdir().unwrap();
    let study_folder = folder("study.toml", "samples = 10", "samples = 3");
    let (old, new) = (root.path().join("old"), root.path().join("new"));
    std::fs::create_dir_all(old.join("study")).unwrap();
    for name in ["study.toml", "mass.mtx", "stiffness.mtx"] {
        std::fs::copy(study_folder.path().join(name), old.join("study").join(name)).unwrap();
    }
    succeed(
        &old,
        &["run", "study/study.toml", "--quiet", "--output", "results"],
    );
    let atlas = std::fs::read(old.join("results/atlas.parquet")).unwrap();
    let place = root.path().file_name().unwrap().to_str().unwrap();
    let found = atlas
        .windows(place.len())
        .any(|part| part == place.as_bytes());
    assert!(!found, "atlas.parquet names the folder {place}");
    std::fs::rename(&old, &new).unwrap();
    succeed(&new, &["extend", "results", "--samples", "5", "--quiet"]);
}
