//! Files of hysteresis tests: the format follows from what a file holds, not from its name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::channels::Channels;
use super::checks::checked;
use super::format::{csv, matlab, tdms, uff58};
use super::signals::HysteresisRecord;
use crate::file::{self, FileError};

/// Bytes of a file of measurements at most: an hour of four signals at 2 kHz.
pub(super) const LONGEST_FILE: u64 = 256 << 20;

/// A test and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct TestInFile {
    /// The test.
    pub record: HysteresisRecord,
    /// Its file.
    pub path: PathBuf,
    /// Line of its first sample, in a file of lines.
    pub line: Option<u64>,
}

/// The tests of all files, in their order.
///
/// # Errors
/// [`FileError`] if a file cannot be read, is of no known format or breaks a rule, or two tests have one name.
pub fn read_hysteresis(paths: &[PathBuf]) -> Result<Vec<TestInFile>, FileError> {
    let mut tests: Vec<TestInFile> = Vec::new();
    let mut from: BTreeMap<String, &Path> = BTreeMap::new();
    for path in paths {
        for test in read_tests(path)? {
            let name = &test.record.name;
            if let Some(other) = from.insert(name.clone(), path) {
                let rule = format!(
                    "test {name}: its name must differ from that in {}",
                    other.display()
                );
                return Err(FileError::content(path, test.line, rule));
            }
            tests.push(test);
        }
    }
    Ok(tests)
}

/// The tests of one file.
///
/// # Errors
/// As [`read_hysteresis`].
pub fn read_tests(path: &Path) -> Result<Vec<TestInFile>, FileError> {
    let bytes = file::read_bytes(path, LONGEST_FILE)?;
    let tests = tests(path, bytes)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let several = tests.len() > 1;
    let records = tests.into_iter().map(|channels| {
        let name = match &channels.label {
            Some(label) if several => format!("{stem} {label}"),
            _ => stem.to_string(),
        };
        let line = channels.lines.first().copied();
        Ok(TestInFile {
            record: checked(path, name, channels)?,
            path: path.to_owned(),
            line,
        })
    });
    records.collect()
}

/// How files begin that are known, and not read.
const REFUSED: [(&[u8], &str); 3] = [
    (b"\x89HDF", file::matlab::NEWER),
    (
        b"PK",
        "is an archive or a spreadsheet: save the table as CSV",
    ),
    (
        b"PAR1",
        "is a Parquet file, which is not read: save the table as CSV",
    ),
];

/// The tests of a file, by the format that its beginning shows.
fn tests(path: &Path, bytes: Vec<u8>) -> Result<Vec<Channels>, FileError> {
    if tdms::begins(&bytes) {
        return tdms::read(path, &bytes);
    }
    if file::matlab::begins(&bytes) {
        return matlab::read(path, &bytes);
    }
    if let Some((_, rule)) = REFUSED.iter().find(|(begin, _)| bytes.starts_with(begin)) {
        return Err(FileError::content(path, None, *rule));
    }
    if uff58::begins(&bytes) {
        return uff58::read(path, &bytes);
    }
    let text = file::text_of(path, bytes)?;
    csv::read(path, &text)
}
