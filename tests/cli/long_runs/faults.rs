//! Faults of the machine under a run: little memory, a disk that is full, a folder that becomes read-only, an output that nobody reads, wrong clocks.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

use super::super::test_functions::LIMIT_STATE;
use super::super::{STUDY, folder, microslip};
use super::{assert_same_results, change, parts, run, solved};
use assert_cmd::cargo::cargo_bin;
use microslip::ensemble::parts::{Claims, PartFolder};

const SAMPLES: u64 = 120;

/// `unshare` with the given options; nothing where the machine does not let a user have a namespace of their own in which the
/// `trial` succeeds.
fn unshared(options: &[&str], trial: &str) -> Option<Command> {
    let mut command = Command::new("unshare");
    command.args(options).args(["sh", "-c", trial]);
    let tried = command.status().is_ok_and(|s| s.success());
    if !tried {
        eprintln!("not tried: this machine has no unshare {options:?}");
        return None;
    }
    let mut command = Command::new("unshare");
    command.args(options);
    Some(command)
}

/// Of the scripts on a disk of 64 MB at `disk`, on which the whole results of another seed lie: `measure` notes what it holds, `leave` lets it
/// have so many more kB, `refused` runs the study and finds the reason in one line (after the warning that other results would be replaced) and the older results as they were, `as_undisturbed`
/// compares what is there with a run elsewhere.
const ON_A_SMALL_DISK: &str = r#"set -e
    measure() { used=$(df -k --output=used disk | tail -1); }
    leave() { mount -o remount,size=$((used + $1))k disk; }
    refused() {
        status=0
        "$MICROSLIP" run study.toml --quiet "$@" --output disk/results 2> message || status=$?
        cat message
        test $status = 2
        grep -q 'No space left' message
        grep -q 'the same command goes on' message
        test "$(grep -vc '^warning: replaces' message)" = 1
        for file in samples.parquet curves.parquet atlas.parquet run.json report.html; do
            cmp whole/$file disk/results/$file
        done
    }
    as_undisturbed() {
        "$MICROSLIP" run study.toml --quiet --output other
        for file in samples.parquet curves.parquet; do
            cmp other/$file disk/results/$file
        done
    }
    mount -t tmpfs -o size=64M tmpfs disk
    cp -r whole disk/results
"#;

/// Runs a script after [`ON_A_SMALL_DISK`], where the machine has namespaces.
fn on_a_small_disk(script: &str) {
    let study = solved(SAMPLES);
    std::fs::create_dir(study.path().join("disk")).unwrap();
    let Some(mut command) = unshared(&["-rm"], "mount -t tmpfs -o size=1M tmpfs /tmp") else {
        return;
    };
    let output = command
        .current_dir(study.path())
        .env("MICROSLIP", cargo_bin("microslip"))
        .args(["sh", "-c", &format!("{ON_A_SMALL_DISK}{script}")])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
}

/// On a disk that fills up while parts or results are written, the run ends with the reason, older results are as they were, and
/// with more room the same command goes on. Seen to fail with the error of a part ignored, with tables written in their places, and without
/// the word that the same command goes on, of parts (results fail in the test after this one).
#[test]
fn a_full_disk_destroys_nothing() {
    let script = r#"
        measure
        sed -i 's/seed = 7/seed = 8/' study.toml
        for room in 16 128 600; do
            leave $room
            refused --flush-every 20ms
        done
        mount -o remount,size=64M disk
        "$MICROSLIP" run study.toml --quiet --output disk/results
        as_undisturbed"#;
    on_a_small_disk(script);
}

/// Where all samples are solved and their results find no room on the disk, the run ends with the reason, older results are as they were,
/// and no sample is solved again once there is room.
///
/// Seen to fail with the tables written in their places, of which 1200 kB hold all but the report.
#[test]
fn results_without_room_are_not_placed() {
    let script = r#"
        sed -i 's/seed = 7/seed = 8/' study.toml
        "$MICROSLIP" run study.toml --quiet --shard 0/1 --output disk/results
        measure
        for room in 8 64 600 1200; do
            leave $room
            refused
        done
        mount -o remount,size=64M disk
        "$MICROSLIP" run study.toml --output disk/results > said 2>&1
        cat said
        grep -q '120 samples were solved before and taken over' said
        as_undisturbed
        test ! -e disk/results/.unfinished"#;
    on_a_small_disk(script);
}

