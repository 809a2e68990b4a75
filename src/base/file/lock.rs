//! One process at a time in a folder.

use super::FileError;
use std::fs::{File, TryLockError};
use std::path::Path;

/// Name of the file that is locked. It stays in a folder that is used: to delete it would let two processes lock two files of that
/// name.
const LOCK: &str = ".lock";

/// The right to work in a folder, until it is dropped or the process ends in whatever way.
#[derive(Debug)]
pub struct FolderLock {
    /// Held open; absent where the file system knows no locks.
    _file: Option<File>,
}

impl FolderLock {
    /// The right to work in `folder` alone.
    ///
    /// # Errors
    /// [`FileError`] if another process has it, or the file cannot be made.
    pub fn alone(folder: &Path) -> Result<Self, FileError> {
        let lock = Self::try_alone(folder)?;
        lock.ok_or_else(|| FileError::content(folder, None, BUSY))
    }

    /// The same; nothing if another process works there.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be made.
    pub fn try_alone(folder: &Path) -> Result<Option<Self>, FileError> {
        Self::taken(folder, File::try_lock)
    }

    /// The right to work in `folder` beside others that have taken it in this way.
    ///
    /// # Errors
    /// [`FileError`] if another process works there alone, or the file cannot be made.
    pub fn shared(folder: &Path) -> Result<Self, FileError> {
        let lock = Self::taken(folder, File::try_lock_shared)?;
        lock.ok_or_else(|| FileError::content(folder, None, BUSY))
    }

    /// Takes the file of the lock out of a folder that holds nothing else, unless another process works there.
    pub(super) fn remove_where_unused(folder: &Path) {
        let Ok(entries) = std::fs::read_dir(folder) else {
            return;
        };
        let names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
        if names == [LOCK]
            && let Ok(Some(_alone)) = Self::try_alone(folder)
        {
            // what cannot be deleted stays, and the folder with it
            let _ = std::fs::remove_file(folder.join(LOCK));
        }
    }

    fn taken(
        folder: &Path,
        lock: fn(&File) -> Result<(), TryLockError>,
    ) -> Result<Option<Self>, FileError> {
        let path = folder.join(LOCK);
        let mut options = File::options();
        let options = options.create(true).truncate(false).write(true).read(true);
        let file = options.open(&path);
        let file = file.map_err(|source| FileError::system(&path, source))?;
        match lock(&file) {
            Ok(()) => Ok(Some(Self { _file: Some(file) })),
            Err(TryLockError::WouldBlock) => Ok(None),
            // parts are written so that they need no lock
            Err(TryLockError::Error(_)) => Ok(Some(Self { _file: None })),
        }
    }
}

/// Why a folder is refused, and what to do.
const BUSY: &str = "another microslip process works in this folder: wait for its end, or take another folder with --output";

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with a lock that is dropped at once.
    #[test]
    fn one_alone_or_several_that_share() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let alone = FolderLock::alone(path).unwrap();
        assert!(FolderLock::alone(path).is_err() && FolderLock::shared(path).is_err());
        drop(alone);
        let both = [FolderLock::shared(path), FolderLock::shared(path)];
        assert!(both.iter().all(Result::is_ok), "{both:?}");
        assert!(FolderLock::alone(path).is_err(), "others work there");
    }
}
