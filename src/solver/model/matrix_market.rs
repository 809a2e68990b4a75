//! Matrix Market files: the dense or sparse real matrices that a user brings.
//!
//! Format: <https://math.nist.gov/MatrixMarket/formats.html>. A reader of our own, since the one at hand panics on numbers
//! beyond 64 bits and cannot say where an entry stands.

use std::io::{BufRead, BufReader};
use std::path::Path;

use faer::Mat;

use super::bounded_lines::Lines;
use crate::file::{self, FileError, parse_number, significant_digits};

/// Largest number of rows or columns: a dense matrix of this size takes 200 MB, its modes some minutes.
pub const LARGEST: usize = 5_000;

/// A matrix, and how exactly its file states it.
#[derive(Debug)]
pub struct Stated {
    /// The matrix.
    pub matrix: Mat<f64>,
    /// Most significant digits that an entry has.
    pub digits: u32,
}

/// What a file states of its matrix before its entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MatrixShape {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Only the lower triangle is stored.
    pub symmetric: bool,
    /// The upper triangle is its conjugate.
    pub hermitian: bool,
}

/// An entry, with indices from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Row.
    pub row: usize,
    /// Column.
    pub column: usize,
    /// Value, in the unit of the matrix.
    pub value: f64,
    /// 0 in a real matrix.
    pub imaginary: f64,
    /// Where it stands in the file.
    pub line: u64,
}

/// What takes the entries of a file.
pub trait Collects {
    /// Whether entries may be complex.
    const COMPLEX: bool = false;

    /// An empty collection; `coordinate` if entries come in any order, so that one may come twice.
    fn empty(shape: MatrixShape, coordinate: bool) -> Self;

    /// Takes an entry.
    ///
    /// # Errors
    /// The rule that it breaks.
    fn add(&mut self, entry: Entry) -> Result<(), String>;
}

/// Reads a real or integer matrix, `coordinate` or `array`, `general` or `symmetric` (lower triangle stored).
///
/// Lines that start with `%` are comments.
///
/// # Errors
/// [`FileError`] if the file cannot be read, or on the first line that does not belong to such a matrix: an entry given
/// twice among them.
pub fn read_matrix(path: &Path) -> Result<Stated, FileError> {
    let (dense, digits) = read_entries::<Dense>(path, LARGEST)?;
    Ok(Stated {
        matrix: dense.matrix,
        digits,
    })
}

/// Reads the entries of such a file, of at most `most` rows and columns, into a collection; and the most digits of an entry.
///
/// # Errors
/// As [`read_matrix`].
pub fn read_entries<C: Collects>(path: &Path, most: usize) -> Result<(C, u32), FileError> {
    let mut lines = Lines::of(path, BufReader::new(file::open(path)?));
    let header = Header::read(&mut lines, C::COMPLEX)?;
    let (number, line) = loop {
        match lines.next()? {
            None => return Err(lines.at(lines.number(), "the size line is missing".to_owned())),
            Some((_, line)) if line.starts_with('%') => {}
            Some(found) => break found,
        }
    };
    let size = header.size(&line, most);
    let size = size.map_err(|rule| lines.at(number, rule))?;
    let mut entries = Entries::<C>::new(&header, &size);
    while let Some((number, line)) = lines.next()? {
        if !line.starts_with('%') {
            let added = entries.add(&line, number);
            added.map_err(|rule| lines.at(number, rule))?;
        }
    }
    entries
        .finish()
        .map_err(|rule| FileError::content(path, None, rule))
}

/// A dense matrix with both triangles.
struct Dense {
    shape: MatrixShape,
    matrix: Mat<f64>,
    given: Given,
}

/// Which entries of a coordinate matrix are there already, column by column; none of an array, whose entries come in order.
pub(super) struct Given {
    rows: usize,
    entries: Vec<bool>,
}

impl Given {
    pub(super) fn none(shape: MatrixShape, coordinate: bool) -> Self {
        let MatrixShape { rows, columns, .. } = shape;
        Self {
            rows,
            entries: vec![false; if coordinate { rows * columns } else { 0 }],
        }
    }

