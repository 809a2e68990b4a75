//! ANSYS `HBMAT`: a Harwell-Boeing file with its `.mapping` beside it.
//!
//! Format: Duff, Grimes & Lewis, Users' guide for the Harwell-Boeing sparse matrix collection, 1992. Assembled real matrices
//! (RSA, RUA) with numbers of fixed width, as the header states it.

use std::path::Path;

use super::super::dof::Dof;
use super::super::lines::{Lines, number, size, whole};
use super::super::matrix::{Content, Entries, ImportedMatrix, Naming, Rows, Storage};
use crate::file::{FileError, significant_digits};

/// Characters of a number at most.
const WIDEST: i64 = 64;
/// Numbers of a line at most.
const MOST_PER_LINE: i64 = 1_000;
/// Lines of a block at most.
const MOST_LINES: i64 = 1_000_000_000;

/// What the header states.
struct Header {
    symmetric: bool,
    n: usize,
    entries: usize,
    pointers: LineBlock,
    indices: LineBlock,
    values: LineBlock,
    /// The right-hand side, a load.
    load: Option<LineBlock>,
}

/// Lines of numbers of one width.
#[derive(Clone, Copy)]
struct LineBlock {
    what: &'static str,
    lines: usize,
    per_line: usize,
    width: usize,
}

/// Reads the matrix, and its right-hand side where there is one. Both are without names: these stand in the `.mapping`.
pub(in crate::import) fn read(path: &Path, text: &str) -> Result<Vec<ImportedMatrix>, FileError> {
    let mut lines = Lines::new(path, text);
    let header = Header::read(&mut lines)?;
    let n = header.n;
    let pointers = whole_numbers(&mut lines, header.pointers, n + 1, header.entries + 1)?;
    let ordered = pointers.first() == Some(&1)
        && pointers.windows(2).all(|two| two[0] <= two[1])
        && pointers.last() == Some(&(header.entries + 1));
    if !ordered {
        let rule = format!(
            "column pointers must ascend from 1 to {}, the number of entries + 1",
            header.entries + 1
        );
        return Err(lines.fault(rule));
    }
    let rows = whole_numbers(&mut lines, header.indices, header.entries, n)?;
    let mut values = Values::new(&mut lines, header.values);
    let mut entries = Entries::default();
    for (column, two) in pointers.windows(2).enumerate() {
        for &row in &rows[two[0] - 1..two[1] - 1] {
            let (value, digits, line) = values.next()?;
            entries.add(row - 1, column, value, line);
            entries.note_digits(digits);
        }
    }
    values.finish(header.entries)?;
    let storage = match header.symmetric {
        true => Storage::Triangle,
        false => Storage::Full,
    };
    let digits = entries.digits();
    let matrix = |name: &str, content, digits| ImportedMatrix {
        name: name.to_owned(),
        path: path.to_owned(),
        rows: Rows::Numbered(n),
        content,
        digits,
    };
    let symmetric = entries.symmetric(path, n, storage)?;
    let mut found = vec![matrix("", Content::Symmetric(symmetric), digits)];
    if let Some(block) = header.load {
        let mut values = Values::new(&mut lines, block);
        let mut column = Vec::with_capacity(n);
        let mut most = 0;
        for _ in 0..n {
            let (value, digits, _) = values.next()?;
            most = most.max(digits);
            column.push(value);
        }
        values.finish(n)?;
        found.push(matrix("RHS", Content::Column(column), most));
    }
    match lines.find(|line| !line.trim().is_empty()) {
        Some(_) => Err(lines.fault("must be the end of the file by its header")),
        None => Ok(found),
    }
}

