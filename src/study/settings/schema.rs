//! JSON Schema of the study file, from the types that read it.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::frequency::FrequencyTable;
use super::identified_inputs::InputsKeys;
use super::model::{BoundaryKeys, CyclicKeys};
use super::read::{KEYS, LEVEL, MOST_LEVELS};
use super::solver_section::{ContactSection, OF_INTERFACE, SolverSection};
use crate::model::matrices::MatricesSettings;
use crate::model::two_blade::{PressureField, TwoBladeSettings};
use crate::report::asked::requirement::LINE;
use crate::report::asked::{
    ControlVariateSettings, Criterion, Operation, StoppingTable, Stress, SurrogateSettings,
};
use crate::sampling::design_settings::MOST_SAMPLES;
use crate::sampling::{CorrelationTable, DesignTable, DistributionTable, EpistemicTable, Input};
use crate::setting::NOT_BLANK;
use crate::study::output::OutputSettings;

/// The schema (JSON Schema, draft 2020-12) of a study file, for editors and programs.
///
/// It knows names, shapes, units, ranges and which keys need or exclude each other. What compares values with each other
/// (ascending levels, a level that is one of `levels`) or with other files is checked by reading the file.
#[must_use]
pub fn schema() -> Value {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let sections = KEYS.map(|key| (key.to_owned(), section(key, &mut generator)));
    let properties: Map<String, Value> = sections.into_iter().collect();
    let mut schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Microslip study",
        "type": "object",
        "properties": properties,
        "required": ["name", "levels", "model", "frequency"],
        "additionalProperties": false,
        "allOf": [
            { "if": of_kind("matrices"), "then": { "properties": without_interface() } },
            { "if": of_sector("matrices"), "then": { "properties": without_interface() } },
            { "if": of_kind("cyclic"), "then": {
                "required": ["operation"],
                "properties": { "pressure_field": false },
            } },
            needs("frequency-margin-percent", "operation"),
            needs("reserve-factor", "stress"),
            needs("probability-of-exceedance", "stress"),
            by_rule(),
            until_decided(),
        ],
        "$defs": generator.take_definitions(true),
    });
    without_null(&mut schema);
    schema
}

/// A study whose model is of this kind.
fn of_kind(kind: &str) -> Value {
    let model = json!({ "properties": { "kind": { "const": kind } }, "required": ["kind"] });
    json!({ "properties": { "model": model }, "required": ["model"] })
}

/// A study of a disk whose sector is of this kind.
fn of_sector(sector: &str) -> Value {
    let model = json!({ "properties": { "sector": { "const": sector } }, "required": ["sector"] });
    json!({ "properties": { "model": model }, "required": ["model"] })
}

/// What a model with its own contacts has no use for.
fn without_interface() -> Value {
    let absent: Map<String, Value> = OF_INTERFACE
        .map(|key| (key.to_owned(), Value::Bool(false)))
        .into_iter()
        .collect();
    json!({ "pressure_field": false, "contact": { "properties": absent } })
}

/// A criterion on `quantity` needs a table.
fn needs(quantity: &str, table: &str) -> Value {
    let criterion =
        json!({ "properties": { "quantity": { "const": quantity } }, "required": ["quantity"] });
    let criteria = json!({ "properties": { "criteria": { "contains": criterion } }, "required": ["criteria"] });
    json!({ "if": criteria, "then": { "required": [table] } })
}

/// A rule for the number of samples needs independent ones.
fn by_rule() -> Value {
    let table =
        json!({ "properties": { "samples": { "type": "object" } }, "required": ["samples"] });
    let independent = json!({ "properties": { "kind": { "const": "monte-carlo" } } });
    json!({ "if": table, "then": { "properties": { "design": independent } } })
}

/// Criteria are decided where there are such.
fn until_decided() -> Value {
    let decided = json!({ "properties": { "until": { "const": "decided" } }, "required": ["until"], "type": "object" });
    let samples = json!({ "properties": { "samples": decided }, "required": ["samples"] });
    let some = json!({ "properties": { "criteria": { "minItems": 1 } }, "required": ["criteria"] });
    json!({ "if": samples, "then": some })
}

