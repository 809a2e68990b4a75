//! Nastran OUTPUT4: text and binary, dense and sparse, both byte orders, 32 and 64 bits.

use crate::chain::MODELS;
use crate::chain::{ROWS, assert_is, mass, read_as, stiffness};
use microslip::import::matrix::Content;

/// How columns are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Form {
    Dense,
    Strings,
    BigStrings,
}

type Entry = fn(usize, usize) -> f64;

/// Runs of entries that are not zero in a column: first row (from 0) and values.
fn strings(entry: Entry, column: usize) -> Vec<(usize, Vec<f64>)> {
    let mut strings: Vec<(usize, Vec<f64>)> = Vec::new();
    for row in 0..ROWS {
        let value = entry(row, column);
        match strings.last_mut() {
            _ if value == 0.0 => {}
            Some((first, values)) if *first + values.len() == row => values.push(value),
            _ => strings.push((row, vec![value])),
        }
    }
    strings
}

/// The rows between the first and the last entry of a column.
fn dense(entry: Entry, column: usize) -> (usize, Vec<f64>) {
    let strings = strings(entry, column);
    let (first, _) = strings[0];
    let (last, values) = strings.last().unwrap();
    let end = last + values.len();
    (first, (first..end).map(|row| entry(row, column)).collect())
}

/// Text with three numbers a line.
pub(crate) fn text(name: &str, entry: Entry, form: Form) -> String {
    let rows = if form == Form::BigStrings {
        -(ROWS as i64)
    } else {
        ROWS as i64
    };
    let mut text = format!("{ROWS:8}{rows:8}{:8}{:8}{name:8}1P,3E23.15\n", 6, 2);
    let numbers = |values: &[f64]| {
        let words: Vec<_> = values.iter().map(|v| format!("{v:23.15E}")).collect();
        let lines: Vec<_> = words.chunks(3).map(<[String]>::concat).collect();
        lines.join("\n") + "\n"
    };
    for column in 0..ROWS {
        let strings = strings(entry, column);
        let values: usize = strings.iter().map(|(_, values)| values.len()).sum();
        match form {
            Form::Dense => {
                let (first, values) = dense(entry, column);
                text.push_str(&format!(
                    "{:8}{:8}{:8}\n",
                    column + 1,
                    first + 1,
                    values.len()
                ));
                text.push_str(&numbers(&values));
            }
            Form::Strings => {
                let words = 2 * values + strings.len();
                text.push_str(&format!("{:8}{:8}{words:8}\n", column + 1, 0));
                for (row, values) in &strings {
                    let packed = (row + 1) + ((2 * values.len() + 1) << 16);
                    text.push_str(&format!("{packed:8}\n{}", numbers(values)));
                }
            }
            Form::BigStrings => {
                let words = 2 * values + 2 * strings.len();
                text.push_str(&format!("{:8}{:8}{words:8}\n", column + 1, 0));
                for (row, values) in &strings {
                    let length = 2 * values.len() + 1;
                    text.push_str(&format!("{length:8}{:8}\n{}", row + 1, numbers(values)));
                }
            }
        }
    }
    text.push_str(&format!(
        "{:8}{:8}{:8}\n 1.000000000000000E+00\n",
        ROWS + 1,
        1,
        1
    ));
    text
}

/// Records of 32 or 64 bits in either byte order, in double or single precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binary {
    pub(crate) big_endian: bool,
    pub(crate) bits64: bool,
    pub(crate) double: bool,
    pub(crate) form: Form,
}

impl Binary {
    fn whole(self, value: i64) -> Vec<u8> {
        match (self.bits64, self.big_endian) {
            (false, false) => (value as i32).to_le_bytes().to_vec(),
            (false, true) => (value as i32).to_be_bytes().to_vec(),
            (true, false) => value.to_le_bytes().to_vec(),
            (true, true) => value.to_be_bytes().to_vec(),
        }
    }

    fn real(self, value: f64) -> Vec<u8> {
        let single = !self.double && !self.bits64;
        match (single, self.big_endian) {
            (true, false) => (value as f32).to_le_bytes().to_vec(),
            (true, true) => (value as f32).to_be_bytes().to_vec(),
            (false, false) => value.to_le_bytes().to_vec(),
            (false, true) => value.to_be_bytes().to_vec(),
        }
    }

