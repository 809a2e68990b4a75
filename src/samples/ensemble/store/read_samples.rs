//! The rows of a table of samples as outcomes.

use super::samples::{
    BLADE_COLUMN, GROUP_COLUMNS, INPUTS_KEY, MISTUNED_COLUMNS, MODE_COLUMNS, OTHER_COLUMNS,
    SWEEP_COLUMNS,
};
use crate::ensemble::outcome::{
    AroundPeak, FollowedModes, LevelOutcome, Maximum, MistunedRecord, ModeOfMaximum, PeakRecord,
    SampleOutcome, SweepRecord,
};
use crate::ensemble::table::{
    RowCursor, Rows, TableReader, missing, number, optional, real, whole,
};
use crate::file::{Fault, FileError};
use crate::hb::{PeakRoute, Status};
use crate::sampling::SampleGroup;
use arrow_array::cast::AsArray;
use arrow_array::types::{ArrowPrimitiveType, Float64Type, Int64Type};
use arrow_array::{Array, Float64Array, Int64Array, ListArray, StringArray};
use std::collections::BTreeMap;
use std::path::Path;

/// Samples read back from `samples.parquet`.
#[derive(Debug, Clone)]
pub struct StoredSamples {
    /// Key-value metadata of the file, one entry per field of [`super::Provenance`].
    pub metadata: BTreeMap<String, String>,
    /// Names of the inputs.
    pub input_names: Vec<String>,
    /// The outcomes, without their curves.
    pub outcomes: Vec<SampleOutcome>,
}

/// Reads what [`super::write_samples`] wrote.
///
/// # Errors
/// [`FileError`] if the file cannot be read or lacks a column.
pub fn read_samples(path: &Path) -> Result<StoredSamples, FileError> {
    let mut samples = SampleCursor::open(path)?;
    let mut outcomes = Vec::new();
    while let Some(outcome) = samples.take()? {
        outcomes.push(outcome);
    }
    Ok(StoredSamples {
        metadata: samples.rows.reader.metadata,
        input_names: samples.input_names,
        outcomes,
    })
}

/// The samples of a table, ascending, and whether every level of each has a solution.
///
/// # Errors
/// [`FileError`] if the file cannot be read, lacks a column, or is out of order.
pub fn read_indices(path: &Path) -> Result<Vec<(u64, bool)>, FileError> {
    indices_of(TableReader::open(path, &INDEX_COLUMNS)?)
}

/// The columns from which they come.
pub(in crate::ensemble) const INDEX_COLUMNS: [&str; 2] = ["sample", "status"];

/// The same of a table that is open.
pub(in crate::ensemble) fn indices_of(reader: TableReader) -> Result<Vec<(u64, bool)>, FileError> {
    let columns = |rows: &Rows| {
        let (samples, statuses) = (rows.counts("sample")?, rows.texts("status")?);
        Ok((samples.clone(), statuses.clone()))
    };
    let mut rows = RowCursor::new(reader, columns);
    let row = |(samples, statuses): &(Int64Array, StringArray), at: usize| {
        let status = named(statuses, at, &Status::ALL, Status::name)?;
        let status = status.ok_or_else(|| missing("status"))?;
        let index = whole(samples, at, "sample")?;
        Ok((index, status.has_solution()))
    };
    let mut found: Vec<(u64, bool)> = Vec::new();
    while let Some((index, solved)) = rows.take(row)? {
        match found.last_mut() {
            Some(last) if last.0 == index => last.1 &= solved,
            Some(last) if last.0 > index => {
                return rows.reader.checked(Err(Fault::new("samples must ascend")));
            }
            _ => found.push((index, solved)),
        }
    }
    Ok(found)
}

/// The samples of a table, one after the other.
pub(super) struct SampleCursor {
    pub rows: RowCursor<SampleBatch>,
    /// Names of the inputs.
    pub input_names: Vec<String>,
}

