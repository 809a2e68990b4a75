//! Matrices of CalculiX's `*FREQUENCY, SOLVER=MATRIXSTORAGE`: `row column value` (`.sti`, `.mas`) and names `node.dof` (`.dof`).

use std::path::Path;

use super::super::dof::Dof;
use super::super::lines::{Lines, number, size, words};
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

/// Reads names: one `node.dof` per line.
pub(in crate::import) fn read_names(path: &Path, text: &str) -> Result<Vec<Dof>, FileError> {
    let mut naming = Naming::default();
    let mut lines = Lines::new(path, text);
    while let Some(line) = lines.next() {
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        let rule = "must be a degree of freedom: node.dof, such as 113.1";
        let (node, component) = line.split_once('.').ok_or_else(|| lines.fault(rule))?;
        let dof = dof_of(node, component).map_err(|rule| lines.fault(rule))?;
        naming.add(dof).map_err(|rule| lines.fault(rule))?;
    }
    match naming.len() {
        0 => Err(FileError::content(path, None, "has no name")),
        _ => Ok(naming.names()),
    }
}
