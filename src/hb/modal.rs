//! The linear model in the coordinates of its free modes.
//!
//! With q = Φ η, Φᵀ M Φ = I and Φᵀ K Φ = Λ the free structure (contacts open) obeys
//! η̈ + Ĉ η̇ + Λ η = Φᵀ f. Where Ĉ is diagonal, as for components with modal or proportional damping,
//! its dynamic stiffness costs nothing to invert; that is why these coordinates are used. No mode is left out.

use super::ProblemError;
use crate::linalg::symmetric_generalized_eigen;
use crate::model::{ReducedModel, SparseRow};
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;

/// Off-diagonal damping below this share of its diagonal neighbours is round-off.
const DIAGONAL_TOLERANCE: f64 = 1e-8;

/// Free modes of a [`ReducedModel`] and its contact, load and response vectors in modal coordinates.
#[derive(Debug, Clone)]
pub struct ModalModel {
    /// Λ, squared natural frequencies of the free structure ((rad/s)²), ascending. Shape: `[n]`.
    pub lambda: Vec<f64>,
    /// Ĉ.
    pub damping: ModalDamping,
    /// Φᵀ K₀ Φ, stiffness of the 0th harmonic only.
    pub retention: Option<Mat<f64>>,
    /// B Φ: modes → relative contact displacements. Shape: 3·n_contacts × n, rows ordered t1 of every pair, t2, n.
    pub contact: Mat<f64>,
    /// Modes → response coordinates. Shape: n_responses × n.
    pub response: Mat<f64>,
    /// Φᵀ f₀. Shape: `[n]`.
    pub static_force: Vec<f64>,
    /// Φᵀ (f_c − i f_s) per unit level. Shape: `[n]`.
    pub force: Vec<c64>,
    /// Number of contact pairs.
    pub n_contacts: usize,
}

/// Damping in modal coordinates.
#[derive(Debug, Clone)]
pub enum ModalDamping {
    /// Ĉ is diagonal. Shape: `[n]`.
    Diagonal(Vec<f64>),
    /// Ĉ couples the modes. Shape: n × n.
    Coupled(Mat<f64>),
}

/// Factorised dynamic stiffness Λ − Ω² + iΩ Ĉ of the free structure at Ω = kω.
#[derive(Debug)]
pub enum FreeImpedance {
    /// Reciprocals of the diagonal.
    Diagonal(Vec<c64>),
    /// LU factors.
    Coupled(PartialPivLu<c64>),
}

impl ModalModel {
    /// Solves the free eigenproblem and transforms everything.
    ///
    /// # Errors
    /// [`ProblemError::Eigen`] if M is not positive definite or the eigensolver fails.
    pub fn new(model: &ReducedModel) -> Result<Self, ProblemError> {
        let (lambda, modes) = 
            symmetric_generalized_eigen(model.stiffness.as_ref(), model.mass.as_ref())?;
        let pairs = &model.contacts;
        let rows: Vec<&SparseRow> = (pairs.iter().map(|p| &p.t1))
            .chain(pairs.iter().map(|p| &p.t2))
            .chain(pairs.iter().map(|p| &p.n))
            .collect();
        let responses: Vec<&SparseRow> = model.responses.iter().map(|r| &r.row).collect();
        let congruent = |a: &Mat<f64>| modes.transpose() * a * &modes;
        let project = |f: &[f64]| -> Vec<f64> {
            let f = Col::from_fn(f.len(), |i| f[i]);
            (modes.transpose() * f).iter().copied().collect()
        };
        let (cosine, sine) = (project(&model.cosine_force), project(&model.sine_force));
        Ok(Self {
            lambda,
            damping: ModalDamping::new(congruent(&model.damping)),
            retention: model.retention.as_ref().map(congruent),
            contact: rows_times_modes(&rows, &modes),
            response: rows_times_modes(&responses, &modes),
            static_force: project(&model.static_force),
            force: (cosine.iter().zip(&sine))
                .map(|(&c, &s)| c64::new(c, -s))
                .collect(),
            n_contacts: pairs.len(),
        })
    }

    /// Number of modes n.
    #[must_use]
    pub fn n_modes(&self) -> usize {
        self.lambda.len()
    }

    /// Number of relative displacements, 3 per contact pair.
    #[must_use]
    pub fn n_relative(&self) -> usize {
        3 * self.n_contacts
    }

    /// Dynamic stiffness of the free structure at the angular frequency `omega` (rad/s).
    #[must_use]
    pub fn impedance(&self, omega: f64) -> FreeImpedance {
        match &self.damping {
            ModalDamping::Diagonal(c) => FreeImpedance::Diagonal(
                (self.lambda.iter().zip(c))
                    .map(|(&lambda, &c)| c64::new(lambda - omega * omega, omega * c).inv())
                    .collect(),
            ),
            ModalDamping::Coupled(c) => {
                let z = Mat::from_fn(self.n_modes(), self.n_modes(), |i, j| {
                    let real = if i == j { self.lambda[i] - omega * omega } else { 0.0 };
                    c64::new(real, omega * c[(i, j)])
                });
                FreeImpedance::Coupled(z.partial_piv_lu())
            }
        }
    }