impl Header {
    fn read(lines: &mut Lines<'_>) -> Result<Self, FileError> {
        lines.need("the title")?;
        let line = lines.need("the counts of lines")?;
        let counts = counts(line, 5).map_err(|rule| lines.fault(rule))?;
        let line = lines.need("the type of the matrix")?;
        let (kind, sizes) = line.split_at_checked(3).unwrap_or((line, ""));
        let symmetric = match kind.to_ascii_uppercase().as_str() {
            "RSA" => true,
            "RUA" => false,
            _ => return Err(lines.fault("type must be RSA or RUA: a real assembled matrix")),
        };
        let sizes: Vec<&str> = sizes.split_whitespace().collect();
        let [rows, columns, entries, ..] = sizes[..] else {
            return Err(lines.fault("must state type, rows, columns, entries"));
        };
        let fault = |rule| lines.fault(rule);
        let n = size("rows", rows).map_err(fault)?;
        if size("columns", columns).map_err(fault)? != n {
            return Err(lines.fault(format!("{columns} columns: must be {n}, the rows")));
        }
        let most = match symmetric {
            true => n * (n + 1) / 2,
            false => n * n,
        };
        let entries = whole("entries", entries, 1, most as i64).map_err(fault)? as usize;
        let line = lines.need("the formats of the numbers")?;
        let formats: Vec<&str> = line.split_whitespace().collect();
        let block = |what, index: usize, lines_stated: i64| {
            let format = formats.get(index).copied().unwrap_or_default();
            LineBlock::new(what, format, lines_stated)
        };
        let fault = |rule| lines.fault(rule);
        let pointers = block("column pointers", 0, counts[1]).map_err(fault)?;
        let indices = block("row indices", 1, counts[2]).map_err(fault)?;
        let values = block("values", 2, counts[3]).map_err(fault)?;
        let load = match counts[4] {
            0 => None,
            stated => Some(block("right-hand side", 3, stated).map_err(fault)?),
        };
        if load.is_some() {
            let line = lines.need("the type of the right-hand side")?;
            full_and_single(line).map_err(|rule| lines.fault(rule))?;
        }
        Ok(Self {
            symmetric,
            n,
            entries,
            pointers,
            indices,
            values,
            load,
        })
    }
}

/// The line of a right-hand side: `F`, one column.
fn full_and_single(line: &str) -> Result<(), String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    match words[..] {
        [kind, "1", ..] if kind.eq_ignore_ascii_case("F") => Ok(()),
        _ => Err("right-hand side must be full (F) and one column".to_owned()),
    }
}

/// Whole numbers of a header line; those that are absent at its end are 0.
fn counts(line: &str, many: usize) -> Result<Vec<i64>, String> {
    let mut counts = Vec::new();
    for word in line.split_whitespace().take(many) {
        counts.push(whole("count of lines", word, 0, MOST_LINES)?);
    }
    if counts.len() < 4 {
        return Err("must state how many lines follow: in all, pointers, indices, values".into());
    }
    counts.resize(many, 0);
    Ok(counts)
}

impl LineBlock {
    /// `(I14)`, `(8I10)`, `(1P,3D25.15)`.
    fn new(what: &'static str, format: &str, lines: i64) -> Result<Self, String> {
        let rule = format!("format {format} of the {what}: must be such as (I14) or (3D25.15)");
        let upper = format.to_ascii_uppercase();
        let inner = upper.strip_prefix('(').and_then(|f| f.strip_suffix(')'));
        let inner = inner.ok_or_else(|| rule.clone())?;
        let inner = inner.strip_prefix("1P").unwrap_or(inner);
        let inner = inner.trim_start_matches(',');
        let letter = inner.find(|c| "IEDFG".contains(c)).ok_or(rule.clone())?;
        let (count, rest) = (&inner[..letter], &inner[letter + 1..]);
        let width = rest.split('.').next().unwrap_or_default();
        let count = if count.is_empty() { "1" } else { count };
        let per_line = whole("", count, 1, MOST_PER_LINE).map_err(|_| rule.clone())?;
        let width = whole("", width, 1, WIDEST).map_err(|_| rule)?;
        Ok(Self {
            what,
            lines: lines as usize,
            per_line: per_line as usize,
            width: width as usize,
        })
    }

    /// Requires that so many numbers fill the lines that the header states.
    fn holds(&self, numbers: usize) -> Result<(), String> {
        let (needed, stated, what) = (numbers.div_ceil(self.per_line), self.lines, self.what);
        match needed == stated {
            true => Ok(()),
            false => Err(format!(
                "{what}: the header states {stated} lines, but {numbers} numbers fill {needed}"
            )),
        }
    }
}

