//! `[inputs] from`: the joint distribution of an identification as the inputs of a study.

use std::path::Path;

use microslip::sampling::Input;
use microslip::study::Study;
use serde_json::Value;
use tempfile::TempDir;

use super::{STUDY, folder, microslip};

const TABLE: &str =
    "[inputs.friction_coefficient]\ndistribution = \"uniform\"\nlow = 0.1\nhigh = 0.8\n";
const FROM: &str = "[inputs]\nfrom = \"identified.json\"\n";

/// Friction and both stiffnesses; the nominal ones of the study are 0.2 and 1 N/µm.
const ALL: &str = r#"{ "format": 1,
  "inputs": [
    { "parameter": "friction_coefficient", "shape": { "lognormal": { "median": 0.4, "log_standard_deviation": 0.1 } } },
    { "parameter": "tangential_stiffness_n_per_um", "shape": { "lognormal": { "median": 0.1, "log_standard_deviation": 0.3 } } },
    { "parameter": "normal_stiffness_n_per_um", "shape": { "uniform": { "low": 1.5, "high": 2.5 } } }
  ],
  "correlation": [[1.0, -0.6, 0.0], [-0.6, 1.0, 0.5], [0.0, 0.5, 1.0]] }
"#;
/// The same without normal motion.
const TANGENTIAL: &str = r#"{ "format": 1,
  "inputs": [
    { "parameter": "friction_coefficient", "shape": { "lognormal": { "median": 0.4, "log_standard_deviation": 0.1 } } },
    { "parameter": "tangential_stiffness_n_per_um", "shape": { "lognormal": { "median": 0.1, "log_standard_deviation": 0.3 } } }
  ],
  "correlation": [[1.0, -0.6], [-0.6, 1.0]] }
"#;

/// Friction alone, as few specimens leave it: a part of it lies above 10.
const WIDE: &str = r#"{ "format": 1,
  "inputs": [
    { "parameter": "friction_coefficient", "shape": { "lognormal": { "median": 0.5, "log_standard_deviation": 2.0 } } }
  ],
  "correlation": [[1.0]] }
"#;

/// A folder with the study and `identified.json`; `inputs` stands in place of the table of the friction coefficient.
fn identified(json: &str, inputs: &str) -> TempDir {
    let folder = folder("study.toml", TABLE, inputs);
    std::fs::write(folder.path().join("identified.json"), json).unwrap();
    folder
}

fn study(json: &str, inputs: &str) -> Result<Study, String> {
    let folder = identified(json, inputs);
    Study::read(&folder.path().join("study.toml")).map_err(|error| error.to_string())
}

/// Mean and standard deviation of each column, and the correlation of the first two.
fn moments(columns: [Vec<f64>; 2]) -> ([[f64; 2]; 2], f64) {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let means = [mean(&columns[0]), mean(&columns[1])];
    let product = |a: usize, b: usize| {
        let both = columns[a].iter().zip(&columns[b]);
        let products: Vec<f64> = both.map(|(x, y)| (x - means[a]) * (y - means[b])).collect();
        mean(&products)
    };
    let [s, t] = [product(0, 0).sqrt(), product(1, 1).sqrt()];
    ([[means[0], s], [means[1], t]], product(0, 1) / (s * t))
}

/// The tail of a wide distribution ends at the largest value that can be meant, and the rest of it stays; one that lies beyond by more than
/// a half is refused. Seen to fail with the program before, which refused both and told the user to cut what no key can cut.
#[test]
fn the_tail_of_few_specimens_ends_at_the_largest_value() {
    let study = study(WIDE, FROM).unwrap();
    let samples: Vec<f64> = (0..4000).map(|i| study.design.sample(i)[0]).collect();
    let largest = samples.iter().copied().fold(0.0, f64::max);
    assert!((5.0..=10.0).contains(&largest), "{largest}");
    // 93.27 % of the whole lie below 10, and of these below 0.5: half of the whole
    let below = samples.iter().filter(|mu| **mu < 0.5).count() as f64 / 4000.0;
    assert!((below - 0.5 / 0.9327).abs() < 0.02, "{below}");
    let beyond = WIDE.replace("\"median\": 0.5", "\"median\": 20.0");
    let refused = crate::identified::study(&beyond, FROM).unwrap_err();
    assert!(
        refused.contains("must not give values above 10"),
        "{refused}"
    );
}

