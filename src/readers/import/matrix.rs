//! A matrix that was read: its names, its entries, how exactly its file states them. All readers give this type.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::dof::Dof;
use super::lines::MOST_ROWS;
use super::symmetric::Symmetric;
use crate::file::FileError;
pub(super) use crate::model::matrix_writer::DOUBLE_DIGITS;

/// Largest difference of two entries that must be equal, relative to them and to their diagonal entries.
const SYMMETRY: f64 = 1e-8;
/// Digits that a binary number of single precision has, rounded up.
pub(super) const SINGLE_DIGITS: u32 = 8;

/// A matrix or vector as a file states it, in the units of the file.
#[derive(Debug, Clone)]
pub struct ImportedMatrix {
    /// Name in the file; empty where the format has none.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// Names of the rows where the file has them; else the number of rows.
    pub rows: Rows,
    /// The numbers.
    pub content: Content,
    /// Most significant digits that a number of the file has.
    pub digits: u32,
}

/// Rows of a matrix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rows {
    /// So many, without names.
    Numbered(usize),
    /// Names in the order of the rows.
    Named(Vec<Dof>),
}

impl Rows {
    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        match self {
            Self::Numbered(n) => *n,
            Self::Named(names) => names.len(),
        }
    }
}

/// Numbers of a matrix or a vector.
#[derive(Debug, Clone)]
pub enum Content {
    /// A symmetric matrix.
    Symmetric(Symmetric),
    /// One column.
    Column(Vec<f64>),
}

impl Content {
    /// As one column: the only entry of a matrix of one row is one.
    pub(super) fn column(&self) -> Option<Vec<f64>> {
        match self {
            Self::Column(column) => Some(column.clone()),
            Self::Symmetric(number) if number.n == 1 => Some(number.diagonal()),
            Self::Symmetric(_) => None,
        }
    }
}

/// Which entries a file states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Storage {
    /// Those of one triangle, or of both with equal values.
    Triangle,
    /// All that are not zero.
    Full,
    /// The format does not say: all if any pair of entries (i, j), (j, i) is there, else one of each.
    Unknown,
}

/// Rows that become known by their names, in the order in which they come.
#[derive(Debug, Default)]
pub(super) struct Naming {
    index: BTreeMap<Dof, usize>,
    names: Vec<Dof>,
}

impl Naming {
    /// The index of a name, a new one if it is not known.
    ///
    /// # Errors
    /// The rule if there are too many.
    pub(super) fn index(&mut self, dof: Dof) -> Result<usize, String> {
        if let Some(&index) = self.index.get(&dof) {
            return Ok(index);
        }
        if self.names.len() == MOST_ROWS {
            return Err(format!("has more than {MOST_ROWS} degrees of freedom"));
        }
        self.names.push(dof.clone());
        self.index.insert(dof, self.names.len() - 1);
        Ok(self.names.len() - 1)
    }

    /// A name that must be new.
    ///
    /// # Errors
    /// The rule if it is not, or if there are too many.
    pub(super) fn add(&mut self, dof: Dof) -> Result<(), String> {
        if self.index.contains_key(&dof) {
            return Err(format!("degree of freedom {dof}: must be given once"));
        }
        self.index(dof).map(|_| ())
    }

    pub(super) fn names(self) -> Vec<Dof> {
        self.names
    }

    pub(super) fn len(&self) -> usize {
        self.names.len()
    }
}

/// One entry of a file. Indices are below [`MOST_ROWS`].
#[derive(Debug, Clone, Copy)]
struct Entry {
    row: u32,
    column: u32,
    line: u32,
    value: f64,
}

impl Entry {
    /// What is wrong with it; its line is 0 in formats without lines.
    fn fault(&self, path: &Path, rule: String) -> FileError {
        let line = (self.line > 0).then_some(u64::from(self.line));
        FileError::content(path, line, rule)
    }
}

/// Entries as they are read.
#[derive(Debug, Default)]
pub(super) struct Entries {
    entries: Vec<Entry>,
    digits: u32,
}

