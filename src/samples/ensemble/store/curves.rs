//! The table of forced response curves: one row per point.

use super::provenance::Provenance;
use crate::ensemble::columns::CURVE_COLUMNS;
use crate::ensemble::outcome::{CurvePoint, SampleOutcome};
use crate::ensemble::table::{
    Column, RowCursor, Rows, Table, TableLayout, TableReader, missing, number, real, whole,
};
use crate::file::{Fault, FileError};
use arrow_array::{Float64Array, Int64Array};
use std::collections::BTreeMap;
use std::path::Path;

/// The table of curves: `sample`, `level`, `frequency_hz`, `amplitude_m`.
pub(in crate::ensemble) fn curves_layout(
    provenance: &Provenance,
) -> Result<TableLayout<'static, SampleOutcome>, serde_json::Error> {
    Ok(TableLayout {
        metadata: provenance.key_values()?,
        described: &CURVE_COLUMNS,
        columns: Box::new(curve_columns),
    })
}

/// Reads the table of curves into the outcomes of the same run; their curves are empty before.
///
/// # Errors
/// [`FileError`] if the file cannot be read, lacks a column or belongs to other samples.
pub fn read_curves(path: &Path, outcomes: &mut [SampleOutcome]) -> Result<(), FileError> {
    let places: BTreeMap<u64, usize> = outcomes.iter().map(|o| o.index).zip(0..).collect();
    let mut curves = CurveCursor::open(path)?;
    while let Some(sample) = curves.sample()? {
        let place = places.get(&sample).and_then(|&i| outcomes.get_mut(i));
        let outcome = curves.of_sample(place)?;
        curves.take_into(outcome)?;
    }
    Ok(())
}

/// The points of a table of curves, one after the other.
pub(super) struct CurveCursor(RowCursor<CurveBatch>);

struct CurveBatch {
    sample: Int64Array,
    level: Float64Array,
    frequency: Float64Array,
    amplitude: Float64Array,
}

impl CurveBatch {
    fn of(rows: &Rows) -> Result<Self, Fault> {
        Ok(Self {
            sample: rows.counts("sample")?.clone(),
            level: rows.reals("level")?.clone(),
            frequency: rows.reals("frequency_hz")?.clone(),
            amplitude: rows.reals("amplitude_m")?.clone(),
        })
    }
}

impl CurveCursor {
    pub(super) fn open(path: &Path) -> Result<Self, FileError> {
        let reader = TableReader::open(path, &[])?;
        Ok(Self(RowCursor::new(reader, CurveBatch::of)))
    }

    /// The sample of the point at hand; none after the last point.
    pub(super) fn sample(&mut self) -> Result<Option<u64>, FileError> {
        let found = self
            .0
            .row()?
            .map(|(batch, at)| whole(&batch.sample, at, "sample"));
        self.0.reader.checked(found.transpose())
    }

    /// The sample of a curve, which must be there.
    pub(super) fn of_sample<T>(&self, found: Option<T>) -> Result<T, FileError> {
        let found = found.ok_or_else(|| missing("the sample of a curve"));
        self.0.reader.checked(found)
    }

    /// Adds the point at hand to the curve of its level, and passes it.
    pub(super) fn take_into(&mut self, outcome: &mut SampleOutcome) -> Result<(), FileError> {
        let taken = self.0.take(|batch, at| {
            let level = real(&batch.level, at, "level")?;
            let record = outcome.levels.iter_mut().find(|l| l.level == level);
            let record = record.ok_or_else(|| missing("the level of a curve"))?;
            record.around.curve_mut().push(CurvePoint {
                frequency_hz: number(&batch.frequency, at),
                amplitude_m: number(&batch.amplitude, at),
                unstable: None,
            });
            Ok(())
        });
        taken.map(|_| ())
    }
}

fn curve_columns(outcomes: &[SampleOutcome]) -> Table {
    let (mut sample, mut level) = (Vec::new(), Vec::new());
    let (mut frequency, mut amplitude) = (Vec::new(), Vec::new());
    for outcome in outcomes {
        for record in &outcome.levels {
            for point in record.around.curve() {
                sample.push(i64::try_from(outcome.index).ok());
                level.push(Some(record.level).filter(|v| v.is_finite()));
                frequency.push(Some(point.frequency_hz).filter(|v| v.is_finite()));
                amplitude.push(Some(point.amplitude_m).filter(|v| v.is_finite()));
            }
        }
    }
    vec![
        ("sample".to_owned(), Column::Count(sample)),
        ("level".to_owned(), Column::Real(level)),
        ("frequency_hz".to_owned(), Column::Real(frequency)),
        ("amplitude_m".to_owned(), Column::Real(amplitude)),
    ]
}
