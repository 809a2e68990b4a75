//! Signals, kills at any time, and what the next command makes of it.

use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;
use std::time::{Duration, Instant};

use super::super::test_functions;
use super::{
    assert_same_results, change, killed_after, microslip, parts, refused, run, solved, start, study,
};
use assert_cmd::cargo::CommandCargoExt;
use microslip::ensemble::store::read_samples;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Kills at least.
const KILLS: usize = 50;
/// Samples of a run that is killed so often.
const SAMPLES: u64 = 400;

/// Half a hundred times a run is killed at a random moment, on one thread or on two, and then runs to its end: the same bits.
/// Seen to fail with a generation of which some samples were known left out of the anchors, and with parts that are read without
/// their curves.
#[test]
fn kills_at_random_change_no_bit() {
    let study = solved(SAMPLES);
    let path = study.path();
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let (mut kills, mut ends) = (0, 0);
    while kills < KILLS {
        let threads = if random.random_bool(0.5) { "1" } else { "2" };
        let before = parts(path, "killed").len();
        // files of a part; without a new one the run is killed before its first part
        let more = 3 * random.random_range(0..4);
        let mut child = start(path, "killed", "20ms", &["--threads", threads]);
        let pause = |random: &mut ChaCha8Rng, most| {
            std::thread::sleep(Duration::from_millis(random.random_range(0..most)));
        };
        let mut ended = child.try_wait().unwrap();
        while ended.is_none() && parts(path, "killed").len() < before + more {
            pause(&mut random, 5);
            ended = child.try_wait().unwrap();
        }
        pause(&mut random, 30);
        match ended.or(child.try_wait().unwrap()) {
            Some(status) => {
                assert!(status.success(), "{status:?}");
                assert_same_results(path, "killed");
                std::fs::remove_dir_all(path.join("killed")).unwrap();
                ends += 1;
            }
            None => {
                child.kill().unwrap();
                child.wait().unwrap();
                kills += 1;
            }
        }
    }
    let text = run(path, "killed", &[]);
    println!("{ends} runs ended before the last one: {text}");
    assert_same_results(path, "killed");
    let known = text.contains("samples were solved before and taken over");
    assert!(ends > 0 || known, "nothing was taken over: {text}");
}

/// A kill may also come while the results are placed: the next reader finishes. Seen to fail with a reader that does not.
#[test]
fn results_that_were_being_placed_are_whole() {
    let study = solved(6);
    let path = study.path();
    run(path, "placed", &["--quiet"]);
    let placing = path.join("placed/.placing");
    std::fs::create_dir(&placing).unwrap();
    for name in ["samples.parquet", "report.json"] {
        std::fs::rename(path.join("placed").join(name), placing.join(name)).unwrap();
    }
    let report = microslip(path, &["report", "placed", "--quiet"]);
    assert!(report.status.success(), "{report:?}");
    assert_same_results(path, "placed");
}

