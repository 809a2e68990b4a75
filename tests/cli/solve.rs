//! `solve` from study file to result files, against solutions of published codes.

use std::path::Path;

use crate::{microslip, reference_study};

/// The study file of a published-code comparison, solved by the command: every coefficient to 1e-9 of the largest.
///
/// Seen to fail with the slider's two laps replaced by one.
#[test]
fn solve_reproduces_the_reference_solutions_of_three_problems() {
    for case in ["jenkins-1dof", "varying-normal-3dof", "blades-strip-oop"] {
        let (folder, study) = reference_study(case);
        let fixed = Path::new("tests/reference").join(case).join("fixed.json");
        let fixed = std::fs::read_to_string(fixed).unwrap();
        for solution in serde_json::from_str::<Vec<Fixed>>(&fixed).unwrap() {
            let text = solution.study(&study);
            std::fs::write(folder.path().join("study.toml"), text).unwrap();
            let output = microslip(
                folder.path(),
                &["solve", "study.toml", "--output", "out", "--quiet"],
            );
            assert_eq!(output.status.code(), Some(0), "{case}: {output:?}");
            assert!(
                output.stdout.is_empty() && output.stderr.is_empty(),
                "{case}: not quiet"
            );
            solution.assert_equals(case, &folder.path().join("out/solution.json"));
        }
    }
}

