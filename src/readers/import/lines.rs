//! The lines of a text file with their numbers, and the words of a line.

use std::path::Path;

use crate::file::FileError;
pub(super) use crate::file::finite_number as number;

/// Rows of a sparse matrix at most; a reduction of so many takes some 60 GB.
pub(super) const MOST_ROWS: usize = 1_000_000;

/// Lines of a text with their numbers, without white space at the end.
#[derive(Debug, Clone)]
pub(super) struct Lines<'t> {
    path: &'t Path,
    lines: std::str::Lines<'t>,
    /// 1-based number of the line that was given last.
    pub(super) number: u64,
}

impl<'t> Lines<'t> {
    pub(super) fn new(path: &'t Path, text: &'t str) -> Self {
        Self {
            path,
            lines: text.lines(),
            number: 0,
        }
    }

    /// The fault of the line that was given last.
    pub(super) fn fault(&self, rule: impl Into<String>) -> FileError {
        FileError::content(self.path, Some(self.number), rule)
    }

    /// The next line; `missing` says what it should have been if there is none.
    pub(super) fn need(&mut self, missing: &str) -> Result<&'t str, FileError> {
        self.next().ok_or_else(|| {
            let rule = format!("the file ends where {missing} must follow");
            FileError::content(self.path, Some(self.number), rule)
        })
    }
}

impl<'t> Iterator for Lines<'t> {
    type Item = &'t str;

    fn next(&mut self) -> Option<&'t str> {
        let line = self.lines.next()?;
        self.number += 1;
        Some(line.trim_end())
    }
}

/// Words between commas and white space.
pub(super) fn words(line: &str) -> impl Iterator<Item = &str> {
    let between = |c: char| c == ',' || c.is_ascii_whitespace();
    line.split(between).filter(|word| !word.is_empty())
}

/// # Errors
/// The rule, unless the word is a whole number from `least` to `most`.
pub(super) fn whole(what: &str, word: &str, least: i64, most: i64) -> Result<i64, String> {
    let shown: String = word.chars().take(40).collect();
    let value = word.parse().ok();
    let inside = value.filter(|value| (least..=most).contains(value));
    inside.ok_or_else(|| format!("{what} {shown}: must be a whole number from {least} to {most}"))
}

/// A number of rows or columns, checked before memory is taken for them.
///
/// # Errors
/// The rule, unless it is from 1 to the largest size that is read.
pub(super) fn size(what: &str, word: &str) -> Result<usize, String> {
    let value = whole(what, word, 1, MOST_ROWS as i64)?;
    Ok(usize::try_from(value).unwrap_or_default())
}