/// TOML has no null: an optional key is absent, and what is no number (`nan`) is null in JSON.
fn without_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.retain(|key, value| !(key == "default" && value.is_null()));
            if let Some(Value::Array(types)) = object.get_mut("type") {
                types.retain(|name| name != "null");
                if let [single] = types.as_slice() {
                    let single = single.clone();
                    object.insert("type".to_owned(), single);
                }
            }
            if let Some(Value::Array(options)) = object.get_mut("anyOf") {
                options.retain(|option| *option != json!({ "type": "null" }));
            }
            object.values_mut().for_each(without_null);
        }
        Value::Array(values) => values.iter_mut().for_each(without_null),
        _ => {}
    }
}

/// Schema of one top-level key; `false` (nothing is valid) for a key that it does not know.
fn section(key: &str, generator: &mut SchemaGenerator) -> Value {
    match key {
        "name" => {
            json!({ "type": "string", "pattern": NOT_BLANK, "allOf": [{ "pattern": LINE }], "description": "Title of the study." })
        }
        "seed" => json!({
            "type": "integer",
            "minimum": 0,
            "default": 0,
            "description": "Seed of the random numbers: sample i depends on the seed and i alone.",
        }),
        "samples" => json!({
            "default": 1,
            "description": "Number of samples, or the rule by which there are enough. With epistemic inputs it counts the samples of all outer points.",
            "oneOf": [
                { "type": "integer", "minimum": 1, "maximum": MOST_SAMPLES },
                of::<StoppingTable>(generator),
            ],
        }),
        "levels" => json!({
            "type": "array",
            "items": { "type": "number", "minimum": LEVEL[0], "maximum": LEVEL[1] },
            "minItems": 1,
            "maxItems": MOST_LEVELS,
            "uniqueItems": true,
            "description": "Excitation levels, ascending: N on each blade for the built-in model, else factors on the harmonic force.",
        }),
        "model" => json!({
            "description": "The structure: built in, the user's own matrices, or one sector of a tuned disk of either.",
            "oneOf": [
                model::<TwoBladeSettings>("two-blade-strip", generator),
                model::<MatricesSettings>("matrices", generator),
                sector::<TwoBladeSettings>("blade-strip", &["excitation_phase"], generator),
                sector::<MatricesSettings>("matrices", &["mirror"], generator),
            ],
        }),
        "contact" => of::<ContactSection>(generator),
        "inputs" => inputs(generator),
        "design" => of::<DesignTable>(generator),
        "correlation" => of::<CorrelationTable>(generator),
        "epistemic" => of::<EpistemicTable>(generator),
        "pressure_field" => of::<PressureField>(generator),
        "solver" => of::<SolverSection>(generator),
        "frequency" => of::<FrequencyTable>(generator),
        "output" => of::<OutputSettings>(generator),
        "operation" => of::<Operation>(generator),
        "stress" => of::<Stress>(generator),
        "criteria" => json!({
            "type": "array",
            "items": of::<Criterion>(generator),
            "description": "What is judged; without any the report has no verdicts.",
        }),
        "surrogate" => of::<SurrogateSettings>(generator),
        "control_variate" => of::<ControlVariateSettings>(generator),
        _ => Value::Bool(false),
    }
}

fn of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Value {
    generator.subschema_for::<T>().to_value()
}

/// `[model]` of one kind: the settings of that kind and the kind itself.
fn model<T: JsonSchema>(kind: &str, generator: &mut SchemaGenerator) -> Value {
    let mut schema = T::json_schema(generator).to_value();
    let entry = |schema: &mut Value, key: &str, value: Value| {
        if let Some(object) = schema.as_object_mut() {
            object.insert(key.to_owned(), value);
        }
    };
    if let Some(properties) = schema.get_mut("properties") {
        let chosen = json!({ "const": kind, "description": "Kind of the model." });
        entry(properties, "kind", chosen);
    }
    let mut required = vec![json!("kind")];
    let more = schema.get("required").and_then(Value::as_array);
    required.extend(more.into_iter().flatten().cloned());
    entry(&mut schema, "required", Value::Array(required));
    schema
}

