//! Parts that were damaged, and a disk that takes no more.

use std::collections::BTreeSet;
use std::process::Stdio;

use assert_cmd::cargo::CommandCargoExt;
use microslip::ensemble::parts::{PartFolder, StoredPart};

use super::{
    assert_same_results, change_bytes, damage, ended, killed_after, microslip, parts, refused, run,
    solved, start, wait_for_a_part,
};

const SAMPLES: u64 = 60;

/// A part with a wrong bit, or cut off, or without a companion is named by `verify`, and its samples are solved again.
/// Seen to fail with hashes that are not compared.
#[test]
fn damaged_parts_are_solved_again() {
    let study = solved(SAMPLES);
    let path = study.path();
    let flip: fn(&mut Vec<u8>) = |bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 4;
    };
    let cut: fn(&mut Vec<u8>) = |bytes| bytes.truncate(bytes.len() / 2);
    for end in [".samples.parquet", ".curves.parquet", ".atlas.parquet"] {
        for how in [flip, cut] {
            killed_after(path, "results", 2);
            let name = damage(path, "results", end, how);
            let fault = format!("{name}: is not the file that was written");
            let advice = "; `run` solves the samples of a damaged part again";
            refused(path, &["verify", "results"], &format!("{fault}{advice}"));
            let text = run(path, "results", &[]);
            assert!(
                text.contains(&format!("{fault}; its samples are solved again")),
                "{text}"
            );
            assert_same_results(path, "results");
            std::fs::remove_dir_all(path.join("results")).unwrap();
        }
    }
    killed_after(path, "results", 2);
    let names = parts(path, "results");
    let companion = names
        .iter()
        .find(|name| name.ends_with(".atlas.parquet"))
        .unwrap();
    std::fs::remove_file(path.join("results/parts").join(companion)).unwrap();
    refused(path, &["verify", "results"], companion);
    run(path, "results", &["--quiet"]);
    assert_same_results(path, "results");
}

