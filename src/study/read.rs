//! From `study.toml` to the settings of every room.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::document::Document;
use super::frequency::{FrequencySettings, FrequencyTable, ascending_positive};
use super::output::OutputSettings;
use super::requirements::{check_requirements, requirements};
use super::tables::{ContactSection, SolverSection};
use crate::Error;
use crate::contact::ContactParameters;
use crate::hb::HbSettings;
use crate::model::interface::InterfaceSettings;
use crate::model::matrices::{MatricesError, MatricesSettings};
use crate::model::two_blade::{self, ComponentSummary, TwoBladeSettings};
use crate::model::{ModelError, ReducedModel};
use crate::report::requirement::Requirements;
use crate::sampling::{Design, DistributionTable, Input};
use crate::setting::BadSetting;

/// Top-level keys of a study file.
const KEYS: [&str; 13] = [
    "name",
    "seed",
    "samples",
    "levels",
    "model",
    "contact",
    "inputs",
    "solver",
    "frequency",
    "output",
    "operation",
    "stress",
    "criteria",
];
/// Most samples of a study: beyond it the tables of the report do not fit into memory.
const MOST_SAMPLES: u64 = 100_000_000;

/// Which structure is computed.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelSettings {
    /// The built-in two blades with a strip.
    TwoBladeStrip {
        /// Geometry and material.
        blades: TwoBladeSettings,
        /// Constants of both interfaces.
        interface: InterfaceSettings,
    },
    /// The user's own matrices.
    Matrices(MatricesSettings),
}

/// A study: what is computed, with which settings, on which samples.
#[derive(Debug, Clone)]
pub struct Study {
    /// The study file.
    pub path: PathBuf,
    /// Its text, as read.
    pub text: String,
    /// Name, for reports.
    pub name: String,
    /// Number of samples.
    pub samples: u64,
    /// Excitation levels, ascending (N for the built-in model).
    pub levels: Vec<f64>,
    /// Structure.
    pub model: ModelSettings,
    /// Random inputs and seed.
    pub design: Design,
    /// Solver.
    pub solver: HbSettings,
    /// Whether samples of a mirror-symmetric model are solved on one half of its contacts.
    pub mirror: bool,
    /// Frequencies.
    pub frequency: FrequencySettings,
    /// Results.
    pub output: OutputSettings,
    /// What the designer asks for.
    pub requirements: Requirements,
}

/// The nominal model of a study.
#[derive(Debug, Clone)]
pub struct StudyModel {
    /// The structure.
    pub reduced: ReducedModel,
    /// Constants of its contact pairs. Shape: `[n_contacts]`.
    pub contacts: Vec<ContactParameters<f64>>,
    /// The components that it was reduced from, by name; none for the user's own matrices.
    pub components: Vec<(&'static str, ComponentSummary)>,
}

impl Study {
    /// Reads and checks a study file.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read, [`Error::Study`] with line, key, value and rule otherwise.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|source| Error::file(path, source))?;
        Self::parse(path, &text)
    }

