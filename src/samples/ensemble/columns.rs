//! What the columns of the tables mean: the source of the metadata of every column, and of the tables in
//! `docs/src/outputs.md`, which a test compares.

use crate::sampling::Input;
use arrow_schema::{Field, Schema};
use parquet::arrow::{ARROW_SCHEMA_META_KEY, encode_arrow_schema, parquet_to_arrow_schema};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::schema::types::{SchemaDescriptor, TypePtr};
use std::collections::HashMap;

/// Key of the unit in the metadata of a column; absent for a column without unit.
pub const UNIT_KEY: &str = "unit";
/// Key of the meaning in the metadata of a column.
pub const DESCRIPTION_KEY: &str = "description";

/// A column of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DescribedColumn {
    /// Name.
    pub name: &'static str,
    /// Unit, in SI; `1` for a share or ratio, empty for a number or text that has none.
    pub unit: &'static str,
    /// Meaning.
    pub description: &'static str,
}

/// Unit of the excitation level, which depends on the model.
const LEVEL_UNIT: &str = "N on each blade (built-in models), else 1";

const fn column(
    name: &'static str,
    unit: &'static str,
    description: &'static str,
) -> DescribedColumn {
    DescribedColumn {
        name,
        unit,
        description,
    }
}

/// Columns of `samples.parquet` and `further_points.parquet`, but for those of the inputs.
pub const SAMPLE_COLUMNS: [DescribedColumn; 40] = [
    column("sample", "", "index of the sample, from 0"),
    column(
        "outer",
        "",
        "outer point of the epistemic inputs; only with such",
    ),
    column(
        "replicate",
        "",
        "replicate of a `sobol` design; only with such",
    ),
    column(
        "place",
        "",
        "place in the row of a `pick-freeze` design: 0 = A, 1 = B, 2 on = A with one input of B; only with such",
    ),
    column("level", LEVEL_UNIT, "excitation level"),
    column("status", "", "how the search ended"),
    column("frequency_hz", "Hz", "resonance frequency"),
    column(
        "amplitude_m",
        "m",
        "amplitude of the first harmonic of the first response at the peak",
    ),
    column("route", "", "how the peak was found"),
    column(
        "truncation_error",
        "1",
        "stated relative error of the amplitude by the harmonics left out; null without an alert, or where nothing was found with other harmonics",
    ),
    column(
        "multiplier_real",
        "1",
        "real part of the Floquet multiplier of the largest modulus: above 1.01 in modulus the peak is unstable; null where stability was not assessed, and in results of an older program",
    ),
    column(
        "multiplier_imaginary",
        "1",
        "its imaginary part, not negative",
    ),
    column("highest_harmonic", "", "highest harmonic of the solution"),
    column(
        "stick_fraction",
        "1",
        "share of (contact pair, time) that sticks; this and the next two add up to 1",
    ),
    column(
        "slip_fraction",
        "1",
        "share of (contact pair, time) that slips in at least one direction",
    ),
    column(
        "separated_fraction",
        "1",
        "share of (contact pair, time) that is open",
    ),
    column("work_input_j", "J", "work of the excitation per period"),
    column(
        "work_viscous_j",
        "J",
        "work dissipated by the damping matrix per period",
    ),
    column(
        "work_friction_j",
        "J",
        "work dissipated by friction per period",
    ),
    column(
        "damping_ratio",
        "1",
        "equivalent damping ratio of the resonance: dissipated work over 4π times the kinetic energy; null where nothing is dissipated, and in results of an older program",
    ),
    column(
        "residual",
        "1",
        "largest residual of the equations over the static displacement of the contacts",
    ),
    column(
        "other_frequencies_hz",
        "Hz",
        "frequencies of the lower maxima that were found, a list, highest maximum first",
    ),
    column(
        "other_amplitudes_m",
        "m",
        "amplitudes of these maxima, in the same order",
    ),
    column(
        "mode",
        "",
        "mode of the peak by its number among the stuck frequencies, 1 for the lowest, 0 where none is known; this and the next four only where all modes are followed (`peak = \"all\"`)",
    ),
    column(
        "mode_share",
        "1",
        "how clearly the peak is of this mode: its part of the correlations with all modes, 1 where no other mode comes near",
    ),
    column(
        "other_modes",
        "",
        "modes of the lower maxima, in the order of `other_frequencies_hz`",
    ),
    column(
        "other_mode_shares",
        "1",
        "how clearly these are of their modes",
    ),
    column(
        "unfinished_modes",
        "",
        "number of modes whose maximum was searched and not found, though nothing says that it lies outside the band",
    ),
    column(
        "upward_frequency_hz",
        "Hz",
        "where a slow sweep upwards through the band meets its largest amplitude; this and the next five are null without a curve from one end of the band to the other",
    ),
    column("upward_amplitude_m", "m", "that amplitude"),
    column(
        "downward_frequency_hz",
        "Hz",
        "where a slow sweep downwards meets its largest amplitude",
    ),
    column("downward_amplitude_m", "m", "that amplitude"),
    column(
        "several_from_hz",
        "Hz",
        "lowest frequency of the widest range with several solutions, where the downward sweep jumps; null where every frequency has one",
    ),
    column(
        "several_to_hz",
        "Hz",
        "highest frequency of this range, where the upward sweep jumps",
    ),
    column(
        "largest_blade",
        "",
        "blade with the largest amplitude, from 0, to which `amplitude_m` belongs; this and the next three only of a disk whose blades differ",
    ),
    column(
        "amplification",
        "1",
        "amplification factor: that amplitude over the peak of the tuned disk with the same inputs; null where that was not found",
    ),
    column(
        "amplification_over_linear",
        "1",
        "that amplitude over the peak of the tuned disk with all contacts stuck",
    ),
    column(
        "linear_amplification",
        "1",
        "amplification factor of the disk with all contacts stuck: mistuned over tuned",
    ),
    column("newton_iterations", "", "Newton iterations for this row"),
    column("factorizations", "", "linear factorisations for this row"),
];

