//! Models of other programs: their matrices read, checked, put into SI units, and written as a study of kind "matrices".
//!
//! Each format is a file of `format` that gives [`ImportedMatrix`]; [`model::assemble`] puts the matrices of all files together.
//! Nothing is guessed: units are declared, and a matrix that nothing names must be named. Sizes that a file states are
//! checked before memory is taken for them. Start reading at [`import()`].
//!
//! Two masses in mm, t, s, as a finite-element program writes them, become a study of matrices:
//!
//! ```
//! # use microslip_readers as microslip;
//! use microslip::import::{PairConstants, Request, Source, Units, import};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//!
//! let [k, m] = ["K.mtx", "M.mtx"].map(|name| folder.path().join(name));
//! // Abaqus: node, component, node, component, number; here N/mm and t
//! std::fs::write(&k, "1,1,1,1,2000\n1,1,2,1,-1000\n2,1,2,1,1000\n")?;
//! std::fs::write(&m, "1,1,1,1,1e-3\n2,1,2,1,1e-3\n")?;
//! let source = |role, path: &std::path::Path| Source::parse(&format!("{role}={}", path.display()));
//! let imported = import(&Request {
//!     sources: vec![source("K", &k), source("M", &m)],
//!     units: Units::MmTonneSecond,
//!     output: folder.path().join("model"),
//!     pairs: None,
//!     nodes: None,
//!     systems: None,
//!     constants: PairConstants::default(),
//!     excite: vec!["2.1=1".to_owned()],
//!     forces: None,
//!     load: None,
//!     responses: vec!["2.1".to_owned()],
//!     damping_ratio: 0.002,
//!     reduction: None,
//! })?;
//! // (√5 − 1)/2 √(k/m)/2π with k = 1e6 N/m, m = 1 kg
//! let lowest = imported.facts.frequencies_hz[0];
//! assert!((lowest - 98.363_164_308_346_6).abs() < 1e-6);
//! # Ok(())
//! # }
//! ```

pub mod dof;
pub mod facts;
pub mod forces;
pub mod matrix;
pub mod model;
pub mod nearest;
pub mod pairs;
pub mod reduce;
pub mod role;
pub mod symmetric;
pub mod units;
pub mod write;

mod checks;
mod direction;
mod format;
mod lines;
mod read;
mod systems;
mod table;
mod warnings;

pub use facts::Facts;
pub use matrix::ImportedMatrix;
pub use model::{ImportedModel, ReadFile, Source};
pub use nearest::{Proposal, propose};
pub use pairs::PairConstants;
pub use read::{Reading, read};
pub use reduce::{Reduction, ReductionFacts};
pub use role::Role;
pub use units::Units;

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::file::{FileError, refuse_content};
use crate::linalg::LinalgError;
use crate::setting::BadSetting;
use checks::Stage;
use forces::{Forces, Names};
use pairs::ImportedPair;
use write::StudyParts;

/// Why a model cannot be imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file cannot be read or written, or breaks a rule.
    #[error(transparent)]
    File(#[from] FileError),
    /// An option of the command breaks a rule.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// The free structure has no frequencies.
    #[error("frequencies of the free structure: {0}")]
    Linalg(#[from] LinalgError),
}

/// What is imported, and into which folder.
#[derive(Debug, Clone)]
pub struct Request {
    /// Files of matrices and names.
    pub sources: Vec<Source>,
    /// Units of all files and tables.
    pub units: Units,
    /// Folder that is written.
    pub output: PathBuf,
    /// Table of contact pairs.
    pub pairs: Option<PathBuf>,
    /// Table of coordinates, for normals that the pairs do not state.
    pub nodes: Option<PathBuf>,
    /// Table of coordinate systems that pairs name.
    pub systems: Option<PathBuf>,
    /// Constants of pairs that do not state them.
    pub constants: PairConstants,
    /// Forces of the excitation: `12.1=1.0`.
    pub excite: Vec<String>,
    /// Table of forces.
    pub forces: Option<PathBuf>,
    /// What the loads in the files are: harmonic or static forces; not used if absent.
    pub load: Option<Role>,
    /// Response coordinates.
    pub responses: Vec<String>,
    /// Damping ratio of all modes where there is no damping matrix.
    pub damping_ratio: f64,
    /// How it is reduced; not at all if absent.
    pub reduction: Option<Reduction>,
}

/// What was imported.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The files.
    pub files: Vec<ReadFile>,
    /// Names of the degrees of freedom.
    pub dofs: Vec<dof::Dof>,
    /// Sizes, mass, frequencies of what was read.
    pub facts: Facts,
    /// What was kept of it, if it was reduced.
    pub reduced: Option<ReductionFacts>,
    /// Number of contact pairs.
    pub pairs: usize,
    /// What a user should look at.
    pub warnings: Vec<String>,
}

