//! What text and binary files of Nastran's OUTPUT4 share: the header of a matrix, strings of a column, and what becomes of it.
//!
//! Format: MSC Nastran DMAP Programmer's Guide, OUTPUT4.

use std::path::{Path, PathBuf};

use super::super::lines::MOST_ROWS;
use super::super::matrix::{Content, Entries, ImportedMatrix, Rows, Storage};
use crate::file::FileError;

/// Rows or columns of a matrix at most, of one that is passed over too.
const MOST: i64 = 1_000_000_000;
/// Matrices of a file at most.
pub(in crate::import) const MOST_MATRICES: usize = 1_000;

/// What the header of a matrix states.
#[derive(Debug, Clone)]
pub(in crate::import) struct MatrixHeader {
    pub(in crate::import) name: String,
    pub(in crate::import) rows: i64,
    pub(in crate::import) columns: i64,
    /// Strings have two words of their own, not one.
    pub(in crate::import) big: bool,
    /// Numbers of double precision.
    pub(in crate::import) double: bool,
    /// Numbers of an entry: 2 if it is complex.
    pub(in crate::import) parts: i64,
    form: i64,
}

impl MatrixHeader {
    /// Columns, rows, form, type and name.
    ///
    /// # Errors
    /// The rule that they break.
    pub(in crate::import) fn new(
        [columns, rows, form, kind]: [i64; 4],
        name: &str,
    ) -> Result<Self, String> {
        let name: String = name.chars().filter(char::is_ascii_graphic).collect();
        if !(1..=MOST).contains(&columns) || !(1..=MOST).contains(&rows.abs()) {
            return Err(format!(
                "matrix {name}: is {rows} x {columns}: sizes must be from 1 to {MOST}"
            ));
        }
        if !(1..=4).contains(&kind) {
            return Err(format!("matrix {name}: type {kind}: must be 1 to 4"));
        }
        Ok(Self {
            name,
            rows: rows.abs(),
            columns,
            big: rows < 0,
            double: kind % 2 == 0,
            parts: if kind > 2 { 2 } else { 1 },
            form,
        })
    }

    /// Whether it can be a matrix or a force of a model. Others, of recovery and of complex numbers, are passed over.
    fn is_of_use(&self) -> bool {
        let small = self.rows <= MOST_ROWS as i64;
        small && self.parts == 1 && (self.rows == self.columns || self.columns == 1)
    }
}

/// A matrix that grows string by string.
#[derive(Debug)]
pub(in crate::import) struct Growing {
    pub(in crate::import) header: MatrixHeader,
    path: PathBuf,
    entries: Entries,
    column: i64,
    /// Row after the last string of the column.
    next_row: i64,
}

impl Growing {
    pub(in crate::import) fn new(path: &Path, header: MatrixHeader) -> Self {
        Self {
            path: path.to_owned(),
            header,
            entries: Entries::default(),
            column: 0,
            next_row: 1,
        }
    }

    /// Begins a column; false if the number is behind the last one, where the matrix ends.
    ///
    /// # Errors
    /// The rule if columns do not ascend.
    pub(in crate::import) fn begin(&mut self, column: i64) -> Result<bool, String> {
        let (name, last) = (&self.header.name, self.header.columns);
        if column <= self.column || column > last + 1 {
            return Err(format!(
                "matrix {name}: column {column}: must be from {} to {}",
                self.column + 1,
                last + 1
            ));
        }
        (self.column, self.next_row) = (column, 1);
        Ok(column <= last)
    }

    /// Requires that a string of so many numbers from `row` on is inside the matrix.
    ///
    /// # Errors
    /// The rule that it breaks.
    pub(in crate::import) fn string(&mut self, row: i64, numbers: i64) -> Result<(), String> {
        let MatrixHeader {
            name, rows, parts, ..
        } = &self.header;
        let end = row.saturating_add(numbers / parts);
        let fits = row >= self.next_row && numbers >= 1 && numbers % parts == 0 && end <= rows + 1;
        if !fits {
            return Err(format!(
                "matrix {name}: {numbers} numbers from row {row} on in column {}: must be in rows {} to {rows}",
                self.column, self.next_row
            ));
        }
        self.next_row = end;
        Ok(())
    }

    /// Takes number `at` of a string from `row` on.
    ///
    /// # Errors
    /// The rule if it is not finite.
    pub(in crate::import) fn take(
        &mut self,
        row: i64,
        at: i64,
        value: f64,
        place: (u32, u64),
    ) -> Result<(), String> {
        if !self.header.is_of_use() {
            return Ok(());
        }
        let (row, column) = (row + at, self.column);
        if !value.is_finite() {
            let name = &self.header.name;
            return Err(format!(
                "matrix {name}: entry ({row}, {column}) = {value}: must be a finite number"
            ));
        }
        let (digits, line) = place;
        self.entries.note_digits(digits);
        if value != 0.0 {
            self.entries
                .add(row as usize - 1, column as usize - 1, value, line);
        }
        Ok(())
    }

    /// The matrix, if it can be of use.
    pub(in crate::import) fn finish(self) -> Result<Option<ImportedMatrix>, FileError> {
        if !self.header.is_of_use() {
            return Ok(None);
        }
        let n = self.header.rows as usize;
        let digits = self.entries.digits();
        let content = match (self.header.columns, self.header.form) {
            (1, _) if n > 1 => Content::Column(self.entries.column(&self.path, n)?),
            // a symmetric form may hold either triangle, or both
            (_, 6) => {
                Content::Symmetric(self.entries.symmetric(&self.path, n, Storage::Unknown)?)
            }
            _ => Content::Symmetric(self.entries.symmetric(&self.path, n, Storage::Full)?),
        };
        Ok(Some(ImportedMatrix {
            name: self.header.name,
            path: self.path,
            rows: Rows::Numbered(n),
            content,
            digits,
        }))
    }
}
