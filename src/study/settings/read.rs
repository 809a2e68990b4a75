//! From `study.toml` to the settings of every module.

use std::path::{Path, PathBuf};

use super::document::{Document, before_name};
use super::frequency::{FrequencySettings, FrequencyTable, PeakSetting, ascending_positive};
use super::identified_inputs::IdentifiedInputs;
use super::inputs::{Surroundings, design};
use super::model::{ModelSettings, NO_POSITIONS, model};
use super::requirements::Asked;
use super::samples::Samples;
use super::solver_section::{ContactSection, SolverSection};
use crate::Error;
use crate::ensemble::SampleSolver;
use crate::file::{FileError, FileRecord};
use crate::hb::{HbSettings, ProblemError};
use crate::model::two_blade::TwoBladeSettings;
use crate::model::{ContactPair, ReducedModel};
use crate::report::asked::requirement::title;
use crate::report::asked::{ControlVariateSettings, Requirements, Stopping, SurrogateSettings};
use crate::sampling::{Design, Input};
use crate::setting::{BadSetting, within};
use crate::study::output::OutputSettings;

/// Top-level keys of a study file.
pub(super) const KEYS: [&str; 19] = [
    "name",
    "seed",
    "samples",
    "levels",
    "model",
    "contact",
    "inputs",
    "design",
    "correlation",
    "epistemic",
    "pressure_field",
    "solver",
    "frequency",
    "output",
    "operation",
    "stress",
    "criteria",
    "surrogate",
    "control_variate",
];

/// Excitation levels that can be meant, in whatever unit.
pub(super) const LEVEL: [f64; 2] = [1e-12, 1e12];
/// Levels at most: each is a study of its own.
pub(super) const MOST_LEVELS: usize = 1000;

/// Why a strip has no thickness.
const NO_STRIP: &str = "a model of kind \"matrices\" has no strip that could be meshed anew";
/// Why a sector has neither thickness nor pressure as an input.
const NOT_CYCLIC: &str = "a model of kind \"cyclic\" has no such input";
/// Why a tuned disk has no initial tractions of its own.
const EVERY_GAP: &str = "every sector would begin with the same tractions, while those of a disk differ from gap to gap; \
     with model.blade_frequency_scatter they may";
/// Why a punch and a field do not go together.
const TWO_PRESSURES: &str =
    "the deviations of [pressure_field] are relative to model.pressure_weights, not to a punch";

/// Why a common friction coefficient beside those of all interfaces is none.
const OWN_FRICTION: &str = "it would act on nothing: every interface has a friction coefficient of its own among the inputs";

/// A study: what is computed, with which settings, on which samples.
#[derive(Debug, Clone)]
pub struct Study {
    /// The study file.
    pub path: PathBuf,
    /// Its text, as read.
    pub text: String,
    /// Name, for reports.
    pub name: String,
    /// Number of samples, at most.
    pub samples: u64,
    /// When fewer are enough; absent where their number is given.
    pub stopping: Option<Stopping>,
    /// Excitation levels, ascending (N for the built-in model).
    pub levels: Vec<f64>,
    /// Structure.
    pub model: ModelSettings,
    /// Random inputs and seed.
    pub design: Design,
    /// The file of the design, if it has one; relative to the study file's folder.
    pub design_file: Option<PathBuf>,
    /// Inputs from the file of an identification, if `[inputs]` names one.
    pub identified: Option<IdentifiedInputs>,
    /// Solver.
    pub solver: HbSettings,
    /// What gives the peaks of a sample.
    pub sample_solver: SampleSolver,
    /// Whether samples of a mirror-symmetric model are solved on one half of its contacts.
    pub mirror: bool,
    /// Frequencies.
    pub frequency: FrequencySettings,
    /// Results.
    pub output: OutputSettings,
    /// What the designer asks for.
    pub requirements: Requirements,
    /// The surrogate that is wanted, if any.
    pub surrogate: Option<SurrogateSettings>,
    /// The control variate that is wanted, if any.
    pub control_variate: Option<ControlVariateSettings>,
    /// What may be meant but is unusual, with file, line, key and the usual range.
    pub warnings: Vec<String>,
}