impl Entries {
    /// Notes an entry (indices from 0) that stands in `line`.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64, line: u64) {
        assert!(
            row < MOST_ROWS && column < MOST_ROWS,
            "readers check the indices"
        );
        self.entries.push(Entry {
            row: row as u32,
            column: column as u32,
            line: u32::try_from(line).unwrap_or(u32::MAX),
            value,
        });
    }

    /// Notes how many digits a number has.
    pub(super) fn note_digits(&mut self, digits: u32) {
        self.digits = self.digits.max(digits);
    }

    pub(super) fn digits(&self) -> u32 {
        self.digits
    }

    /// 1 + the largest index, 0 without entries.
    pub(super) fn largest(&self) -> usize {
        let indices = self.entries.iter().map(|e| e.row.max(e.column));
        indices.max().map_or(0, |largest| largest as usize + 1)
    }

    /// The symmetric matrix of `n` rows that these entries are.
    ///
    /// # Errors
    /// [`FileError`] with the line if an entry is given twice, or on both sides with different values, or on one side of a
    /// matrix that states both.
    pub(super) fn symmetric(
        mut self,
        path: &Path,
        n: usize,
        storage: Storage,
    ) -> Result<Symmetric, FileError> {
        let sides = |e: &Entry| (e.row.min(e.column), e.row.max(e.column), e.row < e.column);
        self.entries.sort_by_key(sides);
        self.given_once(path)?;
        let fault = |entry: &Entry, rule: String| entry.fault(path, rule);
        let mirrored = |a: &Entry, b: &Entry| (a.row, a.column) == (b.column, b.row);
        let diagonal = self.diagonal(n);
        let scale = |e: &Entry| {
            let product = diagonal[e.row as usize] * diagonal[e.column as usize];
            product.abs().sqrt().max(e.value.abs())
        };
        let both_sides = storage == Storage::Full
            || storage == Storage::Unknown
                && (self.entries.windows(2)).any(|two| mirrored(&two[0], &two[1]));
        let mut lower = Vec::with_capacity(self.entries.len());
        let mut rest = &self.entries[..];
        while let Some((first, after)) = rest.split_first() {
            let second = after.first().filter(|e| mirrored(first, e));
            if let Some(second) = second {
                let allowed = SYMMETRY * scale(first).max(scale(second));
                if (first.value - second.value).abs() > allowed {
                    let (a, b) = (place(first), place(second));
                    let rule = format!(
                        "must be symmetric: {a} = {} and {b} = {} differ",
                        first.value, second.value
                    );
                    return Err(fault(second, rule));
                }
            } else if both_sides && first.row != first.column {
                let small = first.value.abs() <= SYMMETRY * scale(first);
                if !small {
                    let rule = format!(
                        "must be symmetric: {} = {} has no entry on the other side, but the file states both sides",
                        place(first),
                        first.value
                    );
                    return Err(fault(first, rule));
                }
            }
            let (row, column) = (first.row.max(first.column), first.row.min(first.column));
            lower.push((row as usize, column as usize, first.value));
            rest = &after[usize::from(second.is_some())..];
        }
        Ok(Symmetric { n, lower })
    }

    /// The entries of one column of `n` rows.
    ///
    /// # Errors
    /// [`FileError`] with the line if an entry is given twice.
    pub(super) fn column(mut self, path: &Path, n: usize) -> Result<Vec<f64>, FileError> {
        self.entries.sort_by_key(|e| e.row);
        self.given_once(path)?;
        let mut column = vec![0.0; n];
        for entry in &self.entries {
            column[entry.row as usize] = entry.value;
        }
        Ok(column)
    }

    /// Refuses an entry that stands beside itself.
    fn given_once(&self, path: &Path) -> Result<(), FileError> {
        let same = |a: &Entry, b: &Entry| (a.row, a.column) == (b.row, b.column);
        match self.entries.windows(2).find(|two| same(&two[0], &two[1])) {
            None => Ok(()),
            Some(two) => {
                let rule = format!("{}: must be given once", place(&two[1]));
                Err(two[1].fault(path, rule))
            }
        }
    }

    fn diagonal(&self, n: usize) -> Vec<f64> {
        let mut diagonal = vec![0.0; n];
        for entry in self.entries.iter().filter(|e| e.row == e.column) {
            diagonal[entry.row as usize] = entry.value;
        }
        diagonal
    }
}

fn place(entry: &Entry) -> String {
    format!("entry ({}, {})", entry.row + 1, entry.column + 1)
}
