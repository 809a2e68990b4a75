//! `[operation]`, `[stress]`, `[[criteria]]`, `[surrogate]` and `[control_variate]` of a study file.

use super::document::Document;
use super::frequency::FrequencyUnit;
use super::model::ModelSettings;
use crate::Error;
use crate::hb::HbSettings;
use crate::report::asked::Requirements;
use crate::report::asked::{ControlVariateSettings, SurrogateSettings};
use crate::sampling::{Design, DesignKind};
use crate::setting::BadSetting;

/// What a study file asks of its report.
pub(super) struct Asked {
    pub requirements: Requirements,
    pub surrogate: Option<SurrogateSettings>,
    pub control_variate: Option<ControlVariateSettings>,
}

impl Asked {
    /// Takes the tables out of the study file.
    ///
    /// # Errors
    /// [`Error::Study`] if one does not have its shape.
    pub(super) fn take(document: &mut Document<'_>) -> Result<Self, Error> {
        Ok(Self {
            requirements: Requirements {
                operation: document.take("operation")?,
                stress: document.take("stress")?,
                criteria: document.take("criteria")?.unwrap_or_default(),
            },
            surrogate: document.take("surrogate")?,
            control_variate: document.take("control_variate")?,
        })
    }

    /// Checks them for a study with the given model, frequency unit, levels, design and solver.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to the study file.
    pub(super) fn check(
        &self,
        model: &ModelSettings,
        unit: FrequencyUnit,
        levels: &[f64],
        design: &Design,
        solver: &HbSettings,
    ) -> Result<(), BadSetting> {
        check_requirements(&self.requirements, model, unit, levels)?;
        if let Some(settings) = &self.surrogate {
            check_surrogate(settings, design)?;
        }
        match &self.control_variate {
            Some(settings) => check_control_variate(settings, design, solver),
            None => Ok(()),
        }
    }
}

/// Checks the requirements of a study with the given model, frequency unit and levels.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
fn check_requirements(
    requirements: &Requirements,
    model: &ModelSettings,
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
    requirements.validate(levels)?;
    match model {
        ModelSettings::Cyclic(_) => check_engine_orders(requirements),
        _ => Ok(()),
    }
}

/// Requires the engine orders that excite a disk.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
fn check_engine_orders(requirements: &Requirements) -> Result<(), BadSetting> {
    let given = requirements.operation.is_some();
    let rule = "must be given: its engine_orders name the engine orders that excite the disk";
    BadSetting::unless(given, "operation", "(absent)", rule)
}

/// Checks the surrogate of a study with the given design.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
fn check_surrogate(settings: &SurrogateSettings, design: &Design) -> Result<(), BadSetting> {
    settings.validate().map_err(|bad| bad.under("surrogate"))?;
    let numbered = design
        .inputs()
        .iter()
        .any(|(input, _)| input.numbers_draws());
    let no_polynomial =
        "no polynomial follows an input whose values only number the draws of a field";
    let reason = design.indivisible().or(numbered.then_some(no_polynomial));
    let rule = format!("must be absent: {}", reason.unwrap_or_default());
    BadSetting::unless(reason.is_none(), "surrogate", "(table)", &rule)
}

/// Checks the control variate of a study with the given design and solver.
///
/// # Errors
/// [`BadSetting`] with a key relative to the study file.
fn check_control_variate(
    settings: &ControlVariateSettings,
    design: &Design,
    solver: &HbSettings,
) -> Result<(), BadSetting> {
    let independent = design.kind() == DesignKind::MonteCarlo && design.outer().is_none();
    let rule = "must be absent: it is for independent samples of one population, a design of kind \"monte-carlo\" without epistemic inputs";
    BadSetting::unless(independent, "control_variate", "(table)", rule)?;
    let checked = settings.validate(design.samples(), solver.harmonics.highest());
    checked.map_err(|bad| bad.under("control_variate"))
}