impl Study {
    /// Reads and checks a study file.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read, [`Error::Study`] with line, key, value and rule otherwise.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = crate::file::read_text(path)?;
        Self::parse(path, &text)
    }

    /// Checks `text`, the content of `path`.
    ///
    /// # Errors
    /// [`Error::Study`] with line, key, value and rule.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let mut document = Document::parse(path, text)?;
        let name: String = document.required("name")?;
        let seed: u64 = document.take("seed")?.unwrap_or(0);
        let samples = Samples::take(&mut document)?;
        let levels: Vec<f64> = document.required("levels")?;
        let contact: ContactSection = document.take("contact")?.unwrap_or_default();
        let model = model(&mut document, &contact)?;
        let frequency = frequencies(&mut document, &model)?;
        let stated = design(
            &mut document,
            &Surroundings {
                folder: before_name(path),
                model: &model,
                unit: frequency.unit,
                seed,
                samples: samples.most(),
            },
        )?;
        let design = stated.design;
        let solver: SolverSection = document.take("solver")?.unwrap_or_default();
        let output: OutputSettings = document.take("output")?.unwrap_or_default();
        let asked = Asked::take(&mut document)?;
        let sample_solver = sample_solver(&mut document, &design)?;
        document.finish(&KEYS)?;
        let at = |bad: BadSetting| document.bad_setting(&bad);
        validate_head(&name, &levels).map_err(at)?;
        output.validate(before_name(path)).map_err(at)?;
        let solver_settings = solver.settings(&contact, model.assessed()).map_err(at)?;
        let unit = frequency.unit;
        let checked = asked.check(&model, unit, &levels, &design, &solver_settings);
        checked.map_err(at)?;
        let stopping = samples.plan(&asked.requirements, &design).map_err(at)?;
        let of_model = model.unusual(unit).into_iter();
        let beside = unusual(&design, &solver_settings, &asked.requirements);
        let of_file = (stated.file.iter()).flat_map(|file| unusual_in_file(path, file, &design));
        let warnings = of_model.chain(beside).map(|bad| at(bad).to_string());
        Ok(Self {
            path: path.to_owned(),
            text: text.to_owned(),
            warnings: warnings.chain(of_file).collect(),
            name,
            samples: design.samples(),
            stopping,
            levels,
            model,
            design,
            design_file: stated.file,
            identified: stated.identified,
            solver: solver_settings,
            sample_solver,
            mirror: solver.mirror(),
            frequency,
            output,
            requirements: asked.requirements,
            surrogate: asked.surrogate,
            control_variate: asked.control_variate,
        })
    }

    /// Folder of the study file: what its file names are relative to.
    #[must_use]
    pub fn folder(&self) -> &Path {
        before_name(&self.path)
    }

    /// Name of the study file, without its folder.
    #[must_use]
    pub fn file_name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// The files that the study names, as they are now.
    ///
    /// # Errors
    /// [`Error::File`] on the first one that cannot be read.
    pub fn file_records(&self) -> Result<Vec<FileRecord>, Error> {
        let files = self.named_files().into_iter();
        let record = |path: PathBuf| FileRecord::in_folder(self.folder(), &path.to_string_lossy());
        Ok(files.map(record).collect::<Result<_, _>>()?)
    }

    /// The files that the study names, relative to its folder.
    fn named_files(&self) -> Vec<PathBuf> {
        let identified = self.identified.iter().map(|found| found.file.clone());
        let of_model = self.model.files().into_iter();
        let files = of_model.chain(self.design_file.clone());
        files.chain(identified).collect()
    }

    /// Every file that is read: the study file and those that it names.
    #[must_use]
    pub fn inputs_on_disk(&self) -> Vec<PathBuf> {
        let named = self.named_files().into_iter();
        let named = named.map(|path| self.folder().join(path));
        [self.path.clone()].into_iter().chain(named).collect()
    }

    /// File that states the distribution of `input`; `None` where the study file does.
    #[must_use]
    pub fn origin(&self, input: Input) -> Option<String> {
        let found = self.identified.as_ref()?;
        let mut stated = found.inputs.iter().map(|(stated, _)| *stated);
        let from_file = stated.any(|stated| stated == input);
        from_file.then(|| found.correlation.origin.clone())
    }

    /// Names of the inputs that act on one side of the contacts alone.
    fn one_sided(&self) -> Vec<&'static str> {
        let inputs = self.design.inputs().iter().map(|(input, _)| *input);
        let sided = inputs.filter(|input| input.one_sided());
        sided.map(Input::name).collect()
    }

    /// Whether samples may be solved on half of a mirror-symmetric model.
    #[must_use]
    pub fn folds(&self) -> bool {
        self.mirror && self.one_sided().is_empty() && !self.is_cyclic()
    }

    /// Whether the model is one sector of a disk.
    pub(in crate::study) fn is_cyclic(&self) -> bool {
        matches!(self.model, ModelSettings::Cyclic(_))
    }

    /// Why samples are not solved on half of a mirror-symmetric model although `mirror` allows it.
    #[must_use]
    pub fn unfolded(&self) -> Option<String> {
        let names = self.one_sided();
        let has_mirror = match &self.model {
            ModelSettings::TwoBladeStrip { .. } => true,
            ModelSettings::Matrices(matrices) => matrices.mirror.is_some(),
            ModelSettings::Cyclic(_) => false,
        };
        (self.mirror && !names.is_empty() && has_mirror).then(|| {
            format!(
                "solved on all contacts, not on one half of them: the sides differ by {}",
                names.join(", ")
            )
        })
    }

    pub(in crate::study) fn has_input(&self, input: Input) -> bool {
        let mut inputs = self.design.inputs().iter();
        inputs.any(|(other, _)| *other == input)
    }

    /// Refuses an input of something that the model does not have, or that makes no model.
    ///
    /// # Errors
    /// [`Error::Study`] on `inputs.<name>`.
    pub fn check_inputs(&self, model: &ReducedModel) -> Result<(), Error> {
        for (place, (input, _)) in self.design.inputs().iter().enumerate() {
            let absent = self.lacking(*input, model).map_or(Ok(()), |reason| {
                let rule = format!("must be absent: {reason}");
                Err(BadSetting::new("", "(given)", rule))
            });
            let checked = absent.and_then(|()| self.check_strips(*input, place));
            checked.map_err(|bad| {
                let key = format!("inputs.{}", input.name());
                self.bad_setting(&BadSetting { key, ..bad })
            })?;
        }
        Ok(())
    }

    /// What the model lacks for an input.
    fn lacking(&self, input: Input, model: &ReducedModel) -> Option<String> {
        let weighted = |blades: &TwoBladeSettings| blades.pressure_weights.is_some();
        match (&self.model, only_of_rig(input)) {
            (ModelSettings::Matrices(_), Some(reason)) => return Some(reason.to_owned()),
            (ModelSettings::Cyclic(_), Some(_)) => return Some(NOT_CYCLIC.to_owned()),
            (ModelSettings::Cyclic(_), None)
                if input == Input::InitialTraction && !self.is_mistuned() =>
            {
                return Some(EVERY_GAP.to_owned());
            }
            _ => {}
        }
        let reason = match (input, &self.model) {
            (
                Input::EdgePressure,
                ModelSettings::TwoBladeStrip {
                    blades,
                    pressure: Some(_),
                    ..
                },
            ) if weighted(blades) => TWO_PRESSURES,
            (Input::FrictionCoefficient, _) if self.is_common_friction_replaced(model) => {
                OWN_FRICTION
            }
            _ => {
                let interface = input.interface()?;
                let mut pairs = model.contacts.iter();
                let there = pairs.any(|pair| pair.interface == interface);
                let reason = format!("no contact pair has interface = {interface}");
                return (!there).then_some(reason);
            }
        };
        Some(reason.to_owned())
    }

    /// Whether every interface has an input in place of the common friction coefficient.
    fn is_common_friction_replaced(&self, model: &ReducedModel) -> bool {
        let given = |own| self.design.inputs().iter().any(|(input, _)| *input == own);
        let own = [
            Input::LeftFrictionCoefficient,
            Input::RightFrictionCoefficient,
        ]
        .map(given);
        let is_replaced = |pair: &ContactPair| own.get(pair.interface) == Some(&true);
        !model.contacts.is_empty() && model.contacts.iter().all(is_replaced)
    }

    /// Refuses strips that do not fit the blades, as thin and as thick as the input at `place` can be.
    fn check_strips(&self, input: Input, place: usize) -> Result<(), BadSetting> {
        for end in self.design.range(place) {
            self.check_strip(input, end).map_err(|bad| BadSetting {
                rule: format!(
                    "{} (an end of its values; truncation = [low, high] cuts a distribution)",
                    bad.rule
                ),
                ..bad
            })?;
        }
        Ok(())
    }

    /// Refuses a strip that does not fit the blades, where the input is its thickness.
    fn check_strip(&self, input: Input, value: f64) -> Result<(), BadSetting> {
        match (input, &self.model) {
            (Input::StripThickness, ModelSettings::TwoBladeStrip { blades, .. }) => {
                blades.with_strip_thickness(value).validate()
            }
            _ => Ok(()),
        }
    }

    /// Refuses values of the inputs that cannot be meant, by the rules for the user's own samples: as many as there are inputs, in
    /// their order, each within what the input accepts, and a strip that fits the blades.
    ///
    /// # Errors
    /// [`BadSetting`] on `inputs` for their number, else on the name of the first input whose value breaks a rule.
    pub fn check_values(&self, values: &[f64]) -> Result<(), BadSetting> {
        let inputs = self.design.inputs();
        let names: Vec<_> = inputs.iter().map(|(input, _)| input.name()).collect();
        let rule = format!("must be one value for each of: {}", names.join(", "));
        let given = format!("({} values)", values.len());
        BadSetting::unless(values.len() == inputs.len(), "inputs", given, &rule)?;
        for ((input, _), value) in inputs.iter().zip(values) {
            let key = input.name();
            input.accepts_value(key, *value)?;
            let fits = self.check_strip(*input, *value);
            fits.map_err(|bad| BadSetting {
                key: key.to_owned(),
                ..bad
            })?;
        }
        Ok(())
    }

    /// The error of a setting that only a command can find, at its line.
    #[must_use]
    pub fn bad_setting(&self, bad: &BadSetting) -> Error {
        self.placed(|document| document.bad_setting(bad))
    }

    /// The error of a file that the study names, at the line of the key where the file is not there.
    pub(in crate::study) fn bad_file(&self, error: FileError) -> Error {
        self.placed(|document| document.bad_file(error))
    }

    /// The error of a model that is no harmonic balance problem, at the line where the study begins to describe it.
    pub(in crate::study) fn no_problem(&self, error: impl Into<ProblemError>) -> Error {
        let rule = error.into().to_string();
        self.placed(|document| document.at_key("model", rule))
    }

    /// An error with its place in the study file.
    fn placed(&self, error: impl FnOnce(&Document<'_>) -> Error) -> Error {
        match Document::parse(&self.path, &self.text) {
            Ok(document) => error(&document),
            Err(error) => error,
        }
    }
}

