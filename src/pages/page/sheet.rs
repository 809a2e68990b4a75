//! Names with their values, as a table of two columns.

use super::block::{Block, Cell, Table};
use super::display::capitalised;
use serde::Serialize;
use serde_json::Value;

/// A table of names and values.
pub fn sheet(title: &str, file: &str, rows: impl IntoIterator<Item = (String, String)>) -> Block {
    let mut table = Table::of(title, file, &[("Name", &["name"]), ("Value", &["value"])]);
    for (name, value) in rows {
        table.row(vec![
            Cell::text(name),
            Cell::text(value).with_class("text wide"),
        ]);
    }
    table.block()
}

/// The fields of a record under the names that they have in its file.
pub fn fields(record: &impl Serialize) -> Vec<(String, String)> {
    let value = serde_json::to_value(record).unwrap_or_default();
    let fields = value.as_object().into_iter().flatten();
    // an empty list needs no line
    let said = fields.filter(|(_, value)| value.as_array().is_none_or(|list| !list.is_empty()));
    let named =
        |(key, value): (&String, &Value)| (capitalised(&key.replace('_', " ")), shown(value));
    said.map(named).collect()
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "not stated".to_owned(),
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.to_owned(),
        Value::String(text) => text.clone(),
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(shown).collect();
            items.join(", ")
        }
        Value::Object(fields) => {
            let fields = fields
                .iter()
                .map(|(key, value)| format!("{key} {}", shown(value)));
            fields.collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    }
}
