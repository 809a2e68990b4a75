//! Parts of another study, another program, or another process.

use std::path::Path;

use super::{
    assert_same_results, change, killed_after, microslip, parts, refused, run, solved, start,
    study, wait_for_a_part,
};
use microslip::ensemble::SolvedSample;
use microslip::ensemble::outcome::AroundPeak;
use microslip::ensemble::parts::{Merged, MergedSource, PartFolder, PartHead, StoredPart};
use microslip::ensemble::program::this_process;
use microslip::hb::Status;
use microslip::report::RunRecord;
use microslip::study::Study;
use tempfile::TempDir;

const SAMPLES: u64 = 120;

/// The parts of `output`, what their process writes into all, and their samples.
fn stored(folder: &Path, output: &str) -> (PartFolder, PartHead, Vec<SolvedSample>) {
    let parts = PartFolder::of(&folder.join(output));
    let found: Vec<StoredPart> = parts
        .list()
        .unwrap()
        .into_iter()
        .map(Result::unwrap)
        .collect();
    let study = Study::read(&folder.join("study.toml")).unwrap();
    let record = RunRecord::of_folder(&folder.join("whole")).unwrap();
    let head = PartHead {
        identity: found[0].identity.clone(),
        input_names: record.inputs.iter().map(|i| i.name.clone()).collect(),
        provenance: record.provenance,
    };
    let mut merged = Merged::new(found.iter().map(MergedSource::of).collect(), &study.design);
    let samples = std::iter::from_fn(|| merged.take().unwrap());
    (parts, head, samples.collect())
}

/// Seen to fail without the comparison of studies, and without that of files.
#[test]
fn parts_of_another_study_are_refused() {
    let study = study(SAMPLES);
    let path = study.path();
    killed_after(path, "results", 2);
    let arguments = ["run", "study.toml", "--quiet"];
    change(path, "seed = 7", "seed = 8");
    let expected = "results/parts: holds samples of another study (-2: seed = 7; +2: seed = 8)";
    refused(path, &arguments, expected);
    change(path, "seed = 8", "# as before\nseed    = 7");
    let stiffness = std::fs::read_to_string(path.join("stiffness.mtx")).unwrap();
    std::fs::write(
        path.join("stiffness.mtx"),
        stiffness.replace("8e5", "8.1e5"),
    )
    .unwrap();
    refused(
        path,
        &arguments,
        "holds samples of another content of stiffness.mtx",
    );
    std::fs::write(path.join("stiffness.mtx"), stiffness).unwrap();
    run(path, "results", &["--quiet"]);
}

/// Another program is refused unless it is accepted; then the summary names it.
/// Seen to fail with every program taken, with none named, and with a merge that refuses whatever is accepted.
#[test]
fn parts_of_another_program_are_refused_or_named() {
    let study = solved(SAMPLES);
    let path = study.path();
    killed_after(path, "results", 2);
    let (parts, mut head, known) = stored(path, "results");
    parts.remove().unwrap();
    head.identity.program.instruction_set = "a wide one".to_owned();
    parts.write(&head, known).unwrap();
    let arguments = ["run", "study.toml", "--quiet"];
    refused(
        path,
        &arguments,
        "holds samples of another program (0.1.0 on a wide one)",
    );
    run(path, "own", &["--shard", "0/1", "--quiet"]);
    let merge = ["merge", "own", "results", "--quiet", "--output", "merged"];
    refused(path, &merge, "of another program (0.1.0 on a wide one)");
    refused(path, &merge, "or take it over with --any-program");
    let merged = microslip(path, &[&merge[..], &["--any-program"]].concat());
    assert!(merged.status.success(), "{merged:?}");
    let summary = std::fs::read_to_string(path.join("merged/summary.json")).unwrap();
    assert!(summary.contains("a wide one"), "the merged one names it");
    run(path, "results", &["--quiet", "--any-program"]);
    let summary = std::fs::read_to_string(path.join("results/summary.json")).unwrap();
    assert!(summary.contains("a wide one"), "the summary names it");
    let page = std::fs::read_to_string(path.join("results/report.html")).unwrap();
    assert!(page.contains("a wide one"), "the report names it");
}

