//! A model of any size reduced by Craig–Bampton: what contacts, forces and responses need is kept, with the modes below a
//! cut-off.

use std::collections::{BTreeMap, BTreeSet};

use faer::Mat;
use faer::sparse::SparseColMat;
use rayon::prelude::*;

use super::ImportError;
use super::checks::{Stage, massless};
use super::dof::{Component, Dof};
use super::facts::flexible_hz;
use super::forces::{Forces, Names};
use super::matrix::DOUBLE_DIGITS;
use super::model::{ImportedModel, Part};
use super::role::Role;
use super::symmetric::Symmetric;
use super::write::StudyParts;
use crate::file::FileError;
use crate::linalg::{LinalgError, symmetric_eigen};
use crate::model::lower_triangle::{parts, unsigned_energy};
use crate::model::matrix_checks::{SEMIDEFINITE_TOLERANCE, not_negative, rounding};
use crate::model::{CraigBampton, ReductionError};
use crate::setting::BadSetting;

/// Label of the modal coordinates: `1.MODE`, `2.MODE`, ...
const MODE: &str = "MODE";
/// Size of a negative eigenvalue, of a matrix with unit diagonal, that a study file's reader accepts by far.
const NEGLIGIBLE: f64 = 1e-11;
/// Digits that are left of numbers that the reduction computes.
const COMPUTED_DIGITS: u32 = 15;

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
    /// Most negative eigenvalue that was set to zero, of matrices with a unit diagonal: what rounding of the files left.
    pub most_negative: Option<f64>,
    /// First flexible frequencies of the free reduced structure (Hz).
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
            Ok(node) => dof.component != Component::TextRow && dof.node == node,
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

/// The model (in SI units, with so many `rigid`-body modes) reduced to what `parts` and `reduction` need.
///
/// # Errors
/// [`ImportError`] if nothing is kept, if the kept degrees of freedom do not hold the structure, or if there are too many
/// modes below the cut-off.
pub(super) fn reduced(
    model: &ImportedModel,
    rigid: usize,
    parts: &StudyParts,
    reduction: &Reduction,
) -> Result<(ImportedModel, ReductionFacts), ImportError> {
    let masters = masters(&model.dofs, parts, reduction)?;
    let made = craig_bampton(model, &masters, reduction.cut_off)?;
    let (reduced, most_negative) = in_basis(model, &masters, &made)?;
    reduced.check_as_reduced(Stage::Reduced)?;
    let facts = ReductionFacts {
        n_dofs: made.n_dofs(),
        masters: made.n_masters,
        modes: made.n_dofs() - made.n_masters,
        cut_off: reduction.cut_off,
        first_left_out: made.first_left_out,
        massless: massless(&model.matrices[&Role::Mass]).len(),
        most_negative,
        frequencies_hz: flexible_hz(&reduced, rigid)?,
    };
    Ok((reduced, facts))
}

fn craig_bampton(
    model: &ImportedModel,
    masters: &[usize],
    cut_off: f64,
) -> Result<CraigBampton, ImportError> {
    let bad = |rule: String| ImportError::Setting(BadSetting::new("--cut-off", cut_off, rule));
    if masters.is_empty() {
        let rule = "needs degrees of freedom that are kept: --pairs, --excite, --forces, --response or --keep";
        return Err(bad(rule.to_owned()));
    }
    let [stiffness, mass] = [Role::Stiffness, Role::Mass].map(|role| &model.matrices[&role]);
    let rows: Vec<_> = masters.iter().map(|&dof| vec![(dof, 1.0)]).collect();
    let (k, m) = (stiffness.values.to_sparse(), mass.values.to_sparse());
    CraigBampton::new(&k, &m, &rows, cut_off).map_err(|error| match error {
        ReductionError::TooManyModes { .. } => bad(error.to_string()),
        ReductionError::Linalg(LinalgError::NotPositiveDefinite { .. }) => {
            let rule = not_held(&stiffness.values, masters, &model.dofs);
            ImportError::File(FileError::content(&stiffness.path, None, rule))
        }
        ReductionError::Linalg(error) => error.into(),
    })
}

