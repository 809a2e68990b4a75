//! Samples of several parts, and of results that are extended, as one sequence.

use super::super::runner::SolvedSample;
use super::super::store::SolvedCursor;
use super::part::StoredPart;
use crate::file::FileError;
use crate::sampling::Design;
use std::path::{Path, PathBuf};

/// Three tables of samples: samples, curves, anchors.
#[derive(Debug, Clone)]
pub struct MergedSource {
    /// The tables.
    pub paths: [PathBuf; 3],
    /// Index of its first sample.
    pub first: u64,
}

impl MergedSource {
    /// Of a part.
    #[must_use]
    pub fn of(part: &StoredPart) -> Self {
        let first = part.samples.first();
        Self {
            paths: part.paths().clone(),
            first: first.map_or(u64::MAX, |(index, _)| *index),
        }
    }
}

/// The samples of several sources, ascending, each once. A source is open only while its samples are at hand, so that the memory
/// does not grow with their number.
///
/// A sample may stand in several sources, if it is the same in all; one with a solution replaces one without, which was solved again.
pub struct Merged<'d> {
    design: &'d Design,
    /// Sources that are still closed, the one with the lowest first sample last.
    closed: Vec<MergedSource>,
    open: Vec<Box<SolvedCursor<'d>>>,
}

impl<'d> Merged<'d> {
    /// The samples of `sources`, whose inputs are of `design`.
    #[must_use]
    pub fn new(mut sources: Vec<MergedSource>, design: &'d Design) -> Self {
        sources.sort_by(|a, b| (b.first, &b.paths).cmp(&(a.first, &a.paths)));
        Self {
            design,
            closed: sources,
            open: Vec::new(),
        }
    }

    /// The next sample; none after the last one.
    ///
    /// # Errors
    /// [`FileError`] on a source that cannot be read, or that has another result of a sample than another one.
    pub fn take(&mut self) -> Result<Option<SolvedSample>, FileError> {
        let Some(index) = self.next_index()? else {
            return Ok(None);
        };
        let mut chosen: Option<(SolvedSample, usize)> = None;
        for place in 0..self.open.len() {
            if self.open[place].index()? != Some(index) {
                continue;
            }
            let Some(sample) = self.open[place].take()? else {
                continue;
            };
            chosen = match chosen.take() {
                None => Some((sample, place)),
                Some((first, of_first)) => match better(&first, &sample) {
                    Some(true) => Some((sample, place)),
                    Some(false) => Some((first, of_first)),
                    None => {
                        let writers = [of_first, place].map(|place| self.open[place].origin());
                        return Err(contradiction(index, writers));
                    }
                },
            };
        }
        Ok(chosen.map(|(sample, _)| sample))
    }

    /// Opens the sources that begin with the next sample, and gives its index.
    fn next_index(&mut self) -> Result<Option<u64>, FileError> {
        let mut lowest: Option<u64> = None;
        let mut place = 0;
        while let Some(source) = self.open.get_mut(place) {
            match source.index()? {
                Some(index) => {
                    lowest = Some(lowest.map_or(index, |lowest| lowest.min(index)));
                    place += 1;
                }
                // nothing may be left in its other tables
                None => _ = self.open.remove(place).take()?,
            }
        }
        while let Some(source) = self.closed.last() {
            if lowest.is_some_and(|lowest| lowest < source.first) {
                break;
            }
            lowest = Some(source.first);
            let opened = SolvedCursor::open(&source.paths, self.design)?;
            self.open.push(Box::new(opened));
            self.closed.pop();
        }
        Ok(lowest.filter(|index| *index < u64::MAX))
    }
}

/// Whether the second of two results of a sample counts instead of the first one; none where both count and differ.
fn better(first: &SolvedSample, second: &SolvedSample) -> Option<bool> {
    match (first.outcome.is_solved(), second.outcome.is_solved()) {
        (false, true) => Some(true),
        (true, false) | (false, false) => Some(false),
        // texts of numbers are exact, and equal for NaN
        (true, true) => (format!("{first:?}") == format!("{second:?}")).then_some(false),
    }
}

/// Two tables with different results of a sample, and who wrote them.
fn contradiction(index: u64, [first, second]: [(&Path, Option<&str>); 2]) -> FileError {
    let written = |writer: Option<&str>| {
        writer.map_or_else(String::new, |writer| format!(" (written by {writer})"))
    };
    let rule = format!(
        "has another result of sample {index}{} than {}{}: one of the two must be deleted",
        written(second.1),
        first.0.display(),
        written(first.1)
    );
    FileError::content(second.0, None, rule)
}