/// Columns of some rows.
pub(super) struct SampleBatch {
    sample: Int64Array,
    /// As [`GROUP_COLUMNS`].
    group: [Option<Int64Array>; 3],
    inputs: Vec<Float64Array>,
    level: Float64Array,
    status: StringArray,
    peak: PeakColumns,
    /// As [`OTHER_COLUMNS`].
    others: [ListArray; 2],
    /// As [`SWEEP_COLUMNS`]; absent in tables of an older program.
    sweeps: [Option<Float64Array>; 6],
    /// Largest blade, and as [`MISTUNED_COLUMNS`]; only of disks whose blades differ.
    blade: Option<Int64Array>,
    mistuned: [Option<Float64Array>; 3],
    /// Only where all modes are followed.
    modes: Option<ModeColumns>,
    newton_iterations: Int64Array,
    factorizations: Int64Array,
}

/// Columns of the fields of [`PeakRecord`].
struct PeakColumns {
    frequency: Float64Array,
    amplitude: Float64Array,
    route: StringArray,
    truncation_error: Float64Array,
    /// Absent in tables of an older program.
    multiplier: [Option<Float64Array>; 2],
    /// Absent in tables of an older program.
    damping_ratio: Option<Float64Array>,
    highest_harmonic: Int64Array,
    /// Shares of stick, slip and separation, works of input, damping and friction, residual.
    rest: [Float64Array; 7],
}

/// As [`MODE_COLUMNS`].
struct ModeColumns {
    of_peak: (Int64Array, Float64Array),
    of_others: [ListArray; 2],
    unfinished: Int64Array,
}

impl SampleCursor {
    pub(super) fn open(path: &Path) -> Result<Self, FileError> {
        let reader = TableReader::open(path, &[])?;
        let names = reader.metadata.get(INPUTS_KEY);
        let names: Option<Vec<String>> = names.and_then(|names| serde_json::from_str(names).ok());
        let input_names = reader.checked(names.ok_or_else(|| missing(INPUTS_KEY)))?;
        let names = input_names.clone();
        Ok(Self {
            rows: RowCursor::new(reader, move |rows| SampleBatch::of(rows, &names)),
            input_names,
        })
    }

    /// Index of the next sample; none after the last one.
    pub(super) fn index(&mut self) -> Result<Option<u64>, FileError> {
        let found = self.rows.row()?.map(|(batch, at)| batch.index(at));
        self.rows.reader.checked(found.transpose())
    }

    /// The next sample, with all its levels and no curve.
    pub(super) fn take(&mut self) -> Result<Option<SampleOutcome>, FileError> {
        let first = self.rows.take(|batch, at| {
            let outcome = batch.without_levels(at)?;
            Ok((outcome, batch.level(at)?))
        })?;
        let Some((mut outcome, level)) = first else {
            return Ok(None);
        };
        let mut levels = vec![level];
        while self.index()? == Some(outcome.index) {
            levels.extend(self.rows.take(SampleBatch::level)?);
        }
        outcome.levels = levels.into();
        Ok(Some(outcome))
    }
}

impl SampleBatch {
    fn of(rows: &Rows, input_names: &[String]) -> Result<Self, Fault> {
        let inputs = input_names.iter().map(|name| rows.reals(name).cloned());
        let [frequencies, amplitudes] = OTHER_COLUMNS.map(|(name, _)| rows.lists(name).cloned());
        Ok(Self {
            sample: rows.counts("sample")?.clone(),
            group: GROUP_COLUMNS.map(|(name, _)| rows.counts(name).ok().cloned()),
            inputs: inputs.collect::<Result<_, _>>()?,
            level: rows.reals("level")?.clone(),
            status: rows.texts("status")?.clone(),
            peak: PeakColumns::of(rows)?,
            others: [frequencies?, amplitudes?],
            sweeps: SWEEP_COLUMNS.map(|(name, _)| rows.reals(name).ok().cloned()),
            blade: rows.counts(BLADE_COLUMN).ok().cloned(),
            mistuned: MISTUNED_COLUMNS.map(|(name, _)| rows.reals(name).ok().cloned()),
            modes: ModeColumns::of(rows).ok(),
            newton_iterations: rows.counts("newton_iterations")?.clone(),
            factorizations: rows.counts("factorizations")?.clone(),
        })
    }