/// A part that is damaged while the run goes on is named at its end, with how many samples were solved again for it.
///
/// Seen to fail without the number of samples.
#[test]
fn a_part_that_is_damaged_during_the_run_is_named() {
    let study = solved(SAMPLES);
    let path = study.path();
    let arguments = ["run", "study.toml", "--flush-every", "20ms"];
    let mut child = std::process::Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(path)
        .args(arguments)
        .args(["--output", "results"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for_a_part(path, "results");
    let name = damage(path, "results", ".samples.parquet", |bytes| bytes[100] ^= 4);
    assert!(child.try_wait().unwrap().is_none(), "the run has ended");
    let output = child.wait_with_output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert!(output.status.success(), "{said}");
    let fault = format!("{name}: is not the file that was written; its samples are solved again");
    assert!(said.contains(&fault), "{said}");
    let count = "samples stood in parts that were deleted or damaged during the run";
    assert!(said.contains(count), "{said}");
    assert_same_results(path, "results");
}

/// A part is hashed once: a second listing reads again what has another length or time, and nothing else.
///
/// Seen to fail with parts that are not looked at again, changed or not, and with all read again.
#[test]
fn parts_are_hashed_once() {
    let study = solved(SAMPLES);
    let path = study.path();
    killed_after(path, "results", 2);
    let folder = PartFolder::of(&path.join("results"));
    let list = |known: Vec<StoredPart>| -> Vec<Option<StoredPart>> {
        let parts = folder.list_again(known).unwrap();
        parts.into_iter().map(Result::ok).collect()
    };
    let known: Vec<StoredPart> = list(Vec::new()).into_iter().flatten().collect();
    assert!(known.len() >= 2, "parts");
    let name = parts(path, "results")
        .into_iter()
        .find(|name| name.ends_with(".curves.parquet"));
    let file = path.join("results/parts").join(name.unwrap());
    let time = std::fs::metadata(&file).unwrap().modified().unwrap();
    damage(path, "results", ".curves.parquet", |bytes| bytes[100] ^= 4);
    let dated = |time| {
        let file = std::fs::File::options().write(true).open(&file).unwrap();
        file.set_modified(time).unwrap();
    };
    dated(time);
    let sound = |parts: Vec<Option<StoredPart>>| parts.iter().flatten().count();
    assert_eq!(sound(list(known.clone())), known.len(), "not read again");
    assert_eq!(sound(list(Vec::new())), known.len() - 1, "hashed");
    dated(time + std::time::Duration::from_secs(1));
    assert_eq!(sound(list(known.clone())), known.len() - 1, "another time");
}

/// A joined process reads a damaged part as soon as it is whole again: a process of the same number on the same host, as containers have
/// it, writes it again under the same name. Seen to fail with each name looked at once.
#[test]
fn a_part_that_was_mended_is_read() {
    let study = solved(SAMPLES);
    let path = study.path();
    killed_after(path, "results", 2);
    let folder = PartFolder::of(&path.join("results"));
    let mut seen = BTreeSet::new();
    let name = damage(path, "results", ".samples.parquet", |bytes| bytes[100] ^= 4);
    let n = parts(path, "results")
        .iter()
        .filter(|n| n.ends_with(".samples.parquet"))
        .count();
    assert_eq!(folder.unseen(&mut seen).unwrap().len(), n - 1, "damaged");
    let table = path.join("results/parts").join(name);
    change_bytes(&table, |bytes| bytes[100] ^= 4);
    let mended = folder.unseen(&mut seen).unwrap();
    assert_eq!(mended.len(), 1, "mended");
    assert_eq!(mended[0].paths()[0], table);
    assert!(folder.unseen(&mut seen).unwrap().is_empty(), "all are seen");
}

/// Whole results with a wrong bit are named, and solved and written anew. Seen to fail without what to do in the message.
#[test]
fn damaged_results_are_solved_again() {
    let study = solved(12);
    let path = study.path();
    run(path, "results", &["--quiet"]);
    change_bytes(&path.join("results/samples.parquet"), |bytes| {
        bytes[100] ^= 4;
    });
    let expected =
        "is not the file that the run wrote; `run` solves and writes damaged results anew";
    refused(path, &["verify", "results"], expected);
    run(path, "results", &["--quiet"]);
    assert_same_results(path, "results");
}

/// Companions without the table that makes a part count, as a kill leaves them, are no part and no fault.
/// Seen to fail with every file of the folder taken for a part.
#[test]
fn files_of_no_part_are_left_alone() {
    let study = solved(SAMPLES);
    let path = study.path();
    killed_after(path, "results", 2);
    let names = parts(path, "results");
    let table = names
        .iter()
        .find(|name| name.ends_with(".samples.parquet"))
        .unwrap();
    std::fs::remove_file(path.join("results/parts").join(table)).unwrap();
    assert!(
        microslip(path, &["verify", "results"]).status.success(),
        "no fault"
    );
    run(path, "results", &["--quiet"]);
    assert_same_results(path, "results");
}

/// A part that cannot be written ends the run with its reason, and older results are as they were.
/// Seen to fail with the error of a part ignored, and with that of a claim without what to do.
#[cfg(unix)]
#[test]
fn a_part_that_cannot_be_written_ends_the_run() {
    let study = solved(SAMPLES);
    let path = study.path();
    run(path, "results", &["--quiet"]);
    super::change(path, "seed = 7", "seed = 8");
    // a folder that cannot be made: no part can be written, as on a full disk
    std::os::unix::fs::symlink("nowhere", path.join("results/parts")).unwrap();
    for more in [&[][..], &["--join"], &["--shard", "0/1"]] {
        let arguments = [&["run", "study.toml", "--quiet"], more].concat();
        refused(path, &arguments, "results/parts");
        refused(path, &arguments, "the same command goes on");
    }
    std::fs::remove_file(path.join("results/parts")).unwrap();
    super::change(path, "seed = 8", "seed = 7");
    assert_same_results(path, "results");
}

/// A folder that is taken away under a run is made again, and what was in it is solved again. Seen to fail without the second
/// attempt to write, and with samples that are not looked for again.
#[test]
fn a_lost_folder_is_made_again() {
    let study = solved(SAMPLES);
    let path = study.path();
    let mut child = start(path, "results", "20ms", &[]);
    wait_for_a_part(path, "results");
    std::fs::rename(path.join("results"), path.join("elsewhere")).unwrap();
    assert!(child.wait().unwrap().success(), "{child:?}");
    assert_same_results(path, "results");
}

/// The same of a process that joins, whose claims were in the folder, too. Seen to fail with a claim that does not make its folder.
#[test]
fn a_lost_folder_is_made_again_by_a_joined_process() {
    let study = solved(SAMPLES);
    let path = study.path();
    let child = start(path, "results", "20ms", &["--join"]);
    wait_for_a_part(path, "results");
    std::fs::rename(path.join("results"), path.join("elsewhere")).unwrap();
    let (code, said) = ended(child);
    assert_eq!(code, Some(0), "{said}");
    assert_same_results(path, "results");
}

/// A share whose folder is taken away has all of its samples at its end. Seen to fail with samples that are not looked for again.
#[test]
fn a_share_whose_folder_is_lost_is_whole() {
    let study = solved(SAMPLES);
    let path = study.path();
    let mut child = start(path, "results", "20ms", &["--shard", "0/1"]);
    wait_for_a_part(path, "results");
    std::fs::rename(path.join("results"), path.join("elsewhere")).unwrap();
    assert!(child.wait().unwrap().success(), "{child:?}");
    let merged = microslip(path, &["merge", "results", "--output", "merged"]);
    assert!(merged.status.success(), "{merged:?}");
    assert_same_results(path, "merged");
}

/// `verify` compares the report with what the tables give. Seen to fail with hashes of the tables alone, which a number changed by hand
/// in `summary.json` does not change.
#[test]
fn an_edited_report_is_found() {
    let study = solved(12);
    let path = study.path();
    let file = path.join("whole/summary.json");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replacen("\"mean\": ", "\"mean\": 1", 1)).unwrap();
    refused(
        path,
        &["verify", "whole"],
        "summary.json is not what this program makes of the tables",
    );
    assert!(microslip(path, &["report", "whole"]).status.success());
    assert!(microslip(path, &["verify", "whole"]).status.success());
}
