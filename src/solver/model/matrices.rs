//! A user's own reduced model: matrices from Matrix Market files, contacts and loads from tables.
//!
//! Units: any consistent set; SI if frequencies are given in Hz. Start reading at [`MatricesSettings::build`].

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use faer::Mat;

use super::dof_index::DofIndex;
use super::matrix_checks::{positive_definite, positive_semidefinite, symmetric};
use super::matrix_contacts::ContactTable;
use super::matrix_market::{Stated, read_matrix};
use super::{Mirror, ReducedModel, Response};
use crate::contact::ContactParameters;
use crate::file::{self, FileError};
use crate::linalg::symmetric_generalized_eigen;
use crate::setting::{BadSetting, NOT_BLANK, non_negative, unusual};

/// Why a model cannot be built from the user's files.
#[derive(Debug, thiserror::Error)]
pub enum MatricesError {
    /// A value in the study file; the key is relative to `[model]`.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// A file cannot be read, or its content breaks a rule.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Damping ratios of blades with all that damps them.
const USUAL_DAMPING: [f64; 2] = [1e-6, 0.1];

/// The user's own reduced model with node-to-node contacts. Files are relative to the study file's folder. Either `damping`
/// or `modal_damping_ratio` is required.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "oneOf" = [{ "required": ["damping"] }, { "required": ["modal_damping_ratio"] }],
    "required" = ["mass", "stiffness", "contact"]
))]
pub struct MatricesSettings {
    /// M, positive definite: Matrix Market file.
    pub mass: PathBuf,
    /// K without contact springs: Matrix Market file. Rigid-body modes are allowed.
    pub stiffness: PathBuf,
    /// C: Matrix Market file.
    pub damping: Option<PathBuf>,
    /// The same damping ratio in every mode of the free structure; rigid-body modes stay undamped.
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 1))]
    pub modal_damping_ratio: Option<f64>,
    /// Stiffness that acts on the mean position (harmonic 0) only: Matrix Market file.
    pub retention: Option<PathBuf>,
    /// Mirror symmetry of the model, of which one half is then solved where all is symmetric (`solver.mirror`): Matrix Market file of
    /// the matrix that maps each displacement to its image, one entry 1 or -1 per column.
    pub mirror: Option<PathBuf>,
    /// Names of the degrees of freedom, in the order of the matrices; "1", "2", … if absent.
    pub dof_names: Option<DofNames>,
    /// Static force f₀.
    pub static_force: Option<Vector>,
    /// Cosine part f_c of the harmonic force, per unit level.
    pub cosine_force: Option<Vector>,
    /// Sine part f_s of the harmonic force, per unit level.
    pub sine_force: Option<Vector>,
    /// Contact pairs, one table each.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub contact: Vec<ContactTable>,
    /// Response coordinates, all degrees of freedom if absent; resonance is the maximum of the first one's amplitude.
    #[schemars(length(min = 1))]
    pub responses: Option<Vec<ResponseTable>>,
}

/// Names in the study file, or a text file with one name per line.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a list of names or the name of a text file"
)]
pub enum DofNames {
    /// Names.
    List(
        #[schemars(length(min = 1), inner(regex(pattern = NOT_BLANK)), extend("uniqueItems" = true))]
         Vec<String>,
    ),
    /// Name of a text file with one name per line.
    File(PathBuf),
}

/// A vector on the degrees of freedom.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a table of dof = number, or the name of a Matrix Market file"
)]
pub enum Vector {
    /// Name → value; the others are 0.
    Table(BTreeMap<String, f64>),
    /// Matrix Market file with one column.
    File(PathBuf),
}

/// A response coordinate.
#[derive(Debug, Clone, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected the name of a dof, or { name = \"...\", row = { dof = weight } }"
)]
pub enum ResponseTable {
    /// One degree of freedom under its own name.
    Dof(String),
    /// `Σ weight · q[dof]`.
    Row {
        /// Name of the response.
        name: String,
        /// Name of the degree of freedom → weight.
        row: BTreeMap<String, f64>,
    },
}