    fn record(self, content: &[u8]) -> Vec<u8> {
        let length = content.len() as i32;
        let marker = match self.big_endian {
            true => length.to_be_bytes(),
            false => length.to_le_bytes(),
        };
        [&marker[..], content, &marker].concat()
    }

    fn wholes(self, values: &[usize]) -> Vec<u8> {
        values
            .iter()
            .flat_map(|value| self.whole(*value as i64))
            .collect()
    }

    pub(crate) fn file(self, name: &str, entry: Entry) -> Vec<u8> {
        let big = self.form == Form::BigStrings;
        let rows = if big { -(ROWS as i64) } else { ROWS as i64 };
        let kind = if self.double { 2 } else { 1 };
        let mut header: Vec<u8> = self.wholes(&[ROWS]);
        header.extend([rows, 6, kind].iter().flat_map(|value| self.whole(*value)));
        let width = if self.bits64 { 16 } else { 8 };
        header.extend(format!("{name:width$}").into_bytes());
        let mut file = self.record(&header);
        let words_of_value = if self.double && !self.bits64 { 2 } else { 1 };
        for column in 0..ROWS {
            let reals = |values: &[f64]| -> Vec<u8> {
                values.iter().flat_map(|value| self.real(*value)).collect()
            };
            let mut content = Vec::new();
            let mut first = 0;
            match self.form {
                Form::Dense => {
                    let (row, values) = dense(entry, column);
                    first = row + 1;
                    content = reals(&values);
                }
                _ => {
                    for (row, values) in strings(entry, column) {
                        let length = words_of_value * values.len() + 1;
                        content.extend(match big {
                            true => self.wholes(&[length, row + 1]),
                            false => self.wholes(&[row + 1 + (length << 16)]),
                        });
                        content.extend(reals(&values));
                    }
                }
            }
            let words = content.len() / self.whole(0).len();
            let own = self.wholes(&[column + 1, first, words]);
            file.extend(self.record(&[own, content].concat()));
        }
        // Nastran states one word here, whatever the number takes
        let last = [self.wholes(&[ROWS + 1, 1, 1]), self.real(1.0)].concat();
        file.extend(self.record(&last));
        file
    }
}

/// Every combination of a binary file.
pub(crate) fn layouts() -> Vec<Binary> {
    let mut layouts = Vec::new();
    for form in [Form::Dense, Form::Strings, Form::BigStrings] {
        for at in 0..8 {
            layouts.push(Binary {
                big_endian: at & 1 > 0,
                bits64: at & 2 > 0,
                double: at & 4 > 0,
                form,
            });
        }
    }
    layouts
}

/// Seen to fail with the packed length left in the row.
#[test]
fn all_forms_of_text_are_the_chain() {
    for form in [Form::Dense, Form::Strings, Form::BigStrings] {
        let both = text("KXX", stiffness, form) + &text("MXX", mass, form);
        let reading = read_as("model.op4", both.as_bytes()).unwrap();
        assert_eq!(reading.format, "Nastran OUTPUT4 (text)");
        assert_is(&reading.matrices[0], stiffness, &format!("{form:?}"));
        assert_is(&reading.matrices[1], mass, &format!("{form:?}"));
        assert_eq!(reading.matrices[0].digits, 16);
    }
}

/// The record behind the last column states one word and holds a number of two, as Nastran writes it. Seen to fail with the
/// byte order taken for the machine's, and with the words of that record counted.
#[test]
fn all_forms_of_binary_files_are_the_chain() {
    for layout in layouts() {
        let file = layout.file("KXX", stiffness);
        let reading = read_as("model.op4", &file).unwrap();
        assert_eq!(reading.format, "Nastran OUTPUT4 (binary)");
        assert_is(&reading.matrices[0], stiffness, &format!("{layout:?}"));
        assert_eq!(reading.matrices[0].name, "KXX");
    }
}