/// Samples have the medians, scatters and correlation of the file; stiffnesses are divided by the nominal ones. Seen to fail with
/// stiffnesses as they are.
#[test]
fn samples_have_the_joint_distribution_of_the_file() {
    let study = study(ALL, FROM).unwrap();
    let inputs: Vec<Input> = study.design.inputs().iter().map(|(i, _)| *i).collect();
    let expected = [
        Input::NormalStiffnessScale,
        Input::TangentialStiffnessScale,
        Input::FrictionCoefficient,
    ];
    assert_eq!(inputs, expected, "inputs of the study");
    let samples: Vec<_> = (0..4000).map(|i| study.design.sample(i)).collect();
    let ln = |j: usize| samples.iter().map(|s| s[j].ln()).collect::<Vec<f64>>();
    let ([[tangential, scatter], [friction, _]], correlation) = moments([ln(1), ln(2)]);
    assert!((tangential - 0.5_f64.ln()).abs() < 0.02, "{tangential}");
    assert!((scatter - 0.3).abs() < 0.02, "{scatter}");
    assert!((friction - 0.4_f64.ln()).abs() < 0.01, "{friction}");
    assert!((correlation + 0.6).abs() < 0.05, "{correlation}");
    let normal = samples.iter().map(|s| s[0]);
    let ends = normal.fold([9.0_f64, 0.0_f64], |[l, h], v| [l.min(v), h.max(v)]);
    assert!(ends[0] >= 1.5 && ends[1] <= 2.5, "{ends:?}");
}

/// Without normal motion both stiffnesses scale together, or the study states the normal one; it must say which. Seen to fail with the
/// tangential stiffness alone for both.
#[test]
fn an_unmeasured_normal_stiffness_is_stated() {
    let names = |study: Study| -> Vec<&str> {
        let inputs = study.design.inputs().iter();
        inputs.map(|(input, _)| input.name()).collect()
    };
    let together = format!("{FROM}normal_stiffness = \"with-tangential\"\n");
    let found = names(study(TANGENTIAL, &together).unwrap());
    assert_eq!(
        found,
        ["stiffness_scale", "friction_coefficient"],
        "together"
    );
    let own =
        format!("{FROM}[inputs.normal_stiffness_scale]\ndistribution = \"fixed\"\nvalue = 1\n");
    let found = names(study(TANGENTIAL, &own).unwrap());
    let expected = [
        "normal_stiffness_scale",
        "tangential_stiffness_scale",
        "friction_coefficient",
    ];
    assert_eq!(found, expected, "a table of its own");
    let error = study(TANGENTIAL, FROM).unwrap_err();
    for cure in [
        "study.toml:28: inputs.from",
        "[inputs.normal_stiffness_scale]",
        "normal_stiffness = \"with-tangential\"",
    ] {
        assert!(error.contains(cure), "{cure} is not in: {error}");
    }
}

const ABSENT: &str = "inputs.from = \"absent.json\": must name a file: there is no ";

/// What contradicts the file is refused with both places. Seen to fail where an input may be stated twice.
#[test]
fn what_contradicts_the_file_is_refused() {
    let pair = |a: &str, b: &str| {
        format!("{FROM}[correlation]\npairs = [{{ inputs = [\"{a}\", \"{b}\"], value = 0.3 }}]\n")
    };
    let friction = "friction_coefficient";
    let more = |text: &str| format!("{FROM}{text}");
    let scale = |name: &str| {
        more(&format!(
            "[inputs.{name}]\ndistribution = \"fixed\"\nvalue = 1\n"
        ))
    };
    let together = more("normal_stiffness = \"with-tangential\"\n");
    let grid = more("[design]\nkind = \"grid\"\npoints = 3\n");
    for (json, inputs, expected) in [
        (
            ALL,
            more(TABLE),
            "study.toml:29: inputs.friction_coefficient = (given): must be given once: inputs[0] of identified.json",
        ),
        (
            ALL,
            together,
            "study.toml:29: inputs.normal_stiffness = \"with-tangential\": must be absent: identified.json states a normal",
        ),
        (
            ALL,
            scale("stiffness_scale"),
            "study.toml:29: inputs.stiffness_scale = (given): must be absent: identified.json states",
        ),
        (
            ALL,
            pair(friction, "tangential_stiffness_scale"),
            "must be absent: identified.json states the correlation of these two, -0.6",
        ),
        (
            ALL,
            grid,
            "inputs.from = \"identified.json\", with correlated inputs: must be absent",
        ),
        (ALL, FROM.replace("identified", "absent"), ABSENT),
        (
            "{",
            FROM.to_owned(),
            "identified.json:1: is no file of `microslip identify`",
        ),
    ] {
        let error = study(json, &inputs).unwrap_err();
        assert!(error.contains(expected), "{expected} is not in: {error}");
    }
    let negative = ALL.replace("\"low\": 1.5", "\"low\": -1.5");
    let error = study(&negative, FROM).unwrap_err();
    let expected = "as input normal_stiffness_scale of the study inputs[2].distribution = uniform";
    assert!(
        error.contains("identified.json: ") && error.contains(expected),
        "{error}"
    );
}