impl MatricesSettings {
    /// Checks what needs no file.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to `[model]`.
    pub fn validate(&self) -> Result<(), BadSetting> {
        let both = self.damping.is_some() && self.modal_damping_ratio.is_some();
        let ratio = self.modal_damping_ratio.unwrap_or(0.0);
        let rule = "must be absent if damping is given";
        BadSetting::unless(!both, "modal_damping_ratio", ratio, rule)?;
        let neither = self.damping.is_none() && self.modal_damping_ratio.is_none();
        let rule = "must be given, or modal_damping_ratio";
        BadSetting::unless(!neither, "damping", "(absent)", rule)?;
        non_negative("modal_damping_ratio", ratio)?;
        BadSetting::unless(ratio < 1.0, "modal_damping_ratio", ratio, "must be below 1")?;
        let named = self.responses.as_ref().is_none_or(|r| !r.is_empty());
        let rule = "must have at least one response";
        BadSetting::unless(named, "responses", "[]", rule)?;
        let n = self.contact.len();
        BadSetting::unless(n > 0, "contact", "[]", "must have at least one pair")?;
        for (i, contact) in self.contact.iter().enumerate() {
            contact
                .validate()
                .map_err(|bad| bad.under(&format!("contact[{i}]")))?;
        }
        Ok(())
    }

    /// What may be meant but is unusual; keys relative to `[model]`. `in_si`: whether the matrices are in SI units, and no other ones.
    #[must_use]
    pub fn unusual(&self, in_si: bool) -> Vec<BadSetting> {
        let contacts = self.contact.iter().enumerate();
        let of_contacts = contacts.flat_map(|(i, contact)| {
            let found = contact.unusual(in_si).into_iter();
            found.map(move |bad| bad.under(&format!("contact[{i}]")))
        });
        let ratio = self.modal_damping_ratio;
        let damping = ratio.and_then(|ratio| unusual("modal_damping_ratio", ratio, USUAL_DAMPING));
        of_contacts.chain(damping).collect()
    }

    /// Reads the files and builds the model. `folder` is the study file's; `name` goes to the model.
    ///
    /// # Errors
    /// [`MatricesError`] on the first rule that a file or a table breaks.
    pub fn build(
        &self,
        name: &str,
        folder: &Path,
    ) -> Result<(ReducedModel, Vec<ContactParameters<f64>>), MatricesError> {
        self.validate()?;
        let mass = self.checked(folder, &self.mass, None, |mass, _| positive_definite(mass))?;
        let n = mass.nrows();
        let stiffness = self.checked(folder, &self.stiffness, Some(n), positive_semidefinite)?;
        let damping = match &self.damping {
            Some(file) => self.checked(folder, file, Some(n), positive_semidefinite)?,
            None => self.modal_damping(&stiffness, &mass)?,
        };
        let retention = match &self.retention {
            Some(file) => Some(self.checked(folder, file, Some(n), positive_semidefinite)?),
            None => None,
        };
        let is_mirror = |a: &Mat<f64>, _| Mirror::of_matrix(a).map(|_| ());
        let mirror = match &self.mirror {
            Some(file) => Some(self.checked(folder, file, Some(n), is_mirror)?),
            None => None,
        };
        let dof_names = self.names(folder, n)?;
        let index = DofIndex(dof_names.iter().cloned().zip(0..).collect());
        let vector = |key, vector: &Option<Vector>| dense(folder, key, vector, n, &index);
        let cosine_force = vector("cosine_force", &self.cosine_force)?;
        let sine_force = vector("sine_force", &self.sine_force)?;
        excited(&cosine_force, &sine_force)?;
        let mut contacts = Vec::new();
        let mut parameters = Vec::new();
        for (i, table) in self.contact.iter().enumerate() {
            contacts.push(table.pair(&format!("contact[{i}]"), &index)?);
            parameters.push(table.parameters());
        }
        let names = contacts.iter().map(|pair| pair.name.as_str());
        unique(|i| format!("contact[{i}].name"), names)?;
        let model = ReducedModel {
            name: name.to_owned(),
            static_force: vector("static_force", &self.static_force)?,
            loads: Vec::new(),
            responses: self.response_rows(&dof_names, &index)?,
            dof_names,
            mass,
            damping,
            stiffness,
            retention,
            contacts,
            cosine_force,
            sine_force,
            mirror: mirror.and_then(|matrix| Mirror::of_matrix(&matrix).ok()),
        };
        Ok((model, parameters))
    }

