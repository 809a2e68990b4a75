//! What a result folder holds: whole results, and a run that is not finished.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::resume::{identity_of_results, results_source};
use crate::Error;
use crate::ensemble::parts::{
    Merged, MergedSource, PartFolder, RunIdentity, StoredPart, more_samples,
};
use crate::ensemble::store::read_indices;
use crate::file::{FileError, finish_placing};
use crate::report::run::{RECORD, TABLES, order_folder, order_of_folder};
use crate::study::settings::read::Study;

/// What a result folder holds.
#[derive(Debug, Clone)]
pub struct FolderStatus {
    /// The whole results.
    pub results: Option<RunStatus>,
    /// A run that is not finished.
    pub unfinished: Option<RunStatus>,
    /// Whether that run adds samples to the whole results.
    pub extends: bool,
    /// Files that are not what was written, absent companions and contradictions among them; one line each.
    pub faults: Vec<String>,
}

/// How far a run has come.
#[derive(Debug, Clone)]
pub struct RunStatus {
    /// The run.
    pub identity: RunIdentity,
    /// The study file.
    pub study_file: PathBuf,
    /// Samples solved.
    pub done: u64,
    /// Samples in all, at most.
    pub samples: u64,
    /// Those of the solved ones that lack a solution at a level.
    pub failed: u64,
    /// The first ranges of samples that are missing; ends included.
    pub missing: Vec<[u64; 2]>,
    /// Parts.
    pub parts: usize,
    /// When the newest file was written.
    pub newest: Option<SystemTime>,
}

impl RunStatus {
    /// The missing samples, such as `3 to 7, 12 to 12, ...`.
    #[must_use]
    pub fn missing_in_words(&self) -> String {
        let range = |[first, last]: &[u64; 2]| format!("{first} to {last}");
        let ranges: Vec<String> = self.missing.iter().map(range).collect();
        let named: u64 = self
            .missing
            .iter()
            .map(|[first, last]| 1 + last - first)
            .sum();
        let more = if self.done + named < self.samples {
            ", ..."
        } else {
            ""
        };
        ranges.join(", ") + more
    }
}

/// The folders in `folder` of a run that takes several engine orders, ascending; none of another run.
///
/// # Errors
/// [`Error::File`] if the folder cannot be listed.
pub fn order_folders(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let system = |source| Error::file(folder, source);
    let mut orders = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(system)? {
        let name = entry.map_err(system)?.file_name();
        let order = order_of_folder(&name.to_string_lossy());
        orders.extend(order.filter(|_| folder.join(&name).is_dir()));
    }
    orders.sort_unstable();
    let path = |order| folder.join(order_folder(order));
    Ok(orders.into_iter().map(path).collect())
}

/// Ranges of missing samples that are named.
const MOST_RANGES: usize = 5;

impl FolderStatus {
    /// Reads every file of results and parts in `folder`, and compares the hashes.
    ///
    /// # Errors
    /// [`Error::File`] if the folder cannot be listed; [`Error::Study`] if the study that the files name cannot be read.
    pub fn of(folder: &Path) -> Result<Self, Error> {
        let listed = std::fs::read_dir(folder);
        listed.map_err(|source| Error::file(folder, source))?;
        finish_placing(folder)?;
        let mut status = Self {
            results: None,
            unfinished: None,
            extends: false,
            faults: Vec::new(),
        };
        if folder.join(RECORD).exists() {
            status.read_results(folder)?;
        }
        status.read_parts(folder)?;
        Ok(status)
    }