/// `solution.json` of a study in which lines are replaced: the function is given what stands before " = ", and the line.
fn solved_with(study: &str, replaced: impl Fn(&str, &str) -> Option<String>) -> serde_json::Value {
    let lines = study.lines().map(|line| {
        let (key, _) = line.split_once(" = ").unwrap_or((line, ""));
        replaced(key, line).unwrap_or_else(|| line.to_owned())
    });
    let folder = tempfile::tempdir().unwrap();
    let text = lines.collect::<Vec<_>>().join("\n");
    std::fs::write(folder.path().join("study.toml"), text).unwrap();
    let output = microslip(folder.path(), &["solve", "study.toml", "--output", "out"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let json = std::fs::read_to_string(folder.path().join("out/solution.json")).unwrap();
    serde_json::from_str(&json).unwrap()
}

/// Towards the frictionless limit: the amplitude of the default study near its peak falls short of it in proportion to a
/// small friction coefficient. Seen to fail with sweeps that start from the stuck structure: no answer at 1e-3 within a minute;
/// and without the start from the structure that slides without friction: no answer at 1e-7.
#[test]
fn small_friction_coefficients_are_solved() {
    let study = std::fs::read_to_string("studies/two-blade-strip/study.toml").unwrap();
    let inputs = study.find("[inputs.friction_coefficient]").unwrap();
    let solver = study.find("[solver]").unwrap();
    let study = format!("{}{}", &study[..inputs], &study[solver..]);
    let amplitude = |mu: &str| {
        let json = solved_with(&study, |key, line| match key {
            "levels" => Some("levels = [5.0]".to_owned()),
            "friction_coefficient" => Some(format!("friction_coefficient = {mu}")),
            "band_hz" => Some(format!("{line}\nvalues_hz = [2622]")),
            _ => None,
        });
        let point = &json["levels"][0]["points"][0];
        assert_eq!(point["status"], "converged", "{mu}");
        json["levels"][0]["largest_amplitude"]["amplitude"]
            .as_f64()
            .unwrap()
    };
    let [small, smaller, hardly_any, none] = ["1e-3", "1e-4", "1e-7", "0"].map(amplitude);
    let losses = [small, smaller].map(|amplitude| 1.0 - amplitude / none);
    println!("{none:e} m without friction, losses {losses:?}");
    assert!((0.005..0.02).contains(&losses[0]), "{losses:?}");
    let ratio = losses[0] / losses[1];
    assert!((8.0..11.0).contains(&ratio), "{ratio}");
    let last = (hardly_any / none - 1.0).abs();
    assert!(last < 1e-4, "{last:e} at 1e-7");
}

/// Next to a fold of the branch a frequency of a list has the answer that a sweep on many harmonics meets there, to its stated error. Seen to fail
/// where any solution on more harmonics counts as the same answer: 4.38 um in place of 5.90.
#[test]
fn more_harmonics_leave_the_answer_on_its_branch() {
    let study = include_str!("../../studies/two-blade-strip/study.toml");
    let solved = |solver: &str| -> Vec<serde_json::Value> {
        let json = solved_with(study, |key, line| match key {
            "levels" => Some("levels = [4.996623173330271]".to_owned()),
            "kind" => Some(format!("{line}\ncontact_nodes = [2, 2]")),
            "friction_coefficient" => Some("friction_coefficient = 0.6156299462796861".to_owned()),
            "harmonics" | "alert" => Some(String::new()),
            "[solver]" => Some(format!("{line}\n{solver}")),
            "band_hz" => Some(
                "band_hz = [2605, 2635]\nsweep = \"downward\"\n\
                 values_hz = [2623.456, 2623.48, 2623.5231549312916, 2623.6]"
                    .to_owned(),
            ),
            _ => None,
        });
        json["levels"][0]["points"].as_array().unwrap().clone()
    };
    let amplitude = |point: &serde_json::Value| {
        let first = &point["responses"]["blade1.airfoil.x"];
        f64::hypot(first[1].as_f64().unwrap(), first[2].as_f64().unwrap())
    };
    let many = solved("harmonics = 14\nalert = false");
    let raised = solved("harmonics = 5\nalert = { threshold = 0.01, highest_harmonic = 14 }");
    let mut certified = 0;
    for (point, exact) in raised.iter().zip(&many) {
        let error = (amplitude(point) / amplitude(exact) - 1.0).abs();
        println!("{} {error:e} {}", point["frequency_hz"], point["status"]);
        assert!(error < 0.06, "{point}");
        if point["status"] == "converged" {
            certified += 1;
            assert!(
                error <= point["truncation_error"].as_f64().unwrap(),
                "{point}"
            );
        }
    }
    assert!(certified > 0, "no answer is certified");
}

/// One entry of `fixed.json`.
#[derive(serde::Deserialize)]
struct Fixed {
    law: String,
    loops: Option<usize>,
    #[serde(rename = "H")]
    highest_harmonic: usize,
    #[serde(rename = "Nt")]
    time_points: usize,
    level: f64,
    unit: String,
    frequency: Vec<f64>,
    dof_names: Vec<String>,
    harmonics: Vec<Vec<Vec<f64>>>,
}

impl Fixed {
    /// The case's study with this entry's settings.
    fn study(&self, text: &str) -> String {
        let laps = self
            .loops
            .map_or("\"periodic\"".to_owned(), |n| n.to_string());
        let unit = if self.unit == "Hz" { "hz" } else { "rad_s" };
        let lines = text.lines().map(|line| match line.split(" = ").next() {
            Some("levels") => format!("levels = [{}]", self.level),
            Some("law") => format!("law = \"{}\"", self.law),
            Some("harmonics") => format!("harmonics = {}\nlaps = {laps}", self.highest_harmonic),
            Some("time_points") => format!("time_points = {}", self.time_points),
            Some("points") => format!("values_{unit} = {:?}", self.frequency),
            _ => line.to_owned(),
        });
        lines.collect::<Vec<_>>().join("\n")
    }

    fn assert_equals(&self, case: &str, file: &Path) {
        let text = std::fs::read_to_string(file).unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        let points = json["levels"][0]["points"].as_array().unwrap();
        assert_eq!(points.len(), self.frequency.len(), "{case}");
        for (point, expected) in points.iter().zip(&self.harmonics) {
            let scale = expected
                .iter()
                .flatten()
                .fold(0.0_f64, |m, x| m.max(x.abs()));
            for (i, name) in self.dof_names.iter().enumerate() {
                let found = point["responses"][name].as_array().unwrap();
                assert_eq!(found.len(), expected.len(), "{case}");
                for (found, row) in found.iter().zip(expected) {
                    let error = (found.as_f64().unwrap() - row[i]).abs() / scale;
                    assert!(
                        error < 1e-9,
                        "{case}, level {}, {name}: off by {error:e}",
                        self.level
                    );
                }
            }
        }
    }
}

/// Without `responses` every degree of freedom is one, and a downward sweep keeps the order of the frequencies.
///
/// Seen to fail with the solutions of a downward sweep left in the order of solving.
#[test]
fn every_degree_of_freedom_is_a_response_by_default() {
    let folder = crate::folder("study.toml", "responses = [\"x1\"]\n", "");
    let study = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&study).unwrap();
    let values = "values_hz = [110, 150]\nsweep = \"downward\"";
    let band = "band_hz = [100, 200]";
    std::fs::write(&study, text.replace(band, &format!("{band}\n{values}"))).unwrap();
    let output = microslip(folder.path(), &["solve", "study.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let file = folder.path().join("results/solution.json");
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let points = json["levels"][0]["points"].as_array().unwrap();
    for (point, frequency) in points.iter().zip([110.0, 150.0]) {
        assert!((point["frequency_hz"].as_f64().unwrap() - frequency).abs() < 1e-9);
        let names: Vec<_> = point["responses"].as_object().unwrap().keys().collect();
        assert_eq!(names, ["x1", "x2"]);
    }
}

/// Runs `solve` on the two masses with the line `old` of the study replaced; gives its text, `curve.csv` and
/// `solution.json`.
fn solved(old: &str, new: &str) -> (String, String, serde_json::Value) {
    let folder = crate::folder("study.toml", old, new);
    let output = microslip(folder.path(), &["solve", "study.toml"]);
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let code = i32::from(text.contains("STOPPED"));
    assert_eq!(output.status.code(), Some(code), "{output:?}");
    let read = |file: &str| std::fs::read_to_string(folder.path().join("results").join(file));
    let json = serde_json::from_str(&read("solution.json").unwrap()).unwrap();
    (text, read("curve.csv").unwrap(), json)
}

/// A peak is called so where the curve has one; at the edge of a band that misses it the text says that.
#[test]
fn a_band_without_the_resonance_says_so() {
    let (text, _, json) = solved("", "");
    assert!(text.contains(", peak "), "{text}");
    let largest = &json["levels"][0]["largest_amplitude"];
    assert_eq!(largest["is"], "maximum");
    let (text, _, json) = solved("band_hz = [100, 200]", "band_hz = [100, 150]");
    let first = text.lines().next().unwrap();
    assert!(
        first.contains("the resonance lies outside the band"),
        "{text}"
    );
    assert!(!first.contains(", peak "), "{text}");
    let level = &json["levels"][0];
    assert_eq!(level["largest_amplitude"]["is"], "at-edge");
    assert!(level["gap"].is_null());
    let edge = level["largest_amplitude"]["frequency_hz"].as_f64().unwrap();
    assert!((edge - 150.0).abs() < 1e-9, "{edge}");
}

/// Warnings stay with `--quiet`: a curve that stops, which has an exit code of its own, and a level without any solution. Seen to fail with
/// the programs before: one was silent, a later one ended with 0.
#[test]
fn what_is_not_solved_is_a_warning() {
    let few = |command: &str, budget: &str| {
        let new = format!("time_points = 128\nbudget = {budget}");
        let folder = crate::folder("study.toml", "time_points = 128", &new);
        let output = microslip(folder.path(), &[command, "study.toml", "--quiet"]);
        assert!(output.stdout.is_empty(), "{output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), text)
    };
    let (code, text) = few("solve", "60");
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("warning: level ") && text.contains(" is not known"),
        "{text}"
    );
    let (code, text) = few("run", "3");
    assert_eq!(code, Some(0), "samples are data: {text}");
    assert!(
        text.contains("warning: level 2: no sample has a solution"),
        "{text}"
    );
    assert_eq!(few("solve", "100000"), (Some(0), String::new()));
}

/// A sweep that cannot go on (its budget is 60 Newton iterations) is no success: text, table and record say where and why.
#[test]
fn a_curve_that_stops_says_where_and_why() {
    let (text, csv, json) = solved("time_points = 128", "time_points = 128\nbudget = 60");
    println!("{text}");
    assert!(text.contains("STOPPED: from below at "), "{text}");
    assert!(text.contains("budget-spent"), "{text}");
    assert!(!text.contains(", peak "), "{text}");
    assert!(csv.contains(",budget-spent,,"), "{csv}");
    assert!(!csv.contains("NaN"), "{csv}");
    let level = (json["levels"].as_array().unwrap().iter())
        .find(|level| !level["gap"].is_null())
        .unwrap();
    let end = |side: &str| level["gap"][side]["frequency_hz"].as_f64().unwrap();
    assert!(100.0 <= end("below") && end("below") < end("above") && end("above") <= 200.0);
    assert_eq!(level["gap"]["below"]["status"], "budget-spent");
    assert_eq!(level["largest_amplitude"]["is"], "of-part");
}

/// A peak that is not certified says so beside its amplitude. Seen to fail with the amplitude alone.
#[test]
fn a_peak_that_is_not_certified_says_so() {
    let said = |harmonics: &str| {
        let study = std::fs::read_to_string("studies/own-matrices/study.toml").unwrap();
        let study = study.replace("levels = [1.0, 20.0]", "levels = [20.0]");
        let solver =
            format!("[solver]\n{harmonics}\nalert = {{ threshold = 1e-4 }}\n\n[frequency]");
        let (folder, study) = in_own_folder(study.replace("[frequency]", &solver));
        let output = microslip(folder.path(), &["solve", &study, "--output", "out"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let few = said("harmonics = 1");
    assert!(
        few.contains(", peak ") && few.contains("Hz (not certified: the harmonics above 1 "),
        "{few}"
    );
    let many = said("harmonics = 21");
    assert!(
        many.contains(", peak ") && !many.contains("not certified"),
        "{many}"
    );
}

/// The damper of this study is held along the blades by friction alone. Seen to fail, without file and key, for a structure with all
/// contacts stuck.
#[test]
fn a_rest_that_only_friction_holds_is_refused_as_a_start() {
    let study = std::fs::read_to_string("studies/own-matrices/study.toml").unwrap();
    let anchored = "[contact]\nanchor = \"static-equilibrium\"\n\n[frequency]";
    let (folder, study) = in_own_folder(study.replace("[frequency]", anchored));
    for command in ["inspect", "solve"] {
        let output = microslip(folder.path(), &[command, &study]);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        let place = "study.toml:46: contact.anchor = \"static-equilibrium\": without friction";
        assert!(said.contains(place), "{said}");
    }
}

/// A study of `studies/own-matrices` with its files.
fn in_own_folder(study: String) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    for file in ["mass.mtx", "stiffness.mtx"] {
        let from = Path::new("studies/own-matrices").join(file);
        std::fs::copy(from, folder.path().join(file)).unwrap();
    }
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    (folder, "study.toml".to_owned())
}
