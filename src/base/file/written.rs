//! Files that appear whole or not at all, with the hash of what was written.

use super::FileError;
use std::fs::File;
use std::io::{BufWriter, Result as IoResult, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

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
        Ok(Self {
            name: name.to_owned(),
            blake3: hash_of(&folder.join(name))?,
        })
    }

    /// Record of a file under its name alone.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be read.
    pub fn of_file(path: &Path) -> Result<Self, FileError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: name.into_owned(),
            blake3: hash_of(path)?,
        })
    }
}

fn hash_of(path: &Path) -> Result<String, FileError> {
    let mut hasher = blake3::Hasher::new();
    let read = hasher.update_reader(super::open(path)?);
    read.map_err(|source| FileError::system(path, source))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// A new file that takes its name when it is whole; it hashes what goes to it.
#[derive(Debug)]
pub struct NewFile {
    path: PathBuf,
    file: NamedTempFile,
    hasher: blake3::Hasher,
}

impl NewFile {
    /// Begins the file `path` under another name beside it.
    ///
    /// # Errors
    /// [`FileError`] if the operating system refuses.
    pub fn begin(path: &Path) -> Result<Self, FileError> {
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        {
            // The library's default is 0600; results are for colleagues too, as far as the umask allows.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder_to_open(path));
        Ok(Self {
            path: path.to_owned(),
            file: file.map_err(|source| FileError::system(path, source))?,
            hasher: blake3::Hasher::new(),
        })
    }

    /// Gives the file its name, once all of it is on the disk. The record is of the bytes as they were written, whatever the file
    /// holds later.
    ///
    /// # Errors
    /// [`FileError`] if the operating system refuses; then `path` is as it was.
    pub fn finish(self) -> Result<FileRecord, FileError> {
        let system = |source| FileError::system(&self.path, source);
        self.file.as_file().sync_all().map_err(system)?;
        let placed = self.file.persist(&self.path);
        placed.map_err(|error| system(error.error))?;
        sync_folder(folder_to_open(&self.path))?;
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        Ok(FileRecord {
            name: name.into_owned(),
            blake3: self.hasher.finalize().to_hex().to_string(),
        })
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
        let taken = self.file.write(bytes)?;
        self.hasher.update(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> IoResult<()> {
        self.file.flush()
    }
}

/// Writes `path` as a whole.
///
/// # Errors
/// [`FileError`] with the path, whatever `fill` or the operating system refuses; then `path` is as it was.
pub fn replace(
    path: &Path,
    fill: impl FnOnce(&mut NewFile) -> IoResult<()>,
) -> Result<FileRecord, FileError> {
    let mut file = NewFile::begin(path)?;
    fill(&mut file).map_err(|source| FileError::system(path, source))?;
    file.finish()
}

/// Name of a file, and what writes its content.
pub type Content<'a> = (&'a str, &'a dyn Fn(&mut dyn Write) -> IoResult<()>);

/// Writes files of `folder` that say the same: the first one takes its name when all of them are on the disk, so that one that finds
/// no space leaves the older ones beside each other. Their paths.
///
/// Needs no lock, unlike [`super::Together`]: two processes that write the same names disturb each other's files no more than two [`replace`].
///
/// # Errors
/// [`FileError`] with the path, whatever a content or the operating system refuses; unless the system refuses a name, all are as they were.
pub fn replace_all(folder: &Path, contents: &[Content<'_>]) -> Result<Vec<PathBuf>, FileError> {
    let mut written = Vec::new();
    for (name, content) in contents {
        let path = folder.join(name);
        let mut file = NewFile::begin(&path)?;
        let filled = {
            let mut buffer = BufWriter::new(&mut file);
            content(&mut buffer).and_then(|()| buffer.flush())
        };
        let on_disk = filled.and_then(|()| file.file.as_file().sync_all());
        on_disk.map_err(|source| FileError::system(&path, source))?;
        written.push((file, path));
    }
    let placed = written.into_iter().map(|(file, path)| {
        file.finish()?;
        Ok(path)
    });
    placed.collect()
}

/// Folder of a file as the system opens it: that of a bare name is `.`.
fn folder_to_open(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The second file finds no space: the first one has not taken its name, and nothing else is left.
    #[test]
    fn files_that_say_the_same_are_replaced_all_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let text = |text: &'static str| move |out: &mut dyn Write| out.write_all(text.as_bytes());
        let full = |_: &mut dyn Write| Err(std::io::ErrorKind::StorageFull.into());
        let (old, new) = (text("old"), text("new"));
        let read = || ["a", "b"].map(|name| std::fs::read_to_string(path.join(name)).unwrap());
        replace_all(path, &[("a", &old), ("b", &old)]).unwrap();
        let failed = replace_all(path, &[("a", &new), ("b", &full)]).unwrap_err();
        assert!(failed.to_string().contains("b: "), "{failed}");
        assert_eq!(read(), ["old", "old"]);
        assert_eq!(std::fs::read_dir(path).unwrap().count(), 2);
        let paths = replace_all(path, &[("a", &new), ("b", &new)]).unwrap();
        assert_eq!(paths, ["a", "b"].map(|name| path.join(name)));
        assert_eq!(read(), ["new", "new"]);
    }
}