/// `[correlation]` adds pairs of other inputs to those of the file. Seen to fail with those of the table alone.
#[test]
fn the_table_of_correlations_adds_pairs() {
    let inputs = format!(
        "{FROM}[inputs.damping_scale]\ndistribution = \"lognormal\"\nmedian = 1\nlog_standard_deviation = 0.2\n\
         [correlation]\npairs = [{{ inputs = [\"damping_scale\", \"friction_coefficient\"], value = 0.5 }}]\n"
    );
    let study = study(ALL, &inputs).unwrap();
    let samples: Vec<_> = (0..4000).map(|i| study.design.sample(i)).collect();
    let ln = |j: usize| samples.iter().map(|s| s[j].ln()).collect::<Vec<f64>>();
    let (_, added) = moments([ln(2), ln(3)]);
    let (_, kept) = moments([ln(1), ln(2)]);
    assert!((added - 0.5).abs() < 0.05, "added: {added}");
    assert!((kept + 0.6).abs() < 0.05, "kept: {kept}");
}

/// Sums over the pairs of an interface are the nominal stiffness; there must be one for all interfaces, in SI units. Seen to fail with
/// stiffnesses as they are in the file.
#[test]
fn the_nominal_stiffness_is_that_of_an_interface() {
    let second = |interface: u32, k_t1: &str| {
        let old = "[contact]\nlaw";
        let pair = format!(
            "[[model.contact]]\nname = \"c2\"\nt1 = {{ x2 = 1.0 }}\nk_t1 = {k_t1}\nmu = 0.3\nn_0 = 1.0\ninterface = {interface}\n"
        );
        let folder = identified(ALL, FROM);
        let path = folder.path().join("study.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replacen(old, &format!("{pair}\n{old}"), 1)).unwrap();
        Study::read(&path).map_err(|error| error.to_string())
    };
    let median = |study: Study| study.design.inputs()[1].1.quantile(0.5);
    // 0.1 N/µm over 0.2 + 0.2 of one interface, over 0.2 of each of two
    let found = median(second(0, "2e5").unwrap());
    assert!((found - 0.25).abs() < 1e-12, "{found}");
    let found = median(second(1, "2e5").unwrap());
    assert!((found - 0.5).abs() < 1e-12, "{found}");
    let error = second(1, "3e5").unwrap_err();
    let expected =
        "k_t1 of interface 0: 0.2 N/µm, k_t1 of interface 1: 0.3 N/µm: must have the same";
    assert!(error.contains(expected), "{error}");
    let study = STUDY.replace(TABLE, FROM).replace("band_hz", "band_rad_s");
    let folder = identified(ALL, FROM);
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let output = microslip(folder.path(), &["inspect", "study.toml"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(
        error.contains("inputs.from = (given): must be absent: it needs a model in SI"),
        "{error}"
    );
}

/// The file is part of the run: `inspect` and the report name it, `run.json` has its hash, a changed file is another study, and
/// `export` takes it along. Seen to fail with an export that leaves it out.
#[test]
fn the_file_is_part_of_the_run() {
    let folder = identified(ALL, FROM);
    let at = folder.path();
    let run = |arguments: &[&str]| microslip(at, arguments);
    let text = |output: &std::process::Output| {
        let [out, err] =
            [&output.stdout, &output.stderr].map(|t| String::from_utf8_lossy(t).into_owned());
        out + &err
    };
    let shown = text(&run(&["inspect", "study.toml"]));
    let line = "tangential_stiffness_scale";
    let line = (shown.lines()).find(|l| l.trim().starts_with(line) && l.contains("lognormal"));
    assert!(
        line.is_some_and(|l| l.ends_with("from identified.json")),
        "{shown}"
    );
    let done = run(&["run", "study.toml", "--quiet"]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let record = std::fs::read_to_string(at.join("results/run.json")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let files: Vec<_> = (record["files"].as_array().unwrap().iter())
        .map(|file| file["name"].as_str().unwrap())
        .collect();
    assert!(files.contains(&"identified.json"), "{files:?}");
    assert_eq!(record["inputs"][1]["origin"], "identified.json", "{record}");
    let page = std::fs::read_to_string(at.join("results/report.html")).unwrap();
    assert!(
        page.contains("from identified.json"),
        "the report names the file"
    );
    let prior =
        "[inputs.friction_coefficient]\ndistribution = \"uniform\"\nlow = 0.3\nhigh = 0.5\n";
    std::fs::write(at.join("prior.toml"), prior).unwrap();
    let refused = text(&run(&["reweight", "results", "--prior", "prior.toml"]));
    assert!(refused.contains("without correlated inputs"), "{refused}");
    let exported = run(&["export", "study.toml", "--output", "copy"]);
    assert_eq!(exported.status.code(), Some(0), "{}", text(&exported));
    assert!(
        Path::exists(&at.join("copy/identified.json")),
        "the export has the file"
    );
    std::fs::write(at.join("identified.json"), ALL.replace("0.4,", "0.5,")).unwrap();
    let refused = run(&["extend", "results", "--samples", "12"]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(
        text(&refused).contains("identified.json"),
        "{}",
        text(&refused)
    );
}
