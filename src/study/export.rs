//! The model of a study as files that a study of kind "matrices" names: what `export` writes.
//!
//! Every number is written with as many digits as tell it from all others, so that the exported study gives the same answer.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Component, Path};

use toml::{Table, Value};

use super::built::StudyModel;
use super::settings::frequency::FrequencyUnit;
use super::settings::read::{Study, only_of_rig};
use super::settings::solver_section::OF_INTERFACE;
use crate::Error;
use crate::contact::ContactParameters;
use crate::file::{self, FileError, refuse_content, write_folder};
use crate::model::lower_triangle::lower;
use crate::model::matrix_contacts::ContactTable;
use crate::model::matrix_writer::{DOUBLE_DIGITS, write_column, write_symmetric};
use crate::model::model_text::{inline, quoted};
use crate::model::{ContactPair, ReducedModel, Response, SparseRow};
use crate::sampling::Input;
use crate::setting::BadSetting;

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exported {
    /// Rows of the matrices.
    pub dofs: usize,
    /// Contact pairs.
    pub contacts: usize,
    /// What the exported study does not have of the first one, with its key.
    pub warnings: Vec<String>,
}

/// Writes the model of `study` and a study of it to the folder `output`, which must not exist or be empty.
///
/// # Errors
/// [`Error::Study`] on a key that matrices have no place for; whatever building the model refuses; [`Error::File`] if the folder
/// has content or cannot be written. Then nothing is left behind.
pub fn export(study: &Study, output: &Path) -> Result<Exported, Error> {
    refuse_content(output)?;
    let rule = "must be another: the matrices of a sector depend on the nodal diameter, for which an export has no place";
    let one_set = BadSetting::unless(!study.is_cyclic(), "model.kind", "\"cyclic\"", rule);
    one_set.map_err(|bad| study.bad_setting(&bad))?;
    study.refuse_inputs_of_rig()?;
    let (kept, moved) = study.kept()?;
    let model = study.build_model()?;
    study.check_inputs(&model.reduced)?;
    let text = study_text(study, &model, &kept)?;
    write_folder(output, |folder| {
        write_matrices(&model.reduced, folder)?;
        for (_, _, path) in study.files_of_inputs() {
            let from = study.folder().join(path);
            let to = folder.join(path.file_name().unwrap_or_default());
            std::fs::copy(&from, to).map_err(|source| FileError::system(&from, source))?;
        }
        let path = folder.join("study.toml");
        file::replace(&path, |out| out.write_all(text.as_bytes()))?;
        let written = Study::read(&path).and_then(|written| written.build_model());
        written.map(|_| ()).map_err(|error| {
            Error::unfit(
                &study.path,
                format!("what export writes of it is no study: {error}"),
            )
        })
    })?;
    let rig = model.rig.is_some();
    let grid = rig.then_some(
        "model.contact_nodes: the error of the contact grid, which results of the built-in model state, is not known of matrices",
    );
    let warnings = grid.into_iter().map(str::to_owned);
    Ok(Exported {
        dofs: model.reduced.n_dofs(),
        contacts: model.reduced.n_contacts(),
        warnings: warnings.chain(moved).collect(),
    })
}

impl Study {
    /// Refuses inputs that change the built-in model in a way that matrices cannot follow.
    fn refuse_inputs_of_rig(&self) -> Result<(), Error> {
        for (input, _) in self.design.inputs() {
            if let Some(reason) = only_of_rig(*input) {
                let key = match input {
                    Input::PressureMode(_) => "pressure_field".to_owned(),
                    input => format!("inputs.{}", input.name()),
                };
                let rule = format!("must be absent for an export: {reason}");
                return Err(self.bad_setting(&BadSetting::new(key, "(given)", rule)));
            }
        }
        Ok(())
    }