/// Reads a model and writes it as a study.
///
/// # Errors
/// [`ImportError`] on the first rule that is broken; then nothing is written.
pub fn import(request: &Request) -> Result<Imported, ImportError> {
    refuse_content(&request.output)?;
    let (model, files) = model::assemble(&request.sources)?;
    model.check_semidefinite()?;
    if request.reduction.is_none() {
        model.check_as_reduced(Stage::Read)?;
    }
    let mut warnings = warnings::of_files(&model, &files, request);
    let mut model = model.in_si(request.units);
    if let Some(role) = request.load {
        use_load(&mut model, role)?;
    }
    let (pairs, forces) = attached(&model, request)?;
    warnings.extend(leave_out_replaced(&mut model, &forces));
    let facts = Facts::of(&model)?;
    warnings.extend(warnings::too_stiff(&model, &facts));
    if facts.frequencies_hz.is_empty() {
        warnings.push("the free structure has no flexible mode".to_owned());
    }
    let parts = StudyParts {
        name: name_of(request),
        origin: origin(request),
        forces,
        responses: request.responses.clone(),
        damping_ratio: request.damping_ratio,
        frequencies_hz: facts.frequencies_hz.clone(),
        pairs,
    };
    let mut reduced = None;
    if let Some(reduction) = &request.reduction {
        let (smaller, kept) = reduce::reduced(&model, facts.rigid.count, &parts, reduction)?;
        (model, reduced) = (smaller, Some(kept));
    }
    write::write(&model, &parts, &request.output)?;
    Ok(Imported {
        files,
        facts,
        reduced,
        pairs: parts.pairs.len(),
        dofs: model.dofs,
        warnings,
    })
}

/// Pairs and forces by names of the model's degrees of freedom.
fn attached(
    model: &ImportedModel,
    request: &Request,
) -> Result<(Vec<ImportedPair>, Forces), ImportError> {
    let (dofs, units) = (&model.dofs, request.units);
    let pairs = match &request.pairs {
        None => Vec::new(),
        Some(path) => {
            let (nodes, systems) = (request.nodes.as_deref(), request.systems.as_deref());
            pairs::read_pairs(path, nodes, systems, dofs, units, request.constants)?
        }
    };
    let names = Names::of(dofs);
    let mut forces = Forces::default();
    if let Some(path) = &request.forces {
        forces.add_table(path, &names, units)?;
    }
    for word in &request.excite {
        forces.add_word(word, &names, units)?;
    }
    let mut responses = BTreeSet::new();
    for name in &request.responses {
        let refused = |rule| BadSetting::new("--response", name, rule);
        if !responses.insert(names.dof(name).map_err(refused)?) {
            return Err(refused("must be given once".to_owned()).into());
        }
    }
    Ok((pairs, forces))
}

/// Takes the load of the files for a force of this role.
fn use_load(model: &mut ImportedModel, role: Role) -> Result<(), BadSetting> {
    let kind = if role == Role::StaticForce {
        "static"
    } else {
        "harmonic"
    };
    let refused = |rule| Err(BadSetting::new("--load", kind, rule));
    let Some(load) = model.forces.remove(&Role::Load) else {
        return refused("must be absent: no file has a load");
    };
    match model.forces.insert(role, load) {
        None => Ok(()),
        Some(_) => refused("must be absent: the files have such a force beside the load"),
    }
}

/// Leaves out the forces of the files that those of options and tables take the place of, and says which: the harmonic one as a whole,
/// whether another cosine or another sine part is stated.
fn leave_out_replaced(model: &mut ImportedModel, forces: &Forces) -> Vec<String> {
    let harmonic = !(forces.cosine.is_empty() && forces.sine.is_empty());
    let given = [
        ("harmonic", Role::HarmonicForce, harmonic),
        ("static", Role::StaticForce, !forces.fixed.is_empty()),
    ];
    let lost = given
        .into_iter()
        .filter(|(_, role, given)| *given && model.forces.remove(role).is_some());
    let warning = |kind| {
        format!("the {kind} force of the files is not used: --excite or --forces states another")
    };
    lost.map(|(kind, ..)| warning(kind)).collect()
}

/// The study has the name of its folder.
fn name_of(request: &Request) -> String {
    let name = request.output.file_name().unwrap_or_default();
    match name.to_string_lossy().trim() {
        "" => "imported model".to_owned(),
        name => name.to_owned(),
    }
}

fn origin(request: &Request) -> String {
    let names = request.sources.iter().map(|source| {
        let name = source.path.file_name().unwrap_or_default();
        name.to_string_lossy().replace(char::is_control, " ")
    });
    let names: Vec<_> = names.collect();
    format!(
        "Imported by Microslip from {} (units {}).",
        names.join(", "),
        request.units.in_words()
    )
}