/// Recovery matrices and complex ones beside K and M are passed over; a single column is a force. Seen to fail with
/// complex ones taken.
#[test]
fn other_matrices_are_passed_over() {
    let complex = "       2       2       2       4CMAT    1P,3E23.15\n       1       1       2\n  1.000000000000000E+00  2.000000000000000E+00\n       3       1       1\n 1.0\n";
    let wide = "       3    9000       2       2MUG1    1P,3E23.15\n       1    9000       1\n  1.000000000000000E+00\n       4       1       1\n 1.0\n";
    let force = "       1       3       2       2PAX     1P,3E23.15\n       1       2       1\n  1.500000000000000E+00\n       2       1       1\n 1.0\n";
    let all = format!(
        "{complex}{wide}{force}{}",
        text("KXX", stiffness, Form::Strings)
    );
    let reading = read_as("model.op4", all.as_bytes()).unwrap();
    let names: Vec<_> = reading.matrices.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["PAX", "KXX"]);
    let Content::Column(force) = &reading.matrices[0].content else {
        panic!("is a force");
    };
    assert_eq!(*force, [0.0, 1.5, 0.0]);
}

/// Whole lines with the blanks at their beginning.
fn refuse_lines(text: &str, cases: &[(usize, &str, &str)]) {
    for (number, new, fragment) in cases {
        let mut lines: Vec<&str> = text.lines().collect();
        lines[number - 1] = new;
        let damaged = lines.join("\n") + "\n";
        MODELS.refuse_bytes("model.op4", damaged.as_bytes(), new, fragment);
    }
}

/// Of dense text: line 2 is the head of column 1 (rows 1 to 4), lines 3 and 4 its numbers, line 5 the head of column 2.
const DENSE_LINES: [(usize, &str, &str); 27] = [
    (
        1,
        "      12      12       6       9KXX     1P,3E23.15",
        ":1: matrix KXX: type 9",
    ),
    (
        1,
        "       0      12       6       2KXX     1P,3E23.15",
        "is 12 x 0: sizes must be from 1",
    ),
    (
        1,
        "      12       0       6       2KXX     1P,3E23.15",
        "is 0 x 12: sizes",
    ),
    (
        1,
        "      -1      12       6       2KXX     1P,3E23.15",
        "is 12 x -1: sizes",
    ),
    (
        1,
        "       x      12       6       2KXX     1P,3E23.15",
        ":1: must be a header",
    ),
    (
        1,
        "      12      12       6       2KXX     1P,3A23.15",
        "format 1P,3A23.15: must be such as",
    ),
    (
        1,
        "      12      12       6       2KXX     1P,0E23.15",
        "format 1P,0E23.15",
    ),
    (
        1,
        "      12      12       6       2KXX     1P,3E999.1",
        "format 1P,3E999.1",
    ),
    (1, "      11      12       6       2KXX     1P,3E23.15", ""),
    (1, "      13      12       6       2KXX     1P,3E23.15", ""),
    (
        1,
        "      12       2       6       2KXX     1P,3E23.15",
        "must be in rows 1 to 2",
    ),
    (
        2,
        "       0       1       4",
        ":2: matrix KXX: column 0: must be from 1 to 13",
    ),
    (
        2,
        "      14       1       4",
        "column 14: must be from 1 to 13",
    ),
    (2, "      -1       1       4", "column -1"),
    (
        2,
        "       x       1       4",
        ":2: must be a column: 3 whole numbers",
    ),
    (2, "       1       1", ":2: must be a column"),
    (2, "       1       1       0", ":2: column 1: 0 words"),
    (2, "       1       1      -4", ":2: column 1: -4 words"),
    (2, "       1      -1       4", "4 numbers from row -1 on"),
    (
        2,
        "       1      10       4",
        "4 numbers from row 10 on in column 1: must be in rows 1 to 12",
    ),
    (
        2,
        "       1       199999999",
        "99999999 numbers from row 1 on",
    ),
    (2, "       1       1       3", ":4: must be a column"),
    (2, "       1       1       5", ":4: : must be a number"),
    (3, "                    NaN", ":3"),
    (3, "                    one", ":3: one: must be a number"),
    (3, "", ":3: : must be a number"),
    (
        5,
        "       1       2       4",
        ":5: matrix KXX: column 1: must be from 2 to 13",
    ),
];

const STRING_LINES: [(usize, &str, &str); 8] = [
    (3, "  196609.", ":3: must be a string: 1 whole numbers"),
    (3, "       1", "string of -1 words"),
    (3, "   65537", "string of 0 words"),
    (3, "  131073", "string of 1 words"),
    (3, "  196608", "1 numbers from row 0 on"),
    (3, "  196622", "1 numbers from row 14 on"),
    (3, "99999999", "does not fit the words of its column"),
    (
        2,
        "       1       0       5",
        "does not fit the words of its column",
    ),
];

