//! A mirror-symmetric model folded onto half of its contacts.
//!
//! Let the mirror S map the structure, the static load and the contacts onto themselves.
//!
//! - If S changes the sign of the excitation (blades against each other), the balance equations have solutions with
//!   q(t + T/2) = S q(t), T the period: even harmonics are symmetric under S, odd ones antisymmetric. The contacts of one side
//!   are then the only unknowns, and their images do the same half a period later.
//! - If S keeps the excitation (blades together), all harmonics are symmetric, and the images do the same at the same time.
//!
//! A harmonic only needs the half structure of its parity. Solutions without the symmetry are not found on the folded model;
//! the whole model finds one from a start close to it.

use super::linear::{LinearModel, ModalPart};
use crate::contact::ContactParameters;
use crate::hb::ProblemError;
use crate::model::mirror::Parity;
use crate::model::{ContactPair, Mirror, ReducedModel, Response, SparseRow};
use faer::Mat;

/// Largest difference between the model and its mirror image, over the diagonal, that counts as round-off of the reduction.
const TOLERANCE: f64 = 1e-7;

impl LinearModel {
    /// What is solved: `model` folded if `mirror` allows it and the model is symmetric, else the whole model. Shape: `contacts`
    /// `[model.n_contacts()]`.
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub fn of(
        model: &ReducedModel,
        contacts: &[ContactParameters<f64>],
        mirror: bool,
    ) -> Result<Self, ProblemError> {
        let folded = match mirror {
            true => Self::folded(model, contacts)?,
            false => None,
        };
        match folded {
            Some(half) => Ok(half),
            None => Self::new(model),
        }
    }

    /// `model` folded along its mirror; `None` if it states no mirror, or if matrices, loads, contact pairs or the constants
    /// `contacts` are not symmetric. Shape: `contacts` `[model.n_contacts()]`.
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub fn folded(
        model: &ReducedModel,
        contacts: &[ContactParameters<f64>],
    ) -> Result<Option<Self>, ProblemError> {
        let Some(mirror) = model.mirror.as_ref().filter(|m| keeps_matrices(m, model)) else {
            return Ok(None);
        };
        let Some(pairs) = half_of_pairs(mirror, model, contacts) else {
            return Ok(None);
        };
        let forces = [&model.cosine_force, &model.sine_force];
        let excited = |parity| (forces.iter()).all(|f| has_parity(mirror, f, largest(f), parity));
        let mut loads = [&model.static_force].into_iter().chain(&model.loads);
        let load = largest(&model.static_force);
        if !loads.all(|f| has_parity(mirror, f, load, Parity::Even)) {
            return Ok(None);
        }
        let parities: &[Parity] = if excited(Parity::Even) {
            &[Parity::Even]
        } else if excited(Parity::Odd) {
            &Parity::BOTH
        } else {
            return Ok(None);
        };
        let mut parts = Vec::new();
        let mut floats = false;
        for &parity in parities {
            let (part, part_floats) = ModalPart::new(&half(model, mirror, parity, &pairs), 2.0)?;
            parts.push(part);
            floats |= part_floats;
        }
        let breaking = match parities.len() {
            1 => Some(ModalPart::new(&half(model, mirror, Parity::Odd, &pairs), 2.0)?.0),
            _ => None,
        };
        Ok(Some(Self {
            alternates: parts.len() > 1,
            parts,
            breaking,
            ring: None,
            pairs,
            floats,
        }))
    }
}

/// Whether M, C, K and K₀ are symmetric under the mirror.
fn keeps_matrices(mirror: &Mirror, model: &ReducedModel) -> bool {
    let keeps = |a: &Mat<f64>| {
        let n = a.nrows();
        let largest = (0..n).map(|i| a[(i, i)]).fold(0.0, f64::max);
        (0..n).all(|j| {
            let (image_j, sign_j) = mirror.image[j];
            (0..=j).all(|i| {
                let (image_i, sign_i) = mirror.image[i];
                let difference = a[(i, j)] - sign_i * sign_j * a[(image_i, image_j)];
                let scale = (a[(i, i)] * a[(j, j)]).sqrt();
                difference.abs() <= TOLERANCE * scale + f64::EPSILON * largest
            })
        })
    };
    mirror.image.len() == model.n_dofs()
        && [&model.mass, &model.damping, &model.stiffness]
            .into_iter()
            .chain(&model.retention)
            .all(keeps)
}