/// The same samples in two parts are taken once; another result of one, in parts of the same samples, is an error that names both
/// files with the processes that wrote them. Seen to fail with the first result taken, and without the second writer.
#[test]
fn parts_that_contradict_each_other_are_an_error() {
    let study = solved(SAMPLES);
    let path = study.path();
    killed_after(path, "results", 3);
    let (folder, head, known) = stored(path, "results");
    folder
        .write(&head, known.iter().take(3).cloned().collect())
        .unwrap();
    assert!(
        microslip(path, &["verify", "results"]).status.success(),
        "equal samples"
    );
    let mut other = known[..3].to_vec();
    other[0].outcome.levels[0].newton_iterations += 1;
    let before = parts(path, "results");
    folder.write(&head, other).unwrap();
    let mut after = parts(path, "results");
    after.retain(|name| !before.contains(name));
    let new = after
        .iter()
        .find(|name| name.ends_with(".samples.parquet"))
        .unwrap();
    for arguments in [
        &["run", "study.toml", "--quiet"][..],
        &["verify", "results"],
    ] {
        refused(path, arguments, "has another result of sample 0");
        let message = microslip(path, arguments).stderr;
        let message = String::from_utf8_lossy(&message).into_owned();
        let writers: Vec<&str> = message.split("(written by ").skip(1).collect();
        assert_eq!(writers.len(), 2, "{message}");
        let this = this_process();
        assert!(writers.iter().any(|w| w.starts_with(&this)), "{message}");
        assert!(
            writers.iter().all(|w| w.contains(", process ")),
            "{message}"
        );
    }
    for name in after.iter().filter(|name| name[..38] == new[..38]) {
        std::fs::remove_file(path.join("results/parts").join(name)).unwrap();
    }
    run(path, "results", &["--quiet"]);
    assert_same_results(path, "results");
}

/// A study with results of so many samples, extended to more.
fn solved_and_extended(samples: u64, more: &str) -> TempDir {
    let study = solved(samples);
    let further = ["extend", "whole", "--samples", more, "--quiet"];
    let extended = microslip(study.path(), &further);
    assert!(extended.status.success(), "{extended:?}");
    study
}

/// A run of a study whose results were extended would lose samples: it is refused in every way, and what there is stays.
/// Seen to fail without the refusal, which solved the fewer samples and put them in the place of all; and with requirements that count as
/// another study.
#[test]
fn extended_results_are_not_replaced_by_fewer_samples() {
    let study = solved_and_extended(12, "30");
    let path = study.path();
    let table = || std::fs::read(path.join("whole/samples.parquet")).unwrap();
    let before = table();
    let expected = "holds 30 samples of this study, of which its file asks for 12";
    for more in [None, Some("--join"), Some("--only-atlas")] {
        let run = ["run", "study.toml", "--quiet", "--output", "whole"];
        let arguments: Vec<&str> = run.into_iter().chain(more).collect();
        refused(path, &arguments, expected);
        assert!(table() == before, "{more:?} changed the results");
    }
    assert!(parts(path, "whole").is_empty(), "something was solved");
    // requirements change no sample
    require(path);
    refused(
        path,
        &["run", "study.toml", "--quiet", "--output", "whole"],
        expected,
    );
    // another study replaces them, as ever, and says so
    change(path, "seed = 7", "seed = 8");
    let text = run(path, "whole", &["--quiet"]);
    assert!(table() != before, "another study solves its own samples");
    assert!(
        text.contains("replaces the results in whole, of another study (-"),
        "{text}"
    );
}

/// Adds a criterion to the study of `folder`.
fn require(folder: &Path) {
    let criterion =
        "[[criteria]]\nname = \"amplitude\"\nquantity = \"amplitude-um\"\nlimit = 200\n\n[output]";
    change(folder, "[output]", criterion);
}

/// A study that only asks other things of its samples takes them over: those that `extend` solved, too. The results are those of a run of
/// the new study. Seen to fail with the program before, which solved all samples again.
#[test]
fn samples_serve_other_requirements() {
    let study = study(12);
    let path = study.path();
    run(path, "results", &["--quiet"]);
    let further = ["extend", "results", "--samples", "30", "--quiet"];
    assert!(microslip(path, &further).status.success());
    require(path);
    change(path, "samples = 12", "samples = 30");
    let text = run(path, "results", &[]);
    assert!(
        text.contains("30 samples were solved before and taken over"),
        "{text}"
    );
    assert!(!text.contains("replaces"), "{text}");
    run(path, "whole", &["--quiet"]);
    assert_same_results(path, "results");
}

/// Engine orders change no sample of a model that is no disk: a run with others is refused where it has fewer samples, and takes over as
/// many. Seen to fail with the program before, which solved the fewer samples and put them in the place of all.
#[test]
fn samples_serve_other_engine_orders() {
    let study = study(12);
    let path = study.path();
    let operation = "[operation]\nspeed_rpm = [2000, 2200]\nengine_orders = [3]\n\n[output]";
    change(path, "[output]", operation);
    run(path, "results", &["--quiet"]);
    let further = ["extend", "results", "--samples", "30", "--quiet"];
    assert!(microslip(path, &further).status.success());
    change(path, "engine_orders = [3]", "engine_orders = [3, 4]");
    let expected = "holds 30 samples of this study, of which its file asks for 12";
    refused(path, &["run", "study.toml", "--quiet"], expected);
    change(path, "samples = 12", "samples = 30");
    let text = run(path, "results", &[]);
    let taken = "30 samples were solved before and taken over";
    assert!(text.contains(taken) && !text.contains("replaces"), "{text}");
    run(path, "whole", &["--quiet"]);
    assert_same_results(path, "results");
}