    /// The files that it names, relative to the study file's folder.
    #[must_use]
    pub fn files(&self) -> Vec<&Path> {
        let vectors = [&self.static_force, &self.cosine_force, &self.sine_force];
        let of_vectors = vectors.into_iter().filter_map(|vector| match vector {
            Some(Vector::File(file)) => Some(file),
            _ => None,
        });
        let names = match &self.dof_names {
            Some(DofNames::File(file)) => Some(file),
            _ => None,
        };
        let matrices = [&self.mass, &self.stiffness].into_iter();
        (matrices
            .chain(&self.damping)
            .chain(&self.retention)
            .chain(&self.mirror))
        .chain(names)
        .chain(of_vectors)
        .map(PathBuf::as_path)
        .collect()
    }

    /// Reads a square symmetric matrix of `size` rows with a further property.
    pub(super) fn checked(
        &self,
        folder: &Path,
        file: &Path,
        size: Option<usize>,
        property: fn(&Mat<f64>, u32) -> Result<(), String>,
    ) -> Result<Mat<f64>, MatricesError> {
        let path = folder.join(file);
        let Stated { matrix, digits } = read_matrix(&path)?;
        let broken = |rule: String| FileError::content(&path, None, rule);
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        if rows != columns {
            return Err(broken(format!("is {rows} x {columns}: must be square")).into());
        }
        if let Some(n) = size.filter(|n| *n != rows) {
            return Err(broken(format!(
                "is {rows} x {rows}: must be {n} x {n}, the size of {}",
                self.mass.display()
            ))
            .into());
        }
        let matrix = symmetric(&matrix).map_err(broken)?;
        property(&matrix, digits).map_err(broken)?;
        Ok(matrix)
    }

    /// C = Σ 2 ζ ω (Mφ)(Mφ)ᵀ over the modes of the free structure.
    fn modal_damping(
        &self,
        stiffness: &Mat<f64>,
        mass: &Mat<f64>,
    ) -> Result<Mat<f64>, MatricesError> {
        let ratio = self.modal_damping_ratio.unwrap_or(0.0);
        let (lambda, shapes) = symmetric_generalized_eigen(stiffness.as_ref(), mass.as_ref())
            .map_err(|error| {
                let rule = format!("needs the modes of the structure, but {error}");
                BadSetting::new("modal_damping_ratio", ratio, rule)
            })?;
        let weighted = mass * &shapes;
        let scaled = Mat::from_fn(mass.nrows(), lambda.len(), |i, m| {
            2.0 * ratio * lambda[m].max(0.0).sqrt() * weighted[(i, m)]
        });
        Ok(scaled * weighted.transpose())
    }

    pub(super) fn names(&self, folder: &Path, n: usize) -> Result<Vec<String>, MatricesError> {
        let names = self.first_names(folder, n)?;
        let rule = format!("must be {n}, one per row of the mass matrix");
        let given = format!("{} names", names.len());
        BadSetting::unless(names.len() == n, "dof_names", given, &rule)?;
        Ok(names)
    }

