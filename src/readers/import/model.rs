//! The matrices of all files together: one list of degrees of freedom, one matrix for each part of the equation of motion.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::dof::Dof;
use super::matrix::{Content, ImportedMatrix, Rows};
use super::read::{Reading, read};
use super::role::Role;
use super::symmetric::Symmetric;
use super::units::{MatrixKind, Units};
use crate::file::FileError;

/// A file of the command line, and what of it is meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Role that is stated for its matrix.
    pub role: Option<Role>,
    /// The file.
    pub path: PathBuf,
    /// Name of the one matrix of the file that is meant.
    pub name: Option<String>,
}

impl Source {
    /// `FILE`, `K=FILE`, `K=FILE#NAME`.
    #[must_use]
    pub fn parse(word: &str) -> Self {
        let (role, rest) = match word.split_once('=') {
            Some((role, rest)) if Role::named(role).is_some() => (Role::named(role), rest),
            _ => (None, word),
        };
        let plain = Path::new(rest).exists();
        match rest.rsplit_once('#').filter(|_| !plain) {
            Some((path, name)) => Self {
                role,
                path: path.into(),
                name: Some(name.to_owned()),
            },
            None => Self {
                role,
                path: rest.into(),
                name: None,
            },
        }
    }
}

/// A linear structure, ready to be written.
#[derive(Debug, Clone)]
pub struct ImportedModel {
    /// Names of the degrees of freedom, in the order of the matrices.
    pub dofs: Vec<Dof>,
    /// Its matrices: K and M at least.
    pub matrices: BTreeMap<Role, Part<Symmetric>>,
    /// Its forces.
    pub forces: BTreeMap<Role, Part<Vec<f64>>>,
}

/// A matrix or a force with its origin.
#[derive(Debug, Clone)]
pub struct Part<T> {
    /// The file.
    pub path: PathBuf,
    /// Digits of its numbers.
    pub digits: u32,
    /// The numbers.
    pub values: T,
}

/// What the files are and what they are used for, in words, for the terminal.
#[derive(Debug, Clone)]
pub struct ReadFile {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: &'static str,
    /// Name and role of each matrix; no role: it is not used.
    pub matrices: Vec<(String, Option<Role>)>,
    /// Number of names.
    pub names: Option<usize>,
}

/// Files of names that stand beside a file: the same name with another extension.
const BESIDE: [&str; 4] = ["mapping", "dof", "pch", "asm"];

/// Reads all files and puts their matrices together.
///
/// # Errors
/// [`FileError`] on the first rule that a file breaks, alone or together with the others.
pub fn assemble(sources: &[Source]) -> Result<(ImportedModel, Vec<ReadFile>), FileError> {
    let readings = readings(sources)?;
    let mut chosen: BTreeMap<Role, &ImportedMatrix> = BTreeMap::new();
    let mut files = Vec::new();
    for (source, reading) in &readings {
        let mut matrices = Vec::new();
        for (matrix, role) in roles(source.as_ref(), reading)? {
            if let Some(role) = role
                && let Some(other) = chosen.insert(role, matrix)
            {
                let (letter, other) = (role.letter(), other.path.display());
                let rule = format!(
                    "is a second {letter} beside {other}: give one of them, or say what each is with K=, M=, C=, R=, F= or F0= before its name"
                );
                return Err(FileError::content(&matrix.path, None, rule));
            }
            matrices.push((matrix.name.clone(), role));
        }
        files.push(ReadFile {
            path: reading.path.clone(),
            format: reading.format,
            matrices,
            names: reading.names.as_ref().map(Vec::len),
        });
    }
    for role in [Role::Stiffness, Role::Mass] {
        if !chosen.contains_key(&role) {
            let letter = role.letter();
            let first = sources.first().map_or(Path::new(""), |s| &s.path);
            let rule = format!(
                "no file has {letter}: give its file, or say which one it is with {letter}= before its name"
            );
            return Err(FileError::content(first, None, rule));
        }
    }
    let dofs = common_dofs(&chosen, &readings)?;
    Ok((ImportedModel::new(dofs, &chosen)?, files))
}