    fn index(&self, at: usize) -> Result<u64, Fault> {
        whole(&self.sample, at, "sample")
    }

    /// The sample of a row.
    fn without_levels(&self, at: usize) -> Result<SampleOutcome, Fault> {
        // of their own length, which `collect` does not know before
        let mut inputs = Vec::with_capacity(self.inputs.len());
        for input in &self.inputs {
            inputs.push(real(input, at, "the value of an input")?);
        }
        let number = |i: usize| {
            let column = self.group[i].as_ref()?;
            whole(column, at, "group").ok()
        };
        Ok(SampleOutcome {
            index: self.index(at)?,
            group: SampleGroup {
                outer: number(0),
                replicate: number(1),
                place: number(2),
            },
            inputs: inputs.into(),
            levels: Box::default(),
        })
    }

    fn level(&self, at: usize) -> Result<LevelOutcome, Fault> {
        let status = named(&self.status, at, &Status::ALL, Status::name);
        let mut around = AroundPeak::new(self.others(at)?, Vec::new(), self.sweeps(at));
        if let Some(record) = self.mistuned(at) {
            around.set_mistuned(record);
        }
        let modes = self.modes.as_ref().map(|columns| columns.at(at));
        if let Some(modes) = modes.transpose()?.flatten() {
            around.set_modes(modes);
        }
        Ok(LevelOutcome {
            level: real(&self.level, at, "level")?,
            status: status?.ok_or_else(|| missing("status"))?,
            peak: self.peak.record(at)?,
            around,
            newton_iterations: whole(&self.newton_iterations, at, "newton_iterations")?,
            factorizations: whole(&self.factorizations, at, "factorizations")?,
        })
    }

    fn others(&self, at: usize) -> Result<Vec<Maximum>, Fault> {
        let [(frequencies, _), (amplitudes, _)] = OTHER_COLUMNS;
        let [of_frequency, of_amplitude] = &self.others;
        let frequency_hz = list::<Float64Type>(of_frequency, at, frequencies)?;
        let amplitude_m = list::<Float64Type>(of_amplitude, at, amplitudes)?;
        let places = frequency_hz.into_iter().zip(amplitude_m);
        let others = places.map(|(frequency_hz, amplitude_m)| Maximum {
            frequency_hz,
            amplitude_m,
        });
        Ok(others.collect())
    }

    /// What mistuning makes of the peak, where there is such.
    fn mistuned(&self, at: usize) -> Option<MistunedRecord> {
        let blade = whole(self.blade.as_ref()?, at, BLADE_COLUMN).ok()?;
        let factor = |i: usize| optional(self.mistuned[i].as_ref()?, at);
        Some(MistunedRecord {
            blade,
            amplification: factor(0).into(),
            over_linear: factor(1).into(),
            linear_amplification: factor(2).into(),
        })
    }

    /// What sweeps meet, where that is known.
    fn sweeps(&self, at: usize) -> Option<SweepRecord> {
        let number = |i: usize| optional(self.sweeps[i].as_ref()?, at);
        let point = |i: usize| {
            Some(Maximum {
                frequency_hz: number(i)?,
                amplitude_m: number(i + 1)?,
            })
        };
        Some(SweepRecord {
            upward: point(0)?,
            downward: point(2)?,
            several_hz: Option::zip(number(4), number(5)).map(|(from, to)| [from, to]),
        })
    }
}

impl ModeColumns {
    fn of(rows: &Rows) -> Result<Self, Fault> {
        let [number, share, numbers, shares, unfinished] = MODE_COLUMNS;
        Ok(Self {
            of_peak: (rows.counts(number)?.clone(), rows.reals(share)?.clone()),
            of_others: [rows.lists(numbers)?.clone(), rows.lists(shares)?.clone()],
            unfinished: rows.counts(unfinished)?.clone(),
        })
    }