    /// Notes an entry.
    ///
    /// # Errors
    /// The rule, if it is there already.
    pub(super) fn add(&mut self, Entry { row, column, .. }: Entry) -> Result<(), String> {
        let given = self.entries.get_mut(row + column * self.rows);
        match given.is_some_and(|given| std::mem::replace(given, true)) {
            true => Err(format!("{}: must be given once", place(row, column))),
            false => Ok(()),
        }
    }
}

impl Collects for Dense {
    fn empty(shape: MatrixShape, coordinate: bool) -> Self {
        Self {
            shape,
            matrix: Mat::zeros(shape.rows, shape.columns),
            given: Given::none(shape, coordinate),
        }
    }

    fn add(&mut self, entry: Entry) -> Result<(), String> {
        let Entry { row, column, .. } = entry;
        self.given.add(entry)?;
        self.matrix[(row, column)] = entry.value;
        if self.shape.symmetric {
            self.matrix[(column, row)] = entry.value;
        }
        Ok(())
    }
}

/// What the first line states.
struct Header {
    coordinate: bool,
    symmetric: bool,
    complex: bool,
    hermitian: bool,
}

const HEADER_RULE: &str = "must start with a Matrix Market header such as \
    `%%MatrixMarket matrix coordinate real symmetric`";

impl Header {
    fn read<R: BufRead>(lines: &mut Lines<'_, R>, may_be_complex: bool) -> Result<Self, FileError> {
        let Some((number, line)) = lines.next()? else {
            return Err(lines.at(1, "the file is empty".to_owned()));
        };
        let rule = |rule: &str| lines.at(number, rule.to_owned());
        let lower = line.to_ascii_lowercase();
        let words: Vec<&str> = lower.split_whitespace().collect();
        let ["%%matrixmarket", "matrix", format, field, symmetry] = words[..] else {
            return Err(rule(HEADER_RULE));
        };
        let complex = field == "complex" && may_be_complex;
        if !complex && !matches!(field, "real" | "integer" | "double") {
            return Err(rule("must be a real or integer matrix"));
        }
        let hermitian = symmetry == "hermitian" && complex;
        if !matches!(format, "coordinate" | "array")
            || !(hermitian || matches!(symmetry, "general" | "symmetric"))
        {
            return Err(rule(HEADER_RULE));
        }
        Ok(Self {
            coordinate: format == "coordinate",
            symmetric: hermitian || symmetry == "symmetric",
            complex,
            hermitian,
        })
    }

    /// What a line with an entry must have.
    fn entry_rule(&self) -> &'static str {
        match (self.coordinate, self.complex) {
            (true, false) => "must be an entry: row column value",
            (false, false) => "must be an entry: one value",
            (true, true) => "must be an entry: row column real imaginary",
            (false, true) => "must be an entry: real imaginary",
        }
    }

    /// Rows, columns and number of entries that the size line states.
    fn size(&self, line: &str, largest: usize) -> Result<Size, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (rows, columns, stated) = match (self.coordinate, &words[..]) {
            (true, [rows, columns, entries]) => (rows, columns, Some(entries)),
            (false, [rows, columns]) => (rows, columns, None),
            (true, _) => return Err("must be the size line: rows columns entries".to_owned()),
            (false, _) => return Err("must be the size line: rows columns".to_owned()),
        };
        let length = |word: &str| {
            let length = word.parse().ok().filter(|n| (1..=largest).contains(n));
            length.ok_or_else(|| format!("size {word}: must be an integer from 1 to {largest}"))
        };
        let (rows, columns) = (length(rows)?, length(columns)?);
        if self.symmetric && rows != columns {
            return Err("a symmetric matrix must be square".to_owned());
        }
        let most = match self.symmetric {
            true => rows * (rows + 1) / 2,
            false => rows * columns,
        };
        let entries = match stated {
            None => most,
            Some(word) => {
                let entries = word.parse().ok().filter(|n| *n <= most);
                entries
                    .ok_or_else(|| format!("{word} entries: must be an integer from 0 to {most}"))?
            }
        };
        Ok(Size {
            rows,
            columns,
            entries,
        })
    }
}