#[cfg(not(feature = "test-functions"))]
fn sample_solver(_: &mut Document<'_>, _: &Design) -> Result<SampleSolver, Error> {
    Ok(SampleSolver::HarmonicBalance)
}

/// Reads `test_function`, the function that stands for the solver.
#[cfg(feature = "test-functions")]
fn sample_solver(document: &mut Document<'_>, design: &Design) -> Result<SampleSolver, Error> {
    use crate::ensemble::test_function::TestFunction;
    let Some(function) = document.take::<TestFunction>("test_function")? else {
        return Ok(SampleSolver::HarmonicBalance);
    };
    if design.inputs().len() != function.inputs() {
        let rule = format!("must have {} inputs", function.inputs());
        return Err(document.at_key("test_function", rule));
    }
    Ok(SampleSolver::Function(function))
}

/// Why an input is of the built-in model alone; nothing for an input of any model.
pub(in crate::study) fn only_of_rig(input: Input) -> Option<&'static str> {
    match input {
        Input::EdgePressure | Input::PressureMode(_) => Some(NO_POSITIONS),
        Input::StripThickness => Some(NO_STRIP),
        _ => None,
    }
}

fn validate_head(name: &str, levels: &[f64]) -> Result<(), BadSetting> {
    title("name", name)?;
    let rule = format!("must be at most {MOST_LEVELS} levels");
    let written = format!("[{} levels]", levels.len());
    BadSetting::unless(levels.len() <= MOST_LEVELS, "levels", written, &rule)?;
    ascending_positive("levels", levels)?;
    let ends = [levels.first(), levels.last()].into_iter().flatten();
    ends.copied()
        .try_for_each(|level| within("levels", level, LEVEL))
}

