//! Files read within bounds and written as a whole: a device that never ends, a pipe that never answers, a damaged table
//! and a text in another encoding are messages, not a full memory, a wait or a panic.
//!
//! ```
//! # use microslip_base as microslip;
//! use microslip::file::{Rows, read_text, replace};
//! use std::io::Write;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//!
//! let path = folder.path().join("points.csv");
//! replace(&path, |file| file.write_all(b"x,y\n1,2\n# a comment\n3\n"))?;
//! let text = read_text(&path)?;
//! let rows: Vec<_> = Rows::new(&path, &text, ',').collect();
//! assert_eq!(rows.len(), 3);
//! let message = rows[2].as_ref().err().map(ToString::to_string).unwrap_or_default();
//! assert!(message.ends_with("points.csv:4: has 1 fields: must have 2, as the first line"));
//! # Ok(())
//! # }
//! ```

pub mod binary;
pub mod compressed_rows;
pub mod delimited;
pub mod folder;
pub mod lock;
pub mod matlab;
pub mod number;
pub mod parquet;
pub mod together;
pub mod written;

pub use delimited::{Row, Rows};
pub use folder::{MadeFolders, refuse_content, refuse_inputs, write_folder};
pub use lock::FolderLock;
pub use number::{
    finite_number, parse_number, scaled_number, shortest_decimal, significant_digits,
};
pub use parquet::{Fault, read_parquet};
pub use together::{Together, finish_placing, remove_folder};
pub use written::{Content, FileRecord, NewFile, replace, replace_all};

use std::fs::File;
use std::io::{Error as IoError, ErrorKind, Read};
use std::path::{Path, PathBuf};

/// Why a file cannot be taken.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    System {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: IoError,
    },
    /// The file, or a line of it, breaks a rule.
    #[error("{}{}: {rule}", path.display(), line.map_or_else(String::new, |line| format!(":{line}")))]
    Content {
        /// The file.
        path: PathBuf,
        /// 1-based line where there is one; row of a Parquet file.
        line: Option<u64>,
        /// What is wrong and the rule.
        rule: String,
    },
}

impl FileError {
    /// `source` happened on `path`.
    #[must_use]
    pub fn system(path: &Path, source: IoError) -> Self {
        Self::System {
            path: path.to_owned(),
            source,
        }
    }

    /// The content of `path`, or its line, breaks `rule`.
    #[must_use]
    pub fn content(path: &Path, line: Option<u64>, rule: impl Into<String>) -> Self {
        Self::Content {
            path: path.to_owned(),
            line,
            rule: rule.into(),
        }
    }

    /// Whether the file, or the folder that it is to be in, was not there.
    #[must_use]
    pub fn is_absence(&self) -> bool {
        matches!(self, Self::System { source, .. } if source.kind() == ErrorKind::NotFound)
    }
}

/// Some editors begin a text in UTF-8 with it.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();
/// Bytes of a file that is held in memory at most: no study, list or record comes near it.
const LONGEST_TEXT: u64 = 256 << 20;

/// Opens a file for reading. Folders, pipes and devices are refused before they are opened: a pipe without a writer never
/// answers, and a device such as `/dev/zero` never ends.
///
/// # Errors
/// [`FileError`] if it is none or the operating system refuses.
pub fn open(path: &Path) -> Result<File, FileError> {
    let system = |source| FileError::system(path, source);
    let kind = std::fs::metadata(path).map_err(system)?.file_type();
    if kind.is_dir() {
        return Err(FileError::content(path, None, "is a folder, not a file"));
    }
    if !kind.is_file() {
        let rule = "is a pipe or a device: must be a regular file, which has an end";
        return Err(FileError::content(path, None, rule));
    }
    File::open(path).map_err(system)
}

/// The text of a file in UTF-8, at most 256 MiB.
///
/// # Errors
/// [`FileError`] if it cannot be read, is longer, or is no UTF-8; then with the line and the encoding that it may have.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    text_of(path, read_bytes(path, LONGEST_TEXT)?)
}

/// The bytes of a file as text.
///
/// # Errors
/// [`FileError`] if they are no UTF-8, with the line and the encoding that it may have.
pub fn text_of(path: &Path, bytes: Vec<u8>) -> Result<String, FileError> {
    text(bytes).map_err(|(line, rule)| FileError::content(path, Some(line), rule))
}

/// The bytes of a file, at most `most`.
///
/// # Errors
/// [`FileError`] if it cannot be read or is longer.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    let system = |source| FileError::system(path, source);
    let mut bounded = open(path)?.take(most + 1);
    bounded.read_to_end(&mut bytes).map_err(system)?;
    if bytes.len() as u64 > most {
        let rule = format!("is longer than {} MiB", most >> 20);
        return Err(FileError::content(path, None, rule));
    }
    Ok(bytes)
}

/// `bytes` as text without a byte order mark, or the line that is none and why.
///
/// # Errors
/// 1-based line and rule.
pub fn text(mut bytes: Vec<u8>) -> Result<String, (u64, String)> {
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    let line = |end: usize| 1 + bytes[..end].iter().filter(|b| **b == b'\n').count() as u64;
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err((1, "is UTF-16 text: save the file as UTF-8".to_owned()));
    }
    if let Some(at) = bytes.iter().position(|b| *b == 0) {
        let rule = "has a null byte: must be text; if an editor shows text, it is UTF-16: save the file as UTF-8";
        return Err((line(at), rule.to_owned()));
    }
    match std::str::from_utf8(&bytes) {
        Ok(_) => {}
        Err(error) => {
            let at = error.valid_up_to();
            let rule = format!(
                "byte 0x{:02X} is no UTF-8: save the file as UTF-8 (it may be Latin-1 or Windows-1252)",
                bytes[at]
            );
            return Err((line(at), rule));
        }
    }
    String::from_utf8(bytes).map_err(|error| (1, error.to_string()))
}
