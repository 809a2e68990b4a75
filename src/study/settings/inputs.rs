//! The random inputs of a study, and the design of its samples.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::document::Document;
use super::frequency::FrequencyUnit;
use super::identified_inputs::{IdentifiedInputs, InputsKeys};
use super::model::ModelSettings;
use crate::Error;
use crate::sampling::input::{LARGEST_DEVIATION, MOST_BLADES, PRESSURE_MODES};
use crate::sampling::{
    CorrelationTable, Design, DesignSettings, DesignTable, Distribution, DistributionTable,
    EpistemicTable, Input, SampleTable, Shape, Uncertainty,
};
use crate::setting::BadSetting;

/// What the design of a study is made from, beside the study file's own sections of it.
pub(super) struct Surroundings<'s> {
    /// Folder of the study file.
    pub(super) folder: &'s Path,
    /// The structure.
    pub(super) model: &'s ModelSettings,
    /// Unit of the frequencies.
    pub(super) unit: FrequencyUnit,
    /// The seed.
    pub(super) seed: u64,
    /// Number of samples, if it is given.
    pub(super) samples: Option<u64>,
}

/// A design, and the files that it is made from.
pub(super) struct StatedDesign {
    /// The design.
    pub(super) design: Design,
    /// The file of `[design]`, relative to the study file's folder.
    pub(super) file: Option<PathBuf>,
    /// What the file of `[inputs]` states.
    pub(super) identified: Option<IdentifiedInputs>,
}

/// Reads `[inputs]`, `[design]`, `[correlation]` and `[epistemic]`, and the files that they name.
pub(super) fn design(
    document: &mut Document<'_>,
    of: &Surroundings<'_>,
) -> Result<StatedDesign, Error> {
    let keys = InputsKeys::take(document)?;
    let tables: BTreeMap<String, DistributionTable> = document.take("inputs")?.unwrap_or_default();
    let own = tables.keys().map(String::as_str).collect();
    let mut inputs = own_inputs(document, &tables, of.model)?;
    let identified = keys.read(document, of.folder, of.model, of.unit, &own)?;
    for (input, distribution) in identified.iter().flat_map(|found| &found.inputs) {
        inputs.push((*input, Uncertainty::Aleatory(distribution.clone())));
    }
    let table: DesignTable = document.take("design")?.unwrap_or_default();
    document.checked(table.validate().map_err(|bad| bad.under("design")))?;
    let path = table.path().map(Path::to_owned);
    let file = match &path {
        Some(path) => {
            let read = SampleTable::read(&of.folder.join(path));
            Some(read.map_err(|error| document.bad_file(error))?)
        }
        None => None,
    };
    let settings = DesignSettings {
        seed: of.seed,
        samples: of.samples,
        design: table,
        inputs,
        correlation: document.take::<CorrelationTable>("correlation")?,
        known_correlation: (identified.as_ref()).map(|found| found.correlation.clone()),
        epistemic: document.take::<EpistemicTable>("epistemic")?,
        file,
    };
    Ok(StatedDesign {
        design: document.checked(settings.build())?,
        file: path,
        identified,
    })
}

/// Inputs with tables in the study file, and those of its pressure field.
fn own_inputs(
    document: &Document<'_>,
    tables: &BTreeMap<String, DistributionTable>,
    model: &ModelSettings,
) -> Result<Vec<(Input, Uncertainty)>, Error> {
    let pressure = match model {
        ModelSettings::TwoBladeStrip { pressure, .. } => *pressure,
        ModelSettings::Matrices(_) | ModelSettings::Cyclic(_) => None,
    };
    let (blades, scatter) = match model {
        ModelSettings::Cyclic(disk) => (disk.sectors, disk.blade_frequency_scatter),
        _ => (0, 0.0),
    };
    let mut inputs = Vec::new();
    for (name, table) in tables {
        let key = format!("inputs.{name}");
        let Some(input) = Input::from_name(name) else {
            let known = Input::ALL.map(Input::name).join(", ");
            return Err(document.at_key(&key, format!("unknown input; known are {known}")));
        };
        let uncertainty = table.uncertainty().map_err(|bad| bad.under(&key));
        inputs.push((input, document.checked(uncertainty)?));
    }
    let coefficients = 2 * pressure.map_or(0, |field| field.modes);
    for k in (0..PRESSURE_MODES as u8).take(coefficients) {
        let (mean, standard_deviation) = (0.0, 1.0);
        let shape = Shape::Normal {
            mean,
            standard_deviation,
        };
        let normal = document.checked(Distribution::new(shape, None))?;
        inputs.push((Input::PressureMode(k), Uncertainty::Aleatory(normal)));
    }
    inputs.extend(document.checked(blade_deviations(blades, scatter))?);
    Ok(inputs)
}

/// The deviations of all blades of a disk with so many and such a scatter (standard deviation); none of a tuned disk.
fn blade_deviations(blades: usize, scatter: f64) -> Result<Vec<(Input, Uncertainty)>, BadSetting> {
    let blades = if scatter > 0.0 { blades } else { 0 };
    let deviation = |blade: u8| {
        let shape = Shape::Normal {
            mean: 0.0,
            standard_deviation: scatter,
        };
        let most = Some([-LARGEST_DEVIATION, LARGEST_DEVIATION]);
        let normal = Distribution::new(shape, most)?;
        Ok((Input::BladeFrequency(blade), Uncertainty::Aleatory(normal)))
    };
    (0..MOST_BLADES as u8).take(blades).map(deviation).collect()
}
