//! CSV tables with named columns: pairs, nodes, loads.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::lines::{number, whole};
use crate::file::{self, FileError, Rows};

/// A table as a file states it.
#[derive(Debug)]
pub(super) struct TextTable {
    path: PathBuf,
    columns: BTreeMap<String, usize>,
    rows: Vec<(u64, Vec<String>)>,
}

/// One row of a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct TextRow<'t> {
    table: &'t TextTable,
    /// 1-based line of the file.
    pub(super) line: u64,
    fields: &'t [String],
}

impl TextTable {
    /// Reads a table whose columns are among `required` and `optional`. `#` begins a comment.
    pub(super) fn read(
        path: &Path,
        required: &[&str],
        optional: &[&str],
    ) -> Result<Self, FileError> {
        let text = file::read_text(path)?;
        let mut lines = Rows::new(path, &text, ',');
        let Some(heading) = lines.next().transpose()? else {
            return Err(FileError::content(path, None, "is empty"));
        };
        let (line, heading) = (heading.line, heading.fields);
        let fault = |rule: String| FileError::content(path, Some(line), rule);
        let mut columns = BTreeMap::new();
        for (at, name) in heading.iter().enumerate() {
            let name = name.to_ascii_lowercase();
            if !required.iter().chain(optional).any(|known| *known == name) {
                let known = [required, optional].concat().join(", ");
                return Err(fault(format!(
                    "column {name:.40}: the first line must name columns among {known}"
                )));
            }
            if columns.insert(name.clone(), at).is_some() {
                return Err(fault(format!("column {name}: must be given once")));
            }
        }
        if let Some(missing) = required.iter().find(|name| !columns.contains_key(**name)) {
            return Err(fault(format!("must have a column {missing}")));
        }
        let mut rows = Vec::new();
        for row in lines {
            let row = row?;
            let fields = row.fields.into_iter().map(Cow::into_owned).collect();
            rows.push((row.line, fields));
        }
        Ok(Self {
            path: path.to_owned(),
            columns,
            rows,
        })
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = TextRow<'_>> {
        self.rows.iter().map(|(line, fields)| TextRow {
            table: self,
            line: *line,
            fields,
        })
    }
}

impl<'t> TextRow<'t> {
    /// The text of a column; nothing where it is absent or blank.
    pub(super) fn text(&self, column: &str) -> Option<&'t str> {
        let at = self.table.columns.get(column)?;
        let text = self.fields.get(*at)?.as_str();
        Some(text).filter(|text| !text.is_empty())
    }

    pub(super) fn fault(&self, rule: impl Into<String>) -> FileError {
        FileError::content(&self.table.path, Some(self.line), rule)
    }

    /// The number of a column, if it is given.
    pub(super) fn number(&self, column: &str) -> Result<Option<f64>, FileError> {
        let Some(text) = self.text(column) else {
            return Ok(None);
        };
        let value = number(text).map_err(|rule| self.fault(format!("{column} = {rule}")))?;
        Ok(Some(value))
    }

    /// A number ≥ 0, if it is given.
    pub(super) fn not_negative(&self, column: &str) -> Result<Option<f64>, FileError> {
        match self.number(column)? {
            Some(value) if value < 0.0 => {
                Err(self.fault(format!("{column} = {value}: must be a number >= 0")))
            }
            value => Ok(value),
        }
    }

    /// A number that must be there.
    pub(super) fn required(&self, column: &str) -> Result<f64, FileError> {
        let value = self.number(column)?;
        value.ok_or_else(|| self.fault(format!("{column}: must be given")))
    }

    /// Three numbers: all given, or none.
    pub(super) fn vector(&self, columns: [&str; 3]) -> Result<Option<[f64; 3]>, FileError> {
        let [x, y, z] = columns;
        match (self.number(x)?, self.number(y)?, self.number(z)?) {
            (Some(x), Some(y), Some(z)) => Ok(Some([x, y, z])),
            (None, None, None) => Ok(None),
            _ => Err(self.fault(format!("{x}, {y}, {z}: must be given together"))),
        }
    }

    /// Number of a node.
    pub(super) fn node(&self, column: &str) -> Result<i64, FileError> {
        let text = self.text(column).unwrap_or_default();
        let node = whole(column, text, 1, i64::from(i32::MAX));
        node.map_err(|rule| self.fault(rule))
    }
}

/// Coordinates of nodes: columns node, x, y, z.
pub(super) fn read_nodes(path: &Path) -> Result<BTreeMap<i64, [f64; 3]>, FileError> {
    let table = TextTable::read(path, &["node", "x", "y", "z"], &[])?;
    let mut nodes = BTreeMap::new();
    for row in table.rows() {
        let node = row.node("node")?;
        let position = [row.required("x")?, row.required("y")?, row.required("z")?];
        if nodes.insert(node, position).is_some() {
            return Err(row.fault(format!("node {node}: must be given once")));
        }
    }
    Ok(nodes)
}