/// Matrices and forces in the basis of the reduction, and the most negative eigenvalue that was set to zero in them.
fn in_basis(
    model: &ImportedModel,
    masters: &[usize],
    made: &CraigBampton,
) -> Result<(ImportedModel, Option<f64>), ImportError> {
    let basis = &made.basis;
    let mut most_negative = None;
    let mut matrices = BTreeMap::new();
    for (&role, part) in &model.matrices {
        let (dense, negative) = match role {
            Role::Mass => (made.mass.clone(), None),
            Role::Stiffness => semidefinite(part, basis, made.stiffness.clone())?,
            _ => semidefinite(part, basis, projected(&part.values.to_sparse(), basis))?,
        };
        most_negative = most_negative.into_iter().chain(negative).reduce(f64::min);
        matrices.insert(role, part.computed(Symmetric::of_dense(&dense)));
    }
    let projected = |part: &Part<Vec<f64>>| {
        let column = |j: usize| basis.col_as_slice(j).iter().zip(&part.values);
        let work = |j: usize| column(j).map(|(a, b)| a * b).sum();
        part.computed((0..basis.ncols()).map(work).collect())
    };
    let kept = masters.iter().map(|&dof| model.dofs[dof].clone());
    let modes = (1..=(basis.ncols() - masters.len()) as i64).map(|mode| Dof::labelled(mode, MODE));
    let reduced = ImportedModel {
        dofs: kept.chain(modes).collect(),
        matrices,
        forces: (model.forces.iter())
            .map(|(role, part)| (*role, projected(part)))
            .collect(),
    };
    Ok((reduced, most_negative))
}

impl<T> Part<T> {
    /// Numbers that were computed from it.
    fn computed<U>(&self, values: U) -> Part<U> {
        Part {
            path: self.path.clone(),
            digits: DOUBLE_DIGITS,
            values,
        }
    }
}

/// ΨᵀAΨ.
fn projected(a: &SparseColMat<usize, f64>, basis: &Mat<f64>) -> Mat<f64> {
    let product = basis.transpose() * (a * basis);
    let n = product.nrows();
    Mat::from_fn(n, n, |i, j| 0.5 * (product[(i, j)] + product[(j, i)]))
}

/// The nearest positive semidefinite matrix, after scaling to a unit diagonal; and its most negative eigenvalue, if it was not.
///
/// A reduced matrix is a difference of large numbers, so what rounding to the digits of the file changes is a larger share of it.
/// Rounding the entries of A by the share ε changes (ΨᵀAΨ)_ij by at most ε √(e_i e_j), e_i = Σ |Ψ_ki| |A_kl| |Ψ_li|, hence the
/// eigenvalues with a unit diagonal by at most ε Σ e_i / (ΨᵀAΨ)_ii.
fn semidefinite(
    part: &Part<Symmetric>,
    basis: &Mat<f64>,
    a: Mat<f64>,
) -> Result<(Mat<f64>, Option<f64>), ImportError> {
    let n = a.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| Some(a[(i, i)].abs().sqrt()).filter(|s| *s > 0.0))
        .map(|scale| scale.unwrap_or(1.0))
        .collect();
    let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] / (scale[i] * scale[j]));
    let (lambda, vectors) = symmetric_eigen(scaled.as_ref())?;
    let Some(negative) = lambda.first().copied().filter(|l| *l < -NEGLIGIBLE) else {
        return Ok((a, None));
    };
    let shares = (0..n).into_par_iter().map(|i| {
        let column = basis.col_as_slice(i);
        let energy = unsigned_energy(part.values.lower.iter().copied(), |dof| column[dof]);
        energy / scale[i].powi(2)
    });
    let shares: Vec<f64> = shares.collect();
    let share = rounding(part.digits.min(COMPUTED_DIGITS));
    let tolerance = SEMIDEFINITE_TOLERANCE + share * shares.iter().sum::<f64>();
    not_negative(negative, tolerance, part.digits)
        .map_err(|rule| FileError::content(&part.path, None, rule))?;
    let kept = Mat::from_fn(n, n, |i, m| vectors[(i, m)] * lambda[m].max(0.0).sqrt());
    let nearest = &kept * kept.transpose();
    let nearest = Mat::from_fn(n, n, |i, j| nearest[(i, j)] * scale[i] * scale[j]);
    Ok((nearest, Some(negative)))
}

/// Why the structure still moves with the masters held.
fn not_held(stiffness: &Symmetric, masters: &[usize], dofs: &[Dof]) -> String {
    let parts = parts(stiffness.n, stiffness.lower.iter().copied());
    let held: BTreeSet<usize> = masters.iter().map(|&dof| parts[dof]).collect();
    let free = (0..stiffness.n).find(|&dof| !held.contains(&parts[dof]));
    match free {
        Some(dof) => format!(
            "with the kept degrees of freedom held, a part of the structure still moves: no degree of freedom is kept of the part with {}; --keep names some",
            dofs[dof]
        ),
        None => "with the kept degrees of freedom held, the structure still moves, or its stiffness is negative: keep more of them by --keep, such as the displacements of three nodes that are not in a line".to_owned(),
    }
}