/// Columns of `curves.parquet`.
pub const CURVE_COLUMNS: [DescribedColumn; 4] = [
    column("sample", "", "index of the sample"),
    column("level", LEVEL_UNIT, "excitation level"),
    column(
        "frequency_hz",
        "Hz",
        "frequency; the first and the last one lie inside the band",
    ),
    column(
        "amplitude_m",
        "m",
        "amplitude of the first harmonic of the first response, interpolated between solutions to 0.3 % of the peak",
    ),
];

/// Unit and meaning of the column `name` of a table with `columns`, or of an input; none for any other name.
fn meaning(columns: &[DescribedColumn], name: &str) -> Option<(&'static str, String)> {
    let described = columns.iter().find(|column| column.name == name);
    let of_column = described.map(|column| (column.unit, column.description.to_owned()));
    of_column.or_else(|| Input::of_column(name).map(|input| (input.unit(), input.description())))
}

/// The schema as readers of Arrow tables take it from the file's metadata, with unit and meaning of each column.
///
/// It is made of the Parquet schema, so that types and nulls cannot differ from it. `pairs` are those of the file: pyarrow
/// takes them from this schema as soon as there is one.
pub(super) fn described_schema(
    schema: &TypePtr,
    columns: &[DescribedColumn],
    pairs: &[KeyValue],
) -> Result<KeyValue, ParquetError> {
    let plain = parquet_to_arrow_schema(&SchemaDescriptor::new(schema.clone()), None)?;
    let described = |field: &Field| {
        let Some((unit, description)) = meaning(columns, field.name()) else {
            return field.clone();
        };
        let unit = Some((UNIT_KEY, unit.to_owned())).filter(|(_, unit)| !unit.is_empty());
        let pairs = unit.into_iter().chain([(DESCRIPTION_KEY, description)]);
        let pairs = pairs.map(|(key, value)| (key.to_owned(), value));
        field
            .clone()
            .with_metadata(pairs.collect::<HashMap<_, _>>())
    };
    let fields: Vec<Field> = plain
        .fields()
        .iter()
        .map(|field| described(field))
        .collect();
    let pair = |pair: &KeyValue| Some((pair.key.clone(), pair.value.clone()?));
    let pairs: HashMap<String, String> = pairs.iter().filter_map(pair).collect();
    let encoded = encode_arrow_schema(&Schema::new_with_metadata(fields, pairs));
    Ok(KeyValue::new(ARROW_SCHEMA_META_KEY.to_owned(), encoded))
}
