//! JSON Schemas of the result files that other programs read, from the types that write them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::solve::SolutionRecord;
use crate::report::assessment::Assessment;
use crate::report::numbers::Summary;

/// A result file with stable field names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputFile {
    /// `summary.json`.
    Summary,
    /// `report.json`.
    Report,
    /// `solution.json`.
    Solution,
}

/// The schema (JSON Schema, draft 2020-12) of a result file, with the meaning and unit of every field.
///
/// A file of this version has no field beyond it. Programs that read files of other versions should not ask for that.
#[must_use]
pub fn output_schema(file: OutputFile) -> Value {
    match file {
        OutputFile::Summary => schema_of::<Summary>("Microslip summary.json"),
        OutputFile::Report => schema_of::<Assessment>("Microslip report.json"),
        OutputFile::Solution => schema_of::<SolutionRecord<'_>>("Microslip solution.json"),
    }
}

/// The schema of a file that is a `T`, under this title.
pub(crate) fn schema_of<T: JsonSchema>(title: &str) -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    schema.insert("title".to_owned(), json!(title));
    let mut schema = schema.to_value();
    close(&mut schema);
    schema
}

/// Objects with stated fields have no others. Conditions on fields (`if`, `then`) are no objects of their own and stay open.
fn close(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            if object.get("type") == Some(&json!("object")) && object.contains_key("properties") {
                // an alternative beside the fields brings further ones
                let beside = ["oneOf", "anyOf", "allOf", "$ref"];
                let rest = match beside.iter().any(|key| object.contains_key(*key)) {
                    true => "unevaluatedProperties",
                    false => "additionalProperties",
                };
                object.entry(rest).or_insert(Value::Bool(false));
            }
            object.values_mut().for_each(close);
        }
        Value::Array(values) => values.iter_mut().for_each(close),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::{JsonSchema, Value, schema_of};
    use crate::hb::{PeakRoute, Status};
    use crate::sampling::DesignKind;

    /// Names of all variants in files, as the schema has them from the type itself.
    fn in_files<T: JsonSchema>() -> Vec<String> {
        let schema = schema_of::<T>("names");
        let variants = schema["oneOf"].as_array().expect("variants with words");
        let name = |variant: &Value| variant["const"].as_str().map(str::to_owned);
        variants.iter().filter_map(name).collect()
    }

    /// Programs that read files, and readers of a report, find the same name. Seen to fail with a status twice in the list.
    #[test]
    fn statuses_have_their_names_of_files() {
        assert_eq!(in_files::<Status>(), Status::ALL.map(Status::name));
    }

    /// Seen to fail with another name of one.
    #[test]
    fn routes_have_their_names_of_files() {
        assert_eq!(in_files::<PeakRoute>(), PeakRoute::ALL.map(PeakRoute::name));
    }

    /// Seen to fail with another name of one.
    #[test]
    fn designs_have_their_names_of_files() {
        let kinds = in_files::<DesignKind>();
        assert!(kinds.len() > 1, "{kinds:?}");
        for name in kinds {
            let kind: DesignKind = serde_json::from_value(Value::from(name.clone())).expect("kind");
            assert_eq!(kind.name(), name);
        }
    }
}
