//! The structure that disturbances move in: one set of modes for each symmetry that disturbances may have.

use crate::hb::structure::linear::{LinearModel, ModalPart};
use faer::prelude::*;

/// Modes up to this multiple of the excitation frequency move with their inertia; those above follow the forces statically.
pub(super) const HIGHEST: f64 = 30.0;

/// Most modes with inertia; of more than these the lowest ones.
const MOST_MODES: usize = 250;

/// The structure for disturbances of one symmetry, in coordinates η: η̈ + Ĉ η̇ + Λ η = −`factor` Bᵀ f, r = B η − H f.
#[derive(Debug)]
pub(super) struct Disturbed {
    /// Λ, diagonal (1/s²). Shape: `[n]`.
    pub(super) lambda: Vec<f64>,
    /// Ĉ (1/s). Shape: n × n.
    pub(super) damping: Mat<f64>,
    /// B. Shape: 3 · pairs × n, rows ordered t1 of every pair, t2, n; pairs of the other side after those of this one.
    pub(super) contact: Mat<f64>,
    /// Contacts that one of the pairs stands for.
    pub(super) factor: f64,
    /// H, static compliance of the other modes (m/N). Shape: 3 · pairs square.
    pub(super) residual: Mat<f64>,
    /// 2 if the pairs are those of both sides, and the motion of the other side is that of this one half a period later; else 1.
    pub(super) sides: usize,
    /// Coordinates from this one on change their sign under the mirror.
    pub(super) first_odd: usize,
}

impl Disturbed {
    /// The structure for every symmetry that disturbances of a solution of `model` may have; `None` for a sector of a
    /// disk, where they belong to all nodal diameters.
    pub(super) fn all(model: &LinearModel, omega: f64) -> Option<Vec<Self>> {
        if model.alternates {
            return Some(vec![Self::new(&[&model.parts[0], &model.parts[1]], omega)]);
        }
        let [part] = &model.parts[..] else {
            return None;
        };
        if model.sector {
            return None;
        }
        let parts = [part].into_iter().chain(&model.breaking);
        Some(parts.map(|part| Self::new(&[part], omega)).collect())
    }

    /// Both parities with the pairs of both sides, or one part alone.
    fn new(parts: &[&ModalPart], omega: f64) -> Self {
        let sides = parts.len();
        let cut = (HIGHEST * omega).powi(2);
        let moving: Vec<usize> = (parts.iter())
            .map(|part| part.structure.lambda.partition_point(|&l| l <= cut))
            .map(|n| n.min(MOST_MODES / sides))
            .collect();
        let n: usize = moving.iter().sum();
        let rows = parts[0].contact.nrows();
        let factor = parts[0].multiplicity / sides as f64;
        let mut disturbed = Self {
            lambda: Vec::with_capacity(n),
            damping: Mat::zeros(n, n),
            contact: Mat::zeros(sides * rows, n),
            factor,
            residual: Mat::zeros(sides * rows, sides * rows),
            sides,
            first_odd: if sides == 2 { moving[0] } else { n },
        };
        for (parity, (part, &n)) in parts.iter().zip(&moving).enumerate() {
            disturbed.add(part, n, parity == 1);
        }
        disturbed
    }

    /// Adds the first `n` modes of a part as coordinates, and the others by their compliance.
    fn add(&mut self, part: &ModalPart, n: usize, odd: bool) {
        let first = self.lambda.len();
        let structure = &part.structure;
        self.lambda.extend(&structure.lambda[..n]);
        for (i, &c) in structure.damping[..n].iter().enumerate() {
            self.damping[(first + i, first + i)] = c;
        }
        let coupled = &structure.coupling;
        for (a, &i) in coupled.modes.iter().enumerate().filter(|(_, i)| **i < n) {
            for (b, &j) in coupled.modes.iter().enumerate().filter(|(_, j)| **j < n) {
                if a != b {
                    self.damping[(first + i, first + j)] = coupled.damping.real[(a, b)];
                }
            }
        }
        let contact = both_sides(&part.contact.real, self.sides, odd);
        for j in 0..n {
            self.contact.col_mut(first + j).copy_from(contact.col(j));
        }
        let rest = contact.subcols(n, contact.ncols() - n);
        let compliance = Mat::from_fn(rest.nrows(), rest.ncols(), |i, j| {
            rest[(i, j)] * self.factor / structure.lambda[n + j]
        });
        self.residual += compliance * rest.transpose();
    }

    /// Number of pairs, of both sides where there are two.
    pub(super) fn n_pairs(&self) -> usize {
        self.contact.nrows() / 3
    }
}

/// Rows of one side, followed component by component by those of the other side where there are two.
fn both_sides(contact: &Mat<f64>, sides: usize, odd: bool) -> Mat<f64> {
    let pairs = contact.nrows() / 3;
    let sign = if odd { -1.0 } else { 1.0 };
    Mat::from_fn(sides * contact.nrows(), contact.ncols(), |i, j| {
        let (component, pair) = (i / (sides * pairs), i % (sides * pairs));
        let value = contact[(component * pairs + pair % pairs, j)];
        if pair < pairs { value } else { sign * value }
    })
}
