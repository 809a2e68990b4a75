//! `[inputs] from`: inputs with their joint distribution from the file of an identification.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::document::Document;
use super::frequency::FrequencyUnit;
use super::model::ModelSettings;
use super::nominal_stiffness::{Direction, nominal_stiffness};
use crate::Error;
use crate::file::FileError;
use crate::identify::{ContactParameter, Identified};
use crate::sampling::correlation::KnownCorrelation;
use crate::sampling::{Distribution, Input, Shape};
use crate::setting::BadSetting;

/// Keys of `[inputs]` that are no inputs.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[schemars(extend("dependentRequired" = { "normal_stiffness": ["from"] }))]
pub(super) struct InputsKeys {
    /// File of `microslip identify`, relative to the study file: friction coefficient and stiffnesses of the contact with their
    /// joint distribution. They are the inputs `friction_coefficient`, `tangential_stiffness_scale` and `normal_stiffness_scale`;
    /// a scale is the measured stiffness over the nominal one of an interface.
    pub(super) from: Option<PathBuf>,
    /// What the normal stiffness is where it was not measured, unless `[inputs.normal_stiffness_scale]` states it.
    pub(super) normal_stiffness: Option<NormalStiffness>,
}

/// What an unmeasured normal stiffness is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum NormalStiffness {
    /// It keeps its nominal ratio to the tangential one: both are scaled together, by the input `stiffness_scale`.
    WithTangential,
}

/// Inputs that a file states.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedInputs {
    /// The file, relative to the study file's folder.
    pub file: PathBuf,
    /// Inputs with their distributions.
    pub inputs: Vec<(Input, Distribution)>,
    /// Correlation of their normal scores.
    pub correlation: KnownCorrelation,
}

impl InputsKeys {
    /// Takes the keys out of `[inputs]`.
    pub(super) fn take(document: &mut Document<'_>) -> Result<Self, Error> {
        Ok(Self {
            from: document.take_below("inputs", "from")?,
            normal_stiffness: document.take_below("inputs", "normal_stiffness")?,
        })
    }

    /// Reads the file that they name; `None` where they name none. `own` are the inputs that have tables of their own.
    ///
    /// # Errors
    /// [`Error::File`] on a file that is none; [`Error::Study`] on keys that do not go with what the file holds.
    pub(super) fn read(
        &self,
        document: &Document<'_>,
        folder: &Path,
        model: &ModelSettings,
        unit: FrequencyUnit,
        own: &BTreeSet<&str>,
    ) -> Result<Option<IdentifiedInputs>, Error> {
        let Some(file) = &self.from else {
            let given = self.normal_stiffness.is_some();
            let rule = "must be absent without inputs.from";
            let key = "inputs.normal_stiffness";
            document.checked(BadSetting::unless(!given, key, "(given)", rule))?;
            return Ok(None);
        };
        let path = folder.join(file);
        let identified = Identified::read(&path).map_err(|error| document.bad_file(error))?;
        document.checked(self.check_normal(file, &identified, own))?;
        let mut inputs = Vec::new();
        for (i, found) in identified.inputs.iter().enumerate() {
            let input = self.input(found.parameter);
            document.checked(once(input, file, i, own))?;
            let factor = match direction(found.parameter) {
                Some(direction) => {
                    1.0 / document.checked(nominal_stiffness(model, unit, direction))?
                }
                None => 1.0,
            };
            let distribution = accepted(input, found.shape.scaled(factor));
            let distribution = distribution.map_err(|bad| {
                let (parameter, bad) = (found.parameter.name(), bad.under(&format!("inputs[{i}]")));
                let rule = format!("{parameter}: as input {} of the study {bad}", input.name());
                FileError::content(&path, None, rule)
            })?;
            inputs.push((input, distribution));
        }
        Ok(Some(IdentifiedInputs {
            file: file.clone(),
            correlation: KnownCorrelation {
                origin: file.to_string_lossy().into_owned(),
                inputs: inputs.iter().map(|(input, _)| *input).collect(),
                matrix: identified.correlation,
            },
            inputs,
        }))
    }

