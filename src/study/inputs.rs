//! The random inputs of a study, and the design of its samples.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::document::Document;
use crate::Error;
use crate::model::two_blade::PressureField;
use crate::sampling::input::PRESSURE_MODES;
use crate::sampling::{
    CorrelationTable, Design, DesignSettings, DesignTable, Distribution, DistributionTable,
    EpistemicTable, Input, SampleTable, Shape, Uncertainty,
};

/// Reads `[inputs.*]`, `[design]`, `[correlation]` and `[epistemic]`, and the file that `[design]` names; its name beside the design.
pub(super) fn design(
    document: &mut Document<'_>,
    pressure: Option<PressureField>,
    folder: &Path,
    seed: u64,
    samples: Option<u64>,
) -> Result<(Design, Option<PathBuf>), Error> {
    let tables: BTreeMap<String, DistributionTable> = document.take("inputs")?.unwrap_or_default();
    let mut inputs = Vec::new();
    for (name, table) in &tables {
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
    let table: DesignTable = document.take("design")?.unwrap_or_default();
    document.checked(table.validate().map_err(|bad| bad.under("design")))?;
    let path = table.path().map(Path::to_owned);
    let file = match &path {
        Some(path) => Some(SampleTable::read(&folder.join(path))?),
        None => None,
    };
    let settings = DesignSettings {
        seed,
        samples,
        design: table,
        inputs,
        correlation: document.take::<CorrelationTable>("correlation")?,
        epistemic: document.take::<EpistemicTable>("epistemic")?,
        file,
    };
    Ok((document.checked(settings.build())?, path))
}
