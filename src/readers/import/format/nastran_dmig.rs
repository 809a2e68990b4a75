//! Nastran DMIG entries: matrices column by column, rows and columns named by grid point and component.
//!
//! Format: MSC Nastran Quick Reference Guide, DMIG. Form 6 (symmetric) may state either triangle.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::lines::{number, whole};
use super::super::matrix::{Content, Entries, ImportedMatrix, Naming, Rows, Storage};
use super::abaqus_matrix::dof_of;
use super::nastran_cards::{Card, each_card};
use crate::file::{FileError, significant_digits};

/// Largest number of a column of a load.
const MOST_COLUMNS: i64 = 1_000_000;

/// Numbers of all columns of a load at most.
const MOST_LOADS: usize = 1_000_000;
/// Matrices of a file at most.
const MOST_MATRICES: usize = 100;

/// A matrix that grows column by column.
struct Growing {
    name: String,
    shape: Shape,
    naming: Naming,
    entries: Entries,
    /// Column number, row, value of a load.
    loads: Vec<(String, usize, f64, u64)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Square,
    Symmetric,
    Rectangular,
    /// Passed over: no part of a model.
    Complex,
}

/// Reads all real matrices.
pub(in crate::import) fn read(path: &Path, text: &str) -> Result<Vec<ImportedMatrix>, FileError> {
    let mut matrices: Vec<Growing> = Vec::new();
    each_card(path, text, &["DMIG"], |card| {
        let name = card.field(0).to_ascii_uppercase();
        let known = matrices.iter().position(|matrix| matrix.name == name);
        match (known, card.field(1)) {
            (None, "0") if matrices.len() == MOST_MATRICES => {
                let rule = format!("has more than {MOST_MATRICES} matrices");
                Err(card.fault(path, 0, rule))
            }
            (None, "0") => {
                let shape = header(&card).map_err(|rule| card.fault(path, 0, rule))?;
                matrices.push(Growing {
                    name,
                    shape,
                    naming: Naming::default(),
                    entries: Entries::default(),
                    loads: Vec::new(),
                });
                Ok(())
            }
            (Some(_), "0") => {
                Err(card.fault(path, 0, format!("matrix {name}: has a second header")))
            }
            (None, _) => Err(card.fault(
                path,
                0,
                format!("matrix {name:.40}: has no header (DMIG name 0) before its columns"),
            )),
            (Some(at), _) if matrices[at].shape == Shape::Complex => Ok(()),
            (Some(at), _) => matrices[at].column(path, &card),
        }
    })?;
    let stated = matrices.len();
    matrices.retain(|matrix| matrix.shape != Shape::Complex);
    if stated > 0 && matrices.is_empty() {
        let rule = "has complex matrices only: must have real ones";
        return Err(FileError::content(path, None, rule));
    }
    let mut found = Vec::new();
    for matrix in matrices {
        found.extend(matrix.finish(path)?);
    }
    Ok(found)
}

/// `DMIG name 0 form type type-out polar blank columns`.
fn header(card: &Card<'_>) -> Result<Shape, String> {
    let name = card.field(0);
    if name.is_empty() || name.len() > 8 {
        return Err("must have a name of at most 8 letters".to_owned());
    }
    match card.field(3) {
        "1" | "2" => {}
        "3" | "4" => return Ok(Shape::Complex),
        other => {
            return Err(format!(
                "matrix {name}: type {other:.20}: must be 1 or 2 (real)"
            ));
        }
    }
    match card.field(2) {
        "1" => Ok(Shape::Square),
        "6" => Ok(Shape::Symmetric),
        "2" | "9" => Ok(Shape::Rectangular),
        other => Err(format!(
            "matrix {name}: form {other:.20}: must be 1 (square), 6 (symmetric), 2 or 9 (rectangular)"
        )),
    }
}

