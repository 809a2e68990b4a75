//! A model of any size reduced by Craig–Bampton: what contacts, forces and responses need is kept, with the modes below a
//! cut-off.

use std::collections::{BTreeMap, BTreeSet};

use faer::Mat;
use faer::sparse::SparseColMat;
use rayon::prelude::*;

use super::ImportError;
use super::checks::massless;
use super::dof::{Component, Dof};
use super::forces::{Forces, Names};
use super::model::{ImportedModel, Part};
use super::role::Role;
use super::symmetric::Symmetric;
use super::write::StudyParts;
use crate::file::FileError;
use crate::linalg::LinalgError;
use crate::model::matrix_checks::rounding;
use crate::model::{CraigBampton, ReductionError};
use crate::setting::BadSetting;

/// Label of the modal coordinates: `1.MODE`, `2.MODE`, ...
const MODE: &str = "MODE";
/// Digits that a reduced number keeps at least: with fewer it would count as exact.
const FEWEST_DIGITS: u32 = 6;
/// Digits of numbers that were computed here.
const COMPUTED_DIGITS: u32 = 16;

/// How a model is reduced.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Modes with the kept degrees of freedom held are kept below it (Hz).
    pub cut_off: f64,
    /// Nodes and degrees of freedom that are kept besides those of pairs, forces and responses: `12`, `12.1`.
    pub keep: Vec<String>,
}

/// What a reduction kept and what it left out.
#[derive(Debug, Clone, PartialEq)]
pub struct ReductionFacts {
    /// Degrees of freedom of the reduced model.
    pub n_dofs: usize,
    /// Kept degrees of freedom of the full model; they come first.
    pub masters: usize,
    /// Kept modes.
    pub modes: usize,
    /// Cut-off (Hz).
    pub cut_off: f64,
    /// First mode that was left out (Hz); infinite if none was.
    pub first_left_out: f64,
    /// Degrees of freedom without mass, which follow the others statically.
    pub massless: usize,
    /// First flexible frequencies of the free reduced structure (Hz); each is at least that of the full one.
    pub frequencies_hz: Vec<f64>,
}

/// Rows that are kept, ascending: what pairs, forces, responses and `--keep` name.
///
/// # Errors
/// [`BadSetting`] on a word of `--keep` that is no node and no degree of freedom.
fn masters(
    dofs: &[Dof],
    parts: &StudyParts,
    reduction: &Reduction,
) -> Result<Vec<usize>, BadSetting> {
    let names = Names::of(dofs);
    let of_pairs = parts.pairs.iter();
    let of_pairs = of_pairs.flat_map(|pair| pair.t1.iter().chain(&pair.t2).chain(&pair.n));
    let Forces {
        cosine,
        sine,
        fixed,
    } = &parts.forces;
    let of_forces = cosine.keys().chain(sine.keys()).chain(fixed.keys());
    let named = of_pairs.map(|(name, _)| name).chain(of_forces);
    let mut rows: BTreeSet<usize> = named
        .chain(&parts.responses)
        .filter_map(|name| names.row(name).ok())
        .collect();
    for word in &reduction.keep {
        let of_node = |dof: &Dof| match word.parse::<i64>() {
            Ok(node) => dof.component != Component::Row && dof.node == node,
            Err(_) => false,
        };
        let found: Vec<usize> = match names.row(word) {
            Ok(row) => vec![row],
            Err(_) => (0..dofs.len()).filter(|&row| of_node(&dofs[row])).collect(),
        };
        let rule = "must be a node or a degree of freedom of the matrices, such as 12 or 12.1";
        BadSetting::unless(!found.is_empty(), "--keep", word, rule)?;
        rows.extend(found);
    }
    Ok(rows.into_iter().collect())
}

/// The model (in SI units) reduced to what `parts` and `reduction` need, and its modes below the cut-off.
///
/// # Errors
/// [`ImportError`] if nothing is kept, if the kept degrees of freedom do not hold the structure, or if there are too many
/// modes below the cut-off.
pub(super) fn reduced(
    model: &ImportedModel,
    parts: &StudyParts,
    reduction: &Reduction,
) -> Result<(ImportedModel, CraigBampton), ImportError> {
    let cut_off = reduction.cut_off;
    let masters = masters(&model.dofs, parts, reduction)?;
    let bad = |rule: String| {
        let (key, value) = ("--cut-off".to_owned(), cut_off.to_string());
        ImportError::Setting(BadSetting { key, value, rule })
    };
    if masters.is_empty() {
        return Err(bad("needs degrees of freedom that are kept: --pairs, --excite, --forces, --response or --keep".to_owned()));
    }
    let [stiffness, mass] = [Role::Stiffness, Role::Mass].map(|role| &model.matrices[&role]);
    let rows: Vec<_> = masters.iter().map(|&dof| vec![(dof, 1.0)]).collect();
    let (k, m) = (stiffness.values.to_sparse(), mass.values.to_sparse());
    let made = CraigBampton::new(&k, &m, &rows, cut_off);
    let made = made.map_err(|error| match error {
        ReductionError::TooManyModes { .. } => bad(error.to_string()),
        ReductionError::Linalg(LinalgError::NotPositiveDefinite { .. }) => {
            let rule = not_held(&stiffness.values, &masters, &model.dofs);
            ImportError::File(FileError::content(&stiffness.path, None, rule))
        }
        ReductionError::Linalg(error) => error.into(),
    })?;
    let basis = &made.basis;
    let mut matrices = BTreeMap::new();
    for (&role, part) in &model.matrices {
        let dense = match role {
            Role::Stiffness => made.stiffness.clone(),
            Role::Mass => made.mass.clone(),
            _ => projected(&part.values.to_sparse(), basis),
        };
        matrices.insert(role, rounded(part, basis, dense));
    }
    let forces = (model.forces.iter()).map(|(role, part)| {
        let column = |j: usize| basis.col_as_slice(j).iter().zip(&part.values);
        let value = |j: usize| column(j).map(|(a, b)| a * b).sum();
        let values = (0..basis.ncols()).map(value).collect();
        let (path, digits) = (part.path.clone(), part.digits);
        (
            *role,
            Part {
                path,
                digits,
                values,
            },
        )
    });
    let kept = masters.iter().map(|&dof| model.dofs[dof].clone());
    let modes = (1..=(basis.ncols() - masters.len()) as i64).map(|mode| Dof::labelled(mode, MODE));
    let reduced = ImportedModel {
        dofs: kept.chain(modes).collect(),
        matrices,
        forces: forces.collect(),
    };
    Ok((reduced, made))
}