struct Size {
    rows: usize,
    columns: usize,
    entries: usize,
}

/// Entries that come line by line.
struct Entries<'h, C> {
    header: &'h Header,
    size: &'h Size,
    collection: C,
    read: usize,
    digits: u32,
    /// Place of the next entry of an array.
    next: (usize, usize),
}

impl<'h, C: Collects> Entries<'h, C> {
    fn new(header: &'h Header, size: &'h Size) -> Self {
        let shape = MatrixShape {
            rows: size.rows,
            columns: size.columns,
            symmetric: header.symmetric,
            hermitian: header.hermitian,
        };
        Self {
            header,
            size,
            collection: C::empty(shape, header.coordinate),
            read: 0,
            digits: 0,
            next: (0, 0),
        }
    }

    /// Adds the entry of a line.
    fn add(&mut self, line: &str, number: u64) -> Result<(), String> {
        if self.read == self.size.entries {
            return Err(format!(
                "is entry {}, of {} stated",
                self.read + 1,
                self.read
            ));
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let (indices, values) =
            words.split_at(words.len().min(2 * usize::from(self.header.coordinate)));
        let (i, j) = match indices {
            [row, column] => {
                let i = index(row, self.size.rows, "row")?;
                (i, index(column, self.size.columns, "column")?)
            }
            _ => self.next,
        };
        let (word, imaginary) = match (self.header.complex, values) {
            (false, [value]) => (value, None),
            (true, [real, imaginary]) => (real, Some(imaginary)),
            _ => return Err(self.header.entry_rule().to_owned()),
        };
        let value = finite_number(word, i, j)?;
        let imaginary = imaginary.map_or(Ok(0.0), |word| finite_number(word, i, j))?;
        if self.header.symmetric && i < j {
            let rule = "a symmetric matrix must store its lower triangle (row >= column) only";
            return Err(format!("{}: {rule}", place(i, j)));
        }
        self.digits = self.digits.max(significant_digits(word));
        self.collection.add(Entry {
            row: i,
            column: j,
            value,
            imaginary,
            line: number,
        })?;
        self.read += 1;
        self.next = match i + 1 < self.size.rows {
            true => (i + 1, j),
            false if self.header.symmetric => (j + 1, j + 1),
            false => (0, j + 1),
        };
        Ok(())
    }

    fn finish(self) -> Result<(C, u32), String> {
        match self.read == self.size.entries {
            true => Ok((self.collection, self.digits)),
            false => Err(format!(
                "{} entries required by the size line, {} found",
                self.size.entries, self.read
            )),
        }
    }
}

/// The number that a word states, of the entry in this place.
fn finite_number(word: &str, row: usize, column: usize) -> Result<f64, String> {
    let place = place(row, column);
    let value: f64 =
        parse_number(word).ok_or_else(|| format!("{place} = {word}: must be a number"))?;
    match value.is_finite() {
        true => Ok(value),
        false => Err(format!("{place} = {word}: must be a finite number")),
    }
}

/// An entry as messages name it.
pub(super) fn place(row: usize, column: usize) -> String {
    format!("entry ({}, {})", row + 1, column + 1)
}

/// A 0-based index from a 1-based one of at most `size`.
fn index(word: &str, size: usize, what: &str) -> Result<usize, String> {
    let index: Option<usize> = word.parse().ok().filter(|i| (1..=size).contains(i));
    index.map(|i| i - 1).ok_or_else(|| {
        format!("{what} {word}: must be an integer from 1 to {size} (indices start at 1; the size line states the last)")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Stated, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mtx");
        std::fs::write(&path, text).unwrap();
        read_matrix(&path)
    }

    /// Seen to fail with the mirrored entry of a symmetric matrix left out.
    #[test]
    fn every_storage_of_one_matrix_reads_the_same() {
        let storages = [
            "%%MatrixMarket matrix array real general\n2 2\n4\n-1\n-1\n3.5\n",
            "%%MatrixMarket matrix array real general\n2 2\n4.0D0\n-1\n-.1D+01\n0.35D+001\n",
            "%%MatrixMarket matrix array real symmetric\n% comment\n2 2\n4\n-1\n3.5\n",
            "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 4\n2 1 -1.0e0\n2 2 3.5\n",
            "%%matrixmarket matrix coordinate real general\n2 2 4\n1 1 4\n2 1 -1\n1 2 -1\n2 2 3.5\n",
            "%%MatrixMarket matrix coordinate INTEGER symmetric\n2 2 3\n1 1 4\n% comment\n2 1 -1\n2 2 3.5\n",
            "%%MatrixMarket matrix array real general\r\n2 2\r\n4\r\n-1\r\n-1\r\n3.5\r\n",
        ];
        for text in storages {
            let a = read(text).unwrap().matrix;
            let entries = [a[(0, 0)], a[(1, 0)], a[(0, 1)], a[(1, 1)]];
            assert_eq!(entries, [4.0, -1.0, -1.0, 3.5], "{text}");
        }
    }

    /// Seen to panic (sizes, counts and indices beyond 2^64) and to accept (an entry twice, too many of them) with the
    /// reader of `nalgebra-sparse`.
    #[test]
    fn what_is_no_real_matrix_is_refused_with_its_line() {
        let header = "%%MatrixMarket matrix coordinate real general";
        let huge = "99999999999999999999999";
        let cases = [
            ("2 2".to_owned(), ":2: must be the size line"),
            (
                "2 2 1".to_owned(),
                ": 1 entries required by the size line, 0 found",
            ),
            ("2 2 1\n3 1 1.0".to_owned(), ":3: row 3: must be"),
            ("2 2 1\n0 1 1.0".to_owned(), ":3: row 0: must be"),
            ("2 2 1\n1 -1 1.0".to_owned(), ":3: column -1: must be"),
            ("2 2 1\n1 1".to_owned(), ":3: must be an entry"),
            ("0 0 0".to_owned(), ":2: size 0: must be"),
            ("-1 2 1".to_owned(), ":2: size -1: must be"),
            (
                "2 2 1\n1 1 1e".to_owned(),
                ":3: entry (1, 1) = 1e: must be a number",
            ),
            (
                "2 2 1\n1 1 1e999".to_owned(),
                ":3: entry (1, 1) = 1e999: must be a finite",
            ),
            ("a b c".to_owned(), ":2: size a: must be"),
            (
                "2 2 5".to_owned(),
                ":2: 5 entries: must be an integer from 0 to 4",
            ),
            (format!("{huge} 2 1"), ":2: size 9999"),
            (format!("2 {huge} 1"), ":2: size 9999"),
            (
                "5001 5001 1".to_owned(),
                ":2: size 5001: must be an integer from 1 to 5000",
            ),
            (format!("2 2 {huge}"), "entries: must be"),
            (format!("2 2 1\n{huge} 1 1.0"), ":3: row 9999"),
            (format!("2 2 1\n1 {huge} 1.0"), ":3: column 9999"),
            (
                "2 2 2\n1 1 1\n\n1 1 2".to_owned(),
                ":5: entry (1, 1): must be given once",
            ),
            (
                "2 2 1\n1 1 1\n2 2 2".to_owned(),
                ":4: is entry 2, of 1 stated",
            ),
            (
                format!("2 2 1\n1 1 {}", "1".repeat(5000)),
                ":3: must be shorter",
            ),
        ];
        for (lines, expected) in cases {
            let error = read(&format!("{header}\n{lines}\n"))
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{lines}: {error}");
        }
    }

    #[test]
    fn what_does_not_begin_as_a_real_matrix_is_refused_with_its_line() {
        let others = [
            (
                "%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n",
                ":1: must be a real",
            ),
            (
                "%%MatrixMarket vector array real general\n1\n1\n",
                ":1: must start with",
            ),
            (
                "%%MatrixMarket matrix array real symmetric\n2 1\n1\n1\n",
                ":2: a symmetric matrix must be square",
            ),
            (
                "%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 2 1\n",
                ":3: entry (1, 2): a symmetric",
            ),
            ("", ":1: the file is empty"),
            (
                "%%MatrixMarket matrix coordinate real general",
                ":1: the size line is missing",
            ),
        ];
        for (text, expected) in others {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
