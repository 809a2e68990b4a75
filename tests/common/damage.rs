//! Damaged files: one message with the file, the rule, and the line where there is one.

use std::fmt::Display;

/// Reads a file with this name and these bytes; the message if it is refused.
pub(crate) struct Reader(pub(crate) fn(&str, &[u8]) -> Result<(), String>);

/// The message of what was refused.
pub(crate) fn message<T>(found: Result<T, impl Display>) -> Result<(), String> {
    found.map(drop).map_err(|error| error.to_string())
}

impl Reader {
    /// Each damage of `text` alone is refused with its message. `table` has a line `place | new | message` for each: the place is
    /// the number of a line that is replaced, or a text of which the first one is. `\\n` and `\\0` are a new line and a null byte.
    pub(crate) fn refuse(&self, name: &str, text: &str, table: &str) -> usize {
        assert_eq!((self.0)(name, text.as_bytes()), Ok(()), "{name}: whole");
        let rows = table.lines().filter(|row| !row.trim().is_empty());
        let mut count = 0;
        for row in rows {
            let damaged = damaged(text, row);
            let fragment = row.split('|').nth(2).unwrap().trim();
            self.refuse_bytes(name, damaged.as_bytes(), row, fragment);
            count += 1;
        }
        count
    }

    /// The bytes are refused with a message that has file and rule.
    pub(crate) fn refuse_bytes(&self, name: &str, bytes: &[u8], what: &str, fragment: &str) {
        match (self.0)(name, bytes) {
            Ok(()) => panic!("{name}: {what}: is read"),
            Err(message) => {
                let has_both = message.contains(name) && message.contains(fragment);
                assert!(has_both, "{what}: {message} lacks {fragment:?}");
            }
        }
    }

    /// A file cut at each of `cuts` shares of its length is refused.
    pub(crate) fn refuse_cuts(&self, name: &str, bytes: &[u8], cuts: &[f64], fragment: &str) {
        for cut in cuts {
            let end = (cut * bytes.len() as f64) as usize;
            let what = format!("cut at {cut}");
            self.refuse_bytes(name, &bytes[..end], &what, fragment);
        }
    }
}

/// The text with the damage of a row of the table.
pub(crate) fn damaged(text: &str, row: &str) -> String {
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let new = cells[1].replace("\\n", "\n").replace("\\0", "\0");
    match cells[0].parse::<usize>() {
        Ok(number) => {
            let mut lines: Vec<&str> = text.lines().collect();
            assert!(number <= lines.len(), "{row}");
            lines[number - 1] = &new;
            lines.join("\n") + "\n"
        }
        Err(_) => {
            assert!(text.contains(cells[0]), "no {row}");
            text.replacen(cells[0], &new, 1)
        }
    }
}