/// What is in the files, and in files of names beside them.
fn readings(sources: &[Source]) -> Result<Vec<(Option<Source>, Reading)>, FileError> {
    let mut readings = Vec::new();
    let mut seen = BTreeSet::new();
    for source in sources {
        let reading = read(&source.path)?;
        seen.insert(source.path.clone());
        readings.push((Some(source.clone()), reading));
    }
    if readings.iter().any(|(_, reading)| reading.names.is_some()) {
        return Ok(readings);
    }
    for source in sources {
        for extension in BESIDE {
            let beside = source.path.with_extension(extension);
            if beside.is_file() && seen.insert(beside.clone()) {
                let mut reading = read(&beside)?;
                // its matrices were not asked for
                reading.matrices.clear();
                readings.push((None, reading));
            }
        }
    }
    Ok(readings)
}

/// The role of each matrix of a file.
fn roles<'r>(
    source: Option<&Source>,
    reading: &'r Reading,
) -> Result<Vec<(&'r ImportedMatrix, Option<Role>)>, FileError> {
    let fault = |rule: String| Err(FileError::content(&reading.path, None, rule));
    let all: Vec<&str> = reading.matrices.iter().map(|m| m.name.as_str()).collect();
    let name = source.and_then(|source| source.name.as_deref());
    let named = |matrix: &&ImportedMatrix| name.is_none_or(|n| matrix.name.eq_ignore_ascii_case(n));
    let meant: Vec<&ImportedMatrix> = reading.matrices.iter().filter(named).collect();
    if let (Some(name), true) = (name, meant.is_empty()) {
        return fault(format!("has no matrix {name}: it has {}", all.join(", ")));
    }
    let stated = source.and_then(|source| source.role);
    let Some(stated) = stated else {
        let roles = meant.iter();
        let roles: Vec<_> = roles.map(|m| (*m, Role::of(m, reading.arrays))).collect();
        if let [(matrix, None)] = roles[..] {
            let what = if matrix.name.is_empty() {
                "a matrix"
            } else {
                &matrix.name
            };
            return fault(format!(
                "is {what} of which nothing says what it is: write K=, M=, C=, R=, F= or F0= before its name"
            ));
        }
        return Ok(roles);
    };
    // a right-hand side comes along with its matrix
    let is_vector = |m: &&&ImportedMatrix| matches!(m.content, Content::Column(_));
    let fits = |m: &&&ImportedMatrix| match stated.is_vector() {
        true => m.content.column().is_some(),
        false => !is_vector(m),
    };
    let fitting = meant.iter().filter(fits);
    match fitting.collect::<Vec<_>>()[..] {
        [one] => Ok(meant
            .iter()
            .map(|m| match std::ptr::eq(*m, *one) {
                true => (*m, Some(stated)),
                false => (*m, Some(Role::Load).filter(|_| is_vector(&m))),
            })
            .collect()),
        _ => fault(format!(
            "has {} matrices ({}): say which one with #NAME after the file's name",
            meant.len(),
            all.join(", ")
        )),
    }
}

/// The degrees of freedom of K, or names for its rows.
fn common_dofs(
    chosen: &BTreeMap<Role, &ImportedMatrix>,
    readings: &[(Option<Source>, Reading)],
) -> Result<Vec<Dof>, FileError> {
    let with_names = chosen.values().find_map(|m| match &m.rows {
        Rows::Named(names) => Some(names.clone()),
        Rows::Numbered(_) => None,
    });
    if let Some(names) = with_names {
        let mut all = chosen.values();
        if let Some(without) = all.find(|m| matches!(m.rows, Rows::Numbered(_))) {
            let rule =
                "has no names, but other matrices have: give all of them from files of one kind";
            return Err(FileError::content(&without.path, None, rule));
        }
        for (_, reading) in readings {
            let listed: Option<BTreeSet<&Dof>> = reading.names.as_ref().map(|l| l.iter().collect());
            if let Some(listed) = listed
                && let Some(missing) = names.iter().find(|name| !listed.contains(name))
            {
                let rule = format!(
                    "has no degree of freedom {missing}, which the matrices have: it is of another model"
                );
                return Err(FileError::content(&reading.path, None, rule));
            }
        }
        return Ok(names);
    }
    let n = chosen[&Role::Stiffness].rows.count();
    let mut found: Option<(&Path, &Vec<Dof>)> = None;
    for (_, reading) in readings {
        let Some(names) = &reading.names else {
            continue;
        };
        let fault = |rule: String| Err(FileError::content(&reading.path, None, rule));
        if let Some((other, _)) = found.filter(|(_, other)| *other != names) {
            let other = other.display();
            return fault(format!(
                "has other names than {other}: it is of another model"
            ));
        }
        if names.len() != n {
            let stiffness = chosen[&Role::Stiffness].path.display();
            return fault(format!(
                "has {} names, but {stiffness} has {n} rows: it is of another model (or the matrix is of a cyclic sector, which doubles it)",
                names.len()
            ));
        }
        found = Some((&reading.path, names));
    }
    Ok(match found {
        Some((_, names)) => names.clone(),
        None => (0..n).map(Dof::row).collect(),
    })
}

