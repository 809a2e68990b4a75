//! Parquet files read so that a damaged one is a message.

use super::{FileError, open};
use parquet::errors::ParquetError;
use parquet::file::reader::SerializedFileReader;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// What is wrong with a Parquet file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// 1-based row where there is one.
    pub row: Option<u64>,
    /// What is wrong and the rule.
    pub rule: String,
}

impl Fault {
    /// A fault of the whole file.
    #[must_use]
    pub fn new(rule: impl Into<String>) -> Self {
        let rule = rule.into();
        Self { row: None, rule }
    }

    /// A fault of a row.
    #[must_use]
    pub fn at(row: u64, rule: impl Into<String>) -> Self {
        let rule = rule.into();
        let row = Some(row);
        Self { row, rule }
    }
}

impl From<ParquetError> for Fault {
    fn from(error: ParquetError) -> Self {
        Self::new(format!("cannot be read: {error}"))
    }
}

/// What `read` makes of the file `path`.
///
/// # Errors
/// [`FileError`] if it cannot be opened, is no Parquet file, or has a fault. The library panics on some damaged files:
/// that is a fault, too.
pub fn read_parquet<T>(
    path: &Path,
    read: impl FnOnce(SerializedFileReader<File>) -> Result<T, Fault>,
) -> Result<T, FileError> {
    let file = open(path)?;
    let found = without_panic(|| read(SerializedFileReader::new(file)?));
    let damaged = || Err(Fault::new("is damaged: the Parquet library cannot read it"));
    let found = found.unwrap_or_else(damaged);
    found.map_err(|fault| FileError::content(path, fault.row, fault.rule))
}

thread_local! {
    /// Whether a panic of this thread is on its way to become an error.
    static CAUGHT: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// What `read` gives; `None` if it panics. Nothing is printed.
pub fn without_panic<T>(read: impl FnOnce() -> T) -> Option<T> {
    static QUIET: std::sync::Once = std::sync::Once::new();
    QUIET.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !CAUGHT.get() {
                usual(panic);
            }
        }));
    });
    let before = CAUGHT.replace(true);
    let found = catch_unwind(AssertUnwindSafe(read));
    CAUGHT.set(before);
    found.ok()
}