    /// The input that a parameter of the file is.
    fn input(&self, parameter: ContactParameter) -> Input {
        match (parameter, self.normal_stiffness) {
            (ContactParameter::FrictionCoefficient, _) => Input::FrictionCoefficient,
            (ContactParameter::NormalStiffnessNPerUm, _) => Input::NormalStiffnessScale,
            (ContactParameter::TangentialStiffnessNPerUm, None) => Input::TangentialStiffnessScale,
            (
                ContactParameter::TangentialStiffnessNPerUm,
                Some(NormalStiffness::WithTangential),
            ) => Input::StiffnessScale,
        }
    }

    /// The normal stiffness must come from exactly one place, and no second factor may act on a measured one.
    fn check_normal(
        &self,
        file: &Path,
        identified: &Identified,
        own: &BTreeSet<&str>,
    ) -> Result<(), BadSetting> {
        let has = |wanted| (identified.inputs.iter()).any(|input| input.parameter == wanted);
        let normal = has(ContactParameter::NormalStiffnessNPerUm);
        let tangential = has(ContactParameter::TangentialStiffnessNPerUm);
        let name = file.display();
        let (key, written) = ("inputs.normal_stiffness", "\"with-tangential\"");
        let together = self.normal_stiffness.is_some();
        let rule = format!("must be absent: {name} states a normal stiffness");
        BadSetting::unless(!(together && normal), key, written, &rule)?;
        let rule = format!("must be absent: {name} states no tangential stiffness");
        BadSetting::unless(!together || tangential, key, written, &rule)?;
        let table = own.contains(Input::NormalStiffnessScale.name());
        let rule = "must be absent: [inputs.normal_stiffness_scale] states the normal stiffness";
        BadSetting::unless(!(together && table), key, written, rule)?;
        let rule = "states no normal stiffness, which was not measured: the study must say what it is, by a table \
             [inputs.normal_stiffness_scale] or by normal_stiffness = \"with-tangential\" in [inputs], which scales both \
             stiffnesses together";
        let said = normal || together || table || !tangential;
        BadSetting::unless(said, "inputs.from", format!("\"{name}\""), rule)?;
        let second = own.contains(Input::StiffnessScale.name()) && (normal || tangential);
        let key = "inputs.stiffness_scale";
        let rule = format!(
            "must be absent: {name} states the stiffness, and this is a factor on top of it"
        );
        BadSetting::unless(!second || together, key, "(given)", &rule)
    }
}

fn direction(parameter: ContactParameter) -> Option<Direction> {
    match parameter {
        ContactParameter::FrictionCoefficient => None,
        ContactParameter::TangentialStiffnessNPerUm => Some(Direction::Tangential),
        ContactParameter::NormalStiffnessNPerUm => Some(Direction::Normal),
    }
}

/// Refuses an input that a table of the study states, too.
fn once(input: Input, file: &Path, i: usize, own: &BTreeSet<&str>) -> Result<(), BadSetting> {
    let key = format!("inputs.{}", input.name());
    let place = file.display();
    let rule = format!("must be given once: inputs[{i}] of {place} states it, too");
    BadSetting::unless(!own.contains(input.name()), &key, "(given)", &rule)
}

/// The distribution of an input. Few specimens leave its tail so wide that it may reach beyond the largest value that can be meant: it ends
/// there, unless half of it lies beyond.
fn accepted(input: Input, shape: Shape) -> Result<Distribution, BadSetting> {
    let whole = Distribution::new(shape, None)?;
    let [low, high] = whole.support();
    let largest = input.largest();
    let is_cut =
        high.is_infinite() && whole.quantile(0.5) < largest && input.accepts(&whole).is_err();
    let distribution = match is_cut {
        true => Distribution::new(shape, Some([low, largest]))?,
        false => whole,
    };
    input.accepts(&distribution)?;
    Ok(distribution)
}
