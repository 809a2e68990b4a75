//! What all parts of a run have in common, and how two runs differ.

use super::super::program::Program;
use super::super::store::StoredStudy;
use crate::file::FileRecord;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A run: study, files that it reads, program. Its samples are a function of these.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunIdentity {
    /// The study file.
    pub study: StoredStudy,
    /// The files that the study names.
    pub files: Vec<FileRecord>,
    /// Who solves.
    pub program: Program,
}

/// Why samples do not belong to a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Difference {
    /// Another study: the lines that it has not (`-`), and those that only it has (`+`).
    Study(Vec<String>),
    /// Files that the study names have another content.
    Files(Vec<String>),
    /// Another program, or another instruction set.
    Program(Program),
}

impl Difference {
    /// `advice` where another program is the difference, which may be ignored.
    #[must_use]
    pub fn advice_on_program<'a>(&self, advice: &'a str) -> &'a str {
        match self {
            Self::Program(_) => advice,
            Self::Study(_) | Self::Files(_) => "",
        }
    }
}

impl RunIdentity {
    /// How the run `other` differs from this one, if it does. Comments and the order of keys are no difference.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        if !same_values(&self.study.text, &other.study.text) {
            let lines = different_lines(&other.study.text, &self.study.text);
            return Some(Difference::Study(lines));
        }
        if self.files != other.files {
            let differs = |file: &&FileRecord| !other.files.contains(file);
            let names = self.files.iter().filter(differs);
            return Some(Difference::Files(names.map(|f| f.name.clone()).collect()));
        }
        (self.program != other.program).then(|| Difference::Program(other.program.clone()))
    }

    /// Whether the studies of the two differ, but in nothing that changes a sample: name, `[operation]` (but for the engine orders of a
    /// disk), `[stress]` and `[[criteria]]`.
    #[must_use]
    pub fn has_other_requirements(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|of| &of.study.text);
        let samples = without_requirements(own);
        !same_values(own, others) && samples.is_some() && samples == without_requirements(others)
    }
}

/// Whether two study files say the same.
fn same_values(a: &str, b: &str) -> bool {
    let values = |text: &str| text.parse::<toml::Table>().ok();
    a == b || values(a).is_some_and(|table| Some(table) == values(b))
}

/// `model.kind` of a disk: its engine order excites a wave of it, and that of any other model only says where margins are looked for.
const DISK: &str = "cyclic";
const OPERATION: &str = "operation";

/// The values of a study file without those that change no sample, but only what is asked of all. Of the operation the engine orders of a disk
/// are left.
fn without_requirements(text: &str) -> Option<toml::Table> {
    let mut table = text.parse::<toml::Table>().ok()?;
    for key in ["name", "criteria", "stress"] {
        table.remove(key);
    }
    let operation = table.remove(OPERATION);
    let kind = table.get("model").and_then(|model| model.get("kind"));
    if kind.and_then(toml::Value::as_str) == Some(DISK) {
        let orders = operation.and_then(|operation| operation.get("engine_orders").cloned());
        table.extend(orders.map(|orders| (OPERATION.to_owned(), orders)));
    }
    Some(table)
}

/// The same without the engine orders of a disk.
fn without_operation(text: &str) -> Option<toml::Table> {
    let mut table = without_requirements(text)?;
    table.remove(OPERATION);
    Some(table)
}

/// Number of samples of the study `stored`, if it is the study `own` with more of them, such as `extend` makes, whatever its requirements.
#[must_use]
pub fn more_samples(own: &str, stored: &str) -> Option<i64> {
    more(own, stored, without_requirements)
}

/// The same, whatever the engine order of a disk.
#[must_use]
pub fn more_samples_of_any_order(own: &str, stored: &str) -> Option<i64> {
    more(own, stored, without_operation)
}

fn more(own: &str, stored: &str, compared: fn(&str) -> Option<toml::Table>) -> Option<i64> {
    let parted = |text: &str| {
        let mut table = compared(text)?;
        let number = match table.remove("samples") {
            Some(toml::Value::Table(mut rule)) => {
                let most = rule.remove("at_most");
                table.insert("samples".to_owned(), toml::Value::Table(rule));
                most
            }
            number => number,
        };
        Some((number.and_then(|n| n.as_integer()).unwrap_or(0), table))
    };
    let ((own, of_own), (stored, of_stored)) = (parted(own)?, parted(stored)?);
    (stored > own && of_stored == of_own).then_some(stored)
}

/// Lines of `old` that are not in `new`, then those of `new` that are not in `old`; with their numbers.
fn different_lines(old: &str, new: &str) -> Vec<String> {
    let only = |sign: char, of: &str, other: &str| -> Vec<String> {
        let there: Vec<&str> = other.lines().map(str::trim).collect();
        let lines = (1..).zip(of.lines().map(str::trim));
        lines
            .filter(|(_, line)| !there.contains(line))
            .map(|(number, line)| format!("{sign}{number}: {line}"))
            .collect()
    };
    [only('-', old, new), only('+', new, old)].concat()
}