    /// Files that the samples come from: section and key that name each, and the file.
    fn files_of_inputs(&self) -> impl Iterator<Item = (&'static str, &'static str, &Path)> {
        let design = self.design_file.as_deref();
        let identified = self.identified.as_ref().map(|found| found.file.as_path());
        let design = design.map(|path| ("design", "path", path));
        design
            .into_iter()
            .chain(identified.map(|path| ("inputs", "from", path)))
    }

    /// The keys of the study file that hold for matrices, too, and what of them had to change.
    fn kept(&self) -> Result<(Table, Option<String>), Error> {
        let no_table = |error: toml::de::Error| {
            Error::unfit(
                &self.path,
                format!("export cannot write this file again: {}", error.message()),
            )
        };
        let mut kept: Table = toml::from_str(&self.text).map_err(no_table)?;
        kept.remove("model");
        if let Some(Value::Table(contact)) = kept.get_mut("contact") {
            contact.retain(|key, _| !OF_INTERFACE.contains(&key));
        }
        for (section, key, path) in self.files_of_inputs() {
            if let Some(Value::Table(table)) = kept.get_mut(section) {
                let name = path.file_name().unwrap_or_default();
                let name = Value::String(name.to_string_lossy().into_owned());
                table.insert(key.to_owned(), name);
            }
        }
        let folder = &self.output.folder;
        let inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
        let mut moved = None;
        if !folder.components().all(inside)
            && let Some(Value::Table(output)) = kept.get_mut("output")
        {
            output.remove("folder");
            moved = Some(format!(
                "output.folder: {} is outside of the study's folder, so results of the exported study go to results beside it",
                folder.display()
            ));
        }
        kept.retain(|_, value| !matches!(value, Value::Table(table) if table.is_empty()));
        Ok((kept, moved))
    }
}

/// Text of the exported study file: single keys, the model, sections.
fn study_text(study: &Study, model: &StudyModel, kept: &Table) -> Result<String, Error> {
    let is_section = |value: &Value| match value {
        Value::Table(_) => true,
        Value::Array(items) => items.iter().any(Value::is_table),
        _ => false,
    };
    let part = |sections: bool| {
        let entries = kept
            .iter()
            .filter(|(_, value)| is_section(value) == sections);
        let entries = entries.map(|(key, value)| (key.clone(), value.clone()));
        toml::to_string(&entries.collect::<Table>()).map_err(|error| {
            Error::unfit(
                &study.path,
                format!("export cannot write this file again: {error}"),
            )
        })
    };
    let si = study.frequency.unit == FrequencyUnit::Hertz;
    let units = match si {
        true => "All numbers are in SI units",
        false => "Numbers are in one consistent set of units",
    };
    let (head, sections) = (part(false)?, part(true)?);
    let structure = model_text(&model.reduced, &model.contacts, si);
    Ok(format!(
        "# Written by microslip export: the model as matrices. {units}; frequencies in {}.\n{head}\n{structure}\n{sections}",
        study.frequency.unit.name()
    ))
}

/// `[model]` with its contact pairs.
fn model_text(model: &ReducedModel, contacts: &[ContactParameters<f64>], si: bool) -> String {
    let mut text = "[model]\nkind = \"matrices\"\n".to_owned();
    let files = matrices(model).into_iter().map(|(key, _)| key);
    for key in files.chain(forces(model).map(|(key, _)| key)) {
        let _ = writeln!(text, "{key} = \"{}\"", file_of(key));
    }
    if model.mirror.is_some() {
        let _ = writeln!(text, "mirror = \"{}\"", file_of("mirror"));
    }
    let names = &model.dof_names;
    let _ = match in_lines(names) {
        true => writeln!(text, "dof_names = \"{NAMES}\""),
        false => writeln!(
            text,
            "dof_names = [{}]",
            joined(names.iter().map(|n| quoted(n)))
        ),
    };
    let alone = |response: &Response| match response.row[..] {
        [(dof, 1.0)] => names[dof] == response.name,
        _ => false,
    };
    let every = model.responses.len() == names.len()
        && (model.responses.iter().zip(names)).all(|(r, name)| alone(r) && r.name == *name);
    if !every {
        let responses = model
            .responses
            .iter()
            .map(|response| match alone(response) {
                true => quoted(&response.name),
                false => {
                    let row = inline(named(&response.row, names).iter());
                    format!("{{ name = {}, row = {row} }}", quoted(&response.name))
                }
            });
        let _ = writeln!(text, "responses = [{}]", joined(responses));
    }
    for (pair, constants) in model.contacts.iter().zip(contacts) {
        text.push_str(&contact_table(pair, constants, names).text(si));
    }
    text
}

