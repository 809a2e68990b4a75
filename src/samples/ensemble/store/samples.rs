//! The table of samples: one row per sample and level.
//!
//! A sample without a solution keeps its row: status and work counts are there, the numbers of the peak are null. No column ever
//! holds NaN.

use super::provenance::Provenance;
use crate::ensemble::columns::SAMPLE_COLUMNS;
use crate::ensemble::outcome::{
    FollowedModes, LevelOutcome, Maximum, MistunedRecord, ModeOfMaximum, PeakRecord, SampleOutcome,
    SweepRecord,
};
use crate::ensemble::table::{Column, Table, TableError, TableLayout, TableWriter, count};
use crate::file::{FileError, FileRecord};
use crate::hb::PeakRoute;
use crate::sampling::{Input, SampleGroup};
use parquet::file::metadata::KeyValue;
use std::path::Path;

/// Key of the names of the inputs.
pub(super) const INPUTS_KEY: &str = "inputs";
/// Columns of what a sample belongs to.
pub(super) type GroupColumn = (&'static str, fn(&SampleGroup) -> Option<u32>);
pub(super) const GROUP_COLUMNS: [GroupColumn; 3] = [
    ("outer", |group| group.outer),
    ("replicate", |group| group.replicate),
    ("place", |group| group.place),
];

/// Columns of the lower maxima: lists, highest maximum first.
type OtherColumn = (&'static str, fn(&Maximum) -> f64);
pub(super) const OTHER_COLUMNS: [OtherColumn; 2] = [
    ("other_frequencies_hz", |other| other.frequency_hz),
    ("other_amplitudes_m", |other| other.amplitude_m),
];

/// Columns of what sweeps meet.
type SweepColumn = (&'static str, fn(&SweepRecord) -> Option<f64>);
pub(super) const SWEEP_COLUMNS: [SweepColumn; 6] = [
    ("upward_frequency_hz", |s| Some(s.upward.frequency_hz)),
    ("upward_amplitude_m", |s| Some(s.upward.amplitude_m)),
    ("downward_frequency_hz", |s| Some(s.downward.frequency_hz)),
    ("downward_amplitude_m", |s| Some(s.downward.amplitude_m)),
    ("several_from_hz", |s| Some(s.several_hz?[0])),
    ("several_to_hz", |s| Some(s.several_hz?[1])),
];

/// Columns of what mistuning makes of a peak; only of disks whose blades differ.
type MistunedColumn = (&'static str, fn(&MistunedRecord) -> Option<f64>);
pub(super) const BLADE_COLUMN: &str = "largest_blade";
pub(super) const MISTUNED_COLUMNS: [MistunedColumn; 3] = [
    ("amplification", |m| m.amplification.get()),
    ("amplification_over_linear", |m| m.over_linear.get()),
    ("linear_amplification", |m| m.linear_amplification.get()),
];

/// Columns of the modes of the maxima; only where all modes are followed.
pub(super) const MODE_COLUMNS: [&str; 5] = [
    "mode",
    "mode_share",
    "other_modes",
    "other_mode_shares",
    "unfinished_modes",
];

/// Writes one row per sample and level.
///
/// Columns: `sample`, those of [`SampleGroup`] that the design has, the inputs by name, `level`, `status`, then the fields
/// of [`PeakRecord`] (null without a solution). Then come `other_frequencies_hz` and `other_amplitudes_m` (lists of the lower maxima,
/// highest first, empty without a solution), what sweeps meet (null without a curve), the modes of the maxima where all modes are
/// followed, `newton_iterations`, `factorizations`.
/// [`SAMPLE_COLUMNS`] has their units and meanings, and so has the metadata of each column.
///
/// # Errors
/// [`TableError`]; then `path` is as it was.
pub fn write_samples(
    path: &Path,
    provenance: &Provenance,
    input_names: &[String],
    outcomes: &[SampleOutcome],
) -> Result<FileRecord, TableError> {
    let group = outcomes.first().map(|outcome| outcome.group);
    let layout = samples_layout(provenance, input_names, group.unwrap_or_default());
    let layout = layout.map_err(|error| FileError::system(path, error.into()))?;
    let mut table = TableWriter::create(path, layout)?;
    table.write(outcomes)?;
    table.finish()
}

/// The table of samples; `group` tells which of its columns there are.
pub(in crate::ensemble) fn samples_layout<'t>(
    provenance: &Provenance,
    input_names: &'t [String],
    group: SampleGroup,
) -> Result<TableLayout<'t, SampleOutcome>, serde_json::Error> {
    let mut metadata = provenance.key_values()?;
    let names = serde_json::to_string(input_names)?;
    metadata.push(KeyValue::new(INPUTS_KEY.to_owned(), names));
    let with_modes = !provenance.followed_modes.is_empty();
    Ok(TableLayout {
        metadata,
        described: &SAMPLE_COLUMNS,
        columns: Box::new(move |outcomes| sample_columns(input_names, group, with_modes, outcomes)),
    })
}

/// A sample at one of its levels: a row of the table of samples.
type LevelRow<'a> = (&'a SampleOutcome, &'a LevelOutcome);

/// `group` tells which of its columns there are, and `with_modes` whether all modes are followed.
fn sample_columns(
    input_names: &[String],
    group: SampleGroup,
    with_modes: bool,
    outcomes: &[SampleOutcome],
) -> Table {
    let rows: Vec<LevelRow> = outcomes
        .iter()
        .flat_map(|outcome| outcome.levels.iter().map(move |level| (outcome, level)))
        .collect();
    let mut table = input_columns(input_names, group, &rows);
    table.extend(peak_columns(&rows));
    let has_blades =
        |name: &String| matches!(Input::of_column(name), Some(Input::BladeFrequency(_)));
    if input_names.iter().any(has_blades) {
        table.extend(mistuned_columns(&rows));
    }
    if with_modes {
        table.extend(mode_columns(&rows));
    }
    let newton = rows.iter().map(|(_, l)| count(l.newton_iterations));
    let factorizations = rows.iter().map(|(_, l)| count(l.factorizations));
    table.extend([
        named("newton_iterations", Column::Count(newton.collect())),
        named("factorizations", Column::Count(factorizations.collect())),
    ]);
    table
}

fn named(name: &str, column: Column) -> (String, Column) {
    (name.to_owned(), column)
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}

/// Which sample and level a row is of, and how the search for its peak ended.
fn input_columns(input_names: &[String], group: SampleGroup, rows: &[LevelRow]) -> Table {
    let index = |outcome: &SampleOutcome| i64::try_from(outcome.index).ok();
    let sample = rows.iter().map(|(o, _)| index(o));
    let mut table = vec![named("sample", Column::Count(sample.collect()))];
    for (name, of) in GROUP_COLUMNS {
        if of(&group).is_some() {
            let number = |o: &SampleOutcome| of(&o.group).map(i64::from);
            let numbers = rows.iter().map(|(o, _)| number(o));
            table.push(named(name, Column::Count(numbers.collect())));
        }
    }
    for (i, name) in input_names.iter().enumerate() {
        let input = |o: &SampleOutcome| o.inputs.get(i).copied().and_then(finite);
        let inputs = rows.iter().map(|(o, _)| input(o));
        table.push(named(name, Column::Real(inputs.collect())));
    }
    let level = rows.iter().map(|(_, l)| finite(l.level));
    let status = rows.iter().map(|(_, l)| Some(l.status.name()));
    table.extend([
        named("level", Column::Real(level.collect())),
        named("status", Column::Text(status.collect())),
    ]);
    table
}

/// The peaks of the rows, the lower maxima and what sweeps meet; empty where the search has no solution.
fn peak_columns(rows: &[LevelRow]) -> Table {
    let real = |name: &str, f: fn(&PeakRecord) -> Option<f64>| {
        let value =
            |(_, level): &LevelRow| level.solved_peak().as_ref().and_then(f).and_then(finite);
        named(name, Column::Real(rows.iter().map(value).collect()))
    };
    let route = |(_, l): &LevelRow| l.solved_peak().and_then(|p| p.route).map(PeakRoute::name);
    let highest = |(_, l): &LevelRow| l.solved_peak().and_then(|p| count(p.highest_harmonic));
    let mut table = vec![
        real("frequency_hz", |p| Some(p.frequency_hz)),
        real("amplitude_m", |p| Some(p.amplitude_m)),
        named("route", Column::Text(rows.iter().map(route).collect())),
        real("truncation_error", |p| p.truncation_error.get()),
        real("multiplier_real", |p| p.multiplier_real.get()),
        real("multiplier_imaginary", |p| p.multiplier_imaginary.get()),
        named(
            "highest_harmonic",
            Column::Count(rows.iter().map(highest).collect()),
        ),
        real("stick_fraction", |p| Some(p.stick_fraction)),
        real("slip_fraction", |p| Some(p.slip_fraction)),
        real("separated_fraction", |p| Some(p.separated_fraction)),
        real("work_input_j", |p| Some(p.work_input_j)),
        real("work_viscous_j", |p| Some(p.work_viscous_j)),
        real("work_friction_j", |p| Some(p.work_friction_j)),
        real("damping_ratio", |p| p.damping_ratio.get()),
        real("residual", |p| Some(p.residual)),
    ];
    for (name, of) in OTHER_COLUMNS {
        let others = |(_, l): &LevelRow| match l.solved_peak() {
            Some(_) => l.around.others().iter().map(of).collect(),
            None => Vec::new(),
        };
        table.push(named(
            name,
            Column::Reals(rows.iter().map(others).collect()),
        ));
    }
    for (name, of) in SWEEP_COLUMNS {
        let sweeps = |(_, l): &LevelRow| l.around.sweeps().and_then(of).and_then(finite);
        table.push(named(name, Column::Real(rows.iter().map(sweeps).collect())));
    }
    table
}

/// What mistuning makes of the peaks of the rows.
fn mistuned_columns(rows: &[LevelRow]) -> Table {
    let blade = |(_, l): &LevelRow| l.around.mistuned().and_then(|m| count(m.blade));
    let blades = rows.iter().map(blade).collect();
    let mut table = vec![named(BLADE_COLUMN, Column::Count(blades))];
    for (name, of) in MISTUNED_COLUMNS {
        let factor = |(_, l): &LevelRow| l.around.mistuned().and_then(of).and_then(finite);
        table.push(named(name, Column::Real(rows.iter().map(factor).collect())));
    }
    table
}

/// The modes of the maxima of the rows.
fn mode_columns(rows: &[LevelRow]) -> Table {
    let modes: Vec<Option<&FollowedModes>> =
        rows.iter().map(|(_, level)| level.around.modes()).collect();
    let peaks = || {
        modes
            .iter()
            .map(|modes| modes.and_then(|modes| modes.of_maxima.first()))
    };
    let others = || {
        let maxima = modes
            .iter()
            .map(|modes| modes.map_or(&[][..], |modes| &modes.of_maxima));
        maxima.map(|maxima| maxima.iter().skip(1))
    };
    let number = |of: &ModeOfMaximum| i64::from(of.number);
    let unfinished = |modes: &FollowedModes| i64::from(modes.unfinished);
    let columns = [
        Column::Count(peaks().map(|of| of.map(number)).collect()),
        Column::Real(
            peaks()
                .map(|of| of.and_then(|of| finite(of.share)))
                .collect(),
        ),
        Column::Counts(others().map(|of| of.map(number).collect()).collect()),
        Column::Reals(others().map(|of| of.map(|of| of.share).collect()).collect()),
        Column::Count(modes.iter().map(|modes| modes.map(unfinished)).collect()),
    ];
    let named = MODE_COLUMNS.into_iter().zip(columns);
    named
        .map(|(name, column)| (name.to_owned(), column))
        .collect()
}