/// SIGTERM ends a run within five seconds, with exit code 3 and a line that says how to go on; nothing that was solved is lost.
/// Seen to fail with a stop that nobody looks at, with exit code 2, and with parts that are not read.
#[cfg(unix)]
#[test]
fn a_terminated_run_goes_on() {
    let study = solved(SAMPLES);
    let path = study.path();
    // one part an hour: what is kept was written because of the signal
    let mut child = std::process::Command::cargo_bin("microslip")
        .unwrap()
        .current_dir(path)
        .args(["run", "study.toml", "--output", "ended"])
        .args(["--flush-every", "1h"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut message = String::new();
    // the first line of progress
    said.read_line(&mut message).unwrap();
    let clock = Instant::now();
    crate::terminate(&child);
    let status = child.wait().unwrap();
    assert!(
        clock.elapsed() < Duration::from_secs(5),
        "{:?}",
        clock.elapsed()
    );
    said.read_to_string(&mut message).unwrap();
    assert_eq!(status.code(), Some(3), "{message}");
    assert!(message.contains("the same command goes on"), "{message}");
    let (_, stopped) = message.split_once("stopped: ").unwrap();
    let done: u64 = stopped.split(' ').next().unwrap().parse().unwrap();
    let status = microslip(path, &["status", "ended"]);
    let status = String::from_utf8_lossy(&status.stdout).into_owned();
    let expected = format!("unfinished: {done} of {SAMPLES} samples, 0 without");
    assert!(done > 0 && status.contains(&expected), "{done}: {status}");
    let text = run(path, "ended", &[]);
    let expected = format!("{done} samples were solved before and taken over");
    assert!(text.contains(&expected), "{text}");
    assert_same_results(path, "ended");
}

/// The same by the clock. Seen to fail with the option ignored.
#[test]
fn a_run_stops_after_the_time_asked_for() {
    let study = study(SAMPLES);
    let path = study.path();
    let arguments = ["run", "study.toml", "--quiet", "--stop-after", "300ms"];
    let stopped = microslip(path, &arguments);
    assert_eq!(stopped.status.code(), Some(3), "{stopped:?}");
    let message = String::from_utf8_lossy(&stopped.stderr);
    assert!(message.contains("the same command goes on"), "{message}");
    let wrong = microslip(path, &["run", "study.toml", "--stop-after", "soon"]);
    assert_eq!(wrong.status.code(), Some(2), "{wrong:?}");
}

/// Whole results of the same study are not solved again; of another one they are replaced, and not before the new ones are whole.
/// Seen to fail with results that are solved anew.
#[test]
fn older_results_stay_until_new_ones_are_whole() {
    let study = solved(SAMPLES);
    let path = study.path();
    let changed = |name: &str| {
        std::fs::metadata(path.join("whole").join(name))
            .unwrap()
            .modified()
            .unwrap()
    };
    let before = changed("samples.parquet");
    let text = run(path, "whole", &[]);
    assert!(
        text.contains(&format!("{SAMPLES} samples were solved before")),
        "{text}"
    );
    assert_eq!(changed("samples.parquet"), before, "solved again");
    let old = std::fs::read(path.join("whole/samples.parquet")).unwrap();
    change(path, "seed = 7", "seed = 8");
    killed_after(path, "whole", 2);
    let verified = microslip(path, &["verify", "whole"]);
    assert!(verified.status.success(), "{verified:?}");
    assert!(
        std::fs::read(path.join("whole/samples.parquet")).unwrap() == old,
        "not the old ones"
    );
    run(path, "whole", &["--quiet"]);
    assert!(
        std::fs::read(path.join("whole/samples.parquet")).unwrap() != old,
        "the old ones"
    );
}

/// A killed extension goes on, too, and `run` does not take its parts for those of the shorter study.
/// Seen to fail with parts that are not looked at, and with a status that knows the samples of the parts alone.
#[test]
fn a_killed_extension_goes_on() {
    let study = study(40);
    let path = study.path();
    run(path, "extended", &["--quiet"]);
    let n = SAMPLES.to_string();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("microslip"))
        .current_dir(path)
        .args([
            "extend",
            "extended",
            "--samples",
            &n,
            "--quiet",
            "--flush-every",
            "20ms",
        ])
        .spawn()
        .unwrap();
    while parts(path, "extended").len() < 6 {
        assert!(
            child.try_wait().unwrap().is_none(),
            "the run ended before it was killed"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    refused(
        path,
        &["run", "study.toml", "--output", "extended"],
        "holds samples of another study",
    );
    let status = microslip(path, &["status", "extended"]).stdout;
    let status = String::from_utf8_lossy(&status);
    let goes_on = format!("`extend --samples {n}` of this folder goes on");
    assert!(status.contains(&goes_on), "{status}");
    assert!(
        !status.contains("missing: 0 to"),
        "samples of the results: {status}"
    );
    let done = microslip(path, &["extend", "extended", "--samples", &n]);
    assert!(done.status.success(), "{done:?}");
    change(path, "samples = 40", &format!("samples = {SAMPLES}"));
    run(path, "whole", &["--quiet"]);
    assert_same_results(path, "extended");
}

/// A defect of the program in one sample is a status of that sample. Seen to fail without the isolation: the run ends.
#[test]
fn a_panic_costs_one_sample() {
    let uniform = "distribution = \"uniform\"\nlow = 0.0\nhigh = 1.0";
    let study = test_functions::study("panicking", &[uniform], "monte-carlo", 50, "");
    let path = study.path();
    run(path, "results", &["--quiet"]);
    let stored = read_samples(&path.join("results/samples.parquet")).unwrap();
    let mut panicked = 0;
    for outcome in &stored.outcomes {
        let level = &outcome.levels[0];
        assert_eq!(level.status.name() == "panicked", outcome.inputs[0] > 0.8);
        panicked += usize::from(level.peak.is_none());
    }
    assert!((1..50).contains(&panicked), "{panicked}");
    let summary = std::fs::read_to_string(path.join("results/summary.json")).unwrap();
    assert!(summary.contains("panicked"), "{summary}");
}

/// A command for whole results says of a run that is not finished that its command goes on.
/// Seen to fail with the words of a folder without a run.
#[test]
fn an_unfinished_run_has_no_report() {
    let study = study(SAMPLES);
    let path = study.path();
    killed_after(path, "results", 2);
    let expected = "the command that began it goes on (`microslip status` shows";
    refused(path, &["report", "results"], expected);
}

/// However seldom parts are written, none has more samples than fit into the memory with ease.
/// Seen to fail with parts by the clock alone.
#[test]
fn a_part_has_4096_samples_at_most() {
    let uniform = "distribution = \"uniform\"\nlow = 0.0\nhigh = 1.0";
    let study = test_functions::study("panicking", &[uniform], "monte-carlo", 9000, "");
    let path = study.path();
    let share = ["--shard", "0/1", "--quiet", "--flush-every", "1h"];
    run(path, "results", &share);
    let found = microslip::ensemble::parts::PartFolder::of(&path.join("results"));
    let sizes = found.list().unwrap().into_iter();
    let sizes: Vec<usize> = sizes.map(|part| part.unwrap().samples.len()).collect();
    assert_eq!(sizes.iter().sum::<usize>(), 9000, "{sizes:?}");
    assert!(sizes.iter().all(|n| *n <= 4096), "{sizes:?}");
}