/// A folder that takes no more files ends the run with the reason; once it does again, the same command goes on.
/// Seen to fail with the error of a part ignored.
#[cfg(unix)]
#[test]
fn a_folder_that_becomes_read_only_ends_the_run() {
    use std::os::unix::fs::PermissionsExt;
    let study = solved(SAMPLES);
    let path = study.path();
    // nobody may write where the permissions forbid it, not even the user `root`
    let Some(mut command) = unshared(&["-U"], "true") else {
        return;
    };
    let arguments = ["run", "study.toml", "--quiet", "--flush-every", "20ms"];
    let child = command
        .current_dir(path)
        .arg(cargo_bin("microslip"))
        .args(arguments)
        .args(["--output", "results"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    super::wait_for_a_part(path, "results");
    let folder = path.join("results/parts");
    let allow = |mode: u32| {
        std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    allow(0o555);
    let output = child.wait_with_output().unwrap();
    allow(0o755);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("Permission denied"), "{message}");
    assert!(message.contains("the same command goes on"), "{message}");
    assert!(!parts(path, "results").is_empty(), "what was written stays");
    run(path, "results", &["--quiet"]);
    assert_same_results(path, "results");
}

/// A reader of the output that goes away costs no result. Seen to fail with `println!`, which panics.
#[test]
fn closed_outputs_cost_nothing() {
    let study = solved(SAMPLES);
    let path = study.path();
    for (number, log) in ["text", "json"].iter().enumerate() {
        let output = format!("results-{number}");
        let mut child = Command::new(cargo_bin("microslip"))
            .current_dir(path)
            .args([
                "run",
                "study.toml",
                "--profile",
                "--log",
                log,
                "--output",
                &output,
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop((child.stdout.take(), child.stderr.take()));
        assert!(child.wait().unwrap().success(), "{log}");
        assert_same_results(path, &output);
    }
}

/// Sets the time of a file.
fn date(path: &Path, time: SystemTime) {
    let file = std::fs::File::options().write(true).open(path).unwrap();
    file.set_modified(time).unwrap();
}

/// The clock of another node, or one that jumps, makes no claim void: only one's own clock decides how long a claim stands still.
/// Seen to fail with the time of the file compared with the time now.
#[test]
fn a_wrong_clock_makes_no_claim_void() {
    let folder = tempfile::tempdir().unwrap();
    let parts = PartFolder::of(folder.path());
    let claim = Claims::of(&parts).unwrap().take("7").unwrap();
    assert!(claim.is_some(), "nobody had it");
    let file = parts.path().join("claims/7");
    let mut others = Claims::of(&parts).unwrap();
    let years = |n: u64| Duration::from_secs(n * 365 * 86_400);
    for time in [
        SystemTime::UNIX_EPOCH,
        SystemTime::UNIX_EPOCH + years(200),
        SystemTime::now() - years(1),
    ] {
        date(&file, time);
        assert!(others.take("7").unwrap().is_none(), "{time:?}");
        assert!(file.exists(), "the claim is void at {time:?}");
    }
}

/// A panic of the work ends the claim: a thread that went on refreshing it would keep this process and all others waiting.
#[test]
fn a_claim_ends_with_a_panic_of_its_work() {
    let folder = tempfile::tempdir().unwrap();
    let parts = PartFolder::of(folder.path());
    let claim = Claims::of(&parts).unwrap().take("7").unwrap().unwrap();
    let held = std::panic::AssertUnwindSafe(|| claim.hold(|| panic!("the work")));
    assert!(std::panic::catch_unwind(held).is_err());
    drop(claim);
    let mut others = Claims::of(&parts).unwrap();
    assert!(others.take("7").unwrap().is_some(), "still claimed");
}

/// Parts whose files bear any time are taken over. Seen to fail with parts of the future left out.
#[test]
fn times_of_parts_do_not_matter() {
    let study = solved(SAMPLES);
    let path = study.path();
    super::killed_after(path, "results", 2);
    let found = PartFolder::of(&path.join("results")).list().unwrap();
    let solved: usize = found
        .iter()
        .map(|p| p.as_ref().unwrap().samples.len())
        .sum();
    let future = SystemTime::now() + Duration::from_secs(86_400);
    for (name, time) in parts(path, "results")
        .iter()
        .zip([future, SystemTime::UNIX_EPOCH].iter().cycle())
    {
        date(&path.join("results/parts").join(name), *time);
    }
    let text = run(path, "results", &[]);
    let expected = format!("{solved} samples were solved before and taken over");
    assert!(text.contains(&expected), "{expected}: {text}");
    assert_same_results(path, "results");
}

/// Where the memory has no room for a sample on each thread, fewer are solved at once, with the same results; where it has none for
/// one, the run says so before it begins. Seen to fail with as many samples at once as threads.
#[test]
#[cfg(target_os = "linux")]
fn little_memory_means_fewer_samples_at_once() {
    // each solve on 200 harmonics takes hundreds of megabytes, as far as the estimate knows; a function stands for it
    let [resistance, load] = LIMIT_STATE;
    let inputs = format!(
        "[inputs.stiffness_scale]\n{resistance}\n[inputs.normal_stiffness_scale]\n{load}\n[output]\n"
    );
    let study = folder("study.toml", "[output]\n", &inputs);
    let path = study.path();
    let friction = &STUDY[STUDY.find("[inputs.friction_coefficient]").unwrap()..];
    change(path, &friction[..friction.find("[solver]").unwrap()], "");
    change(
        path,
        "seed = 7",
        "seed = 7\ntest_function = \"limit-state\"",
    );
    change(path, "harmonics = 5", "harmonics = 200\nalert = false");
    change(path, "time_points = 128", "time_points = 1024");
    change(path, "band_hz = [100, 200]", "band_hz = [50, 1000]");
    let pairs = (2..7).map(|pair| {
        let contact = &STUDY[STUDY.find("[[model.contact]]").unwrap()..];
        let contact = &contact[..contact.find("[contact]").unwrap()];
        contact.replace("\"c1\"", &format!("\"c{pair}\""))
    });
    let pairs: String = pairs.chain(["[contact]\n".to_owned()]).collect();
    change(path, "[contact]\n", &pairs);
    let limited = |kilobytes: u64, output: &str| {
        let script = format!(
            "ulimit -v {kilobytes} && exec \"$0\" run study.toml --quiet --threads 8 --output {output}"
        );
        let mut command = Command::new("sh");
        command.args(["-c", &script]).arg(cargo_bin("microslip"));
        let output = command.current_dir(path).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), said)
    };
    run(path, "whole", &["--quiet"]);
    let (code, said) = limited(2_000_000, "few");
    assert_eq!(code, Some(0), "{said}");
    let (number, rest) = said.split_once(" of 8 threads solve: ").expect(&said);
    let number: usize = number.rsplit(' ').next().unwrap().parse().unwrap();
    assert!((1..8).contains(&number), "{said}");
    assert!(rest.starts_with("a sample takes up to 6"), "{said}");
    assert_same_results(path, "few");
    let (code, said) = limited(300_000, "none");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("MB are available: fewer harmonics"), "{said}");
}

/// The stated memory is that of the largest harmonic set on which a solution is compared, 20 at least. Seen to fail with twice the
/// highest harmonic of the alert.
#[test]
fn the_stated_memory_is_that_of_the_largest_comparison() {
    let stated = |highest: usize| {
        let folder = tempfile::tempdir().unwrap();
        let study = include_str!("../../../studies/two-blade-strip/study.toml");
        // no nominal peak is solved for the time of assessments
        let alert = format!("highest_harmonic = {highest} }}\nstability = \"off\"");
        let study = study.replace("highest_harmonic = 56 }", &alert);
        std::fs::write(folder.path().join("study.toml"), study).unwrap();
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let facts = String::from_utf8(output.stdout).unwrap();
        let line = facts.lines().find(|line| line.starts_with("memory"));
        line.unwrap().to_owned()
    };
    assert_eq!(stated(5), stated(10));
    assert_ne!(stated(10), stated(28));
}