impl ReductionFacts {
    /// `frequencies_hz` are those of the free reduced structure.
    pub(super) fn new(
        model: &ImportedModel,
        made: &CraigBampton,
        reduction: &Reduction,
        frequencies_hz: Vec<f64>,
    ) -> Self {
        Self {
            n_dofs: made.n_dofs(),
            masters: made.n_masters,
            modes: made.n_dofs() - made.n_masters,
            cut_off: reduction.cut_off,
            first_left_out: made.first_left_out,
            massless: massless(&model.matrices[&Role::Mass]).len(),
            frequencies_hz,
        }
    }
}

/// ΨᵀAΨ.
fn projected(a: &SparseColMat<usize, f64>, basis: &Mat<f64>) -> Mat<f64> {
    let product = basis.transpose() * (a * basis);
    let n = product.nrows();
    Mat::from_fn(n, n, |i, j| 0.5 * (product[(i, j)] + product[(j, i)]))
}

/// A reduced matrix with the digits that are left of those of its file.
///
/// Rounding an entry of A by the share ε changes (ΨᵀAΨ)_ij by at most ε √(e_i e_j), e_i = Σ |Ψ_ki| |A_kl| |Ψ_li|. What is smaller
/// is zero, and the digits of the rest follow from the largest e_i / (ΨᵀAΨ)_ii.
fn rounded(part: &Part<Symmetric>, basis: &Mat<f64>, mut dense: Mat<f64>) -> Part<Symmetric> {
    let n = basis.ncols();
    let energies = (0..n).into_par_iter();
    let energies = energies.map(|j| part.values.unsigned_energy(basis.col_as_slice(j)));
    let energies: Vec<f64> = energies.collect();
    let digits = part.digits.min(COMPUTED_DIGITS);
    let least = rounding(digits);
    for j in 0..n {
        for i in 0..n {
            if dense[(i, j)].abs() <= least * (energies[i] * energies[j]).sqrt() {
                dense[(i, j)] = 0.0;
            }
        }
    }
    let ratio = |j: usize| match dense[(j, j)] {
        0.0 => 1.0,
        diagonal => energies[j] / diagonal.abs(),
    };
    let lost = (0..n).map(ratio).fold(1.0, f64::max).log10().ceil() as u32;
    Part {
        path: part.path.clone(),
        digits: digits.saturating_sub(lost).max(FEWEST_DIGITS),
        values: Symmetric::of_dense(&dense),
    }
}

/// Why the structure still moves with the masters held.
fn not_held(stiffness: &Symmetric, masters: &[usize], dofs: &[Dof]) -> String {
    let mut parts = Parts::new(stiffness.n);
    for &(row, column, _) in stiffness.lower.iter().filter(|(.., value)| *value != 0.0) {
        parts.join(row, column);
    }
    let held: Vec<usize> = masters.iter().map(|&dof| parts.of(dof)).collect();
    let free = (0..stiffness.n).find(|&dof| !held.contains(&parts.of(dof)));
    match free {
        Some(dof) => format!(
            "with the kept degrees of freedom held, a part of the structure still moves: no degree of freedom is kept of the part with {}; --keep names some",
            dofs[dof]
        ),
        None => "with the kept degrees of freedom held, the structure still moves: keep more of them by --keep, such as the displacements of three nodes that are not in a line".to_owned(),
    }
}

/// Parts of the structure that no stiffness joins.
struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    fn new(n: usize) -> Self {
        Self {
            parent: (0..n).collect(),
        }
    }

    /// The part that a degree of freedom belongs to, by its first one.
    fn of(&mut self, dof: usize) -> usize {
        let mut dof = dof;
        while self.parent[dof] != dof {
            self.parent[dof] = self.parent[self.parent[dof]];
            dof = self.parent[dof];
        }
        dof
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.parent[a.max(b)] = a.min(b);
    }
}
