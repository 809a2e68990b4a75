//! `[design]`, `[correlation]` and `[epistemic]` from study file to result files.

use super::{STUDY, folder, microslip};

const SECOND: &str =
    "[inputs.stiffness_scale]\ndistribution = \"log-uniform\"\nlow = 0.5\nhigh = 2\n";

const SURROGATE: &str = "[surrogate]\nkind = \"polynomial-chaos\"\n";

/// What `inspect` says about a design, or its message; `head` replaces the line of samples, `tail` comes last.
fn inspect(head: &str, tail: &str) -> Result<String, String> {
    let folder = folder("study.toml", "samples = 10", "samples = 10");
    let text = STUDY.replace("samples = 10\n", head);
    std::fs::write(folder.path().join("study.toml"), format!("{text}\n{tail}")).unwrap();
    std::fs::write(folder.path().join("good.csv"), "stiffness_scale\n1\n2\n3\n").unwrap();
    std::fs::write(folder.path().join("bad.csv"), "stiffness_scale\n1\nx\n").unwrap();
    std::fs::write(folder.path().join("gap.csv"), "stiffness_scale\n1\n\n3\n\n").unwrap();
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    if output.status.success() {
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let line = text
            .lines()
            .find(|line| line.starts_with("design  "))
            .unwrap();
        Ok(line["design".len()..].trim().to_owned())
    } else {
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

#[test]
fn inspect_shows_the_design() {
    let epistemic = "[inputs.stiffness_scale]\nkind = \"epistemic\"\nlower = 0.1\nupper = 10\n";
    let pair = "[correlation]\npairs = [{ inputs = [\"stiffness_scale\", \"friction_coefficient\"], value = 0.5 }]\n";
    let cases = [
        ("samples = 10\n", String::new(), "monte-carlo, 10 samples"),
        (
            "samples = 20\n",
            "[design]\nkind = \"latin-hypercube\"".to_owned(),
            "latin-hypercube, 20 samples",
        ),
        (
            "samples = 64\n",
            format!("[design]\nkind = \"sobol\"\nreplicates = 4\n{SECOND}{pair}"),
            "sobol, 4 replicates of 16 points, correlated (stiffness_scale and friction_coefficient 0.5 of the normal scores)",
        ),
        (
            "samples = 64\n",
            format!("[design]\nkind = \"pick-freeze\"\n{SECOND}"),
            "pick-freeze, 16 rows of 4 samples",
        ),
        (
            "",
            format!("[design]\nkind = \"grid\"\npoints = 5\n{SECOND}"),
            "grid of 5 x 5 points",
        ),
        (
            "",
            "[design]\nkind = \"file\"\npath = \"good.csv\"".to_owned(),
            "file, 3 samples",
        ),
        (
            "samples = 60\n",
            format!("{epistemic}[epistemic]\npoints = 3"),
            "monte-carlo, 10 samples at each of 6 outer points",
        ),
    ];
    for (head, tail, expected) in cases {
        assert_eq!(inspect(head, &tail).unwrap(), expected);
    }
}

/// Names of the inputs of the study, and its number of samples.
const K: &str = "stiffness_scale";
const MU: &str = "friction_coefficient";
const TEN: &str = "samples = 10\n";

fn pairs(list: &str) -> String {
    format!("{SECOND}[correlation]\npairs = [{list}]\n")
}

fn pair(a: &str, b: &str, value: f64) -> String {
    format!("{{ inputs = [\"{a}\", \"{b}\"], value = {value} }}")
}

fn epistemic(lower: f64, more: &str) -> String {
    format!("[inputs.stiffness_scale]\nkind = \"epistemic\"\nlower = {lower}\nupper = 3\n{more}")
}

/// What begins and ends a study, and a part of the message that it gets.
fn refuse(cases: &[(&str, String, &str)]) {
    for (head, tail, expected) in cases {
        let message = inspect(head, tail).unwrap_err();
        assert!(
            message.contains(expected),
            "{tail}: {expected:?} is not in: {message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

/// Seen to fail with the keys of other kinds ignored.
#[test]
fn bad_sobol_design_names_line_key_and_rule() {
    refuse(&[
        (
            TEN,
            "[design]\nkind = \"halton\"".to_owned(),
            ":42: design.kind: ",
        ),
        (
            TEN,
            "[design]\nkind = \"sobol\"".to_owned(),
            ":3: samples = 10: must be a power of two: 8 or 16",
        ),
        (
            TEN,
            "[design]\nkind = \"sobol\"\nreplicates = 3".to_owned(),
            "a power of two times 3 replicates: 6 or 12",
        ),
        (
            TEN,
            "[design]\nkind = \"sobol\"\nreplicates = 0".to_owned(),
            ":43: design.replicates = 0: must be from 1",
        ),
        (
            TEN,
            "[design]\nkind = \"sobol\"\npoints = 3".to_owned(),
            ":43: design.points = (given): must be absent",
        ),
    ]);
}

#[test]
fn bad_pick_freeze_design_names_line_key_and_rule() {
    refuse(&[
        (
            TEN,
            format!("[design]\nkind = \"pick-freeze\"\n{SECOND}"),
            ":3: samples = 10: must be a power of two times 4 (2 and one per input): 8 or 16",
        ),
        (
            "",
            "[design]\nkind = \"pick-freeze\"".to_owned(),
            "samples = (absent): must be given",
        ),
        (
            TEN,
            "[design]\nkind = \"pick-freeze\"\nreplicates = 2".to_owned(),
            ":43: design.replicates = (given): must be absent",
        ),
        (
            TEN,
            "[design]\nkind = \"pick-freeze\"\npath = \"good.csv\"".to_owned(),
            ":43: design.path = (given): must be absent",
        ),
        (
            "samples = 8\n",
            format!(
                "[design]\nkind = \"pick-freeze\"\n{}",
                pairs(&pair(K, MU, 0.5))
            ),
            ": correlation = (given): must be absent: with correlated inputs Sobol' indices are no shares",
        ),
        (
            "samples = 33\n",
            format!("{}[design]\nkind = \"pick-freeze\"", epistemic(1.0, "")),
            ":42: inputs.stiffness_scale.kind = \"epistemic\": must be \"aleatory\" in a pick-freeze design",
        ),
    ]);
}

#[test]
fn bad_grid_or_hypercube_names_line_key_and_rule() {
    refuse(&[
        (
            TEN,
            "[design]\nkind = \"grid\"".to_owned(),
            ":41: design.points = (absent): must be given",
        ),
        (
            TEN,
            "[design]\nkind = \"grid\"\npoints = 3".to_owned(),
            ":3: samples = 10: must be the number of grid points, 3",
        ),
        (
            "",
            "[design]\nkind = \"grid\"\npoints = 0".to_owned(),
            "design.points = 0: must be at least 1",
        ),
        (
            "",
            "[design]\nkind = \"grid\"\npoints = { mu = 3 }".to_owned(),
            "design.points.mu = (given): must name an input",
        ),
        (
            "",
            "[design]\nkind = \"latin-hypercube\"".to_owned(),
            "samples = (absent): must be given",
        ),
        (
            "samples = 1\n",
            format!("[design]\nkind = \"latin-hypercube\"\n{SECOND}"),
            ":3: samples = 1: must be more",
        ),
    ]);
}

#[test]
fn bad_file_of_samples_names_line_key_and_rule() {
    refuse(&[
        (
            TEN,
            "[design]\nkind = \"file\"".to_owned(),
            "design.path = (absent): must be given",
        ),
        (
            TEN,
            "[design]\nkind = \"file\"\npath = \"none.csv\"".to_owned(),
            "design.path = \"none.csv\": must name a file: there is no ",
        ),
        (
            TEN,
            "[design]\nkind = \"file\"\npath = \"bad.csv\"".to_owned(),
            "bad.csv:3: stiffness_scale = \"x\": must be a number",
        ),
        (
            TEN,
            "[design]\nkind = \"file\"\npath = \"gap.csv\"".to_owned(),
            "gap.csv:3: must have no empty line between values",
        ),
        (
            TEN,
            "[design]\nkind = \"file\"\npath = \"good.csv\"".to_owned(),
            ":3: samples = 10: must be at most 3: the file has 3 rows",
        ),
        (
            "",
            format!("[design]\nkind = \"file\"\npath = \"good.csv\"\n{SECOND}"),
            "inputs.stiffness_scale = (given): must be absent: it is a column",
        ),
    ]);
}

#[test]
fn bad_correlation_names_line_key_and_rule() {
    refuse(&[
        (
            TEN,
            pairs(""),
            ":46: correlation.pairs = []: must not be empty",
        ),
        (
            TEN,
            pairs(&pair(K, MU, 1.5)),
            ":46: correlation.pairs[0].value = 1.5: must be between",
        ),
        (
            TEN,
            pairs(&pair(K, K, 0.5)),
            ":46: correlation.pairs[0].inputs = ",
        ),
        (
            TEN,
            pairs(&pair(K, "mu", 0.5)),
            ":46: correlation.pairs[0].inputs = \"mu\": must be inputs with a distribution",
        ),
    ]);
}

#[test]
fn bad_epistemic_names_line_key_and_rule() {
    refuse(&[
        (
            TEN,
            epistemic(-1.0, ""),
            ":43: inputs.stiffness_scale.lower = -1: must be > 0",
        ),
        (
            TEN,
            epistemic(4.0, ""),
            ":44: inputs.stiffness_scale.upper = 3: must be greater than lower",
        ),
        (
            TEN,
            epistemic(1.0, "value = 3"),
            ":45: inputs.stiffness_scale.value = 3: must be absent",
        ),
        (
            TEN,
            format!("{SECOND}scale = \"log\""),
            "inputs.stiffness_scale.scale = (given): must be absent: only an input of kind \"epistemic\"",
        ),
        (
            TEN,
            epistemic(1.0, "scale = \"decades\""),
            ":45: inputs.stiffness_scale.scale: ",
        ),
        (
            TEN,
            epistemic(1.0, ""),
            ":3: samples = 10: must be a multiple of the 11 outer points",
        ),
        (
            TEN,
            epistemic(1.0, "[epistemic]\nkind = \"grid\"\npoints = 1"),
            ":47: epistemic.points = 1: must be at least 2",
        ),
        (
            TEN,
            epistemic(1.0, "[epistemic]\nsearch = 10001"),
            ":46: epistemic.search = 10001: must be at most 10000",
        ),
        (
            TEN,
            "[epistemic]\npoints = 1".to_owned(),
            ":41: epistemic = (given): must be absent: no input",
        ),
    ]);
}

#[test]
fn bad_surrogate_names_line_key_and_rule() {
    refuse(&[
        (
            TEN,
            format!("{SURROGATE}hold_out = 0.9"),
            ":43: surrogate.hold_out = 0.9: must be from 0.05 to 0.5",
        ),
        (
            TEN,
            "[surrogate]\nkind = \"kriging\"".to_owned(),
            ":42: surrogate.kind: ",
        ),
        (
            TEN,
            format!("{}{SURROGATE}", pairs(&pair(K, MU, 0.5))),
            ":47: surrogate = (table): must be absent: inputs are correlated",
        ),
        (
            "samples = 11\n",
            epistemic(1.0, SURROGATE),
            "surrogate = (table): must be absent: an epistemic input has no distribution",
        ),
        (
            "",
            format!("[design]\nkind = \"file\"\npath = \"good.csv\"\n{SURROGATE}"),
            "surrogate = (table): must be absent: inputs from a file have no distribution",
        ),
    ]);
}

/// Every sample knows its outer point or its replicate, and the values of one outer point are the same throughout.
#[test]
fn samples_know_their_outer_point_and_replicate() {
    let tail = "[inputs.stiffness_scale]\nkind = \"epistemic\"\nlower = 0.5\nupper = 2\n\
                [epistemic]\npoints = 0\n[design]\nkind = \"sobol\"\nreplicates = 2\n";
    let folder = folder("study.toml", "samples = 10", "samples = 12");
    let text = std::fs::read_to_string(folder.path().join("study.toml")).unwrap();
    std::fs::write(folder.path().join("study.toml"), format!("{text}\n{tail}")).unwrap();
    let output = microslip(folder.path(), &["run", "study.toml", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let path = folder.path().join("results/samples.parquet");
    let stored = microslip::ensemble::store::read_samples(&path).unwrap();
    for outcome in &stored.outcomes {
        let outer = outcome.group.outer.unwrap();
        assert_eq!(u64::from(outer), outcome.index % 3);
        assert_eq!(
            outcome.group.replicate,
            Some((outcome.index / 3 % 2) as u32)
        );
        assert_eq!(outcome.inputs[0], [0.5, 2.0, 1.25][outer as usize]);
    }
    let friction = |i: usize| stored.outcomes[i].inputs[1];
    assert_eq!([friction(0), friction(1)], [friction(1), friction(2)]);
    assert_ne!(friction(0), friction(3));
}

/// Warnings of `inspect` where the friction coefficients stand in a file.
fn warnings_of_column(values: &str) -> Vec<String> {
    let table =
        "[inputs.friction_coefficient]\ndistribution = \"uniform\"\nlow = 0.1\nhigh = 0.8\n";
    let folder = folder("study.toml", table, "");
    let path = folder.path().join("study.toml");
    let study = std::fs::read_to_string(&path).unwrap();
    let study = study.replace("samples = 10\n", "");
    let design = "[design]\nkind = \"file\"\npath = \"mu.csv\"\n";
    std::fs::write(&path, format!("{study}\n{design}")).unwrap();
    let column = format!("friction_coefficient\n{values}");
    std::fs::write(folder.path().join("mu.csv"), column).unwrap();
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let warnings = text.lines().filter(|line| line.starts_with("warning"));
    warnings.map(str::to_owned).collect()
}

/// A column of a file is judged by its own values, and the message names the file. Seen to fail with the distribution that stands for the
/// scale of a column: every one had a warning of 0.0095 in the study file.
#[test]
fn unusual_values_of_a_file_are_those_in_it() {
    let usual = warnings_of_column("0.3\n0.4\n0.5\n");
    assert!(usual.is_empty(), "{usual:?}");
    let unusual = warnings_of_column("0.3\n3.5\n0.4\n");
    let expected = "mu.csv: friction_coefficient = 3.5: is unusual: usual is 0.05 to 1.5";
    assert_eq!(unusual.len(), 1, "{unusual:?}");
    assert!(unusual[0].contains(expected), "{unusual:?}");
}
