//! Solved samples read back, so that a run goes on from them.
//!
//! The table of anchors, `atlas.parquet`, holds the peaks of the first samples with all their coefficients, exact to the bit: later
//! samples start from them. Together with the tables of samples and curves it restores all that a run needs in memory.

use super::atlas::{Anchor, AnchorPeak, ModePeaks};
use super::outcome::SampleOutcome;
use super::runner::{Known, MOST_ANCHORS, SolvedSample};
use super::store::{read_curves, read_samples};
use super::table::{Column, Record, Table, TableContent, TableError, metadata, missing};
use crate::file::{Fault, FileError, FileRecord, read_parquet};
use crate::harmonics::HarmonicSet;
use crate::hb::newton::Point;
use crate::sampling::Design;
use faer::prelude::c64;
use parquet::file::metadata::KeyValue;
use parquet::file::reader::FileReader;
use std::path::{Path, PathBuf};

/// The file of the anchors in a result folder.
pub const ATLAS_FILE: &str = "atlas.parquet";
const STUDY_TEXT: &str = "study_text";
const STUDY_PATH: &str = "study_path";

/// The study that a result folder belongs to.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct StoredStudy {
    /// Text of the study file.
    pub text: String,
    /// Where it was: absolute, or relative to the result folder.
    pub path: String,
}

/// Writes the anchors: one row per sample, level and mode with a solution.
///
/// Columns: `sample`, `level_index`, `mode`, `harmonics` (orders, u32), `angular_frequency`, `level`, `response_real`,
/// `response_imaginary`, `sharpness` (null where unknown), `displacements` (f64); the numbers of a list are bytes, little-endian.
///
/// # Errors
/// [`TableError`]; then `path` is as it was.
pub fn write_anchors(
    path: &Path,
    study: &StoredStudy,
    anchors: &[Anchor],
) -> Result<FileRecord, TableError> {
    let pairs = [(STUDY_TEXT, &study.text), (STUDY_PATH, &study.path)];
    let metadata = pairs.map(|(key, value)| KeyValue::new(key.to_owned(), value.clone()));
    let rows = rows((0..).zip(anchors));
    anchors_content(metadata.to_vec(), &rows).into_file(path)
}

/// The table of anchors.
pub(super) fn anchors_content<'t>(
    metadata: Vec<KeyValue>,
    rows: &'t [Row<'t>],
) -> TableContent<'t, Row<'t>, impl Fn(&[Row<'t>]) -> Table> {
    TableContent {
        metadata,
        described: &[],
        rows,
        table: columns,
    }
}

/// The peaks of anchors, with the numbers of their samples.
pub(super) fn rows<'a>(anchors: impl Iterator<Item = (u64, &'a Anchor)>) -> Vec<Row<'a>> {
    let of_anchor = |(sample, anchor): (u64, &'a Anchor)| {
        let levels = anchor.peaks.iter().enumerate();
        levels.flat_map(move |(level, peaks)| {
            let peaks = peaks.0.iter();
            peaks.map(move |(mode, peak)| ([sample as usize, level, *mode], peak))
        })
    };
    anchors.flat_map(of_anchor).collect()
}

/// Sample, number of its level and of the mode; peak.
pub(super) type Row<'a> = ([usize; 3], &'a AnchorPeak);

fn columns(rows: &[Row]) -> Table {
    let count = |of: fn(&Row) -> usize| {
        Column::Count(rows.iter().map(|row| i64::try_from(of(row)).ok()).collect())
    };
    let real = |of: fn(&AnchorPeak) -> f64| {
        Column::Real(rows.iter().map(|(_, peak)| Some(of(peak))).collect())
    };
    let orders = |peak: &AnchorPeak| -> Vec<u8> {
        let orders = peak.harmonics.orders().iter();
        orders.flat_map(|k| (*k as u32).to_le_bytes()).collect()
    };
    let displacements = |peak: &AnchorPeak| -> Vec<u8> {
        peak.point.r.iter().flat_map(|r| r.to_le_bytes()).collect()
    };
    let bytes = |of: &dyn Fn(&AnchorPeak) -> Vec<u8>| {
        Column::Bytes(rows.iter().map(|(_, peak)| of(peak)).collect())
    };
    let sharpness = rows.iter().map(|(_, peak)| peak.sharpness);
    let columns = [
        ("sample", count(|row| row.0[0])),
        ("level_index", count(|row| row.0[1])),
        ("mode", count(|row| row.0[2])),
        ("harmonics", bytes(&orders)),
        ("angular_frequency", real(|peak| peak.point.omega)),
        ("level", real(|peak| peak.point.level)),
        ("response_real", real(|peak| peak.response.re)),
        ("response_imaginary", real(|peak| peak.response.im)),
        ("sharpness", Column::Real(sharpness.collect())),
        ("displacements", bytes(&displacements)),
    ];
    columns
        .map(|(name, column)| (name.to_owned(), column))
        .into()
}

