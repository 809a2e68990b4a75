//! The folder of the parts.

use super::super::runner::SolvedSample;
use super::super::table::TableError;
use super::part::{PartHead, SAMPLES, StoredPart, write_part};
use crate::file::{FileError, remove_folder};
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Name of the folder inside a result folder.
const PARTS: &str = "parts";

/// The folder of the parts of a run, which need not exist.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartFolder(PathBuf);

impl PartFolder {
    /// That of the result folder `results`.
    #[must_use]
    pub fn of(results: &Path) -> Self {
        Self(results.join(PARTS))
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The tables of samples of its parts, in the order of their names.
    ///
    /// # Errors
    /// [`FileError`] if the folder cannot be listed.
    pub fn tables(&self) -> Result<Vec<PathBuf>, FileError> {
        let system = |source| FileError::system(&self.0, source);
        let entries = match std::fs::read_dir(&self.0) {
            Err(source) if source.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(system)?,
        };
        let mut tables = Vec::new();
        for entry in entries {
            let path = entry.map_err(system)?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name.ends_with(SAMPLES) {
                tables.push(path);
            }
        }
        tables.sort();
        Ok(tables)
    }

    /// Every part, or why it cannot be used, in the order of the names.
    ///
    /// # Errors
    /// [`FileError`] if the folder cannot be listed.
    pub fn list(&self) -> Result<Vec<Result<StoredPart, FileError>>, FileError> {
        self.list_again(Vec::new())
    }

    /// The same; a part of `known` whose files have kept their length and time is not read again.
    ///
    /// # Errors
    /// As [`PartFolder::list`].
    pub fn list_again(
        &self,
        known: Vec<StoredPart>,
    ) -> Result<Vec<Result<StoredPart, FileError>>, FileError> {
        let named = known
            .into_iter()
            .map(|part| (part.paths()[0].clone(), part));
        let mut known: BTreeMap<PathBuf, StoredPart> = named.collect();
        let open = |path: &PathBuf| match known.remove(path) {
            Some(part) if part.is_untouched() => Ok(part),
            _ => StoredPart::open(path),
        };
        Ok(self.tables()?.iter().map(open).collect())
    }

    /// The parts that are not among those `seen`, which they then are. A damaged one is none, and is looked at again the next time:
    /// who solves its samples again may write it under the same name.
    ///
    /// # Errors
    /// [`FileError`] if the folder cannot be listed.
    pub fn unseen(&self, seen: &mut BTreeSet<PathBuf>) -> Result<Vec<StoredPart>, FileError> {
        let mut found = Vec::new();
        for table in self.tables()? {
            if seen.contains(&table) {
                continue;
            }
            if let Ok(part) = StoredPart::open(&table) {
                seen.insert(table);
                found.push(part);
            }
        }
        Ok(found)
    }

    /// Writes samples as a part; the folder is made where it is missing.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn write(&self, head: &PartHead, samples: Vec<SolvedSample>) -> Result<(), TableError> {
        if samples.is_empty() {
            return Ok(());
        }
        write_part(&self.0, head, samples)
    }

    /// Removes the folder with all that is in it.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn remove(&self) -> Result<(), FileError> {
        remove_folder(&self.0)
    }
}
