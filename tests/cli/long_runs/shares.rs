//! A run that several processes share.

use std::path::Path;
use std::process::Child;
use std::time::Duration;

use super::{
    assert_same_results, change, damage, ended, microslip, refused, run, solved, start, study,
    wait_for_a_part,
};
use crate::{files, write};
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

/// The atlas in one folder, shards in folders of their own that begin with a copy of it, merged: the same bits.
/// Seen to fail with shards that leave the last block out, with a merge that does not look for what is missing, and with one that copies
/// before it looks.
#[test]
fn merged_shards_are_the_whole_run() {
    let study = cheap(1500);
    let path = study.path();
    run(path, "whole", &["--quiet"]);
    let text = run(path, "atlas", &["--only-atlas"]);
    assert!(text.contains("1024 of 1500 samples"), "{text}");
    for n in [1, 3, 7] {
        let names: Vec<String> = (0..n).rev().map(|i| format!("shard-{i}-{n}")).collect();
        for (name, i) in names.iter().zip((0..n).rev()) {
            write(&files(&path.join("atlas")), &path.join(name));
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
        if n > 1 {
            let lacking = merge(&names[1..]);
            let message = String::from_utf8_lossy(&lacking.stderr).into_owned();
            assert_eq!(lacking.status.code(), Some(2), "{message}");
            let found = message.contains("of 1500 samples are there; 1");
            assert!(found, "{message}");
            assert!(!path.join(&output).exists(), "something was written");
        }
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

/// Shards of two studies are refused before anything is written, and so is a damaged part; each message says what to do.
/// Seen to fail with parts that are copied before all are compared.
#[test]
fn shards_that_do_not_fit_are_refused() {
    let study = cheap(12);
    let path = study.path();
    run(path, "own", &["--shard", "0/1", "--quiet"]);
    change(path, "seed = 7", "seed = 8");
    run(path, "other", &["--shard", "0/1", "--quiet"]);
    let merge = ["merge", "own", "other", "--output", "merged"];
    let expected = "other: holds samples of another study";
    refused(path, &merge, expected);
    refused(path, &merge, "leave one of the two out");
    refused(
        path,
        &["merge", "own", "--output", "other"],
        "take another --output",
    );
    damage(path, "own", ".samples.parquet", |bytes| bytes.truncate(100));
    let merge = ["merge", "own", "--output", "merged"];
    refused(path, &merge, "delete it and solve its shard again");
    assert!(!path.join("merged").exists(), "something was written");
}

/// A part of another study that somebody puts into the folder of joined processes ends them, with what to do.
/// Seen to fail with the parts of others not compared.
#[test]
fn a_joined_process_refuses_parts_of_another_study() {
    let study = study(400);
    let path = study.path();
    change(path, "seed = 7", "seed = 8");
    run(path, "other", &["--shard", "0/1", "--quiet"]);
    change(path, "seed = 8", "seed = 7");
    let child = start(path, "results", "20ms", &["--join", "--threads", "1"]);
    wait_for_a_part(path, "results");
    write(
        &files(&path.join("other/parts")),
        &path.join("results/parts"),
    );
    let (code, said) = ended(child);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("holds samples of another study"), "{said}");
    assert!(said.contains("or delete this folder"), "{said}");
}

/// Rounds in which two of three joined processes are killed.
const ROUNDS: u64 = 4;

/// Of three joined processes two are killed at random; the third does their work after a while. In one of the rounds that one is
/// killed, too, and a process that joins later ends the run.
///
/// Seen to fail with claims that are never void.
#[test]
fn the_last_of_three_ends_the_run() {
    let study = solved(150);
    let path = study.path();
    // side by side, since each waits for claims that become void
    std::thread::scope(|scope| {
        for round in 0..ROUNDS {
            scope.spawn(move || two_of_three_are_killed(path, round));
        }
    });
}

fn two_of_three_are_killed(path: &Path, round: u64) {
    let output = format!("results-{round}");
    let mut random = ChaCha8Rng::seed_from_u64(3 + round);
    let join = || start(path, &output, "20ms", &["--join", "--threads", "1"]);
    let mut children = [join(), join(), join()];
    let last = random.random_range(0..3);
    let kill = |child: &mut Child| {
        child.kill().unwrap();
        child.wait().unwrap();
    };
    for (i, child) in children.iter_mut().enumerate() {
        if i != last {
            std::thread::sleep(Duration::from_millis(random.random_range(100..400)));
            kill(child);
        }
    }
    if round == 0 {
        kill(&mut children[last]);
        children[last] = join();
    }
    assert!(children[last].wait().unwrap().success(), "the last one");
    assert_same_results(path, &output);
}
