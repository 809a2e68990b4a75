//! Tables in text: rows of fields between separators, with the numbers of their lines.
//!
//! Comma, semicolon or tab separate; a field with a separator stands in double quotes, and a quote in it is doubled (RFC 4180). A
//! row is one line. Lines that begin with `#` are comments; they and empty lines are passed over.

use std::borrow::Cow;
use std::path::Path;

use super::FileError;

/// One row of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row<'t> {
    /// 1-based line of the file.
    pub line: u64,
    /// Fields without white space around them.
    pub fields: Vec<Cow<'t, str>>,
}

/// The rows of a text, the line of names included.
#[derive(Debug, Clone)]
pub struct Rows<'t> {
    path: &'t Path,
    lines: std::str::Lines<'t>,
    separator: char,
    number: u64,
    width: Option<usize>,
}

impl<'t> Rows<'t> {
    /// The rows of `text`, which was read from `path`.
    #[must_use]
    pub fn new(path: &'t Path, text: &'t str, separator: char) -> Self {
        Self {
            path,
            lines: text.lines(),
            separator,
            number: 0,
            width: None,
        }
    }

    fn fault(&self, rule: String) -> FileError {
        FileError::content(self.path, Some(self.number), rule)
    }

    fn row(&mut self, line: &'t str) -> Result<Row<'t>, FileError> {
        let fields = fields(line, self.separator).map_err(|rule| self.fault(rule))?;
        let (width, n) = (*self.width.get_or_insert(fields.len()), fields.len());
        if n != width {
            let rule = format!("has {n} fields: must have {width}, as the first line");
            return Err(self.fault(rule));
        }
        let line = self.number;
        Ok(Row { line, fields })
    }
}

impl<'t> Iterator for Rows<'t> {
    type Item = Result<Row<'t>, FileError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let line = self.lines.next()?;
            self.number += 1;
            if !is_passed_over(line) {
                return Some(self.row(line));
            }
        }
    }
}

/// Whether a line is empty or a comment.
#[must_use]
pub fn is_passed_over(line: &str) -> bool {
    let line = line.trim();
    line.is_empty() || line.starts_with('#')
}

/// The fields of a line.
fn fields(line: &str, separator: char) -> Result<Vec<Cow<'_, str>>, String> {
    let mut found = Vec::new();
    let mut rest = line;
    loop {
        let (field, after) = match rest.trim_start_matches(' ').strip_prefix('"') {
            Some(quoted) => unquoted(quoted, separator)?,
            None => match rest.split_once(separator) {
                Some((field, after)) => (Cow::Borrowed(field.trim()), Some(after)),
                None => (Cow::Borrowed(rest.trim()), None),
            },
        };
        found.push(field);
        match after {
            Some(after) => rest = after,
            None => return Ok(found),
        }
    }
}

/// A field whose first quote is gone, and what follows the separator after it.
fn unquoted(text: &str, separator: char) -> Result<(Cow<'_, str>, Option<&str>), String> {
    let mut from = 0;
    let end = loop {
        let at = text[from..].find('"').map(|at| from + at);
        let at = at.ok_or("a field begins with a quote: must end with one in the same line")?;
        if !text[at + 1..].starts_with('"') {
            break at;
        }
        from = at + 2;
    };
    let field = match text[..end].contains('"') {
        true => Cow::Owned(text[..end].replace("\"\"", "\"").trim().to_owned()),
        false => Cow::Borrowed(text[..end].trim()),
    };
    let after = text[end + 1..].trim_start_matches(' ');
    match after.strip_prefix(separator) {
        Some(after) => Ok((field, Some(after))),
        None if after.trim().is_empty() => Ok((field, None)),
        None => {
            Err("a quote ends a field: a separator or the end of the line must follow".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with a split at each separator: a quoted one divided its field.
    #[test]
    fn fields_stand_between_separators_and_in_quotes() {
        let lines = [
            ("a,b", vec!["a", "b"]),
            (" a , b ", vec!["a", "b"]),
            ("a,,", vec!["a", "", ""]),
            ("\"a,b\",c", vec!["a,b", "c"]),
            ("x, \"say \"\"a\"\"\" ,c", vec!["x", "say \"a\"", "c"]),
            ("\"\"", vec![""]),
            ("", vec![""]),
        ];
        for (line, expected) in lines {
            assert_eq!(fields(line, ',').unwrap(), expected, "{line}");
        }
        assert_eq!(fields("1,5;2", ';').unwrap(), ["1,5", "2"]);
        for line in ["\"a", "a,\"b", "\"a\"b,c", "\"a\"\""] {
            assert!(fields(line, ',').is_err(), "{line}");
        }
    }

    /// Seen to fail with comments and empty lines not counted.
    #[test]
    fn comments_and_empty_lines_count() {
        let text = "# note\na;b\n\n# note\n1;2\n\n3\n";
        let path = Path::new("t.csv");
        let mut rows = Rows::new(path, text, ';');
        let lines: Vec<_> = [rows.next(), rows.next()]
            .into_iter()
            .map(|row| row.unwrap().unwrap().line)
            .collect();
        assert_eq!(lines, [2, 5]);
        let fault = rows.next().unwrap().unwrap_err().to_string();
        assert_eq!(
            fault,
            "t.csv:7: has 1 fields: must have 2, as the first line"
        );
        assert!(rows.next().is_none());
    }
}