/// File of the names of the degrees of freedom.
const NAMES: &str = "dofs.txt";

/// File of a matrix or a force.
fn file_of(key: &str) -> String {
    format!("{key}.mtx")
}

/// The matrices that the model has, by their keys.
fn matrices(model: &ReducedModel) -> Vec<(&'static str, &faer::Mat<f64>)> {
    let always = [
        ("mass", &model.mass),
        ("stiffness", &model.stiffness),
        ("damping", &model.damping),
    ];
    let retention = model.retention.iter().map(|matrix| ("retention", matrix));
    always.into_iter().chain(retention).collect()
}

/// The forces that are not zero, by their keys.
fn forces(model: &ReducedModel) -> impl Iterator<Item = (&'static str, &[f64])> {
    let all = [
        ("static_force", &model.static_force[..]),
        ("cosine_force", &model.cosine_force[..]),
        ("sine_force", &model.sine_force[..]),
    ];
    let acts = |(_, force): &(&str, &[f64])| force.iter().any(|f| *f != 0.0);
    all.into_iter().filter(acts)
}

fn write_matrices(model: &ReducedModel, folder: &Path) -> Result<(), FileError> {
    for (key, matrix) in matrices(model) {
        let path = folder.join(file_of(key));
        let entries: Vec<_> = lower(matrix).collect();
        write_symmetric(&path, matrix.nrows(), &entries, DOUBLE_DIGITS)?;
    }
    if let Some(mirror) = &model.mirror {
        let path = folder.join(file_of("mirror"));
        write_symmetric(&path, model.n_dofs(), &mirror.lower(), DOUBLE_DIGITS)?;
    }
    for (key, force) in forces(model) {
        write_column(&folder.join(file_of(key)), force, DOUBLE_DIGITS)?;
    }
    if in_lines(&model.dof_names) {
        file::replace(&folder.join(NAMES), |out| {
            model
                .dof_names
                .iter()
                .try_for_each(|name| writeln!(out, "{name}"))
        })?;
    }
    Ok(())
}

/// Whether each name can stand in a line of a file.
fn in_lines(names: &[String]) -> bool {
    let plain = |name: &String| name.trim() == name && !name.chars().any(char::is_control);
    names.iter().all(plain)
}

fn contact_table(
    pair: &ContactPair,
    constants: &ContactParameters<f64>,
    names: &[String],
) -> ContactTable {
    let row = |row: &SparseRow| (!row.is_empty()).then(|| named(row, names));
    let of = |row: &SparseRow, stiffness: f64| (!row.is_empty()).then_some(stiffness);
    ContactTable {
        name: pair.name.clone(),
        t1: row(&pair.t1),
        t2: row(&pair.t2),
        n: row(&pair.n),
        k_n: of(&pair.n, constants.k_n),
        k_t1: of(&pair.t1, constants.k_t[0]),
        k_t2: of(&pair.t2, constants.k_t[1]),
        mu: constants.mu,
        n_0: Some(constants.n_0),
        gap: None,
        interface: pair.interface,
    }
}

/// A row by the names of its degrees of freedom.
fn named(row: &SparseRow, names: &[String]) -> BTreeMap<String, f64> {
    row.iter()
        .map(|&(dof, weight)| (names[dof].clone(), weight))
        .collect()
}

fn joined(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(", ")
}