    /// The names of the first of `n` degrees of freedom, as many as it states.
    pub(super) fn first_names(
        &self,
        folder: &Path,
        n: usize,
    ) -> Result<Vec<String>, MatricesError> {
        let names: Vec<String> = match &self.dof_names {
            None => (1..=n).map(|i| i.to_string()).collect(),
            Some(DofNames::List(names)) => names.clone(),
            Some(DofNames::File(name)) => {
                let text = file::read_text(&folder.join(name))?;
                let lines = text.lines().map(str::trim);
                lines.filter(|l| !l.is_empty()).map(str::to_owned).collect()
            }
        };
        let rule = format!("must be {n}, one per row of the mass matrix");
        let given = format!("{} names", names.len());
        BadSetting::unless(names.len() <= n, "dof_names", given, &rule)?;
        unique(
            |i| format!("dof_names[{i}]"),
            names.iter().map(String::as_str),
        )?;
        Ok(names)
    }

    pub(super) fn response_rows(
        &self,
        dof_names: &[String],
        index: &DofIndex,
    ) -> Result<Vec<Response>, BadSetting> {
        let Some(tables) = &self.responses else {
            let named = dof_names.iter().cloned().enumerate();
            let response = |(i, name)| Response {
                name,
                row: vec![(i, 1.0)],
            };
            return Ok(named.map(response).collect());
        };
        let mut responses = Vec::new();
        for (i, table) in tables.iter().enumerate() {
            let key = format!("responses[{i}]");
            let (name, row) = match table {
                ResponseTable::Dof(dof) => (dof, index.row(&key, &[(dof.clone(), 1.0)].into())?),
                ResponseTable::Row { name, row } => (name, index.row(&format!("{key}.row"), row)?),
            };
            let rule = "must have a weight that is not zero";
            BadSetting::unless(!row.is_empty(), &key, name, rule)?;
            responses.push(Response {
                name: name.clone(),
                row,
            });
        }
        unique(
            |i| format!("responses[{i}]"),
            responses.iter().map(|r| r.name.as_str()),
        )?;
        Ok(responses)
    }
}

/// Requires a harmonic force.
pub(super) fn excited(cosine_force: &[f64], sine_force: &[f64]) -> Result<(), BadSetting> {
    let excited = cosine_force.iter().chain(sine_force).any(|f| *f != 0.0);
    let rule = "must not be zero together with sine_force: nothing would vibrate";
    BadSetting::unless(excited, "cosine_force", "0", rule)
}

/// The n values that a table or a file states.
pub(super) fn dense(
    folder: &Path,
    key: &str,
    vector: &Option<Vector>,
    n: usize,
    index: &DofIndex,
) -> Result<Vec<f64>, MatricesError> {
    let mut values = vec![0.0; n];
    match vector {
        None => {}
        Some(Vector::Table(table)) => {
            for (i, value) in index.row(key, table)? {
                values[i] = value;
            }
        }
        Some(Vector::File(file)) => {
            let path = folder.join(file);
            let matrix = read_matrix(&path)?.matrix;
            if (matrix.nrows(), matrix.ncols()) != (n, 1) {
                let rule = format!(
                    "is {} x {}: must be {n} x 1",
                    matrix.nrows(),
                    matrix.ncols()
                );
                return Err(FileError::content(&path, None, rule).into());
            }
            values.copy_from_slice(matrix.col_as_slice(0));
        }
    }
    Ok(values)
}

/// Refuses the first name that is empty or given twice; `key_of` gives the key of the name at a place.
pub(super) fn unique<'a>(
    key_of: impl Fn(usize) -> String,
    names: impl Iterator<Item = &'a str>,
) -> Result<(), BadSetting> {
    let mut seen = std::collections::BTreeSet::new();
    for (i, name) in names.enumerate() {
        let key = key_of(i);
        BadSetting::unless(!name.trim().is_empty(), &key, "\"\"", "must not be empty")?;
        BadSetting::unless(seen.insert(name), &key, name, "must not be given twice")?;
    }
    Ok(())
}
