//! What was read, for comparison with the finite-element program: sizes, total mass, frequencies of the free structure.

use faer::sparse::{SparseColMat, Triplet};

use super::dof::Dof;
use super::matrix::Symmetric;
use super::model::ImportedModel;
use super::role::Role;
use crate::linalg::{LinalgError, lowest_modes, symmetric_generalized_eigen};
use crate::model::rigid::{RigidModes, Triangles, axes, total_mass};
use crate::units::rad_s_to_hz;

/// Flexible frequencies that are shown.
const SHOWN: usize = 10;
/// Modes that are computed of a large model: those that are shown and the rigid-body modes of two bodies.
const COMPUTED: usize = 24;
/// Up to this size all modes are computed, by a dense routine.
const DENSE_SIZE: usize = 400;
/// Shift for the lowest modes, relative to the largest ratio of the diagonals of K and M.
const SHIFT: f64 = 1e-8;

/// Numbers of a model in SI units.
#[derive(Debug, Clone)]
pub struct Facts {
    /// Role, rows, entries that are not zero in both triangles, bandwidth, digits of each matrix.
    pub matrices: Vec<MatrixFacts>,
    /// r'Mr of the displacements along x, y and z (kg), where names have such components.
    pub total_mass: Option<[f64; 3]>,
    /// Rigid-body modes among the modes that were computed.
    pub rigid: RigidModes,
    /// First flexible frequencies of the free structure (Hz).
    pub frequencies_hz: Vec<f64>,
}

/// Numbers of a matrix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MatrixFacts {
    /// Which matrix.
    pub role: Role,
    /// Rows.
    pub rows: usize,
    /// Entries of both triangles that are not zero.
    pub non_zeros: usize,
    /// Largest distance of an entry from the diagonal.
    pub bandwidth: usize,
    /// Digits of its numbers.
    pub digits: u32,
}

impl Facts {
    /// Of a model in SI units.
    ///
    /// # Errors
    /// [`LinalgError`] if its eigenvalue problem fails.
    pub fn of(model: &ImportedModel) -> Result<Self, LinalgError> {
        let matrices = model.matrices.iter().map(|(role, part)| {
            let entries = || part.values.lower.iter().filter(|(.., value)| *value != 0.0);
            let both = |&(row, column, _): &(usize, usize, f64)| 1 + usize::from(row != column);
            MatrixFacts {
                role: *role,
                rows: part.values.n,
                non_zeros: entries().map(both).sum(),
                bandwidth: entries()
                    .map(|(row, column, _)| row - column)
                    .max()
                    .unwrap_or(0),
                digits: part.digits,
            }
        });
        let mass = &model.matrices[&Role::Mass].values;
        let axes = axes(model.dofs.iter().map(Dof::to_string));
        let (rigid, frequencies_hz) = frequencies(model, &axes)?;
        Ok(Self {
            matrices: matrices.collect(),
            total_mass: total_mass(mass.lower.iter().copied(), &axes),
            rigid,
            frequencies_hz,
        })
    }
}

/// Rigid-body modes, and the first flexible frequencies (Hz).
fn frequencies(
    model: &ImportedModel,
    axes: &[Option<usize>],
) -> Result<(RigidModes, Vec<f64>), LinalgError> {
    let [stiffness, mass] = [Role::Stiffness, Role::Mass].map(|role| &model.matrices[&role]);
    let (lambda, shapes) = if stiffness.values.n <= DENSE_SIZE {
        let (k, m) = (stiffness.values.to_dense(), mass.values.to_dense());
        symmetric_generalized_eigen(k.as_ref(), m.as_ref())?
    } else {
        let (k, m) = (sparse(&stiffness.values), sparse(&mass.values));
        let shift = SHIFT * largest_ratio(&stiffness.values, &mass.values);
        let modes = lowest_modes(&k, &m, COMPUTED, shift)?;
        (modes.lambda, modes.shapes)
    };
    let triangles = Triangles {
        stiffness: || stiffness.values.lower.iter().copied(),
        digits: stiffness.digits,
        mass: || mass.values.lower.iter().copied(),
    };
    let searched = &lambda[..lambda.len().min(COMPUTED)];
    let rigid = triangles.rigid_modes(searched, &shapes, axes);
    let flexible = lambda[rigid.count..].iter().take(SHOWN);
    Ok((
        rigid,
        flexible.map(|l| rad_s_to_hz(l.max(0.0).sqrt())).collect(),
    ))
}

/// Largest K_ii/M_ii.
fn largest_ratio(stiffness: &Symmetric, mass: &Symmetric) -> f64 {
    let diagonal = |a: &Symmetric| {
        let mut diagonal = vec![0.0; a.n];
        for &(row, column, value) in &a.lower {
            if row == column {
                diagonal[row] = value;
            }
        }
        diagonal
    };
    let (k, m) = (diagonal(stiffness), diagonal(mass));
    let ratios = k.iter().zip(&m).map(|(k, m)| k / m);
    ratios.fold(0.0, f64::max)
}

fn sparse(a: &Symmetric) -> SparseColMat<usize, f64> {
    let both = |&(row, column, value): &(usize, usize, f64)| {
        let mirrored = (row != column).then_some(Triplet::new(column, row, value));
        std::iter::once(Triplet::new(row, column, value)).chain(mirrored)
    };
    let triplets: Vec<_> = a.lower.iter().flat_map(both).collect();
    SparseColMat::try_new_from_triplets(a.n, a.n, &triplets)
        .unwrap_or_else(|_| unreachable!("indices are below n"))
}
