//! `[operation]`, `[stress]` and `[[criteria]]` of a study file.

use super::document::Document;
use super::frequency::FrequencyUnit;
use crate::Error;
use crate::report::requirement::Requirements;
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

/// Checks the requirements of a study with the given frequency unit and levels.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
pub(super) fn check_requirements(
    requirements: &Requirements,
    unit: FrequencyUnit,
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
    requirements.validate(levels)
}