/// Seen to fail without the bounds of `Growing::string`.
#[test]
fn damaged_text_is_refused() {
    let dense = text("KXX", stiffness, Form::Dense);
    refuse_lines(&dense, &DENSE_LINES);
    refuse_lines(&text("KXX", stiffness, Form::Strings), &STRING_LINES);
    assert!(DENSE_LINES.len() + STRING_LINES.len() > 30);
    MODELS.refuse_cuts(
        "model.op4",
        dense.as_bytes(),
        &[0.1, 0.3, 0.5, 0.8, 0.98],
        "",
    );
}

/// A whole number of a little-endian file with 32 bits, written over its place.
fn with_whole(file: &[u8], at: usize, value: i32) -> Vec<u8> {
    let mut damaged = file.to_vec();
    damaged[at..at + 4].copy_from_slice(&value.to_le_bytes());
    damaged
}

/// Bytes of the header's record; behind it: length, column, row, words, numbers of the first column.
const FIRST_COLUMN: usize = 32;

/// Place, value, message.
const BINARY_WHOLES: [(usize, i32, &str); 25] = [
    (0, 25, ""),
    (0, 0, ""),
    (0, -1, ""),
    (28, 23, "record 1: its two lengths must agree"),
    (28, i32::MAX, "record 1: its two lengths"),
    (4, 0, "record 1: matrix KXX: is 12 x 0"),
    (4, -12, "is 12 x -12"),
    (4, i32::MAX, "sizes must be"),
    (4, 11, ""),
    (8, 0, "is 0 x 12"),
    (8, 2, "must be in rows 1 to 2"),
    (16, 0, "type 0: must be 1 to 4"),
    (16, 5, "type 5"),
    (16, 7000, "type 7000"),
    (FIRST_COLUMN, 5, "record 2: its two lengths"),
    (FIRST_COLUMN, -8, "record 2: its two lengths"),
    (FIRST_COLUMN, i32::MAX, "record 2: its two lengths"),
    (
        FIRST_COLUMN + 4,
        0,
        "record 2: matrix KXX: column 0: must be from 1 to 13",
    ),
    (FIRST_COLUMN + 4, 99, "column 99: must be"),
    (FIRST_COLUMN + 4, -1, "column -1"),
    (
        FIRST_COLUMN + 8,
        11,
        "from row 11 on in column 1: must be in rows 1 to 12",
    ),
    (FIRST_COLUMN + 8, -3, "from row -3 on"),
    (FIRST_COLUMN + 12, 7, "states 7 words, but its record has 8"),
    (FIRST_COLUMN + 12, -1, "states -1 words"),
    (FIRST_COLUMN + 12, i32::MAX, "words, but its record has 8"),
];

/// Seen to fail without the check of the second length of a record.
#[test]
fn damaged_binary_files_are_refused() {
    let layout = |form| Binary {
        big_endian: false,
        bits64: false,
        double: true,
        form,
    };
    let file = layout(Form::Dense).file("KXX", stiffness);
    read_as("model.op4", &file).unwrap();
    for (at, value, fragment) in BINARY_WHOLES {
        let damaged = with_whole(&file, at, value);
        MODELS.refuse_bytes("model.op4", &damaged, &format!("{at}: {value}"), fragment);
    }
    let nan = with_whole(&file, FIRST_COLUMN + 20, -1);
    MODELS.refuse_bytes(
        "model.op4",
        &nan,
        "NaN",
        "entry (1, 1) = NaN: must be a finite number",
    );
    let wrong = with_whole(&file, FIRST_COLUMN + 20, 0x4000_0000);
    let still = read_as("model.op4", &wrong);
    assert!(still.is_ok(), "another diagonal entry is another matrix");
    MODELS.refuse_cuts(
        "model.op4",
        &file,
        &[0.1, 0.3, 0.5, 0.7, 0.9, 0.99],
        "model.op4",
    );
    let strings = layout(Form::Strings).file("KXX", stiffness);
    for (value, fragment) in [
        (1, "string of -1 words"),
        (0x7fff_0001, "does not fit"),
        (14 + (3 << 16), "from row 14 on"),
    ] {
        let damaged = with_whole(&strings, FIRST_COLUMN + 16, value);
        MODELS.refuse_bytes("model.op4", &damaged, fragment, fragment);
    }
}
