//! What was read, for comparison with the finite-element program: sizes, total mass, frequencies of the free structure.

use super::dof::Dof;
use super::model::ImportedModel;
use super::role::Role;
use super::symmetric::Symmetric;
use crate::linalg::{LinalgError, LowestModes, lowest_modes, symmetric_generalized_eigen};
use crate::model::rigid::{RigidModes, Triangles, axes, total_mass};
use crate::units::rad_s_to_hz;

/// Flexible frequencies that are shown.
const SHOWN: usize = 10;
/// Modes that are computed first of a large model: those that are shown and the rigid-body modes of two bodies. Twice as many are, until so
/// many flexible ones are known.
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
    /// Rigid-body modes.
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

/// First flexible frequencies (Hz) of a structure with so many rigid-body modes.
///
/// # Errors
/// [`LinalgError`] if its eigenvalue problem fails.
pub(super) fn flexible_hz(model: &ImportedModel, rigid: usize) -> Result<Vec<f64>, LinalgError> {
    let lambda = lowest(model, COMPUTED.max(rigid + SHOWN))?.lambda;
    Ok(in_hz(lambda.get(rigid..).unwrap_or_default()))
}

/// Rigid-body modes, and the first flexible frequencies (Hz).
fn frequencies(
    model: &ImportedModel,
    axes: &[Option<usize>],
) -> Result<(RigidModes, Vec<f64>), LinalgError> {
    let [stiffness, mass] = [Role::Stiffness, Role::Mass].map(|role| &model.matrices[&role]);
    let triangles = Triangles {
        stiffness: || stiffness.values.lower.iter().copied(),
        digits: stiffness.digits,
        mass: || mass.values.lower.iter().copied(),
    };
    let mut count = COMPUTED;
    loop {
        let LowestModes { lambda, shapes } = lowest(model, count)?;
        let rigid = triangles.rigid_modes(&lambda, &shapes, axes);
        let flexible = &lambda[rigid.count..];
        if flexible.len() >= SHOWN || count >= stiffness.values.n {
            return Ok((rigid, in_hz(flexible)));
        }
        count *= 2;
    }
}

fn in_hz(lambda: &[f64]) -> Vec<f64> {
    let shown = lambda.iter().take(SHOWN);
    shown.map(|l| rad_s_to_hz(l.max(0.0).sqrt())).collect()
}

/// The lowest modes of the free structure: so many of a large one, else all.
fn lowest(model: &ImportedModel, count: usize) -> Result<LowestModes, LinalgError> {
    let [stiffness, mass] = [Role::Stiffness, Role::Mass].map(|role| &model.matrices[&role]);
    if stiffness.values.n <= DENSE_SIZE {
        let (k, m) = (stiffness.values.to_dense(), mass.values.to_dense());
        // a mass that is not definite is left to the sparse routine
        if let Ok((lambda, shapes)) = symmetric_generalized_eigen(k.as_ref(), m.as_ref()) {
            return Ok(LowestModes { lambda, shapes });
        }
    }
    let (k, m) = (stiffness.values.to_sparse(), mass.values.to_sparse());
    let shift = SHIFT * largest_ratio(&stiffness.values, &mass.values);
    lowest_modes(&k, &m, count, shift)
}

/// Largest K_ii/M_ii of the degrees of freedom with mass.
fn largest_ratio(stiffness: &Symmetric, mass: &Symmetric) -> f64 {
    let (k, m) = (stiffness.diagonal(), mass.diagonal());
    let with_mass = k.iter().zip(&m).filter(|(_, m)| **m > 0.0);
    with_mass.map(|(k, m)| k / m).fold(0.0, f64::max)
}