/// The study of the result folder `folder`.
///
/// # Errors
/// [`FileError`] if the file of anchors cannot be read or names no study.
pub fn read_study(folder: &Path) -> Result<StoredStudy, FileError> {
    read_parquet(&folder.join(ATLAS_FILE), |reader| {
        let mut stored = metadata(&reader);
        let mut take = |key: &str| stored.remove(key).ok_or_else(|| missing(key));
        Ok(StoredStudy {
            text: take(STUDY_TEXT)?,
            path: take(STUDY_PATH)?,
        })
    })
}

/// The samples of the result folder `folder`, with their curves, and the anchors among them.
///
/// # Errors
/// [`FileError`] if a file cannot be read or lacks something.
pub fn read_solved(folder: &Path, design: &Design) -> Result<Known, FileError> {
    let tables = ["samples.parquet", "curves.parquet", ATLAS_FILE];
    read_known(tables.map(|name| folder.join(name)), design)
}

/// The samples of three tables: samples, curves, anchors.
pub(super) fn read_known(
    [samples, curves, atlas]: [PathBuf; 3],
    design: &Design,
) -> Result<Known, FileError> {
    let mut outcomes = read_samples(&samples)?.outcomes;
    read_curves(&curves, &mut outcomes)?;
    let solved = |outcome: SampleOutcome| {
        let anchor = (outcome.index < MOST_ANCHORS).then(|| Anchor {
            place: design.place(&outcome.inputs),
            peaks: vec![ModePeaks::default(); outcome.levels.len()],
        });
        (outcome.index, SolvedSample { outcome, anchor })
    };
    let mut known: Known = outcomes.into_iter().map(solved).collect();
    read_parquet(&atlas, |reader| {
        for row in reader.get_row_iter(None)? {
            let row = Record::of(row?);
            let (sample, level) = (row.count("sample")? as u64, row.count("level_index")?);
            let anchor = known.get_mut(&sample).and_then(|s| s.anchor.as_mut());
            let peaks = anchor
                .and_then(|anchor| anchor.peaks.get_mut(level))
                .ok_or_else(|| missing("sample"))?;
            (peaks.0).push((row.count("mode")?, anchor_peak(&row)?));
        }
        Ok(())
    })?;
    Ok(known)
}

fn anchor_peak(row: &Record) -> Result<AnchorPeak, Fault> {
    let (orders, rest) = row.bytes("harmonics")?.as_chunks::<4>();
    let harmonics = HarmonicSet::new(
        orders
            .iter()
            .map(|k| u32::from_le_bytes(*k) as usize)
            .collect(),
    );
    let harmonics = harmonics.ok().filter(|_| rest.is_empty());
    let (displacements, rest) = row.bytes("displacements")?.as_chunks::<8>();
    let whole = rest.is_empty().then_some(displacements);
    let displacements = whole.ok_or_else(|| missing("displacements"))?;
    Ok(AnchorPeak {
        harmonics: harmonics.ok_or_else(|| missing("harmonics"))?,
        point: Point {
            r: displacements
                .iter()
                .map(|r| f64::from_le_bytes(*r))
                .collect(),
            omega: row.real("angular_frequency")?,
            level: row.real("level")?,
        },
        response: c64::new(row.real("response_real")?, row.real("response_imaginary")?),
        sharpness: row.optional("sharpness")?,
    })
}
