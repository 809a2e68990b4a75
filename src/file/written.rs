//! Files that appear whole or not at all, with the hash of what was written.

use super::FileError;
use std::fs::File;
use std::io::{Result as IoResult, Write};
use std::path::Path;

/// A file and the hash of its content.
#[derive(
    Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct FileRecord {
    /// Name, without folder.
    pub name: String,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

impl FileRecord {
    /// Record of a file with the given content.
    #[must_use]
    pub fn of(name: &str, content: &[u8]) -> Self {
        Self {
            name: name.to_owned(),
            blake3: blake3::hash(content).to_hex().to_string(),
        }
    }

    /// Record of a file in `folder`.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be read.
    pub fn in_folder(folder: &Path, name: &str) -> Result<Self, FileError> {
        let path = folder.join(name);
        let mut hasher = blake3::Hasher::new();
        let read = hasher.update_reader(super::open(&path)?);
        read.map_err(|source| FileError::system(&path, source))?;
        Ok(Self {
            name: name.to_owned(),
            blake3: hasher.finalize().to_hex().to_string(),
        })
    }
}

/// A file that is being written; it hashes what goes to it.
#[derive(Debug)]
pub struct Written<'f> {
    file: &'f mut File,
    hasher: blake3::Hasher,
}

impl Write for Written<'_> {
    fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
        let taken = self.file.write(bytes)?;
        self.hasher.update(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> IoResult<()> {
        self.file.flush()
    }
}

/// Writes `path` as a whole: to a temporary file beside it first, which then takes its name. The record is of the bytes as
/// they were written, whatever the file holds later.
///
/// # Errors
/// [`FileError`] with the path, whatever `fill` or the operating system refuses; then `path` is as it was.
pub fn replace(
    path: &Path,
    fill: impl FnOnce(&mut Written<'_>) -> IoResult<()>,
) -> Result<FileRecord, FileError> {
    replaced(path, fill).map_err(|source| FileError::system(path, source))
}

fn replaced(
    path: &Path,
    fill: impl FnOnce(&mut Written<'_>) -> IoResult<()>,
) -> IoResult<FileRecord> {
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // The library's default is 0600; results are for colleagues too, as far as the umask allows.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    let mut written = Written {
        file: file.as_file_mut(),
        hasher: blake3::Hasher::new(),
    };
    fill(&mut written)?;
    let blake3 = written.hasher.finalize().to_hex().to_string();
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    #[cfg(unix)]
    File::open(folder)?.sync_all()?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(FileRecord {
        name: name.into_owned(),
        blake3,
    })
}

/// Waits until the names of the files in `folder` are on the disk.
pub(super) fn sync_folder(folder: &Path) -> Result<(), FileError> {
    #[cfg(unix)]
    {
        let synced = File::open(folder).and_then(|open| open.sync_all());
        synced.map_err(|source| FileError::system(folder, source))?;
    }
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}