impl ImportedModel {
    fn new(dofs: Vec<Dof>, chosen: &BTreeMap<Role, &ImportedMatrix>) -> Result<Self, FileError> {
        let index: BTreeMap<&Dof, usize> = dofs.iter().zip(0..).collect();
        let (mut matrices, mut forces) = (BTreeMap::new(), BTreeMap::new());
        for (&role, matrix) in chosen {
            let places = places(matrix, &index, &chosen[&Role::Stiffness].path)?;
            let (path, digits) = (matrix.path.clone(), matrix.digits);
            match (&matrix.content, matrix.content.column()) {
                (Content::Symmetric(symmetric), _) if !role.is_vector() => {
                    let values = symmetric.placed(&places, dofs.len());
                    let part = Part {
                        path,
                        digits,
                        values,
                    };
                    matrices.insert(role, part);
                }
                (_, Some(column)) if role.is_vector() => {
                    let mut values = vec![0.0; dofs.len()];
                    for (value, &place) in column.iter().zip(&places) {
                        values[place] = *value;
                    }
                    forces.insert(
                        role,
                        Part {
                            path,
                            digits,
                            values,
                        },
                    );
                }
                _ => {
                    let must = if role.is_vector() {
                        "one column"
                    } else {
                        "a square matrix"
                    };
                    let rule = format!("{}: must be {must}", role.letter());
                    return Err(FileError::content(&matrix.path, None, rule));
                }
            }
        }
        Ok(Self {
            dofs,
            matrices,
            forces,
        })
    }

    /// The same in SI units.
    #[must_use]
    pub fn in_si(mut self, units: Units) -> Self {
        let kinds: Vec<_> = self.dofs.iter().map(Dof::kind).collect();
        for (role, part) in &mut self.matrices {
            let of = match role {
                Role::Mass => MatrixKind::Mass,
                Role::Damping => MatrixKind::Damping,
                _ => MatrixKind::Stiffness,
            };
            for (row, column, value) in &mut part.values.lower {
                *value *= units.entry(of, kinds[*row], kinds[*column]);
            }
        }
        for part in self.forces.values_mut() {
            for (value, kind) in part.values.iter_mut().zip(&kinds) {
                *value *= units.load(*kind);
            }
        }
        self
    }
}

/// Where the rows of a matrix stand among all degrees of freedom.
fn places(
    matrix: &ImportedMatrix,
    index: &BTreeMap<&Dof, usize>,
    stiffness: &Path,
) -> Result<Vec<usize>, FileError> {
    let fault = |rule: String| Err(FileError::content(&matrix.path, None, rule));
    let n = index.len();
    match &matrix.rows {
        Rows::Numbered(rows) if *rows != n => fault(format!(
            "has {rows} rows: must have {n}, as {} has",
            stiffness.display()
        )),
        Rows::Numbered(_) => Ok((0..n).collect()),
        Rows::Named(names) => {
            let place = |dof: &Dof| index.get(dof).copied();
            match names.iter().find(|dof| place(dof).is_none()) {
                Some(dof) => fault(format!(
                    "has the degree of freedom {dof}, which {} does not have",
                    stiffness.display()
                )),
                None => Ok(names.iter().filter_map(place).collect()),
            }
        }
    }
}
