//! The keys of the study file as a page of Markdown tables, from its JSON Schema: `docs/src/study-file-keys.md`.

use std::fmt::Write as _;

use serde_json::Value;

use super::read::KEYS;
use super::schema::schema;

const HEAD: &str = "\
# Keys of the study file

<!-- Made by `microslip schema --markdown > docs/src/study-file-keys.md`; a test compares both. -->

Every key of a study file with its meaning, its values and its default. [Study file](study-file.md) says how the tables work
together. `microslip schema` prints the same as JSON Schema, for editors. A dash in the last column: the key may be absent and
has no default value; what its absence means stands beside it.
";

/// The page.
#[must_use]
pub fn key_reference() -> String {
    let schema = schema();
    let mut page = Page {
        definitions: &schema["$defs"],
        text: HEAD.to_owned(),
    };
    page.sections(&schema);
    page.text
}

/// A page that grows, and what the schema refers to.
struct Page<'a> {
    definitions: &'a Value,
    text: String,
}

/// A table of the study file that gets a section of its own.
struct Section<'a> {
    title: String,
    table: &'a Value,
}

impl<'a> Page<'a> {
    fn sections(&mut self, schema: &'a Value) {
        let tables = KEYS.map(|key| (key, &schema["properties"][key]));
        let is_key =
            |of: &'a Value| self.resolved(of)["properties"].is_null() && self.items(of).is_none();
        let single = tables.iter().filter(|(_, of)| is_key(of));
        // `model` is one of two tables, and `inputs` a table of tables
        let single: Vec<_> = single.filter(|(key, _)| *key != "model").copied().collect();
        self.heading("Top level", "");
        let below = self.rows("", &single, &schema["required"]);
        self.write(below);
        for (key, of) in tables {
            match key {
                "model" => self.models(of),
                "inputs" => self.inputs(of),
                _ if single.iter().any(|(name, _)| *name == key) => {}
                _ => self.section(key, of),
            }
        }
    }

    fn models(&mut self, of: &'a Value) {
        for model in of["oneOf"].as_array().into_iter().flatten() {
            let kind = model["properties"]["kind"]["const"].as_str();
            let sector = model["properties"]["sector"]["const"].as_str();
            let sector = sector.map(|name| format!(", sector = \"{name}\""));
            let (kind, sector) = (kind.unwrap_or_default(), sector.unwrap_or_default());
            let title = format!("`[model]`, kind = \"{kind}\"{sector}");
            self.write(vec![Section {
                title,
                table: model,
            }]);
        }
    }

    /// All inputs have the same table.
    fn inputs(&mut self, of: &'a Value) {
        let all = of["properties"].as_object().into_iter().flatten();
        let (tables, keys): (Vec<_>, Vec<_>) = all.partition(|(_, of)| of["allOf"].is_array());
        self.heading("`[inputs]`", &paragraphs(&of["description"]));
        self.text.push('\n');
        let keys: Vec<_> = keys.iter().map(|(key, of)| (key.as_str(), *of)).collect();
        let below = self.rows("inputs", &keys, &of["required"]);
        self.write(below);
        let about = "An uncertain input: `kind = \"aleatory\"` with a distribution, or `kind = \"epistemic\"` with an interval. \
                     NAME is one of these; other numbers than those in the last column are refused.";
        self.heading("`[inputs.NAME]`", about);
        self.text
            .push_str("\n| name | meaning | numbers |\n| --- | --- | --- |\n");
        for (name, input) in &tables {
            let numbers = &input["allOf"][1]["properties"]["value"];
            let meaning = text(&input["description"]);
            self.row([&format!("`{name}`"), &meaning, &range(numbers)]);
        }
        if let Some((_, input)) = tables.first() {
            let table = self.resolved(&input["allOf"][0]);
            self.text.push('\n');
            self.table_of_keys("inputs.NAME", table);
        }
    }

    fn section(&mut self, key: &str, of: &'a Value) {
        let (title, table) = match self.items(of) {
            Some(items) => (format!("`[[{key}]]`"), items),
            None => (format!("`[{key}]`"), self.resolved(of)),
        };
        self.write(vec![Section { title, table }]);
    }

    fn write(&mut self, sections: Vec<Section<'a>>) {
        for Section { title, table } in sections {
            self.heading(&title, &paragraphs(&table["description"]));
            self.text.push('\n');
            let path = title.split(',').next().unwrap_or_default();
            let path = path.trim_matches(['`', '[', ']']).to_owned();
            self.table_of_keys(&path, table);
        }
    }