    /// The modes of the maxima of a row, where they are known.
    fn at(&self, at: usize) -> Result<Option<FollowedModes>, Fault> {
        let [of_peak, _, of_others, of_shares, unfinished] = MODE_COLUMNS;
        if self.unfinished.is_null(at) {
            return Ok(None);
        }
        let mut of_maxima = Vec::new();
        if self.of_peak.0.is_valid(at) {
            of_maxima.push(ModeOfMaximum {
                number: whole(&self.of_peak.0, at, of_peak)?,
                share: number(&self.of_peak.1, at),
            });
        }
        let numbers = list::<Int64Type>(&self.of_others[0], at, of_others)?;
        let shares = list::<Float64Type>(&self.of_others[1], at, of_shares)?;
        for (number, share) in numbers.into_iter().zip(shares) {
            let number = u32::try_from(number).map_err(|_| missing(of_others))?;
            of_maxima.push(ModeOfMaximum { number, share });
        }
        Ok(Some(FollowedModes {
            of_maxima,
            unfinished: whole(&self.unfinished, at, unfinished)?,
        }))
    }
}

impl PeakColumns {
    fn of(rows: &Rows) -> Result<Self, Fault> {
        let real = |name: &str| rows.reals(name).cloned();
        Ok(Self {
            frequency: real("frequency_hz")?,
            amplitude: real("amplitude_m")?,
            route: rows.texts("route")?.clone(),
            truncation_error: real("truncation_error")?,
            multiplier: ["multiplier_real", "multiplier_imaginary"].map(|name| real(name).ok()),
            damping_ratio: real("damping_ratio").ok(),
            highest_harmonic: rows.counts("highest_harmonic")?.clone(),
            rest: [
                real("stick_fraction")?,
                real("slip_fraction")?,
                real("separated_fraction")?,
                real("work_input_j")?,
                real("work_viscous_j")?,
                real("work_friction_j")?,
                real("residual")?,
            ],
        })
    }

    /// The peak of a row, where there is one.
    fn record(&self, at: usize) -> Result<Option<PeakRecord>, Fault> {
        let place = (optional(&self.frequency, at), optional(&self.amplitude, at));
        let (Some(frequency_hz), Some(amplitude_m)) = place else {
            return Ok(None);
        };
        let [stick, slip, separated, input, viscous, friction, residual] = &self.rest;
        let of_older = |column: &Option<Float64Array>| optional(column.as_ref()?, at);
        Ok(Some(PeakRecord {
            frequency_hz,
            amplitude_m,
            route: named(&self.route, at, &PeakRoute::ALL, PeakRoute::name)?,
            truncation_error: optional(&self.truncation_error, at).into(),
            multiplier_real: of_older(&self.multiplier[0]).into(),
            multiplier_imaginary: of_older(&self.multiplier[1]).into(),
            damping_ratio: of_older(&self.damping_ratio).into(),
            highest_harmonic: whole(&self.highest_harmonic, at, "highest_harmonic")?,
            stick_fraction: number(stick, at),
            slip_fraction: number(slip, at),
            separated_fraction: number(separated, at),
            work_input_j: number(input, at),
            work_viscous_j: number(viscous, at),
            work_friction_j: number(friction, at),
            residual: number(residual, at),
        }))
    }
}

/// One of `all`, by the name that it bears in files; none where there is no text.
fn named<T: Copy>(
    texts: &StringArray,
    at: usize,
    all: &[T],
    name_of: fn(T) -> &'static str,
) -> Result<Option<T>, Fault> {
    if texts.is_null(at) {
        return Ok(None);
    }
    let text = texts.value(at);
    let known = all.iter().find(|&&one| name_of(one) == text);
    let unknown = || Fault::new(format!("{text:?} is no name that this program writes"));
    known.copied().map(Some).ok_or_else(unknown)
}

/// The numbers of a list.
fn list<T: ArrowPrimitiveType>(
    lists: &ListArray,
    at: usize,
    name: &str,
) -> Result<Vec<T::Native>, Fault> {
    let elements = lists.value(at);
    let numbers = elements.as_primitive_opt::<T>();
    let numbers = numbers.filter(|numbers| numbers.null_count() == 0);
    numbers
        .map(|numbers| numbers.values().to_vec())
        .ok_or_else(|| missing(name))
}