    /// Checks `text`, the content of `path`.
    ///
    /// # Errors
    /// [`Error::Study`] with line, key, value and rule.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let mut document = Document::parse(path, text)?;
        let name: String = required(&mut document, "name")?;
        let seed: u64 = document.take("seed")?.unwrap_or(0);
        let samples: u64 = document.take("samples")?.unwrap_or(1);
        let levels: Vec<f64> = required(&mut document, "levels")?;
        let contact: ContactSection = document.take("contact")?.unwrap_or_default();
        let model = model(&mut document, &contact)?;
        let design = design(&mut document, seed)?;
        let solver: SolverSection = document.take("solver")?.unwrap_or_default();
        let frequency: FrequencyTable = required(&mut document, "frequency")?;
        let output: OutputSettings = document.take("output")?.unwrap_or_default();
        let requirements = requirements(&mut document)?;
        document.finish(&KEYS)?;
        let at = |bad: BadSetting| document.bad_setting(&bad);
        validate_head(&name, samples, &levels).map_err(at)?;
        output.validate().map_err(|bad| at(bad.under("output")))?;
        let frequency = frequency.settings();
        let frequency = frequency.map_err(|bad| at(bad.under("frequency")))?;
        check_requirements(&requirements, frequency.unit, &levels).map_err(at)?;
        Ok(Self {
            path: path.to_owned(),
            text: text.to_owned(),
            name,
            samples,
            levels,
            model,
            design,
            solver: solver.settings(&contact).map_err(at)?,
            mirror: solver.mirror(),
            frequency,
            output,
            requirements,
        })
    }

    /// Folder of the study file: what its file names are relative to.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or_else(|| Path::new(""))
    }

    /// Name of the study file, without its folder.
    #[must_use]
    pub fn file_name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// Builds the nominal model and the nominal constants of its contact pairs.
    ///
    /// # Errors
    /// [`Error::Study`] or [`Error::Matrices`] on the first rule that the model's tables or files break.
    pub fn build_model(&self) -> Result<StudyModel, Error> {
        match &self.model {
            ModelSettings::TwoBladeStrip { blades, interface } => {
                let rig = two_blade::build(blades).map_err(|error| match error {
                    ModelError::Setting(bad) => self.bad_setting(&bad.under("model")),
                    error => Error::Model(error),
                })?;
                let mut reduced = rig.reduced;
                reduced.name.clone_from(&self.name);
                Ok(StudyModel {
                    contacts: interface.parameters(&reduced.contacts),
                    reduced,
                    components: vec![("blade", rig.blade), ("strip", rig.strip)],
                })
            }
            ModelSettings::Matrices(settings) => {
                let (reduced, contacts) =
                    settings
                        .build(&self.name, self.folder())
                        .map_err(|error| match error {
                            MatricesError::Setting(bad) => self.bad_setting(&bad.under("model")),
                            error => Error::Matrices(error),
                        })?;
                Ok(StudyModel {
                    reduced,
                    contacts,
                    components: Vec::new(),
                })
            }
        }
    }

    /// The error of a setting that only a command can find, at its line.
    #[must_use]
    pub fn bad_setting(&self, bad: &BadSetting) -> Error {
        match Document::parse(&self.path, &self.text) {
            Ok(document) => document.bad_setting(bad),
            Err(error) => error,
        }
    }
}

fn required<T: serde::de::DeserializeOwned>(
    document: &mut Document<'_>,
    key: &str,
) -> Result<T, Error> {
    match document.take(key)? {
        Some(value) => Ok(value),
        None => Err(document.at_key(key, "must be given".to_owned())),
    }
}

fn validate_head(name: &str, samples: u64, levels: &[f64]) -> Result<(), BadSetting> {
    let rule = "must not be empty";
    BadSetting::unless(!name.trim().is_empty(), "name", "\"\"", rule)?;
    let rule = format!("must be from 1 to {MOST_SAMPLES}");
    let holds = (1..=MOST_SAMPLES).contains(&samples);
    BadSetting::unless(holds, "samples", samples, &rule)?;
    ascending_positive("levels", levels)
}

/// Reads `[model]` by its `kind`.
fn model(document: &mut Document<'_>, contact: &ContactSection) -> Result<ModelSettings, Error> {
    let kind = document.take_string("model", "kind")?;
    let of_contact = |bad: BadSetting| bad.under("contact");
    match kind.as_str() {
        "two-blade-strip" => {
            let blades: TwoBladeSettings = required(document, "model")?;
            document.checked(blades.validate().map_err(|b| b.under("model")))?;
            let interface = document.checked(contact.interface().map_err(of_contact))?;
            Ok(ModelSettings::TwoBladeStrip { blades, interface })
        }
        "matrices" => {
            let settings: MatricesSettings = required(document, "model")?;
            document.checked(settings.validate().map_err(|b| b.under("model")))?;
            document.checked(contact.refuse_interface().map_err(of_contact))?;
            Ok(ModelSettings::Matrices(settings))
        }
        _ => Err(document.bad_setting(&BadSetting {
            key: "model.kind".to_owned(),
            value: kind,
            rule: "must be \"two-blade-strip\" or \"matrices\"".to_owned(),
        })),
    }
}

/// Reads `[inputs.*]`.
fn design(document: &mut Document<'_>, seed: u64) -> Result<Design, Error> {
    let tables: BTreeMap<String, DistributionTable> = document.take("inputs")?.unwrap_or_default();
    let mut inputs = Vec::new();
    for (name, table) in &tables {
        let key = format!("inputs.{name}");
        let Some(input) = Input::from_name(name) else {
            let known = Input::ALL.map(Input::name).join(", ");
            return Err(document.at_key(&key, format!("unknown input; known are {known}")));
        };
        let distribution = table.distribution().map_err(|bad| bad.under(&key));
        inputs.push((input, document.checked(distribution)?));
    }
    let design = Design::new(seed, inputs).map_err(|bad| bad.under("inputs"));
    document.checked(design)
}