/// Lines of a study that a message names.
const MOST_LINES: usize = 8;

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Study(lines) => {
                let shown = &lines[..lines.len().min(MOST_LINES)];
                write!(f, "another study ({}", shown.join("; "))?;
                match lines.len() - shown.len() {
                    0 => write!(f, ")"),
                    more => write!(f, "; and {more} more lines)"),
                }
            }
            Self::Files(names) => write!(f, "another content of {}", names.join(", ")),
            Self::Program(program) => write!(f, "another program ({})", program.in_words()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(text: &str, hash: &str, version: &str) -> RunIdentity {
        RunIdentity {
            study: StoredStudy {
                text: text.to_owned(),
                path: "study.toml".to_owned(),
            },
            files: vec![FileRecord {
                name: "mass.mtx".to_owned(),
                blake3: hash.to_owned(),
            }],
            program: Program {
                version: version.to_owned(),
                commit: None,
                instruction_set: "avx2".to_owned(),
            },
        }
    }

    /// Seen to fail with texts compared as such, and without the comparison of files.
    #[test]
    fn differences_are_named() {
        let own = run("seed = 1\nsamples = 4\n", "a", "1");
        let said = |other: &RunIdentity| own.difference(other).map(|d| d.to_string());
        let spaced = run("# a comment\nsamples = 4\nseed   = 1\n", "a", "1");
        assert_eq!(said(&spaced), None);
        let other = run("seed = 2\nsamples = 4\n", "b", "2");
        let expected = "another study (-1: seed = 2; +1: seed = 1)";
        assert_eq!(said(&other).as_deref(), Some(expected));
        let other = run("seed = 1\nsamples = 4\n", "b", "2");
        let expected = "another content of mass.mtx";
        assert_eq!(said(&other).as_deref(), Some(expected));
        let other = run("seed = 1\nsamples = 4\n", "a", "2");
        let expected = "another program (2 on avx2)";
        assert_eq!(said(&other).as_deref(), Some(expected));
    }

    /// Seen to fail with criteria compared, with engine orders of a disk that are not, and with those of other models that are.
    #[test]
    fn requirements_change_no_sample() {
        let study = |requirements: &str| run(&format!("seed = 1\n{requirements}"), "a", "1");
        let own = study("[operation]\nengine_orders = [3]\nspeed_rpm = [1.0, 2.0]\n");
        let differs = |text: &str| own.has_other_requirements(&study(text));
        assert!(!differs(&own.study.text["seed = 1\n".len()..]), "the same");
        assert!(differs("[operation]\nengine_orders = [3]\n"), "speeds");
        let more = "[operation]\nengine_orders = [3]\n[[criteria]]\nlimit = 1.0\n";
        assert!(differs(more), "criteria");
        assert!(differs("[operation]\nengine_orders = [4]\n"), "orders");
        assert!(differs("[stress]\nmean_stress_mpa = 4\n"), "no orders");
        let disk = |order: u32, samples: u32| {
            let text = format!(
                "samples = {samples}\n[model]\nkind = \"cyclic\"\n[operation]\nengine_orders = [{order}]\nspeed_rpm = [1.0, {order}.0]\n"
            );
            study(&text)
        };
        let (three, four) = (disk(3, 9), disk(4, 9));
        assert!(!three.has_other_requirements(&four), "order of a disk");
        let (own, stored) = (&three.study.text, &disk(4, 10).study.text);
        assert_eq!(more_samples(own, stored), None);
        assert_eq!(more_samples_of_any_order(own, stored), Some(10));
        let other = "[operation]\nengine_orders = [3]\n[output]\ncurve_samples = 3\n";
        assert!(!differs(other), "curves");
        let longer = "samples = 40\n[[criteria]]\nlimit = 1.0\n";
        assert_eq!(more_samples("samples = 10\n", longer), Some(40));
    }

    /// Seen to fail with other keys not compared, and with the numbers compared the other way around.
    #[test]
    fn longer_runs_of_a_study_are_known() {
        let study = |samples: &str, seed: u32| format!("seed = {seed}\nsamples = {samples}\n");
        let own = study("10", 1);
        assert_eq!(more_samples(&own, &study("40 # more", 1)), Some(40));
        assert_eq!(more_samples(&own, &study("4", 1)), None);
        assert_eq!(more_samples(&own, &study("10", 1)), None);
        assert_eq!(more_samples(&own, &study("40", 2)), None);
        let rule = |most: u32, width: f64| {
            let rule = format!("{{ until = 'width', width = {width}, at_most = {most} }}");
            study(&rule, 1)
        };
        let own = rule(100, 0.1);
        assert_eq!(more_samples(&own, &rule(200, 0.1)), Some(200));
        assert_eq!(more_samples(&own, &rule(200, 0.2)), None);
    }
}