/// That results of another study are replaced is said before the first sample is solved. Seen to fail with the program before, which said it
/// after the last.
#[test]
fn a_replacement_is_announced() {
    let study = solved(12);
    let path = study.path();
    change(path, "seed = 7", "seed = 8");
    let text = run(path, "whole", &["--log", "json"]);
    let place = |words: &str| {
        text.find(words)
            .unwrap_or_else(|| panic!("{words}: {text}"))
    };
    let warned = place("replaces the results");
    assert!(warned < place("\"event\":\"progress\""), "{text}");
}

/// What a run refuses, `merge` refuses before it copies a part: a copy would be in the way of the results there.
/// Seen to fail with the program before, which copied the parts.
#[test]
fn a_refused_merge_leaves_nothing() {
    let study = solved_and_extended(12, "30");
    let path = study.path();
    run(path, "share", &["--quiet", "--shard", "0/1"]);
    let expected = "holds 30 samples of this study, of which its file asks for 12";
    refused(path, &["merge", "share", "--output", "whole"], expected);
    assert!(parts(path, "whole").is_empty(), "parts were copied");
}

/// Results of another content of a file that the study names are not of this study: a run solves its own samples, fewer or as many, as
/// `extend` says. Seen to fail with the studies alone compared, which refused the run as one of this study.
#[test]
fn results_of_another_content_are_replaced_by_fewer_samples() {
    let study = solved_and_extended(12, "30");
    let path = study.path();
    let stiffness = std::fs::read_to_string(path.join("stiffness.mtx")).unwrap();
    let other = stiffness.replace("8e5", "8.1e5");
    std::fs::write(path.join("stiffness.mtx"), other).unwrap();
    let further = ["extend", "whole", "--samples", "40", "--quiet"];
    let expected = "are results of another content of stiffness.mtx: `run` anew";
    refused(path, &further, expected);
    let text = run(path, "whole", &[]);
    assert!(text.contains("12 of 12 samples solved"), "{text}");
    assert!(!text.contains("solved before"), "{text}");
    run(path, "fresh", &["--quiet"]);
    let table = |of: &str| std::fs::read(path.join(of).join("samples.parquet")).unwrap();
    assert!(table("whole") == table("fresh"), "samples of both contents");
}

/// A sample without a solution is taken over as it is, and solved again where that is asked for.
/// Seen to fail with the option ignored.
#[test]
fn failed_samples_are_solved_again_on_demand() {
    let study = solved(12);
    let path = study.path();
    change(path, "samples = 12", "samples = 120");
    killed_after(path, "results", 2);
    let (folder, mut head, known) = stored(path, "results");
    change(path, "samples = 120", "samples = 12");
    head.identity.study.text = std::fs::read_to_string(path.join("study.toml")).unwrap();
    let mut failed = known[0].clone();
    failed.outcome.levels[0].status = Status::StepTooSmall;
    failed.outcome.levels[0].peak = None;
    failed.outcome.levels[0].around = AroundPeak::default();
    let mut text = String::new();
    for output in ["results", "again"] {
        folder.remove().unwrap();
        let parts = PartFolder::of(&path.join(output));
        parts.write(&head, vec![failed.clone()]).unwrap();
        let retry: &[&str] = if output == "again" {
            &["--retry-failed"]
        } else {
            &["--any-program"]
        };
        text += &run(path, output, retry);
    }
    assert!(text.contains("11 of 12 samples solved"), "{text}");
    assert_same_results(path, "again");
    // whole results, too
    run(path, "results", &["--quiet", "--retry-failed"]);
    assert_same_results(path, "results");
}

/// Two commands in one folder: the second is refused and does no harm. Seen to fail without the lock.
#[test]
fn one_command_at_a_time() {
    let study = solved(SAMPLES);
    let path = study.path();
    let mut first = start(path, "results", "20ms", &[]);
    wait_for_a_part(path, "results");
    let arguments = ["run", "study.toml", "--quiet"];
    refused(
        path,
        &arguments,
        "another microslip process works in this folder",
    );
    assert!(first.wait().unwrap().success());
    assert_same_results(path, "results");
}
