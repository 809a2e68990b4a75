//! Matrices of `*MATRIX OUTPUT, FORMAT=MATRIX INPUT` (Abaqus) and `*MATRIX ASSEMBLE` (CalculiX): `node, dof, node, dof, value`.

use std::path::Path;

use super::super::dof::Dof;
use super::super::lines::{Lines, number, whole, words};
use super::super::matrix::{Content, Entries, ImportedMatrix, Naming, Rows, Storage};
use crate::file::{FileError, significant_digits};

/// Largest number of a node, either sign: that of 32-bit integers.
const LARGEST_NODE: i64 = i32::MAX as i64;
/// Largest number of a component.
const LARGEST_COMPONENT: i64 = 9_999;

/// Reads a matrix, or the loads of one `*CLOAD` (`node, dof, value`). Lines that start with `*` are no entries.
pub(in crate::import) fn read(path: &Path, text: &str) -> Result<ImportedMatrix, FileError> {
    let mut naming = Naming::default();
    let mut entries = Entries::default();
    let mut loads = Vec::new();
    let mut lines = Lines::new(path, text);
    while let Some(line) = lines.next() {
        if line.is_empty() || line.starts_with('*') {
            let upper = line.to_ascii_uppercase();
            if upper.starts_with("*CLOAD") {
                one_load(&upper, loads.is_empty()).map_err(|rule| lines.fault(rule))?;
            }
            continue;
        }
        let number = lines.number;
        let fault = |rule| lines.fault(rule);
        let words: Vec<&str> = words(line).collect();
        match words[..] {
            [node, dof, other, other_dof, value] if loads.is_empty() => {
                let row = dof_of(node, dof).and_then(|dof| naming.index(dof));
                let column = dof_of(other, other_dof).and_then(|dof| naming.index(dof));
                let (row, column) = (row.map_err(fault)?, column.map_err(fault)?);
                entries.add(row, column, entry(value).map_err(fault)?, number);
                entries.note_digits(significant_digits(value));
            }
            [node, dof, value] if entries.largest() == 0 => {
                let dof = dof_of(node, dof).map_err(fault)?;
                naming.add(dof).map_err(fault)?;
                loads.push(entry(value).map_err(fault)?);
                entries.note_digits(significant_digits(value));
            }
            _ => {
                let rule = "must be an entry: node, dof, node, dof, value";
                return Err(lines.fault(rule));
            }
        }
    }
    if naming.len() == 0 {
        return Err(FileError::content(path, None, "has no entry"));
    }
    let digits = entries.digits();
    let content = match loads.is_empty() {
        true => Content::Symmetric(entries.symmetric(path, naming.len(), Storage::Unknown)?),
        false => Content::Column(loads),
    };
    Ok(ImportedMatrix {
        name: String::new(),
        path: path.to_owned(),
        rows: Rows::Named(naming.names()),
        content,
        digits,
    })
}

/// Requires that a CLOAD (in capital letters) begins the only load of a file. Others are further load cases or imaginary parts: that
/// they act at once, or as the cosine part, is nowhere said.
///
/// # Errors
/// The rule that it breaks.
pub(in crate::import) fn one_load(keyword: &str, first: bool) -> Result<(), String> {
    let what = match first {
        _ if keyword.contains("IMAGINARY") => "is the imaginary part of a load",
        false => "is a second load",
        true => return Ok(()),
    };
    Err(format!(
        "{what}: a file must have one, and a real one; --excite or --forces states any other force"
    ))
}

/// The degree of freedom that two words state.
///
/// # Errors
/// The rule that they break.
pub(in crate::import) fn dof_of(node: &str, component: &str) -> Result<Dof, String> {
    let node = whole("node", node, -LARGEST_NODE, LARGEST_NODE)?;
    let component = whole("degree of freedom", component, 0, LARGEST_COMPONENT)?;
    Ok(Dof::new(node, component as u32))
}

fn entry(word: &str) -> Result<f64, String> {
    number(word).map_err(|rule| format!("value {rule}"))
}