/// `[model]` of a tuned disk: the settings of its sector without those that it has no use for, and its own.
fn sector<T: JsonSchema>(sector: &str, unused: &[&str], generator: &mut SchemaGenerator) -> Value {
    let mut schema = model::<T>("cyclic", generator);
    let mut own = CyclicKeys::json_schema(generator).to_value();
    let description = own["description"].take();
    let mut keys = own["properties"].take();
    if sector == "matrices" {
        let mut boundary = BoundaryKeys::json_schema(generator).to_value();
        let of_boundary = boundary["properties"].take();
        let (Some(keys), Value::Object(of_boundary)) = (keys.as_object_mut(), of_boundary) else {
            return Value::Bool(false);
        };
        keys.extend(of_boundary);
    }
    let about = json!({ "const": sector, "description": "What a sector is made of." });
    let (Some(properties), Value::Object(keys)) = (schema["properties"].as_object_mut(), keys)
    else {
        return Value::Bool(false);
    };
    properties.retain(|key, _| !unused.contains(&key.as_str()));
    properties.insert("sector".to_owned(), about);
    properties.extend(keys);
    if let Some(required) = schema["required"].as_array_mut() {
        required.extend([json!("sector"), json!("sectors")]);
    }
    schema["description"] = description;
    schema
}

/// `[inputs.NAME]`: the same table under every name, with the values that the input accepts.
fn inputs(generator: &mut SchemaGenerator) -> Value {
    let table = of::<DistributionTable>(generator);
    let of_input = |input: Input| {
        let (largest, value) = (
            input.largest(),
            json!({ "minimum": 0, "maximum": input.largest() }),
        );
        let single = match input.zero_allowed() {
            true => value.clone(),
            false => json!({ "exclusiveMinimum": 0, "maximum": largest }),
        };
        let uncut = json!({ "low": { "minimum": 0 }, "high": { "maximum": largest } });
        json!({
            "description": input.description(),
            "allOf": [
                table,
                { "properties": { "value": single, "lower": single, "upper": single } },
                { "if": { "required": ["truncation"] },
                  "then": { "properties": { "truncation": { "items": { "minimum": 0 } } } },
                  "else": { "properties": uncut } },
            ],
        })
    };
    let keys = InputsKeys::json_schema(generator).to_value();
    let tables = Input::ALL.map(|input| (input.name().to_owned(), of_input(input)));
    let mut properties: Map<String, Value> = tables.into_iter().collect();
    let files = keys["properties"].as_object().into_iter().flatten();
    properties.extend(files.map(|(key, of)| (key.clone(), of.clone())));
    json!({
        "type": "object",
        "properties": properties,
        "dependentRequired": keys["dependentRequired"],
        "additionalProperties": false,
        "description": "The uncertain inputs: one table each, or from the file of an identification; without any the samples do not scatter.",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keys without a description, as dotted paths.
    fn undescribed(path: &str, schema: &Value, definitions: &Value, found: &mut Vec<String>) {
        for (key, property) in schema["properties"].as_object().into_iter().flatten() {
            let at = format!("{path}.{key}");
            let definition = property["$ref"]
                .as_str()
                .and_then(|r| r.strip_prefix("#/$defs/"));
            let target = definition.map_or(property, |name| &definitions[name]);
            let described = |schema: &Value| schema["description"].is_string();
            let silent = !property.is_boolean() && !described(property) && !described(target);
            found.extend(silent.then(|| at.clone()));
            if definition.is_none() {
                undescribed(&at, property, definitions, found);
            }
        }
        for alternative in ["oneOf", "anyOf"] {
            for option in schema[alternative].as_array().into_iter().flatten() {
                if option["type"] == "object" {
                    undescribed(path, option, definitions, found);
                }
            }
        }
    }

    /// Seen to fail with the keys of `[solver]` without doc comments.
    #[test]
    fn every_key_has_a_description() {
        let schema = schema();
        let mut found = Vec::new();
        undescribed("", &schema, &schema["$defs"], &mut found);
        for (name, definition) in schema["$defs"].as_object().into_iter().flatten() {
            undescribed(name, definition, &schema["$defs"], &mut found);
        }
        assert!(found.is_empty(), "{found:?}");
    }

    /// Seen to fail with `stress` left out of [`section`].
    #[test]
    fn every_key_has_a_schema() {
        let schema = schema();
        for key in KEYS {
            assert_ne!(schema["properties"][key], Value::Bool(false), "{key}");
        }
    }
}
