//! Lines of a text file with their numbers, each of bounded length.

use crate::file::{self, FileError};
use std::io::{BufRead, Read};
use std::path::Path;

/// Bytes of a line at most.
const LONGEST_LINE: u64 = 4096;

/// Lines with their numbers, each of bounded length.
pub(super) struct Lines<'p, R> {
    path: &'p Path,
    reader: R,
    number: u64,
}

impl<'p, R: BufRead> Lines<'p, R> {
    /// Those of a file, from its first one on.
    pub(super) fn of(path: &'p Path, reader: R) -> Self {
        Self {
            path,
            reader,
            number: 0,
        }
    }

    /// Number of the last line that was read.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// The next line that is not empty, without white space around it.
    pub(super) fn next(&mut self) -> Result<Option<(u64, String)>, FileError> {
        loop {
            let mut bytes = Vec::new();
            let mut bounded = self.reader.by_ref().take(LONGEST_LINE);
            let read = bounded.read_until(b'\n', &mut bytes);
            if read.map_err(|source| FileError::system(self.path, source))? == 0 {
                return Ok(None);
            }
            self.number += 1;
            if bytes.len() as u64 == LONGEST_LINE {
                let rule = format!("must be shorter than {LONGEST_LINE} bytes");
                return Err(self.at(self.number, rule));
            }
            let text = file::text(bytes).map_err(|(_, rule)| self.at(self.number, rule))?;
            let line = text.trim();
            if !line.is_empty() {
                return Ok(Some((self.number, line.to_owned())));
            }
        }
    }

    pub(super) fn at(&self, line: u64, rule: String) -> FileError {
        FileError::content(self.path, Some(line), rule)
    }
}