    fn table_of_keys(&mut self, path: &str, table: &'a Value) {
        let keys = table["properties"].as_object().into_iter().flatten();
        let keys: Vec<_> = keys.map(|(key, of)| (key.as_str(), of)).collect();
        let below = self.rows(path, &keys, &table["required"]);
        self.write(below);
    }

    /// One row per key and per key of a table below it; gives back the lists of tables, for sections of their own.
    fn rows(
        &mut self,
        path: &str,
        keys: &[(&str, &'a Value)],
        required: &Value,
    ) -> Vec<Section<'a>> {
        self.text
            .push_str("| key | meaning | values | default |\n| --- | --- | --- | --- |\n");
        let mut below = Vec::new();
        self.further_rows(path, "", keys, required, &mut below);
        below
    }

    fn further_rows(
        &mut self,
        path: &str,
        prefix: &str,
        keys: &[(&str, &'a Value)],
        required: &Value,
        below: &mut Vec<Section<'a>>,
    ) {
        let required = required.as_array();
        for (key, of) in keys {
            let needed = required.is_some_and(|names| names.iter().any(|name| name == key));
            let meaning = match of["description"].is_string() {
                true => text(&of["description"]),
                false => text(&self.resolved(of)["description"]),
            };
            let default = match &of["default"] {
                _ if needed => "required".to_owned(),
                Value::Null => "–".to_owned(),
                value => format!("`{}`", written(value)),
            };
            let list = self.items(of).is_some();
            let values = match list {
                true => "tables, below".to_owned(),
                false => self.values(of),
            };
            self.row([&format!("`{prefix}{key}`"), &meaning, &values, &default]);
            if let Some(table) = self.items(of) {
                let title = format!("`[[{path}.{key}]]`");
                below.push(Section { title, table });
            } else if let Some(table) = self.table(of) {
                let keys = table["properties"].as_object().into_iter().flatten();
                let keys: Vec<_> = keys.map(|(key, of)| (key.as_str(), of)).collect();
                let prefix = format!("{prefix}{key}.");
                self.further_rows(path, &prefix, &keys, &table["required"], below);
            }
        }
    }

    fn heading(&mut self, title: &str, about: &str) {
        // writing to a text cannot fail
        let _ = writeln!(self.text, "\n## {title}");
        if !about.is_empty() {
            let _ = writeln!(self.text, "\n{about}");
        }
        if title == "Top level" {
            self.text.push('\n');
        }
    }

    fn row<const N: usize>(&mut self, cells: [&str; N]) {
        let cells = cells.map(|cell| cell.replace('|', "\\|"));
        let _ = writeln!(self.text, "| {} |", cells.join(" | "));
    }

    /// What a reference stands for; a single alternative, too.
    fn resolved(&self, of: &'a Value) -> &'a Value {
        if let Some(name) = of["$ref"].as_str() {
            return &self.definitions[name.trim_start_matches("#/$defs/")];
        }
        match of["anyOf"].as_array().map(Vec::as_slice) {
            Some([single]) => self.resolved(single),
            _ => of,
        }
    }

    /// The table of keys that a value is, or may be.
    fn table(&self, of: &'a Value) -> Option<&'a Value> {
        let of = self.resolved(of);
        if of["properties"].is_object() && of["const"].is_null() {
            return Some(of);
        }
        let options = ["anyOf", "oneOf"].iter().filter_map(|k| of[k].as_array());
        let mut tables = options.flatten().filter_map(|option| self.table(option));
        tables.next()
    }

    /// The table that the items of a list are.
    fn items(&self, of: &'a Value) -> Option<&'a Value> {
        let items = self.resolved(&self.resolved(of)["items"]);
        items["properties"].is_object().then_some(items)
    }

    /// The values of a key in words.
    fn values(&self, of: &'a Value) -> String {
        let of = self.resolved(of);
        if !of["const"].is_null() {
            return format!("`{}`", of["const"]);
        }
        if let Some(names) = of["enum"].as_array() {
            let names: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
            return names.join(" or ");
        }
        let options = of["oneOf"].as_array().or_else(|| of["anyOf"].as_array());
        if let Some(options) = options.filter(|_| of["properties"].is_null()) {
            return self.alternatives(options);
        }
        match of["type"].as_str() {
            Some("number") => spaced("number", &range(of)),
            Some("integer") => spaced("whole number", &range(of)),
            Some("boolean") => "`true` or `false`".to_owned(),
            Some("string") => "text".to_owned(),
            Some("array") => self.list(of),
            Some("object") if of["properties"].is_object() => {
                let keys = of["properties"].as_object().into_iter().flatten();
                let keys: Vec<_> = keys.map(|(key, _)| format!("`{key}`")).collect();
                format!("table of {}", keys.join(", "))
            }
            Some("object") => format!(
                "table of NAME = {}",
                self.values(&of["additionalProperties"])
            ),
            _ => String::new(),
        }
    }

    /// Named choices each with its meaning; other alternatives in a row.
    fn alternatives(&self, options: &'a [Value]) -> String {
        let named = options.iter().all(|option| option["const"].is_string());
        let one = |option: &'a Value| {
            let meaning = text(&option["description"]);
            let meaning = meaning.trim_end_matches('.');
            match self.values(option) {
                values if meaning.is_empty() => values,
                values if named => format!("{values}: {meaning}"),
                values => format!("{values} ({meaning})"),
            }
        };
        let texts: Vec<_> = options.iter().map(one).collect();
        texts.join(if named { "<br>" } else { ", or " })
    }

    fn list(&self, of: &'a Value) -> String {
        let [least, most] = ["minItems", "maxItems"].map(|key| of[key].as_u64());
        let number = match (least, most) {
            (Some(least), Some(most)) if least == most => format!("list of {least}: "),
            (Some(1), None) | (None, None) => "list of: ".to_owned(),
            (Some(least), None) => format!("list of {least} or more: "),
            (least, Some(most)) => format!("list of {} to {most}: ", least.unwrap_or(0)),
        };
        format!("{number}{}", self.values(&of["items"]))
    }
}

fn spaced(word: &str, range: &str) -> String {
    match range.is_empty() {
        true => word.to_owned(),
        false => format!("{word} {range}"),
    }
}

/// Minimum and maximum in words.
fn range(of: &Value) -> String {
    let at = |key: &str| of[key].as_f64().map(plain);
    let (least, most) = (at("minimum"), at("maximum"));
    let (above, below) = (at("exclusiveMinimum"), at("exclusiveMaximum"));
    match (least, above, most, below) {
        (Some(least), _, Some(most), _) => format!("from {least} to {most}"),
        (Some(least), _, _, Some(below)) => format!("≥ {least}, < {below}"),
        (_, Some(above), Some(most), _) => format!("> {above}, ≤ {most}"),
        (_, Some(above), _, Some(below)) => format!("> {above}, < {below}"),
        (Some(least), ..) => format!("≥ {least}"),
        (_, Some(above), ..) => format!("> {above}"),
        (_, _, Some(most), _) => format!("≤ {most}"),
        (.., Some(below)) => format!("< {below}"),
        _ => String::new(),
    }
}

/// A number as people write it.
fn plain(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e6).contains(&size) => format!("{value}"),
        _ => format!("{value:e}"),
    }
}

/// A default as people write it.
fn written(value: &Value) -> String {
    match value {
        Value::Number(number) => number.as_f64().map_or_else(String::new, plain),
        Value::Array(values) => {
            let values: Vec<_> = values.iter().map(written).collect();
            format!("[{}]", values.join(", "))
        }
        other => other.to_string(),
    }
}

/// A description on one line.
fn text(description: &Value) -> String {
    let words = description.as_str().unwrap_or_default().split_whitespace();
    words.collect::<Vec<_>>().join(" ")
}

/// A description with its paragraphs.
fn paragraphs(description: &Value) -> String {
    let all = description.as_str().unwrap_or_default().split("\n\n");
    let each = all.map(|one| text(&Value::from(one)));
    each.collect::<Vec<_>>().join("\n\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every key of every table of the schema has a row. Seen to fail with the rows of a table below a key left out.
    #[test]
    fn every_key_has_a_row() {
        let (schema, page) = (schema(), key_reference());
        let first_cell = |line: &str| Some(line.strip_prefix("| `")?.split('`').next()?.to_owned());
        let rows: Vec<String> = page.lines().filter_map(first_cell).collect();
        let listed = |key: &str| rows.iter().any(|row| row.rsplit('.').next() == Some(key));
        let mut missing = Vec::new();
        for (name, definition) in schema["$defs"].as_object().into_iter().flatten() {
            let keys = definition["properties"].as_object().into_iter().flatten();
            let absent = keys.map(|(key, _)| key).filter(|key| !listed(key));
            missing.extend(absent.map(|key| format!("{name}.{key}")));
        }
        assert!(missing.is_empty(), "{missing:?}");
    }
}
