//! The folder of an imported model: matrices, names, and a study to look at, edit and run. It appears whole or not at all.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::dof::Dof;
use super::forces::Forces;
use super::matrix::DOUBLE_DIGITS;
use super::model::{ImportedModel, Part};
use super::pairs::{ImportedPair, Preload};
use super::role::Role;
use super::symmetric::Symmetric;
use crate::file::{self, FileError};
use crate::model::matrix_checks::rounding;

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
    let system = |path: &Path| {
        let path = path.to_owned();
        move |source| FileError::system(&path, source)
    };
    refuse_content(output)?;
    let parent = match output.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    std::fs::create_dir_all(&parent).map_err(system(&parent))?;
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // the library's default is 0700; models are for colleagues too, as far as the umask allows
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o777));
    }
    let folder = builder.prefix(".import-").tempdir_in(&parent);
    let folder = folder.map_err(system(&parent))?;
    fill(model, parts, folder.path())?;
    if output.exists() {
        std::fs::remove_dir(output).map_err(system(output))?;
    }
    std::fs::rename(folder.path(), output).map_err(system(output))?;
    // its old name is free: nothing is left to be deleted
    let _ = folder.keep();
    Ok(())
}

/// An older folder may hold what a user has edited.
///
/// # Errors
/// [`FileError`] if the folder has content.
pub fn refuse_content(output: &Path) -> Result<(), FileError> {
    let entries = match std::fs::read_dir(output) {
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        entries => entries.map_err(|source| FileError::system(output, source))?,
    };
    match entries.count() {
        0 => Ok(()),
        _ => {
            let rule = "has content already: take another folder with --output, or delete it";
            Err(FileError::content(output, None, rule))
        }
    }
}

fn fill(model: &ImportedModel, parts: &StudyParts, folder: &Path) -> Result<(), FileError> {
    for (role, _, name) in FILES {
        if let Some(part) = model.matrices.get(&role) {
            write_matrix(&folder.join(name), part)?;
        }
    }
    for (role, _, name) in FORCE_FILES {
        if let Some(part) = model.forces.get(&role) {
            write_vector(&folder.join(name), part)?;
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

/// A number with the digits that its file had, so that nobody takes it for more exact.
fn rounded(value: f64, digits: u32) -> String {
    match digits {
        digits if rounding(digits) > 0.0 && digits < DOUBLE_DIGITS => {
            format!("{value:.*e}", digits as usize - 1)
        }
        _ => format!("{value:e}"),
    }
}

fn write_matrix(path: &Path, part: &Part<Symmetric>) -> Result<(), FileError> {
    let Symmetric { n, lower } = &part.values;
    let written = file::replace(path, |out| {
        let mut out = std::io::BufWriter::new(out);
        writeln!(out, "%%MatrixMarket matrix coordinate real symmetric")?;
        writeln!(out, "{n} {n} {}", lower.len())?;
        for (row, column, value) in lower {
            let value = rounded(*value, part.digits);
            writeln!(out, "{} {} {value}", row + 1, column + 1)?;
        }
        out.flush()
    });
    written.map(|_| ())
}

fn write_vector(path: &Path, part: &Part<Vec<f64>>) -> Result<(), FileError> {
    let written = file::replace(path, |out| {
        writeln!(out, "%%MatrixMarket matrix array real general")?;
        writeln!(out, "{} 1", part.values.len())?;
        let mut values = part.values.iter();
        values.try_for_each(|value| writeln!(out, "{}", rounded(*value, part.digits)))
    });
    written.map(|_| ())
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
        text.push_str(&contact(pair));
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

fn contact(pair: &ImportedPair) -> String {
    let mut text = format!("\n[[model.contact]]\nname = {}\n", quoted(&pair.name));
    let (k_n, k_t) = (pair.k_n, pair.k_t);
    for (key, row, stiffness) in [
        ("t1", &pair.t1, ("k_t1", k_t)),
        ("t2", &pair.t2, ("k_t2", k_t)),
        ("n", &pair.n, ("k_n", k_n)),
    ] {
        if !row.is_empty() {
            let table: BTreeMap<_, _> = row.iter().cloned().collect();
            let (name, value) = stiffness;
            let _ = writeln!(
                text,
                "{key} = {}\n{name} = {value:e} # N/m",
                inline(table.iter())
            );
        }
    }
    let _ = writeln!(text, "mu = {:?}", pair.mu);
    let _ = match pair.preload {
        Preload::Force(n_0) => writeln!(text, "n_0 = {n_0:?} # N"),
        Preload::Gap(gap) => writeln!(text, "gap = {gap:?} # m"),
    };
    if pair.interface > 0 {
        let _ = writeln!(text, "interface = {}", pair.interface);
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

/// `{ "12.1" = 1.0, "34.1" = -1.0 }`.
fn inline<'e>(entries: impl Iterator<Item = (&'e String, &'e f64)>) -> String {
    let entries: Vec<_> = entries
        .map(|(name, value)| format!("{} = {value:?}", quoted(name)))
        .collect();
    format!("{{ {} }}", entries.join(", "))
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    let plain = text.chars().filter(|c| !c.is_control());
    let escaped: String = plain
        .flat_map(|c| {
            let escape = matches!(c, '"' | '\\').then_some('\\');
            escape.into_iter().chain(std::iter::once(c))
        })
        .collect();
    format!("\"{escaped}\"")
}

/// Whether a name can be told from the names of other degrees of freedom by its node.
#[must_use]
pub fn has_nodes(dofs: &[Dof]) -> bool {
    dofs.iter()
        .any(|dof| dof.component != super::dof::Component::Row)
}