fn largest(force: &[f64]) -> f64 {
    force.iter().fold(0.0, |m: f64, f| m.max(f.abs()))
}

/// Whether a force has this parity, up to the round-off of forces of the size `scale`.
fn has_parity(mirror: &Mirror, force: &[f64], scale: f64, parity: Parity) -> bool {
    (mirror.image.iter().enumerate()).all(|(i, &(j, sign))| {
        (force[j] * sign - parity.sign() * force[i]).abs() <= TOLERANCE * scale
    })
}

/// The first of each two pairs that are images of each other; `None` if a pair has no image with the same constants.
fn half_of_pairs(
    mirror: &Mirror,
    model: &ReducedModel,
    contacts: &[ContactParameters<f64>],
) -> Option<Vec<usize>> {
    let image: Vec<usize> = (model.contacts.iter())
        .map(|pair| (model.contacts.iter()).position(|other| are_images(mirror, pair, other)))
        .collect::<Option<_>>()?;
    let matched = (image.iter().enumerate())
        .all(|(i, &j)| i != j && image[j] == i && same_constants(&contacts[i], &contacts[j]));
    matched.then(|| (0..image.len()).filter(|&i| i < image[i]).collect())
}

/// Whether `b` is the image of `a`: the same normal approach, and the same tangential displacements up to their signs.
fn are_images(mirror: &Mirror, a: &ContactPair, b: &ContactPair) -> bool {
    let image = |row: &SparseRow, sign: f64| -> SparseRow {
        sorted(row.iter().map(|&(i, w)| {
            let (j, s) = mirror.image[i];
            (j, w * s * sign)
        }))
    };
    let is = |row: &SparseRow, sign: f64, other: &SparseRow| {
        image(row, sign) == sorted(other.iter().copied())
    };
    let either = |row, other| is(row, 1.0, other) || is(row, -1.0, other);
    is(&a.n, 1.0, &b.n) && either(&a.t1, &b.t1) && either(&a.t2, &b.t2)
}

fn sorted(row: impl Iterator<Item = (usize, f64)>) -> SparseRow {
    let mut row: SparseRow = row.collect();
    row.sort_by_key(|(i, _)| *i);
    row
}

fn same_constants(a: &ContactParameters<f64>, b: &ContactParameters<f64>) -> bool {
    a.k_n == b.k_n && a.k_t == b.k_t && a.mu == b.mu && a.n_0 == b.n_0
}

/// The model restricted to the displacements of one parity, with the pairs of one side.
fn half(model: &ReducedModel, mirror: &Mirror, parity: Parity, pairs: &[usize]) -> ReducedModel {
    let basis = mirror.basis(parity);
    let matrix = |a: &Mat<f64>| {
        Mat::from_fn(basis.len(), basis.len(), |i, j| {
            let left = basis[i].iter();
            left.map(|(p, w)| {
                let right = basis[j].iter();
                w * right.map(|(q, v)| v * a[(*p, *q)]).sum::<f64>()
            })
            .sum()
        })
    };
    let vector = |f: &[f64]| -> Vec<f64> {
        (basis.iter())
            .map(|column| column.iter().map(|(p, w)| w * f[*p]).sum())
            .collect()
    };
    let row = |row: &SparseRow| -> SparseRow {
        let mut dense = vec![0.0; model.n_dofs()];
        row.iter().for_each(|(i, w)| dense[*i] += w);
        let projected = vector(&dense).into_iter().enumerate();
        projected.filter(|(_, w)| *w != 0.0).collect()
    };
    let pair = |&i: &usize| {
        let whole = &model.contacts[i];
        ContactPair {
            t1: row(&whole.t1),
            t2: row(&whole.t2),
            n: row(&whole.n),
            ..whole.clone()
        }
    };
    ReducedModel {
        name: model.name.clone(),
        dof_names: Vec::new(),
        mass: matrix(&model.mass),
        damping: matrix(&model.damping),
        stiffness: matrix(&model.stiffness),
        retention: model.retention.as_ref().map(matrix),
        contacts: pairs.iter().map(pair).collect(),
        static_force: vector(&model.static_force),
        loads: model.loads.iter().map(|load| vector(load)).collect(),
        cosine_force: vector(&model.cosine_force),
        sine_force: vector(&model.sine_force),
        responses: (model.responses.iter())
            .map(|response| Response {
                name: response.name.clone(),
                row: row(&response.row),
            })
            .collect(),
        mirror: None,
    }
}
