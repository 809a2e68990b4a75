//! Lines of a universal file, between which binary numbers may stand.

use crate::file::binary::take;
use std::borrow::Cow;

/// Lines with their numbers. Bytes that are no UTF-8 are Latin-1, where µ is one byte.
#[derive(Debug, Clone)]
pub(super) struct UffLines<'b> {
    rest: &'b [u8],
    /// 1-based number of the line that was given last.
    pub(super) number: u64,
}

impl<'b> UffLines<'b> {
    pub(super) fn new(bytes: &'b [u8]) -> Self {
        Self {
            rest: bytes,
            number: 0,
        }
    }

    /// The next line, which must be there.
    pub(super) fn need(&mut self) -> Result<Cow<'b, str>, String> {
        let next = self.next();
        next.ok_or_else(|| "the file ends inside a dataset".to_owned())
    }

    /// Passes over lines up to one that is `mark`.
    pub(super) fn pass_to(&mut self, mark: &str) -> Result<(), String> {
        while self.need()?.trim() != mark {}
        Ok(())
    }

    /// So many bytes.
    pub(super) fn take(&mut self, bytes: usize) -> Result<&'b [u8], String> {
        take(&mut self.rest, bytes)
    }
}

impl<'b> Iterator for UffLines<'b> {
    type Item = Cow<'b, str>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|byte| *byte == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &self.rest[self.rest.len()..]),
        };
        self.rest = rest;
        self.number += 1;
        Some(match std::str::from_utf8(line) {
            Ok(line) => Cow::Borrowed(line),
            Err(_) => Cow::Owned(line.iter().map(|byte| char::from(*byte)).collect()),
        })
    }
}