/// Words of fixed width, line by line.
struct Values<'l, 't> {
    lines: &'l mut Lines<'t>,
    block: LineBlock,
    line: &'t str,
    /// Numbers that the line still holds at most.
    left: usize,
    read: usize,
}

impl<'l, 't> Values<'l, 't> {
    fn new(lines: &'l mut Lines<'t>, block: LineBlock) -> Self {
        Self {
            lines,
            block,
            line: "",
            left: 0,
            read: 0,
        }
    }

    fn word(&mut self) -> Result<&'t str, FileError> {
        if self.left == 0 {
            self.nothing_left()?;
            self.line = self.lines.need(self.block.what)?;
            self.left = self.block.per_line;
        }
        let end = self.block.width.min(self.line.len());
        let split = self.line.split_at_checked(end);
        let (word, rest) = split.ok_or_else(|| self.lines.fault("must be plain text (ASCII)"))?;
        (self.line, self.left, self.read) = (rest, self.left - 1, self.read + 1);
        match word.trim() {
            "" => Err(self.lines.fault(format!(
                "number {} of the {} is missing",
                self.read, self.block.what
            ))),
            word => Ok(word),
        }
    }

    /// The next number, its digits and its line.
    fn next(&mut self) -> Result<(f64, u32, u64), FileError> {
        let word = self.word()?;
        let value = number(word).map_err(|rule| self.lines.fault(rule))?;
        Ok((value, significant_digits(word), self.lines.number))
    }

    /// Requires that nothing is left of the last line, and that there were as many lines as stated.
    fn finish(self, numbers: usize) -> Result<(), FileError> {
        let full = self.block.holds(numbers);
        full.map_err(|rule| self.lines.fault(rule))?;
        self.nothing_left()
    }

    fn nothing_left(&self) -> Result<(), FileError> {
        match self.line.trim() {
            "" => Ok(()),
            _ => {
                let rule = format!("has more numbers than the {} need", self.block.what);
                Err(self.lines.fault(rule))
            }
        }
    }
}

/// `count` whole numbers from 1 to `most`.
fn whole_numbers(
    lines: &mut Lines<'_>,
    block: LineBlock,
    count: usize,
    most: usize,
) -> Result<Vec<usize>, FileError> {
    block.holds(count).map_err(|rule| lines.fault(rule))?;
    let mut values = Values::new(lines, block);
    // grows with the file: the header may state more than there is
    let mut found = Vec::new();
    for _ in 0..count {
        let word = values.word()?;
        let value = whole(block.what, word, 1, most as i64);
        found.push(value.map_err(|rule| values.lines.fault(rule))? as usize);
    }
    values.finish(count)?;
    Ok(found)
}

/// Reads a `.mapping`: `equation node label`, one line per row.
pub(in crate::import) fn read_mapping(path: &Path, text: &str) -> Result<Vec<Dof>, FileError> {
    let mut naming = Naming::default();
    let mut lines = Lines::new(path, text);
    while let Some(line) = lines.next() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let heading = words
            .first()
            .is_some_and(|word| word.parse::<i64>().is_err());
        if words.is_empty() || heading && naming.len() == 0 {
            continue;
        }
        let [equation, node, label] = words[..] else {
            return Err(lines.fault("must be a row of the mapping: equation node label"));
        };
        let fault = |rule| lines.fault(rule);
        let next = naming.len() + 1;
        if equation.parse() != Ok(next) {
            let rule = format!("equation {equation}: must be {next}, the next one");
            return Err(lines.fault(rule));
        }
        let node = whole("node", node, 1, i64::from(i32::MAX)).map_err(fault)?;
        let plain = label.len() <= 8 && label.chars().all(|c| c.is_ascii_alphanumeric());
        if !plain {
            return Err(lines.fault("label must be such as UX or ROTZ"));
        }
        naming.add(Dof::labelled(node, label)).map_err(fault)?;
    }
    match naming.len() {
        0 => Err(FileError::content(path, None, "has no row")),
        _ => Ok(naming.names()),
    }
}
