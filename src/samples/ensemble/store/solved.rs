//! Solved samples in three tables side by side: samples, curves, anchors. They are written and read one after the other, so that
//! the memory does not grow with their number.

use super::anchors::{AnchorCursor, StoredStudy, anchors_layout};
use super::curves::{CurveCursor, curves_layout};
use super::provenance::Provenance;
use super::read_samples::SampleCursor;
use super::samples::samples_layout;
use crate::ensemble::atlas::{Anchor, ModePeaks};
use crate::ensemble::outcome::SampleOutcome;
use crate::ensemble::runner::{MOST_ANCHORS, SolvedSample};
use crate::ensemble::table::{ROW_GROUP, TableError, TableWriter};
use crate::file::{FileError, FileRecord, NewFile};
use crate::sampling::{Design, SampleGroup};
use std::path::{Path, PathBuf};

/// The three tables of the samples 0, 1, ..., while they are written.
pub struct SolvedFiles<'t> {
    samples: TableWriter<'t, SampleOutcome, NewFile>,
    curves: TableWriter<'t, SampleOutcome, NewFile>,
    anchors: TableWriter<'t, (u64, Anchor), NewFile>,
    /// A row group of samples at most.
    waiting: Vec<SolvedSample>,
}

impl<'t> SolvedFiles<'t> {
    /// Begins the files `paths`: samples, curves, anchors. `group` tells which numbers a sample has beside its index.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn begin(
        paths: [&Path; 3],
        provenance: &Provenance,
        input_names: &'t [String],
        group: SampleGroup,
        study: &StoredStudy,
    ) -> Result<Self, TableError> {
        let [samples, curves, anchors] = paths;
        let in_memory = |error: serde_json::Error| FileError::system(samples, error.into());
        let of_samples = samples_layout(provenance, input_names, group).map_err(in_memory)?;
        let of_curves = curves_layout(provenance).map_err(in_memory)?;
        Ok(Self {
            samples: TableWriter::create(samples, of_samples)?,
            curves: TableWriter::create(curves, of_curves)?,
            anchors: TableWriter::create(anchors, anchors_layout(study.key_values()))?,
            waiting: Vec::new(),
        })
    }

    /// Writes the next sample.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn write(&mut self, sample: SolvedSample) -> Result<(), TableError> {
        self.waiting.push(sample);
        match self.waiting.len() {
            ROW_GROUP => self.flush(),
            _ => Ok(()),
        }
    }

    fn flush(&mut self) -> Result<(), TableError> {
        let (outcomes, anchors) = parted(std::mem::take(&mut self.waiting));
        self.samples.write(&outcomes)?;
        self.curves.write(&outcomes)?;
        self.anchors.write(&anchors)
    }

    /// Ends the files, which then have their names.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn finish(mut self) -> Result<[FileRecord; 3], TableError> {
        self.flush()?;
        Ok([
            self.samples.finish()?,
            self.curves.finish()?,
            self.anchors.finish()?,
        ])
    }
}

/// Outcomes, and the anchors with the numbers of their samples.
pub(in crate::ensemble) fn parted(
    samples: Vec<SolvedSample>,
) -> (Vec<SampleOutcome>, Vec<(u64, Anchor)>) {
    let mut anchors = Vec::new();
    let outcome = |sample: SolvedSample| {
        anchors.extend(sample.anchor.map(|anchor| (sample.outcome.index, anchor)));
        sample.outcome
    };
    let outcomes = samples.into_iter().map(outcome).collect();
    (outcomes, anchors)
}

/// Key of the process that wrote a part, in the metadata of its samples.
pub(in crate::ensemble) const WRITER: &str = "writer";

/// The samples of three tables, one after the other.
pub struct SolvedCursor<'d> {
    paths: [PathBuf; 3],
    design: &'d Design,
    samples: SampleCursor,
    curves: CurveCursor,
    anchors: AnchorCursor,
}

impl<'d> SolvedCursor<'d> {
    /// Opens the tables `paths`: samples, curves, anchors.
    ///
    /// # Errors
    /// [`FileError`] if one of them cannot be read.
    pub fn open(paths: &[PathBuf; 3], design: &'d Design) -> Result<Self, FileError> {
        let [samples, curves, anchors] = paths;
        Ok(Self {
            samples: SampleCursor::open(samples)?,
            curves: CurveCursor::open(curves)?,
            anchors: AnchorCursor::open(anchors)?,
            paths: paths.clone(),
            design,
        })
    }

    /// The table of samples, and who wrote it, where that is known.
    #[must_use]
    pub fn origin(&self) -> (&Path, Option<&str>) {
        let writer = self.samples.rows.reader.metadata.get(WRITER);
        (&self.paths[0], writer.map(String::as_str))
    }

    /// Index of the next sample; none after the last one.
    ///
    /// # Errors
    /// [`FileError`] if a table cannot be read or lacks something.
    pub fn index(&mut self) -> Result<Option<u64>, FileError> {
        self.samples.index()
    }

    /// The next sample, with its curves and its anchor; none after the last one.
    ///
    /// # Errors
    /// [`FileError`] if a table cannot be read, lacks something, or has rows of other samples.
    pub fn take(&mut self) -> Result<Option<SolvedSample>, FileError> {
        let Some(mut outcome) = self.samples.take()? else {
            // what is left belongs to no sample
            return match (self.curves.sample()?, self.anchors.sample()?) {
                (None, None) => Ok(None),
                (Some(_), _) => self.curves.of_sample(None),
                (None, Some(_)) => self.anchors.take_into(None).map(|()| None),
            };
        };
        while self.curves.sample()? == Some(outcome.index) {
            self.curves.take_into(&mut outcome)?;
        }
        let mut anchor = (outcome.index < MOST_ANCHORS).then(|| Anchor {
            place: self.design.place(&outcome.inputs),
            peaks: vec![ModePeaks::default(); outcome.levels.len()],
        });
        while self.anchors.sample()? == Some(outcome.index) {
            self.anchors.take_into(anchor.as_mut())?;
        }
        Ok(Some(SolvedSample { outcome, anchor }))
    }
}
