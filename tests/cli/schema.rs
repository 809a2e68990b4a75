//! `schema`: what the program accepts is valid, and what it refuses by name or shape is not.

use std::path::Path;

use serde_json::Value;

use super::bad_input::cases::REFUSED;
use super::bad_input::disk_cases::{DISK, DISK_BEYOND_SCHEMA, DISK_REFUSED};
use super::bad_input::program_cases::BEYOND_SCHEMA;
use super::bad_input::rig_cases::{RIG, RIG_BEYOND_SCHEMA, RIG_REFUSED};
use super::{STUDY, microslip};

fn validator() -> jsonschema::Validator {
    let output = microslip(Path::new("."), &["schema"]);
    assert!(output.status.success(), "{output:?}");
    let schema: Value = serde_json::from_slice(&output.stdout).unwrap();
    jsonschema::validator_for(&schema).unwrap()
}

fn valid(validator: &jsonschema::Validator, study: &str) -> bool {
    let json: Value = toml::from_str(study).unwrap();
    validator.is_valid(&json)
}

/// Every study file of the repository and of these tests. Seen to fail with `samples` as a string.
#[test]
fn every_study_is_valid() {
    let validator = validator();
    assert!(valid(&validator, STUDY), "the study of these tests");
    let mut found = 0;
    for root in ["studies", "tests/reference"] {
        for entry in std::fs::read_dir(root).unwrap() {
            let path = entry.unwrap().path().join("study.toml");
            if let Ok(text) = std::fs::read_to_string(&path) {
                assert!(valid(&validator, &text), "{}", path.display());
                found += 1;
            }
        }
    }
    assert!(found > 0, "no study found");
    let page = std::fs::read_to_string("docs/src/own-model.md").unwrap();
    let example = page.split("```toml\n").nth(1).unwrap();
    let example = example.split("```").next().unwrap();
    assert!(
        valid(&validator, example),
        "the example of the page on own models"
    );
}

/// Seen to fail with unknown keys allowed at the top.
#[test]
fn bad_keys_and_shapes_are_invalid() {
    let validator = validator();
    for (old, new) in [
        ("seed = 7", "sead = 7"),
        ("seed = 7", "seed = \"7\""),
        ("levels = [1.0, 2.0]", "levels = []"),
        ("mass = ", "mas = "),
        ("kind = \"matrices\"", "kind = \"matrix\""),
        ("law = \"box\"", "law = \"square\""),
        ("harmonics = 5", "harmonics = \"5\""),
        ("[inputs.friction_coefficient]", "[inputs.friction]"),
        ("distribution = \"uniform\"", "distribution = \"even\""),
        ("band_hz = [100, 200]", "band = [100, 200]"),
        ("[output]", "[stress]\nlimit = 3.0\n[output]"),
        ("[output]", "[output]\nbands = \"deepest\""),
    ] {
        assert!(STUDY.contains(old), "{old}");
        let study = STUDY.replacen(old, new, 1);
        assert!(!valid(&validator, &study), "{new} is valid");
    }
}

/// The schema refuses what the program refuses wherever it can say it, and nothing else: the lists of `bad_input`.
///
/// Seen to fail without minima, maxima and the rules between keys.
#[test]
fn the_schema_refuses_what_the_program_refuses() {
    let validator = validator();
    let lists = [
        (STUDY, REFUSED, false),
        (STUDY, BEYOND_SCHEMA, true),
        (RIG, RIG_REFUSED, false),
        (RIG, RIG_BEYOND_SCHEMA, true),
        (DISK, DISK_REFUSED, false),
        (DISK, DISK_BEYOND_SCHEMA, true),
    ];
    let mut wrong = Vec::new();
    for (study, cases, expected) in lists {
        assert!(valid(&validator, study), "the study of these cases");
        for (old, new, _) in cases {
            assert!(study.contains(old), "{old}");
            let text = study.replacen(old, new, 1);
            // what is no TOML never comes to a schema
            let Ok(json) = toml::from_str::<Value>(&text) else {
                continue;
            };
            if validator.is_valid(&json) != expected {
                wrong.push(format!("{old} -> {new}: valid = {}", !expected));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The page of the book with all keys is the program's. Seen to fail with a range changed on the page.
#[test]
fn the_page_of_the_keys_is_up_to_date() {
    let output = microslip(Path::new("."), &["schema", "--markdown"]);
    assert!(output.status.success(), "{output:?}");
    let page = std::fs::read_to_string("docs/src/study-file-keys.md").unwrap();
    let renew = "cargo run --release -- schema --markdown > docs/src/study-file-keys.md";
    assert!(
        page == String::from_utf8(output.stdout).unwrap(),
        "docs/src/study-file-keys.md is not what the program prints; renew it: {renew}"
    );
}
