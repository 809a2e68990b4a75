//! `[operation]`, `[stress]`, `[[criteria]]` and `[surrogate]` of a study file.

use super::document::Document;
use super::frequency::FrequencyUnit;
use super::model::ModelSettings;
use crate::Error;
use crate::report::asked::Requirements;
use crate::report::asked::SurrogateSettings;
use crate::sampling::Design;
use crate::setting::BadSetting;

/// Takes the three tables out of the study file.
///
/// # Errors
/// [`Error::Study`] if one does not have its shape.
pub(super) fn requirements(document: &mut Document<'_>) -> Result<Requirements, Error> {
    Ok(Requirements {
        operation: document.take("operation")?,
        stress: document.take("stress")?,
        criteria: document.take("criteria")?.unwrap_or_default(),
    })
}

/// Checks the requirements of a study with the given model, frequency unit and levels.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
pub(super) fn check_requirements(
    requirements: &Requirements,
    (model, unit): (&ModelSettings, FrequencyUnit),
    levels: &[f64],
) -> Result<(), BadSetting> {
    let given = [
        ("operation", requirements.operation.is_some()),
        ("stress", requirements.stress.is_some()),
        ("criteria", !requirements.criteria.is_empty()),
    ];
    for (key, given) in given {
        let holds = !given || unit == FrequencyUnit::Hertz;
        let rule = "needs SI units: give frequency.band_hz instead of band_rad_s";
        BadSetting::unless(holds, key, "(table)", rule)?;
    }
    requirements.validate(levels)?;
    match model {
        ModelSettings::Cyclic(_) => check_engine_order(requirements),
        _ => Ok(()),
    }
}

/// Requires the one engine order that excites a disk.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
fn check_engine_order(requirements: &Requirements) -> Result<(), BadSetting> {
    let Some(operation) = &requirements.operation else {
        let rule = "must be given: its engine_orders name the engine order that excites the disk";
        return BadSetting::unless(false, "operation", "(absent)", rule);
    };
    let orders = &operation.engine_orders;
    let rule = "must be one engine order for a model of kind \"cyclic\": each excites another nodal diameter, and is a study of its own";
    let key = "operation.engine_orders";
    BadSetting::unless(orders.len() == 1, key, format!("{orders:?}"), rule)
}

/// Checks the surrogate of a study with the given design.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
pub(super) fn check_surrogate(
    settings: &SurrogateSettings,
    design: &Design,
) -> Result<(), BadSetting> {
    settings.validate().map_err(|bad| bad.under("surrogate"))?;
    let reason = design.indivisible();
    let rule = format!("must be absent: {}", reason.unwrap_or_default());
    BadSetting::unless(reason.is_none(), "surrogate", "(table)", &rule)
}
