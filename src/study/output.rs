//! What a study leaves behind, and how files are written so that a failure spoils none.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::Error;
use crate::ensemble::arrow::write_arrow;
use crate::file::{self, Content, MadeFolders};
use crate::report::asked::Bands;
use crate::report::run::{CONTROL_VARIATE, FURTHER_POINTS, TABLES};
use crate::setting::BadSetting;

/// What `run` and `solve` write.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputSettings {
    /// Folder of the results, relative to the study file; `--output` overrides it.
    #[schemars(length(min = 1))]
    pub folder: PathBuf,
    /// Samples, the first so many, whose forced response curves are computed, for the bands of the report.
    pub curve_samples: u64,
    /// How the bands of whole curves in the report are formed.
    pub bands: Bands,
    /// Whether each random input is also solved alone at its 5 % and its 95 % value, the others at their medians.
    pub one_at_a_time: bool,
    /// Whether the tables are written as uncompressed Arrow IPC files, too.
    pub arrow: bool,
}

impl Default for OutputSettings {
    fn default() -> Self {
        Self {
            folder: PathBuf::from("results"),
            curve_samples: 200,
            bands: Bands::default(),
            one_at_a_time: false,
            arrow: false,
        }
    }
}

impl OutputSettings {
    /// Checks the folder, which is relative to that of the study file, `beside`.
    ///
    /// # Errors
    /// [`BadSetting`] with its whole key.
    pub fn validate(&self, beside: &Path) -> Result<(), BadSetting> {
        const KEY: &str = "output.folder";
        let empty = self.folder.as_os_str().is_empty();
        BadSetting::unless(!empty, KEY, "\"\"", "must not be empty")?;
        let is_file = beside.join(&self.folder).is_file();
        let rule = "must be a folder: a file has this name";
        BadSetting::unless(!is_file, KEY, self.folder.display(), rule)
    }
}

/// Tables that some studies have.
pub(in crate::study) const OPTIONAL_TABLES: [&str; 2] = [FURTHER_POINTS, CONTROL_VARIATE];

/// Writes the tables of the results in `folder` as Arrow files, too: `samples.arrow`, `curves.arrow` and, where there are
/// such, `further_points.arrow` and `control_variate.arrow`.
///
/// Those alone of which `wanted` says so by their name.
///
/// # Errors
/// [`Error::File`] with the Arrow file that cannot be written, or whose table cannot be read.
pub fn write_arrow_tables(folder: &Path, wanted: impl Fn(&Path) -> bool) -> Result<(), Error> {
    let tables = TABLES.into_iter().chain(OPTIONAL_TABLES);
    for table in tables.map(|name| folder.join(name)) {
        if !table.exists() {
            continue;
        }
        let path = table.with_extension("arrow");
        if wanted(Path::new(path.file_name().unwrap_or_default())) {
            write_arrow(&table, &path)?;
        }
    }
    Ok(())
}

/// A folder that exists and can be written to. If it was made for this and nothing was written, it goes when this is dropped: a
/// command that is refused leaves none behind.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    _made: MadeFolders,
}

impl OutputFolder {
    /// Makes the folder where it is missing and tries to write to it, before any work is spent.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be made or written to.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let made = MadeFolders::make(path)?;
        tempfile::tempfile_in(path).map_err(|source| Error::file(path, source))?;
        Ok(Self {
            path: path.to_owned(),
            _made: made,
        })
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file whole or not at all: an older file of that name stays until the new one is on the disk.
    ///
    /// # Errors
    /// [`Error::File`] if the content cannot be produced or written (no space left, …).
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<PathBuf, Error> {
        let path = self.path.join(name);
        file::replace(&path, |file| {
            let mut buffer = BufWriter::new(file);
            content(&mut buffer)?;
            buffer.flush()
        })?;
        Ok(path)
    }

    /// Writes files that say the same, all or none: older ones of these names stay until all new ones are on the disk. Their paths.
    ///
    /// # Errors
    /// [`Error::File`] if a content cannot be produced or written (no space left, …).
    pub fn write_all(&self, contents: &[Content<'_>]) -> Result<Vec<PathBuf>, Error> {
        Ok(file::replace_all(&self.path, contents)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with the content written straight to the file.
    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let output = OutputFolder::open(&folder.path().join("a/b")).unwrap();
        output.write("x.csv", |w| w.write_all(b"old")).unwrap();
        let failed = output.write("x.csv", |w| {
            w.write_all(b"new")?;
            Err(std::io::ErrorKind::StorageFull.into())
        });
        assert!(matches!(failed, Err(Error::File { .. })));
        assert_eq!(std::fs::read(output.path().join("x.csv")).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(output.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_below_a_file_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(OutputFolder::open(&file.path().join("results")).is_err());
    }
}
