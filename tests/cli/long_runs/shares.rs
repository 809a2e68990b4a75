//! A run that several processes share.

use std::path::Path;
use std::process::Child;
use std::time::Duration;

use super::{assert_same_results, change, microslip, refused, run, solved, start, study};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A cheap study with so many samples.
fn cheap(samples: u64) -> tempfile::TempDir {
    let study = study(samples);
    let path = study.path();
    change(path, "levels = [1.0, 2.0]", "levels = [1.0]");
    change(path, "harmonics = 5", "harmonics = 3");
    let curves = format!("curve_samples = {}", samples / 5);
    change(path, &curves, "curve_samples = 10");
    study
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap();
        if path.is_dir() {
            copy_folder(&path, &to.join(name));
        } else {
            std::fs::copy(&path, to.join(name)).unwrap();
        }
    }
}

/// The atlas in one folder, shards in folders of their own that begin with a copy of it, merged: the same bits.
/// Seen to fail with shards that leave the last block out, and with a merge that does not look for what is missing.
#[test]
fn merged_shards_are_the_whole_run() {
    let study = cheap(1500);
    let path = study.path();
    run(path, "whole", &["--quiet"]);
    let text = run(path, "atlas", &["--only-atlas"]);
    assert!(text.contains("1024 of 1500 samples"), "{text}");
    for n in [3, 7] {
        let names: Vec<String> = (0..n).rev().map(|i| format!("shard-{i}-{n}")).collect();
        for (name, i) in names.iter().zip((0..n).rev()) {
            copy_folder(&path.join("atlas"), &path.join(name));
            run(path, name, &["--shard", &format!("{i}/{n}"), "--quiet"]);
        }
        let output = format!("merged-{n}");
        let arguments = |names: &[String]| -> Vec<String> {
            let fixed = ["merge", "--quiet", "--output", &output];
            let fixed = fixed.into_iter().map(str::to_owned);
            fixed.chain(names.iter().cloned()).collect()
        };
        let merge = |names: &[String]| {
            let arguments = arguments(names);
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            microslip(path, &arguments)
        };
        let lacking = merge(&names[1..]);
        let message = String::from_utf8_lossy(&lacking.stderr).into_owned();
        assert_eq!(lacking.status.code(), Some(2), "{message}");
        assert!(
            message.contains("of 1500 samples are there; 1"),
            "{message}"
        );
        let merged = merge(&names);
        assert!(merged.status.success(), "{merged:?}");
        assert_same_results(path, &output);
    }
}

/// Shards in one folder, in any order, and a `run` without a share at the end, which also solves what a shard has left.
/// Seen to fail with a share that leaves a table of results.
#[test]
fn shards_may_share_a_folder() {
    let study = cheap(1200);
    let path = study.path();
    run(path, "whole", &["--quiet"]);
    run(path, "results", &["--only-atlas", "--quiet"]);
    let shard = |i: &str| start(path, "results", "20ms", &["--shard", i]);
    let mut shards: Vec<Child> = ["2/3", "0/3"].into_iter().map(shard).collect();
    for shard in &mut shards {
        assert!(shard.wait().unwrap().success(), "{shard:?}");
    }
    assert!(
        !path.join("results/samples.parquet").exists(),
        "no results yet"
    );
    let text = run(path, "results", &[]);
    assert!(text.contains("samples were solved before"), "{text}");
    assert_same_results(path, "results");
}

/// In a Slurm array the shard is known; elsewhere it must be said. Seen to fail with the variables not read.
#[test]
fn arrays_name_the_shard() {
    let study = cheap(30);
    let path = study.path();
    refused(
        path,
        &["run", "study.toml", "--shard"],
        "must be I/N where SLURM_ARRAY_TASK_ID",
    );
    let wrong = microslip(path, &["run", "study.toml", "--shard", "3/3"]);
    assert_eq!(wrong.status.code(), Some(2), "{wrong:?}");
    let task = assert_cmd::Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(path)
        .args(["run", "study.toml", "--shard"])
        .envs([
            ("SLURM_ARRAY_TASK_ID", "5"),
            ("SLURM_ARRAY_TASK_MIN", "4"),
            ("SLURM_ARRAY_TASK_COUNT", "2"),
        ])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&task.stdout);
    assert!(text.contains("30 of 30 samples, 0 of them"), "{task:?}");
}

/// A run that stops by a rule is judged in order, by one process. Seen to fail without the refusal.
#[test]
fn a_run_with_a_rule_is_not_shared() {
    let study = cheap(30);
    let path = study.path();
    change(
        path,
        "samples = 30",
        "samples = { until = \"decided\", at_most = 200 }",
    );
    let text = std::fs::read_to_string(path.join("study.toml")).unwrap();
    let criterion =
        "[[criteria]]\nname = \"amplitude\"\nquantity = \"amplitude-um\"\nlimit = 1000.0\n";
    std::fs::write(path.join("study.toml"), text + criterion).unwrap();
    for share in [&["--join"][..], &["--only-atlas"], &["--shard", "0/2"]] {
        let arguments = [&["run", "study.toml", "--quiet"][..], share].concat();
        let output = microslip(path, &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("cannot be shared"), "{message}");
    }
}

/// One to four processes that join in a folder, started one after the other: the same bits.
/// Seen to fail with the anchors of the first generation alone.
#[test]
fn joined_processes_make_one_run() {
    let study = solved(100);
    let path = study.path();
    for n in 1..=4 {
        let mut children: Vec<Child> = Vec::new();
        for _ in 0..n {
            children.push(start(
                path,
                "results",
                "20ms",
                &["--join", "--threads", "1"],
            ));
            std::thread::sleep(Duration::from_millis(30));
        }
        for child in &mut children {
            assert!(child.wait().unwrap().success(), "{child:?}");
        }
        assert_same_results(path, "results");
        std::fs::remove_dir_all(path.join("results")).unwrap();
    }
}

/// Of three joined processes two are killed at random; the third does their work after a while.
/// Seen to fail with claims that are never void.
#[test]
fn the_last_of_three_ends_the_run() {
    let study = solved(150);
    let path = study.path();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let join = || start(path, "results", "20ms", &["--join", "--threads", "1"]);
    let mut children = [join(), join(), join()];
    let last = random.random_range(0..3);
    for (i, child) in children.iter_mut().enumerate() {
        if i != last {
            std::thread::sleep(Duration::from_millis(random.random_range(100..400)));
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }
    assert!(children[last].wait().unwrap().success(), "the last one");
    assert_same_results(path, "results");
}