    /// Whether nothing of a run is there, not even a damaged file.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.results.is_none() && self.unfinished.is_none() && self.faults.is_empty()
    }

    fn read_results(&mut self, folder: &Path) -> Result<(), Error> {
        let identity = match identity_of_results(folder) {
            Ok(identity) => identity,
            Err(fault) => {
                self.faults.push(format!("{fault}{OF_RESULTS}"));
                return Ok(());
            }
        };
        let table = folder.join(TABLES[0]);
        let samples = match read_indices(&table) {
            Ok(samples) => samples,
            Err(fault) => {
                self.faults.push(format!("{fault}{OF_RESULTS}"));
                return Ok(());
            }
        };
        let done = samples.len() as u64;
        self.results = Some(RunStatus {
            study_file: folder.join(&identity.study.path),
            identity,
            done,
            samples: done,
            failed: samples.iter().filter(|(_, solved)| !solved).count() as u64,
            missing: Vec::new(),
            parts: 0,
            newest: written(&table),
        });
        Ok(())
    }

    fn read_parts(&mut self, folder: &Path) -> Result<(), Error> {
        let mut parts: Vec<StoredPart> = Vec::new();
        for part in PartFolder::of(folder).list()? {
            match part {
                Ok(part) => parts.push(part),
                Err(fault) => self.faults.push(format!("{fault}{OF_PART}")),
            }
        }
        let Some(first) = parts.first() else {
            return Ok(());
        };
        for part in &parts {
            if let Some(difference) = first.identity.difference(&part.identity) {
                let path = part.paths()[0].display();
                self.faults
                    .push(format!("{path}: is of {difference}{OF_ANOTHER}"));
            }
        }
        let study_file = folder.join(&first.identity.study.path);
        let study = Study::parse(&study_file, &first.identity.study.text)?;
        let results = self.results.as_ref().map(|run| &run.identity);
        self.extends = results.is_some_and(|of| extends(&first.identity, of));
        let before = match self.extends {
            true => Some(results_source(folder)),
            false => None,
        };
        match RunStatus::of_parts(&study, &parts, before) {
            Ok(run) => self.unfinished = Some(run),
            Err(fault) => self.faults.push(fault.to_string()),
        }
        Ok(())
    }
}

/// What to do about a damaged file of the results.
const OF_RESULTS: &str = "; `run` solves and writes damaged results anew";
/// What to do about a damaged part.
const OF_PART: &str = "; `run` solves the samples of a damaged part again";
/// What to do about a part of another run.
const OF_ANOTHER: &str = " than the first part: delete the parts of one of the two";

/// Whether the run `longer` is the run `results` with more samples.
fn extends(longer: &RunIdentity, results: &RunIdentity) -> bool {
    let more = more_samples(&results.study.text, &longer.study.text);
    more.is_some() && longer.files == results.files
}

impl RunStatus {
    /// Progress of the run of `study` that wrote these parts (at least one); `before` are those of complete results.
    ///
    /// # Errors
    /// [`FileError`] if a part cannot be read, or has another result of a sample than another one.
    pub(super) fn of_parts(
        study: &Study,
        parts: &[StoredPart],
        before: Option<MergedSource>,
    ) -> Result<Self, FileError> {
        let sources = before.into_iter().chain(parts.iter().map(MergedSource::of));
        let mut samples = Merged::new(sources.collect(), &study.design);
        let (mut indices, mut failed) = (Vec::new(), 0);
        while let Some(sample) = samples.take()? {
            indices.push(sample.outcome.index);
            failed += u64::from(!sample.outcome.is_solved());
        }
        Ok(Self {
            study_file: study.path.clone(),
            identity: parts[0].identity.clone(),
            done: indices.len() as u64,
            samples: study.samples,
            failed,
            missing: gaps(&indices, study.samples),
            parts: parts.len(),
            newest: parts.iter().filter_map(|p| written(&p.paths()[0])).max(),
        })
    }
}

fn written(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|m| m.modified()).ok()
}

/// The first ranges of 0 … `samples` − 1 that are not among `indices`, which ascend.
fn gaps(indices: &[u64], samples: u64) -> Vec<[u64; 2]> {
    let ends = indices.iter().copied().chain([samples]);
    let starts = [0].into_iter().chain(indices.iter().map(|i| i + 1));
    let gaps = starts.zip(ends).filter(|(start, end)| start < end);
    gaps.map(|(start, end)| [start, end - 1])
        .take(MOST_RANGES)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::gaps;

    /// Seen to fail without the range after the last index.
    #[test]
    fn gaps_are_found() {
        assert_eq!(gaps(&[], 3), [[0, 2]]);
        assert_eq!(gaps(&[0, 1, 4], 7), [[2, 3], [5, 6]]);
        assert!(gaps(&[0, 1, 2], 3).is_empty());
    }
}
