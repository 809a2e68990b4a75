//! The table of anchors, `atlas.parquet`: the peaks of the first samples with all their coefficients, exact to the bit, from which
//! later samples start; and the study that they belong to.

use crate::ensemble::atlas::{Anchor, AnchorPeak};
use crate::ensemble::table::{
    Column, RowCursor, Rows, Table, TableLayout, TableReader, missing, optional, real, whole,
};
use crate::file::{Fault, FileError};
use crate::harmonics::HarmonicSet;
use crate::hb::newton::Point;
use arrow_array::{Array, BinaryArray, Float64Array, Int64Array};
use faer::prelude::c64;
use parquet::file::metadata::KeyValue;
use std::path::Path;

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

impl StoredStudy {
    pub(super) fn key_values(&self) -> Vec<KeyValue> {
        let pairs = [(STUDY_TEXT, &self.text), (STUDY_PATH, &self.path)];
        let pair = |(key, value): (&str, &String)| KeyValue::new(key.to_owned(), value.clone());
        pairs.map(pair).to_vec()
    }
}

/// The study of the result folder `folder`.
///
/// # Errors
/// [`FileError`] if the file of anchors cannot be read or names no study.
pub fn read_study(folder: &Path) -> Result<StoredStudy, FileError> {
    let mut table = TableReader::open(&folder.join(ATLAS_FILE), &[])?;
    let mut take = |key: &str| {
        let value = table.metadata.remove(key).ok_or_else(|| missing(key));
        table.checked(value)
    };
    Ok(StoredStudy {
        text: take(STUDY_TEXT)?,
        path: take(STUDY_PATH)?,
    })
}

/// The table of anchors with the numbers of their samples: one row per sample, level and mode with a solution.
///
/// Columns: `sample`, `level_index`, `mode`, `harmonics` (orders, u32), `angular_frequency`, `level`, `response_real`,
/// `response_imaginary`, `sharpness` (null where unknown), `displacements` (f64); the numbers of a list are bytes, little-endian.
pub(in crate::ensemble) fn anchors_layout(
    metadata: Vec<KeyValue>,
) -> TableLayout<'static, (u64, Anchor)> {
    TableLayout {
        metadata,
        described: &[],
        columns: Box::new(|anchors| columns(&rows(anchors))),
    }
}

/// Sample, number of its level and of the mode; peak.
type Row<'a> = ([usize; 3], &'a AnchorPeak);

fn rows(anchors: &[(u64, Anchor)]) -> Vec<Row<'_>> {
    let mut rows = Vec::new();
    for (sample, anchor) in anchors {
        for (level, peaks) in anchor.peaks.iter().enumerate() {
            for (mode, peak) in &peaks.0 {
                rows.push(([*sample as usize, level, *mode], peak));
            }
        }
    }
    rows
}

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

/// The peaks of a table of anchors, one after the other.
pub(super) struct AnchorCursor(RowCursor<AnchorBatch>);

struct AnchorBatch {
    /// Sample, number of the level and of the mode.
    place: [Int64Array; 3],
    harmonics: BinaryArray,
    displacements: BinaryArray,
    /// Frequency, level, real and imaginary part of the response.
    numbers: [Float64Array; 4],
    sharpness: Float64Array,
}

impl AnchorBatch {
    fn of(rows: &Rows) -> Result<Self, Fault> {
        let count = |name: &str| rows.counts(name).cloned();
        let real = |name: &str| rows.reals(name).cloned();
        Ok(Self {
            place: [count("sample")?, count("level_index")?, count("mode")?],
            harmonics: rows.bytes("harmonics")?.clone(),
            displacements: rows.bytes("displacements")?.clone(),
            numbers: [
                real("angular_frequency")?,
                real("level")?,
                real("response_real")?,
                real("response_imaginary")?,
            ],
            sharpness: real("sharpness")?,
        })
    }

    fn place(&self, at: usize) -> Result<[usize; 3], Fault> {
        let [sample, level, mode] = &self.place;
        let level = whole(level, at, "level_index")?;
        Ok([
            whole(sample, at, "sample")?,
            level,
            whole(mode, at, "mode")?,
        ])
    }

    fn peak(&self, at: usize) -> Result<AnchorPeak, Fault> {
        let (orders, rest) = bytes::<4>(&self.harmonics, at);
        let orders = orders.iter().map(|k| u32::from_le_bytes(*k) as usize);
        let harmonics = HarmonicSet::new(orders.collect());
        let harmonics = harmonics.ok().filter(|_| rest.is_empty());
        let (displacements, rest) = bytes::<8>(&self.displacements, at);
        let whole = rest.is_empty().then_some(displacements);
        let displacements = whole.ok_or_else(|| missing("displacements"))?;
        let [omega, level, re, im] = &self.numbers;
        let number = |column: &Float64Array| real(column, at, "a number of an anchor");
        Ok(AnchorPeak {
            harmonics: harmonics.ok_or_else(|| missing("harmonics"))?,
            point: Point {
                r: (displacements.iter().map(|r| f64::from_le_bytes(*r))).collect(),
                omega: number(omega)?,
                level: number(level)?,
            },
            response: c64::new(number(re)?, number(im)?),
            sharpness: optional(&self.sharpness, at),
        })
    }
}

/// Numbers of `N` bytes each, and what is left over.
fn bytes<const N: usize>(column: &BinaryArray, at: usize) -> (&[[u8; N]], &[u8]) {
    match column.is_valid(at) {
        true => column.value(at).as_chunks::<N>(),
        false => (&[], &[0]),
    }
}

impl AnchorCursor {
    pub(super) fn open(path: &Path) -> Result<Self, FileError> {
        let reader = TableReader::open(path, &[])?;
        Ok(Self(RowCursor::new(reader, AnchorBatch::of)))
    }

    /// The sample of the peak at hand; none after the last one.
    pub(super) fn sample(&mut self) -> Result<Option<u64>, FileError> {
        let found = self.0.row()?.map(|(batch, at)| batch.place(at));
        let found = self.0.reader.checked(found.transpose())?;
        Ok(found.map(|[sample, ..]| sample as u64))
    }

    /// Adds the peak at hand to its anchor, and passes it.
    pub(super) fn take_into(&mut self, anchor: Option<&mut Anchor>) -> Result<(), FileError> {
        let taken = self.0.take(|batch, at| {
            let [_, level, mode] = batch.place(at)?;
            let peaks = anchor.and_then(|anchor| anchor.peaks.get_mut(level));
            let peaks = peaks.ok_or_else(|| missing("the sample of an anchor"))?;
            peaks.0.push((mode, batch.peak(at)?));
            Ok(())
        });
        taken.map(|_| ())
    }
}