    /// (dZ/dω) η for harmonic k at ω: (−2k²ω + ik Ĉ) η.
    #[must_use]
    pub fn impedance_slope(&self, k: usize, omega: f64, eta: &[c64]) -> Vec<c64> {
        let k = k as f64;
        (self.damping.apply(eta).iter().zip(eta))
            .map(|(c_eta, eta)| eta * (-2.0 * k * k * omega) + c64::new(0.0, k) * c_eta)
            .collect()
    }

    /// B Φ η. Shape: `[n]` → `[3·n_contacts]`.
    #[must_use]
    pub fn relative(&self, eta: &[c64]) -> Vec<c64> {
        rows_apply(&self.contact, eta)
    }

    /// Response coordinates of η. Shape: `[n]` → `[n_responses]`.
    #[must_use]
    pub fn responses(&self, eta: &[c64]) -> Vec<c64> {
        rows_apply(&self.response, eta)
    }

    /// Φᵀ Bᵀ f. Shape: `[3·n_contacts]` → `[n]`.
    #[must_use]
    pub fn modal_contact_force(&self, force: &[c64]) -> Vec<c64> {
        (0..self.n_modes())
            .map(|j| (self.contact.col(j).iter().zip(force)).map(|(b, f)| f * *b).sum())
            .collect()
    }
}

impl ModalDamping {
    fn new(full: Mat<f64>) -> Self {
        let n = full.nrows();
        let largest = (0..n).map(|i| full[(i, i)]).fold(0.0, f64::max);
        let floor = largest * f64::EPSILON * n as f64;
        let diagonal = (0..n).all(|i| {
            (0..i).all(|j| {
                let neighbours = (full[(i, i)].abs() * full[(j, j)].abs()).sqrt();
                full[(i, j)].abs() <= DIAGONAL_TOLERANCE * neighbours + floor
            })
        });
        if diagonal {
            Self::Diagonal((0..n).map(|i| full[(i, i)]).collect())
        } else {
            Self::Coupled(full)
        }
    }

    /// Ĉ η.
    #[must_use]
    pub fn apply(&self, eta: &[c64]) -> Vec<c64> {
        match self {
            Self::Diagonal(c) => eta.iter().zip(c).map(|(eta, c)| eta * *c).collect(),
            Self::Coupled(c) => rows_apply(c, eta),
        }
    }
}

impl FreeImpedance {
    /// Z⁻¹ x. Shape: `[n]`.
    #[must_use]
    pub fn solve(&self, x: &[c64]) -> Vec<c64> {
        match self {
            Self::Diagonal(inverse) => x.iter().zip(inverse).map(|(x, d)| x * d).collect(),
            Self::Coupled(lu) => {
                let x = Col::from_fn(x.len(), |i| x[i]);
                lu.solve(x).iter().copied().collect()
            }
        }
    }

    /// Receptance L Z⁻¹ Lᵀ for a real L. Shape: m × n → (real part, imaginary part), m × m each.
    #[must_use]
    pub fn receptance(&self, l: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
        let (m, n) = (l.nrows(), l.ncols());
        match self {
            Self::Diagonal(inverse) => {
                let real = Mat::from_fn(m, n, |i, j| l[(i, j)] * inverse[j].re);
                let imaginary = Mat::from_fn(m, n, |i, j| l[(i, j)] * inverse[j].im);
                (real * l.transpose(), imaginary * l.transpose())
            }
            Self::Coupled(lu) => {
                let columns = lu.solve(Mat::from_fn(n, m, |i, j| c64::new(l[(j, i)], 0.0)));
                let part = |f: fn(&c64) -> f64| l * Mat::from_fn(n, m, |i, j| f(&columns[(i, j)]));
                (part(|z| z.re), part(|z| z.im))
            }
        }
    }
}

fn rows_times_modes(rows: &[&SparseRow], modes: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(rows.len(), modes.ncols(), |i, j| {
        rows[i].iter().map(|&(dof, weight)| weight * modes[(dof, j)]).sum()
    })
}

/// A x of a real matrix and a complex vector, column by column.
fn rows_apply(a: &Mat<f64>, x: &[c64]) -> Vec<c64> {
    let mut y = vec![c64::new(0.0, 0.0); a.nrows()];
    for (j, x) in x.iter().enumerate() {
        for (y, a) in y.iter_mut().zip(a.col(j).iter()) {
            *y += x * *a;
        }
    }
    y
}
