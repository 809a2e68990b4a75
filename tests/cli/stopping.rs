//! `samples = { until = ..., at_most = ... }`: as many samples as a rule takes.

use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

use super::bad_input::assert_refused;
use super::test_functions::{UNIFORM, study};
use super::{change, microslip, succeed};

/// A study of u + 6 exp(…) of x and u, with `samples` as given; x is fixed far from where it matters, so that the result is u.
fn write(samples: &str, limit: f64, seed: u64) -> TempDir {
    let fixed = "distribution = \"fixed\"\nvalue = 0.9";
    let criterion = format!(
        "[[criteria]]\nname = \"amplitude\"\nquantity = \"amplitude-um\"\nlimit = {limit:?}\n"
    );
    let inputs = [fixed, UNIFORM];
    let folder = study("narrow-worst-case", &inputs, "monte-carlo", 10, &criterion);
    change(
        folder.path(),
        "samples = 10",
        &format!("samples = {samples}"),
    );
    change(folder.path(), "seed = 7", &format!("seed = {seed}"));
    folder
}

fn run(folder: &Path, threads: &str) -> Value {
    succeed(
        folder,
        &["run", "study.toml", "--quiet", "--threads", threads],
    );
    report(folder)
}

fn report(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("results/report.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// All looks of the run, the last one that of its samples.
fn looks(report: &Value) -> Vec<u64> {
    let looks = report["stopping"]["looks"].as_array().unwrap();
    let looks: Vec<u64> = looks.iter().map(|n| n.as_u64().unwrap()).collect();
    let samples = report["samples"].as_u64();
    assert_eq!(
        looks.last(),
        samples.as_ref(),
        "the last look is that of the run"
    );
    looks
}

/// A limit far above the quantile is decided at the first look that can pass (73 samples without one beyond it, for half of
/// the risk), one far below it too, one close to it at a later one, and one at it never: then the study stops at the most,
/// undecided. Seen to fail (0.97 at 150) with the whole risk at every look.
#[test]
fn a_study_stops_where_its_criteria_are_decided() {
    let rule = "{ until = \"decided\", at_most = 1200 }";
    for (limit, judgement, expected) in [
        (1.5, "PASS", vec![75]),
        (0.88, "FAIL", vec![75]),
        (0.92, "FAIL", vec![75, 150, 300, 600]),
        (0.97, "PASS", vec![75, 150, 300, 600, 1200]),
        (0.95, "UNDECIDED", vec![75, 150, 300, 600, 1200]),
    ] {
        let folder = write(rule, limit, 7);
        let found = run(folder.path(), "2");
        assert_eq!(found["criteria"][0]["judgement"], judgement, "{limit}");
        assert_eq!(looks(&found), expected, "{limit}");
        assert_eq!(found["stopping"]["met"], judgement != "UNDECIDED");
    }
}

/// The verdict and the bounds of the report have the confidence of the look: ranks of 99.17 % (a sixth of 5 % at the second
/// look), not of 95 %; the page says so, and `inspect` where it will look. Seen to fail with the stated confidence.
#[test]
fn what_is_reported_has_the_confidence_of_the_look() {
    let rule = "{ until = \"width\", of = \"amplitude\", relative = 0.4, at_most = 320 }";
    let folder = write(rule, 2.0, 7);
    let facts = succeed(folder.path(), &["inspect", "study.toml"]);
    assert!(facts.contains("at most 320 x 1"), "{facts}");
    assert!(facts.contains(
        "judged at           40, 80, 160, 320 samples, until the interval of the 50 % quantile"
    ));
    let found = run(folder.path(), "2");
    let looks = looks(&found);
    let j = looks.len() as f64;
    assert!(looks.len() > 1, "{looks:?}");
    let text = std::fs::read_to_string(folder.path().join("results/summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    let median = &summary["levels"][0]["amplitude_m"]["quantiles"][1];
    let n = looks[looks.len() - 1] as usize;
    let confidence = 1.0 - 0.05 / (j * (j + 1.0));
    let (ranks, _) = microslip::statistics::order_statistic_interval(n, 0.5, confidence).unwrap();
    let (plain, _) = microslip::statistics::order_statistic_interval(n, 0.5, 0.95).unwrap();
    assert_eq!(median["ranks"], serde_json::json!([ranks.0, ranks.1]));
    assert_ne!(ranks, plain);
    let width = median["interval"]["upper"].as_f64().unwrap()
        - median["interval"]["lower"].as_f64().unwrap();
    assert!(width <= 0.4 * median["estimate"].as_f64().unwrap());
    let page = std::fs::read_to_string(folder.path().join("results/report.html")).unwrap();
    let words = format!("it is computed at {:.2} %", 100.0 * confidence);
    assert!(page.contains(&words), "{words}");
}

/// The same files with one thread and with three, and from an extension to twice the most, which goes on where the rule was
/// not met; an extension to another number or of a rule that was met is refused. Seen to fail with the looks of an extension
/// counted from its own first one.
#[test]
fn an_extension_is_the_whole_run() {
    let at_most = |n: u64| format!("{{ until = \"decided\", at_most = {n} }}");
    let whole = write(&at_most(1200), 0.92, 7);
    let expected = looks(&run(whole.path(), "1"));
    let folder = write(&at_most(150), 0.92, 7);
    assert_eq!(
        run(folder.path(), "3")["criteria"][0]["judgement"],
        "UNDECIDED"
    );
    let extend = |samples: &str| {
        let arguments = ["extend", "results", "--samples", samples, "--quiet"];
        microslip(folder.path(), &arguments)
    };
    assert_refused(
        "300 + 1",
        &extend("301"),
        &["--samples 301: must be 150 times 2, 4, 8"],
    );
    assert!(extend("1200").status.success());
    for name in ["samples.parquet", "atlas.parquet", "report.json"] {
        let read = |of: &TempDir| std::fs::read(of.path().join("results").join(name)).unwrap();
        assert!(read(&folder) == read(&whole), "{name} differs");
    }
    assert_eq!(looks(&report(folder.path())), expected);
    assert_refused(
        "met",
        &extend("2400"),
        &["its rule was met with 600 samples (every criterion is decided)"],
    );
}

/// What is said to decide can be done: after a rule that was met, with a file that has more rows, and with one that has not. Seen to fail
/// with an `extend` that is refused.
#[test]
fn what_decides_is_not_refused() {
    let sentence = |folder: &TempDir| {
        let criterion = run(folder.path(), "2")["criteria"][0].clone();
        assert_eq!(criterion["judgement"], "UNDECIDED");
        criterion["sentence"].as_str().unwrap().to_owned()
    };
    let rule = "{ until = \"width\", of = \"amplitude\", relative = 1, at_most = 320 }";
    let folder = write(rule, 0.97, 7);
    let said = sentence(&folder);
    let start = "samples needed: the rule of `samples` was met, `run` the study with `samples = ";
    let (_, number) = said.split_once(start).expect(&said);
    let (number, _) = number.split_once('`').unwrap();
    change(folder.path(), rule, number);
    succeed(folder.path(), &["run", "study.toml", "--quiet"]);

    let criterion = "[[criteria]]\nname = \"amplitude\"\nquantity = \"amplitude-um\"\nlimit = 2\n";
    let more = format!("path = \"rows.csv\"\n{criterion}");
    for (rows, words) in [
        (
            20,
            "59 samples needed: the file of samples has 20 rows, add as many and `run` it anew",
        ),
        (
            80,
            "59 samples needed: `microslip extend RESULTS --samples 59`",
        ),
    ] {
        let folder = study("narrow-worst-case", &[], "file", 20, &more);
        let row = |i: u32| format!("0.9,{}\n", (f64::from(i) + 0.5) / f64::from(rows));
        let table: String = (0..rows).map(row).collect();
        let table = format!("stiffness_scale,normal_stiffness_scale\n{table}");
        std::fs::write(folder.path().join("rows.csv"), table).unwrap();
        let said = sentence(&folder);
        assert!(said.contains(words), "{said}");
        if rows == 80 {
            succeed(
                folder.path(),
                &["extend", "results", "--samples", "59", "--quiet"],
            );
            assert_eq!(report(folder.path())["criteria"][0]["judgement"], "PASS");
        }
    }
}

/// Rules whose design does not let them keep their confidence. Those without sense in themselves are in `bad_input::cases`.
/// Seen to fail without the checks.
#[test]
fn rules_of_other_designs_are_refused() {
    let epistemic = "kind = \"epistemic\"\nlower = 0.1\nupper = 0.9";
    for (at_most, old, new, words) in [
        (
            100,
            "kind = \"monte-carlo\"",
            "kind = \"latin-hypercube\"",
            "samples = (table): must be a number in a design of kind \"latin-hypercube\"",
        ),
        (
            110,
            "distribution = \"fixed\"\nvalue = 0.9",
            epistemic,
            "samples = (table): must be a number with epistemic inputs",
        ),
    ] {
        let rule = format!("{{ until = \"decided\", at_most = {at_most} }}");
        let folder = write(&rule, 2.0, 7);
        change(folder.path(), old, new);
        let output = microslip(folder.path(), &["inspect", "study.toml"]);
        assert_refused(new, &output, &[":3: ", words]);
    }
}
