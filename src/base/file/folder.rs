//! A folder that is written as a whole: it appears with all its files or not at all.

use std::path::{Path, PathBuf};

use super::{FileError, FolderLock};

/// Folders that were made for files to come; dropped, it takes away those that are still empty but for the file of a lock.
#[derive(Debug)]
pub struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes `path` and the folders above it, as far as they are missing.
    ///
    /// # Errors
    /// [`FileError`] if one cannot be made.
    pub fn make(path: &Path) -> Result<Self, FileError> {
        let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let innermost_first = path.ancestors().take_while(missing);
        let made = Self(innermost_first.map(Path::to_owned).collect());
        std::fs::create_dir_all(path).map_err(|source| FileError::system(path, source))?;
        Ok(made)
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        if let Some(innermost) = self.0.first() {
            FolderLock::remove_where_unused(innermost);
        }
        for folder in &self.0 {
            // a folder with files stays
            let _ = std::fs::remove_dir(folder);
        }
    }
}

/// An older folder may hold what a user has edited.
///
/// # Errors
/// [`FileError`] if the folder has content.
pub fn refuse_content(output: &Path) -> Result<(), FileError> {
    let entries = match std::fs::read_dir(output) {
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        entries => entries.map_err(|source| FileError::system(output, source))?,
    };
    match entries.count() {
        0 => Ok(()),
        _ => {
            let rule = "has content already: take another folder with --output, or delete it";
            Err(FileError::content(output, None, rule))
        }
    }
}

/// Refuses to write files over those that are read.
///
/// # Errors
/// [`FileError`] on the first of `outputs` that is one of `inputs`, by whatever path.
pub fn refuse_inputs(
    outputs: impl IntoIterator<Item = PathBuf>,
    inputs: &[PathBuf],
) -> Result<(), FileError> {
    // what is not there yet is no input, and an input that is not there is another message
    let whole = |path: &PathBuf| path.canonicalize().ok();
    let read: Vec<PathBuf> = inputs.iter().filter_map(whole).collect();
    for output in outputs {
        if whole(&output).is_some_and(|there| read.contains(&there)) {
            let rule = "is an input of this command, which would replace it: take another --output";
            return Err(FileError::content(&output, None, rule));
        }
    }
    Ok(())
}

/// Writes the folder `output`, which must not exist or be empty: `fill` gets a folder beside it, which then takes its name.
///
/// # Errors
/// [`FileError`] if it has content or cannot be written, or what `fill` says; then nothing is left behind.
pub fn write_folder<E: From<FileError>>(
    output: &Path,
    fill: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<(), E> {
    let system = |path: &Path| {
        let path = path.to_owned();
        move |source| FileError::system(&path, source)
    };
    refuse_content(output)?;
    let parent = match output.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let _parents = MadeFolders::make(&parent)?;
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // the library's default is 0700; models are for colleagues too, as far as the umask allows
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o777));
    }
    let folder = builder.prefix(".microslip-").tempdir_in(&parent);
    let folder = folder.map_err(system(&parent))?;
    fill(folder.path())?;
    if output.exists() {
        std::fs::remove_dir(output).map_err(system(output))?;
    }
    std::fs::rename(folder.path(), output).map_err(system(output))?;
    // its old name is free: nothing is left to be deleted
    let _ = folder.keep();
    Ok(())
}
