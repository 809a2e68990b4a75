//! Files of the program against their schemas.

use std::collections::BTreeSet;
use std::path::Path;

use jsonschema::Validator;
use serde_json::{Value, json};

use crate::program::microslip;

/// The schema of a file.
pub(crate) fn schema(of: &str) -> Value {
    let output = microslip(Path::new("."), &["schema", "--of", of]);
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Its validator.
pub(crate) fn validator(of: &str) -> Validator {
    jsonschema::validator_for(&schema(of)).unwrap()
}

fn assert_valid(validator: &Validator, value: &Value, what: &str) {
    let errors = validator.iter_errors(value);
    let errors: Vec<String> = errors
        .take(5)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(errors.is_empty(), "{what}: {errors:#?}");
}

/// Places of a file, one of those that differ only in the number of an entry.
fn places(value: &Value, at: &str, kind: &str, seen: &mut BTreeSet<String>, all: &mut Vec<String>) {
    if seen.insert(kind.to_owned()) {
        all.push(at.to_owned());
    }
    for (key, member) in value.as_object().into_iter().flatten() {
        let escaped = key.replace('~', "~0").replace('/', "~1");
        let of = |path: &str| format!("{path}/{escaped}");
        places(member, &of(at), &of(kind), seen, all);
    }
    for (i, member) in value.as_array().into_iter().flatten().enumerate() {
        places(
            member,
            &format!("{at}/{i}"),
            &format!("{kind}/-"),
            seen,
            all,
        );
    }
}

/// The file with one place changed: another type of value, or a further field.
fn damaged(file: &Value, place: &str) -> Option<Value> {
    let mut damaged = file.clone();
    let value = damaged.pointer_mut(place)?;
    match value {
        // the response of a further degree of freedom is none of another type
        Value::Object(_) if place.ends_with("/responses") => return None,
        Value::Object(fields) => {
            fields.insert("a_field_of_no_type".to_owned(), json!(1));
        }
        // a limit without a number is a text
        Value::String(text) if text == "unbounded" => *value = json!(true),
        Value::String(_) => *value = json!(1.5),
        Value::Null | Value::Number(_) | Value::Bool(_) => *value = json!("a text"),
        Value::Array(_) => *value = json!("a text"),
    }
    Some(damaged)
}

/// The file is valid, and no damage to it is.
pub(crate) fn assert_described(validator: &Validator, file: &Value, what: &str) {
    assert_valid(validator, file, what);
    let mut all = Vec::new();
    places(file, "", "", &mut BTreeSet::new(), &mut all);
    let unseen = |place: &&String| {
        // null stands for an absent text or number
        let missing = file.pointer(place).is_some_and(Value::is_null);
        let damaged = damaged(file, place).filter(|_| !missing);
        damaged.is_some_and(|damaged| validator.is_valid(&damaged))
    };
    let unseen: Vec<&String> = all.iter().filter(unseen).collect();
    assert!(
        unseen.is_empty(),
        "{what}: damage is not seen at {unseen:#?}"
    );
}
