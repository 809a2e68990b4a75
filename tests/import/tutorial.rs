//! The tutorial from a mesh to a report: every command on its page is run, with CalculiX, on a mesh that the test writes.
//!
//! Without the program `ccx` the test says so and passes, unless MICROSLIP_REQUIRE_CALCULIX is set.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use assert_cmd::cargo::cargo_bin;

use super::calculix_blade;

const PAGE: &str = include_str!("../../docs/src/tutorial-import.md");
const UNCERTAIN: &str = "studies/calculix-blade/uncertain.toml";

/// What the command prints, run by the shell in `folder`.
fn shell(folder: &Path, command: &str) -> String {
    let program = cargo_bin("microslip");
    let own = program.parent().unwrap().display().to_string();
    let path = format!("{own}:{}", std::env::var("PATH").unwrap_or_default());
    let output = Command::new("sh")
        .args(["-c", command])
        .env("PATH", path)
        .current_dir(folder)
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{command}: {output:?}");
    printed
}

fn has_calculix() -> bool {
    if Command::new("ccx").arg("-v").output().is_ok() {
        return true;
    }
    let required = std::env::var_os("MICROSLIP_REQUIRE_CALCULIX").is_some();
    assert!(
        !required,
        "MICROSLIP_REQUIRE_CALCULIX is set, but there is no ccx"
    );
    println!("not tried: there is no ccx");
    false
}

/// Commands of the page, in order.
fn commands() -> Vec<String> {
    let mut commands: Vec<String> = Vec::new();
    for line in PAGE.lines().filter_map(|line| line.strip_prefix("    ")) {
        match commands.last_mut().filter(|last| last.ends_with('\\')) {
            Some(last) => {
                last.pop();
                last.push_str(line);
            }
            None => commands.push(line.to_owned()),
        }
    }
    commands
}

/// Lines that the page shows as printed.
fn shown() -> Vec<&'static str> {
    let blocks = PAGE.split("```").skip(1).step_by(2);
    let printed = blocks.filter_map(|block| block.strip_prefix("text\n"));
    printed.flat_map(str::lines).collect()
}

/// Whether two lines have the same words, and numbers that agree to 1e-5: another processor may change the last digits.
fn same(shown: &str, printed: &str) -> bool {
    let close = |a: &str, b: &str| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-5 * a.abs(),
        _ => a == b,
    };
    let (mut a, mut b) = (shown.split_whitespace(), printed.split_whitespace());
    loop {
        match (a.next(), b.next()) {
            (None, None) => return true,
            (Some(a), Some(b)) if close(a, b) => {}
            _ => return false,
        }
    }
}

/// Frequencies (Hz) that CalculiX computes itself from the same mesh, to seven digits.
fn own_frequencies(folder: &Path) -> Vec<f64> {
    let deck = std::fs::read_to_string(folder.join("blade.inp")).unwrap();
    let deck = deck.replace(", SOLVER=MATRIXSTORAGE", "");
    std::fs::write(folder.join("own.inp"), deck).unwrap();
    shell(folder, "ccx own");
    let table = std::fs::read_to_string(folder.join("own.dat")).unwrap();
    let rows = table
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>());
    let rows = rows.skip_while(|words| words.first() != Some(&"1"));
    let rows = rows.take_while(|words| !words.is_empty());
    rows.map(|words| words[3].parse().unwrap()).collect()
}

/// Every command of the tutorial ends well and prints what the page shows; the frequencies of the import are CalculiX's own to
/// 1e-6; the report is there.
///
/// Seen to fail with the density of the mesh changed for CalculiX's own run, and with another figure on the page.
#[test]
fn every_command_of_the_tutorial_does_what_the_page_says() {
    if !has_calculix() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    calculix_blade::write(folder.path());
    std::fs::copy(UNCERTAIN, folder.path().join("uncertain.toml")).unwrap();
    let own = own_frequencies(folder.path());
    let mut printed = BTreeSet::new();
    let mut found = Vec::new();
    for command in commands() {
        for line in shell(folder.path(), &command).lines() {
            if let Some(numbers) = line
                .strip_prefix("free frequencies")
                .filter(|_| found.is_empty())
            {
                let words = numbers.split_whitespace();
                found = words.map_while(|word| word.parse::<f64>().ok()).collect();
            }
            printed.insert(line.to_owned());
        }
    }
    assert_eq!(found.len(), 10, "frequencies of the import");
    for (found, own) in found.iter().zip(&own) {
        let error = (found / own - 1.0).abs();
        assert!(error < 1e-6, "{found} Hz, CalculiX {own} Hz");
    }
    let is_printed = |line: &&str| printed.iter().any(|printed| same(line, printed));
    let shown = shown().into_iter();
    let missing: Vec<_> = shown.filter(|line| !is_printed(line)).collect();
    assert!(
        missing.is_empty(),
        "shown, but not printed:\n{}\nprinted:\n{}",
        missing.join("\n"),
        printed.into_iter().collect::<Vec<_>>().join("\n")
    );
    let report = std::fs::read_to_string(folder.path().join("results/report.html")).unwrap();
    assert!(
        report.contains("Distance from engine order 17"),
        "the report has its criterion"
    );
}
