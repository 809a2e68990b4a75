//! Matrices of CalculiX's `*FREQUENCY, SOLVER=MATRIXSTORAGE`: `row column value` (`.sti`, `.mas`) and names `node.dof` (`.dof`), those
//! of an imported model (`dofs.txt`) too.

use std::path::Path;

use super::super::dof::{Component, Dof};
use super::super::lines::{Lines, MOST_ROWS, number, size, whole, words};
use super::super::matrix::{Content, Entries, ImportedMatrix, Naming, Rows, Storage};
use super::abaqus_matrix::dof_of;
use crate::file::{FileError, significant_digits};

/// Reads a matrix. Its size is that of its largest index: every row has its diagonal entry.
pub(in crate::import) fn read_matrix(path: &Path, text: &str) -> Result<ImportedMatrix, FileError> {
    let mut entries = Entries::default();
    let mut lines = Lines::new(path, text);
    while let Some(line) = lines.next() {
        let words: Vec<&str> = words(line).collect();
        match words[..] {
            [] => {}
            [row, column, value] => {
                let fault = |rule| lines.fault(rule);
                let row = size("row", row).map_err(fault)?;
                let column = size("column", column).map_err(fault)?;
                let number = number(value).map_err(fault)?;
                entries.add(row - 1, column - 1, number, lines.number);
                entries.note_digits(significant_digits(value));
            }
            _ => return Err(lines.fault("must be an entry: row column value")),
        }
    }
    let n = entries.largest();
    if n == 0 {
        return Err(FileError::content(path, None, "has no entry"));
    }
    let digits = entries.digits();
    Ok(ImportedMatrix {
        name: String::new(),
        path: path.to_owned(),
        rows: Rows::Numbered(n),
        content: Content::Symmetric(entries.symmetric(path, n, Storage::Unknown)?),
        digits,
    })
}

/// Reads names: one `node.dof` per line; or, where none has a number behind the point, rows such as `12`, and `1.MODE`.
pub(in crate::import) fn read_names(path: &Path, text: &str) -> Result<Vec<Dof>, FileError> {
    let mut naming = Naming::default();
    let mut lines = Lines::new(path, text);
    let mut first_row = None;
    let mut numbered = false;
    while let Some(line) = lines.next() {
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        let dof = name(line).map_err(|rule| lines.fault(rule))?;
        match dof.component {
            Component::TextRow => drop(first_row.get_or_insert(lines.number)),
            Component::Number(_) => numbered = true,
            Component::Label(_) => {}
        }
        naming.add(dof).map_err(|rule| lines.fault(rule))?;
    }
    match naming.len() {
        0 => Err(FileError::content(path, None, "has no name")),
        _ if numbered && first_row.is_some() => Err(FileError::content(path, first_row, NAME)),
        _ => Ok(naming.names()),
    }
}

const NAME: &str = "must be a degree of freedom: node.dof, such as 113.1";

/// A degree of freedom as [`Dof`] is shown.
fn name(line: &str) -> Result<Dof, String> {
    let Some((node, component)) = line.split_once('.') else {
        let row = whole("row", line, 1, MOST_ROWS as i64).map_err(|_| NAME)?;
        return Ok(Dof::row(row as usize - 1));
    };
    let in_label = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    if component.starts_with(|c: char| c.is_ascii_uppercase()) && component.chars().all(in_label) {
        let node = dof_of(node, "0")?.node;
        return Ok(Dof::labelled(node, component));
    }
    dof_of(node, component)
}
