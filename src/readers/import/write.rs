//! The folder of an imported model: matrices, names, and a study to look at, edit and run. It appears whole or not at all.

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use super::dof::Dof;
use super::forces::Forces;
use super::model::ImportedModel;
use super::pairs::ImportedPair;
use super::role::Role;
use super::symmetric::Symmetric;
use crate::file::{self, FileError};
use crate::model::matrix_writer::{write_column, write_symmetric};
use crate::model::model_text::{inline, quoted};

/// What is written beside the matrices.
#[derive(Debug, Clone, Default)]
pub struct StudyParts {
    /// Name of the study.
    pub name: String,
    /// The files that were read and their units, for a comment.
    pub origin: String,
    /// Contact pairs.
    pub pairs: Vec<ImportedPair>,
    /// Excitation and static forces.
    pub forces: Forces,
    /// Names of the response coordinates.
    pub responses: Vec<String>,
    /// Damping ratio of all modes where there is no damping matrix.
    pub damping_ratio: f64,
    /// Frequencies of the free structure (Hz), for the band.
    pub frequencies_hz: Vec<f64>,
}

/// Files of the matrices.
const FILES: [(Role, &str, &str); 4] = [
    (Role::Mass, "mass", "mass.mtx"),
    (Role::Stiffness, "stiffness", "stiffness.mtx"),
    (Role::Damping, "damping", "damping.mtx"),
    (Role::Retention, "retention", "retention.mtx"),
];
/// Files of the forces.
const FORCE_FILES: [(Role, &str, &str); 2] = [
    (Role::StaticForce, "static_force", "static_force.mtx"),
    (Role::HarmonicForce, "cosine_force", "cosine_force.mtx"),
];
/// Ends of the band around the first flexible frequency, as shares of it.
const BAND: [f64; 2] = [0.5, 2.0];

/// Writes the folder `output`, which must not exist or be empty.
///
/// # Errors
/// [`FileError`] if it has content or cannot be written; then nothing is left behind.
pub fn write(model: &ImportedModel, parts: &StudyParts, output: &Path) -> Result<(), FileError> {
    file::write_folder(output, |folder| fill(model, parts, folder))
}

fn fill(model: &ImportedModel, parts: &StudyParts, folder: &Path) -> Result<(), FileError> {
    for (role, _, name) in FILES {
        if let Some(part) = model.matrices.get(&role) {
            let Symmetric { n, lower } = &part.values;
            write_symmetric(&folder.join(name), *n, lower, part.digits)?;
        }
    }
    for (role, _, name) in FORCE_FILES {
        if let Some(part) = model.forces.get(&role) {
            write_column(&folder.join(name), &part.values, part.digits)?;
        }
    }
    file::replace(&folder.join("dofs.txt"), |out| {
        model.dofs.iter().try_for_each(|dof| writeln!(out, "{dof}"))
    })?;
    let study = study(model, parts);
    file::replace(&folder.join("study.toml"), |out| {
        out.write_all(study.as_bytes())
    })?;
    Ok(())
}

/// The study file.
fn study(model: &ImportedModel, parts: &StudyParts) -> String {
    let mut text = String::new();
    for line in parts.origin.lines() {
        let _ = writeln!(text, "# {line}");
    }
    let _ = writeln!(
        text,
        "# All numbers are in SI units. Check them; then: microslip inspect study.toml, solve, run.\n\
         name = {}\nseed = 1\nsamples = 1 # more with [inputs]: what is uncertain\nlevels = [1.0] # factors on the harmonic force\n\n\
         [model]\nkind = \"matrices\"",
        quoted(&parts.name)
    );
    for (role, key, name) in FILES {
        if model.matrices.contains_key(&role) {
            let _ = writeln!(text, "{key} = \"{name}\"");
        }
    }
    if !model.matrices.contains_key(&Role::Damping) {
        let _ = writeln!(
            text,
            "modal_damping_ratio = {} # of every mode of the free structure: replace it by what was measured",
            parts.damping_ratio
        );
    }
    let _ = writeln!(text, "dof_names = \"dofs.txt\"");
    text.push_str(&forces(model, &parts.forces));
    match parts.responses.is_empty() {
        true => text.push_str("# responses = [\"...\"] # add: resonance is the maximum of the first one; all dofs if absent\n"),
        false => {
            let names: Vec<_> = parts.responses.iter().map(|name| quoted(name)).collect();
            let _ = writeln!(text, "responses = [{}]", names.join(", "));
        }
    }
    if parts.pairs.is_empty() {
        text.push_str(
            "\n# Add the contact pairs: tables [[model.contact]], or import again with --pairs.\n",
        );
    }
    for pair in &parts.pairs {
        text.push_str(&pair.table().text(true));
    }
    text.push_str("\n[contact]\nlaw = \"circle\"\n\n[frequency]\n");
    text.push_str(&band(&parts.frequencies_hz));
    text
}

/// Static and harmonic forces: tables where the command line states them, else the files of vectors.
fn forces(model: &ImportedModel, forces: &Forces) -> String {
    let mut text = String::new();
    let tables = [
        (Role::StaticForce, "static_force", &forces.fixed, "N"),
        (
            Role::HarmonicForce,
            "cosine_force",
            &forces.cosine,
            "N per unit level",
        ),
        (Role::Load, "sine_force", &forces.sine, "N per unit level"),
    ];
    for (role, key, table, unit) in tables {
        if !table.is_empty() {
            let _ = writeln!(text, "{key} = {} # {unit}", inline(table.iter()));
        } else if let Some((_, _, file)) = FORCE_FILES.iter().find(|(r, ..)| *r == role)
            && model.forces.contains_key(&role)
        {
            let _ = writeln!(text, "{key} = \"{file}\"");
        }
    }
    let excited = !forces.cosine.is_empty()
        || !forces.sine.is_empty()
        || model.forces.contains_key(&Role::HarmonicForce);
    if !excited {
        text.push_str("# cosine_force = { \"...\" = 1.0 } # add: N per unit level\n");
    }
    text
}

/// A band around the first flexible mode, to be replaced.
fn band(frequencies_hz: &[f64]) -> String {
    match frequencies_hz.first() {
        Some(first) => {
            let [low, high] = BAND.map(|share| share * first);
            format!(
                "band_hz = [{low:.4e}, {high:.4e}] # around the first flexible free frequency, {first:.4e} Hz: replace it by that of your mode with stuck contacts (microslip inspect)\n"
            )
        }
        None => "band_hz = [1.0, 1000.0] # the free structure has no flexible mode: replace it\n"
            .to_owned(),
    }
}

/// Whether a name can be told from the names of other degrees of freedom by its node.
#[must_use]
pub fn has_nodes(dofs: &[Dof]) -> bool {
    dofs.iter()
        .any(|dof| dof.component != super::dof::Component::TextRow)
}