/// The frequencies, for which the blades must be meshed finely enough.
fn frequencies(
    document: &mut Document<'_>,
    model: &ModelSettings,
) -> Result<FrequencySettings, Error> {
    let table: FrequencyTable = document.required("frequency")?;
    document.checked(fine_enough(&table, model))
}

fn fine_enough(
    table: &FrequencyTable,
    model: &ModelSettings,
) -> Result<FrequencySettings, BadSetting> {
    let frequency = table.settings().map_err(|bad| bad.under("frequency"))?;
    if let Some(blades) = model.blades() {
        let highest_hz = crate::units::rad_s_to_hz(frequency.band[1]);
        let checked = blades.check_band(highest_hz);
        checked.map_err(|bad| bad.under("model"))?;
    }
    let value = match frequency.peak {
        PeakSetting::Highest => return Ok(frequency),
        PeakSetting::All => "all".to_owned(),
        PeakSetting::Mode(number) => number.to_string(),
    };
    let tuned = !matches!(model, ModelSettings::Cyclic(disk) if disk.blade_frequency_scatter > 0.0);
    let rule = "must be \"highest\" with blade_frequency_scatter: the peak is the largest amplitude over all blades";
    BadSetting::unless(tuned, "frequency.peak", value, rule)?;
    Ok(frequency)
}

/// What may be meant but is unusual beside the model, in the order of the file.
fn unusual(design: &Design, solver: &HbSettings, requirements: &Requirements) -> Vec<BadSetting> {
    let of_inputs = design.unusual().into_iter();
    let of_inputs = of_inputs.map(|bad| bad.under("inputs"));
    let of_solver = solver.unusual().into_iter();
    let of_solver = of_solver.map(|bad| bad.under("solver"));
    of_inputs
        .chain(of_solver)
        .chain(requirements.unusual())
        .collect()
}

/// What may be meant but is unusual in the `file` of `[design]`, which the study file `path` names.
fn unusual_in_file(path: &Path, file: &Path, design: &Design) -> Vec<String> {
    let file = before_name(path).join(file);
    let found = design.unusual_in_file().into_iter();
    let warning = |bad: BadSetting| FileError::content(&file, None, bad.to_string()).to_string();
    found.map(warning).collect()
}