impl Growing {
    /// `DMIG name column-point column-component blank`, then `point component real imaginary` for each row.
    fn column(&mut self, path: &Path, card: &Card<'_>) -> Result<(), FileError> {
        let at = |index: usize| move |rule: String| card.fault(path, index, rule);
        let rectangular = self.shape == Shape::Rectangular;
        let column = match rectangular {
            true => {
                whole("column", card.field(1), 1, MOST_COLUMNS).map_err(at(1))?;
                0
            }
            false => {
                let dof = point(card.field(1), card.field(2)).map_err(at(1))?;
                self.naming.index(dof).map_err(at(1))?
            }
        };
        let column_name = format!("{}.{}", card.field(1), card.field(2));
        for (group, four) in card.fields[4.min(card.fields.len())..]
            .chunks(4)
            .enumerate()
        {
            let index = 4 + 4 * group;
            if four.iter().all(|(_, field)| field.is_empty()) {
                continue;
            }
            let [.., (line, _)] = four else { continue };
            let row = point(card.field(index), card.field(index + 1)).map_err(at(index))?;
            let word = card.field(index + 2);
            let value = number(word).map_err(|rule| format!("value {rule}"));
            let value = value.map_err(at(index))?;
            let imaginary = card.field(index + 3);
            if !imaginary.is_empty() && number(imaginary) != Ok(0.0) {
                let rule = format!("imaginary part {imaginary:.20}: must be absent");
                return Err(card.fault(path, index, rule));
            }
            let row = self.naming.index(row).map_err(at(index))?;
            self.entries.note_digits(significant_digits(word));
            match rectangular {
                false => self.entries.add(row, column, value, *line),
                true => self.loads.push((column_name.clone(), row, value, *line)),
            }
        }
        Ok(())
    }

    /// The matrix, or one load for each column.
    fn finish(self, path: &Path) -> Result<Vec<ImportedMatrix>, FileError> {
        let digits = self.entries.digits();
        let n = self.naming.len();
        let rows = Rows::Named(self.naming.names());
        let matrix = |name: String, content| ImportedMatrix {
            name,
            path: path.to_owned(),
            rows: rows.clone(),
            content,
            digits,
        };
        if n == 0 {
            let rule = format!("matrix {}: has no column", self.name);
            return Err(FileError::content(path, None, rule));
        }
        let storage = match self.shape {
            Shape::Symmetric => Storage::Triangle,
            Shape::Square => Storage::Full,
            Shape::Rectangular => {
                return loads(path, &self.name, &self.loads, n, matrix);
            }
            Shape::Complex => return Ok(Vec::new()),
        };
        let symmetric = self.entries.symmetric(path, n, storage)?;
        Ok(vec![matrix(self.name, Content::Symmetric(symmetric))])
    }
}

/// A vector for each column; `NAME`, or `NAME.COLUMN` where there are several.
fn loads(
    path: &Path,
    name: &str,
    entries: &[(String, usize, f64, u64)],
    n: usize,
    matrix: impl Fn(String, Content) -> ImportedMatrix,
) -> Result<Vec<ImportedMatrix>, FileError> {
    let mut columns: BTreeMap<&str, Vec<Option<f64>>> = BTreeMap::new();
    for (column, row, value, line) in entries {
        let fault = |rule: String| FileError::content(path, Some(*line), rule);
        if !columns.contains_key(column.as_str()) && (columns.len() + 1) * n > MOST_LOADS {
            return Err(fault(format!("matrix {name}: is too large")));
        }
        let values = columns.entry(column).or_insert_with(|| vec![None; n]);
        if values[*row].replace(*value).is_some() {
            let rule = format!("matrix {name}: an entry of column {column} is given twice");
            return Err(fault(rule));
        }
    }
    let several = columns.len() > 1;
    let named = |column: &str| match several {
        true => format!(
            "{name}.{}",
            column.trim_end_matches(".0").trim_end_matches('.')
        ),
        false => name.to_owned(),
    };
    let filled = |values: Vec<Option<f64>>| values.into_iter().map(Option::unwrap_or_default);
    Ok(columns
        .into_iter()
        .map(|(column, values)| matrix(named(column), Content::Column(filled(values).collect())))
        .collect())
}

/// A grid point with its component, or a scalar point, whose component is 0 or blank.
fn point(point: &str, component: &str) -> Result<super::super::dof::Dof, String> {
    let point = whole("grid point", point, 1, i64::from(i32::MAX))?.to_string();
    let component = if component.is_empty() { "0" } else { component };
    if !matches!(component, "0" | "1" | "2" | "3" | "4" | "5" | "6") {
        return Err(format!("component {component:.20}: must be 0 to 6"));
    }
    dof_of(&point, component)
}
