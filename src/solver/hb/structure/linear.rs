//! The linear model in the modes of the free structure (all contacts open).
//!
//! With q = Φ η, Φᴴ M Φ = I and Φᴴ K Φ = Λ its equation of motion is η̈ + Ĉ η̇ + Λ η = Φᴴ f, with all modes. At the frequency
//! Ω its dynamic stiffness is Z = Λ − Ω² I + iΩ Ĉ. With modal or proportional damping Ĉ and Z are diagonal, and the inverse
//! takes one division per mode. Other damping couples some of the modes. Φ is real but for the travelling waves of a disk
//! ([`super::waves`]).

use crate::hb::ProblemError;
use crate::linalg::split::SplitMat;
use crate::linalg::{Scalar, symmetric_generalized_eigen};
use crate::model::disk::Disk;
use crate::model::{ContactPair, ReducedModel, SparseRow};
use faer::prelude::*;
use pulp::{Arch, Simd, WithSimd};
use std::sync::{Arc, OnceLock};

/// An off-diagonal entry of Ĉ counts as round-off below this share of its diagonal neighbours, |Ĉᵢⱼ| / √(Ĉᵢᵢ Ĉⱼⱼ).
const ROUND_OFF: f64 = 1e-8;

/// A model in modal coordinates: one [`ModalPart`], or several where harmonics have different structures.
#[derive(Debug, Clone)]
pub struct LinearModel {
    /// Harmonic k belongs to part k mod length: one part for all, one for the even and one for the odd harmonics of a
    /// folded model ([`super::fold`]), or one for each wave of a disk ([`super::waves`]). Part 0 is real.
    pub parts: Vec<ModalPart>,
    /// Of a folded model with one part: the structure for motions that break the mirror symmetry, which only disturbances have.
    pub breaking: Option<ModalPart>,
    /// Contact pairs of the [`ReducedModel`] whose displacements are unknowns; those of the others follow by the mirror.
    pub pairs: Vec<usize>,
    /// Whether the free structure can move as a rigid body, in part or as a whole: such as a strip that only contacts hold.
    pub floats: bool,
    /// Of one sector: the disk, whose other sectors do the same one after the other.
    pub ring: Option<TunedRing>,
    /// Whether the model is folded and the mirror images do the same half a period later.
    pub alternates: bool,
}

/// The disk that a sector belongs to. Its sectors do the same one after the other, but disturbances of that may be waves of every nodal
/// diameter.
#[derive(Debug, Clone)]
pub struct TunedRing {
    /// The disk.
    pub disk: Arc<Disk>,
    /// The engine order that excites it.
    pub engine_order: usize,
    /// Factor on the damping matrix of the disk.
    pub(super) damping: f64,
    /// A sector in the waves 0 to N/2, with the damping of the disk; computed when it is asked for.
    pub(super) waves: Arc<OnceLock<Option<Vec<ModalPart>>>>,
}

impl TunedRing {
    /// The ring of `disk` under an engine order.
    pub(super) fn new(disk: &Disk, engine_order: usize) -> Self {
        Self {
            disk: Arc::new(disk.clone()),
            engine_order,
            damping: 1.0,
            waves: Arc::default(),
        }
    }
}

/// The linear structure for one class of harmonics, in coordinates η: matrices, contact, load and response vectors.
#[derive(Debug, Clone)]
pub struct ModalPart {
    /// Stiffness and damping of the free structure.
    pub structure: Structure,
    /// Φᴴ K₀ Φ, a stiffness that acts on harmonic 0 only.
    pub retention: Option<SplitMat>,
    /// B Φ: η → relative contact displacements. Shape: 3·n_contacts × n, rows ordered t1 of every pair, t2, n.
    pub contact: SplitMat,
    /// Number of contacts that each pair stands for: 2 with its mirror image, else 1.
    pub multiplicity: f64,
    /// η → response coordinates. Shape: n_responses × n.
    pub response: SplitMat,
    /// Φᵀ f₀. Shape: `[n]`; empty in a part that harmonic 0 does not belong to.
    pub static_force: Vec<f64>,
    /// Φᵀ f of each load that is an input. Shape: loads × n; empty in a part that harmonic 0 does not belong to.
    pub loads: Vec<Vec<f64>>,
    /// Φᴴ (f_c − i f_s) per unit level. Shape: `[n]`.
    pub force: Vec<c64>,
}

/// The free structure in its modes.
#[derive(Debug, Clone)]
pub struct Structure {
    /// Λ, squared natural frequencies ((rad/s)²), ascending. Shape: `[n]`.
    pub lambda: Vec<f64>,
    /// Diagonal of Ĉ (1/s). Shape: `[n]`.
    pub damping: Vec<f64>,
    /// Ĉ beside the diagonal.
    pub coupling: Coupling,
}

/// Damping beside the diagonal.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// Modes that are coupled to any other, ascending; none for classical damping.
    pub modes: Vec<usize>,
    /// Ĉ among them (1/s) with zeros on the diagonal. Shape: modes × modes.
    pub damping: SplitMat,
}

impl LinearModel {
    /// The whole model: all pairs are unknowns.
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub fn new(model: &ReducedModel) -> Result<Self, ProblemError> {
        let (part, floats) = ModalPart::new(model, 1.0)?;
        Ok(Self {
            parts: vec![part],
            breaking: None,
            ring: None,
            pairs: (0..model.n_contacts()).collect(),
            floats,
            alternates: false,
        })
    }

    /// Multiplies the damping matrix by `factor`.
    pub fn scale_damping(&mut self, factor: f64) {
        for part in self.parts.iter_mut().chain(&mut self.breaking) {
            part.scale_damping(factor);
        }
        if let Some(ring) = &mut self.ring {
            ring.damping *= factor;
        }
    }

    /// The part for harmonic k.
    #[must_use]
    pub fn part(&self, k: usize) -> &ModalPart {
        &self.parts[k % self.parts.len()]
    }

    /// Number of contact pairs that are unknowns.
    #[must_use]
    pub fn n_contacts(&self) -> usize {
        self.pairs.len()
    }

    /// Number of relative displacements, 3 per contact pair.
    #[must_use]
    pub fn n_relative(&self) -> usize {
        3 * self.n_contacts()
    }
}

impl ModalPart {
    /// Transforms matrices and vectors to the modes; also returns whether the free structure can move as a rigid body.
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub(in crate::hb) fn new(
        model: &ReducedModel,
        multiplicity: f64,
    ) -> Result<(Self, bool), ProblemError> {
        let (lambda, modes) =
            symmetric_generalized_eigen(model.stiffness.as_ref(), model.mass.as_ref())?;
        let damping = modes.transpose() * &model.damping * &modes;
        // the code for G needs symmetric matrices; differences between the triangles are round-off of the largest entries
        let damping = Scale(0.5) * (damping.transpose() + &damping);
        let structure = Structure {
            damping: (0..lambda.len()).map(|i| damping[(i, i)]).collect(),
            coupling: Coupling::of(&damping.into()),
            lambda,
        };
        let floats = structure.floats();
        Ok((
            Self::in_modes(model, structure, &modes, multiplicity),
            floats,
        ))
    }

    fn in_modes(
        model: &ReducedModel,
        structure: Structure,
        phi: &Mat<f64>,
        multiplicity: f64,
    ) -> Self {
        let rows = rows_of_pairs(&model.contacts).concat();
        let responses: Vec<&SparseRow> = model.responses.iter().map(|r| &r.row).collect();
        let project = |f: &[f64]| -> Vec<f64> {
            let f = Col::from_fn(f.len(), |i| f[i]);
            (phi.transpose() * f).iter().copied().collect()
        };
        let (cosine, sine) = (project(&model.cosine_force), project(&model.sine_force));
        Self {
            structure,
            retention: (model.retention.as_ref()).map(|k| (phi.transpose() * k * phi).into()),
            contact: rows_times(&rows, phi).into(),
            multiplicity,
            response: rows_times(&responses, phi).into(),
            static_force: project(&model.static_force),
            loads: model.loads.iter().map(|load| project(load)).collect(),
            force: cosine
                .iter()
                .zip(&sine)
                .map(|(&c, &s)| c64::new(c, -s))
                .collect(),
        }
    }

    /// Multiplies the damping matrix by `factor`.
    pub(super) fn scale_damping(&mut self, factor: f64) {
        (self.structure.damping.iter_mut()).for_each(|c| *c *= factor);
        self.structure.coupling.damping.scale(factor);
    }

    /// Number n of coordinates η.
    #[must_use]
    pub fn n_coordinates(&self) -> usize {
        self.force.len()
    }

    /// Whether all of it is real: no travelling wave.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.contact.is_real()
    }

    /// Stiffness of the structure with springs `k` (N/m, shape `[3·n_contacts]`) between the contacts; of a real part.
    #[must_use]
    pub(crate) fn stiffness_with_springs(&self, k: &[f64]) -> Mat<f64> {
        let contact = &self.contact.real;
        held_stiffness(&self.structure.lambda, contact, self.multiplicity, k)
    }

    /// The same of any part, Hermitian.
    #[must_use]
    pub fn wave_stiffness_with_springs(&self, k: &[f64]) -> Mat<c64> {
        let contact = self.contact.complex();
        held_stiffness(&self.structure.lambda, &contact, self.multiplicity, k)
    }

    /// (dZ/dω) η for harmonic k at ω: (−2k²ω + ik Ĉ) η.
    #[must_use]
    pub fn impedance_slope(&self, k: usize, omega: f64, eta: &[c64]) -> Vec<c64> {
        let k = k as f64;
        (self.structure.damp(eta).iter().zip(eta))
            .map(|(c_eta, eta)| eta * (-2.0 * k * k * omega) + c64::new(0.0, k) * c_eta)
            .collect()
    }

    /// B Φ η. Shape: `[n]` → `[3·n_contacts]`.
    #[must_use]
    #[inline(always)]
    pub fn relative(&self, eta: &[c64]) -> Vec<c64> {
        self.contact.times(eta)
    }

    /// Response coordinates of η. Shape: `[n]` → `[n_responses]`.
    #[must_use]
    pub fn responses(&self, eta: &[c64]) -> Vec<c64> {
        self.response.times(eta)
    }

    /// Φᴴ Bᵀ f, the load by the contact forces f (N) and those of the mirror images. Shape: `[3·n_contacts]` → `[n]`.
    #[must_use]
    pub fn contact_load(&self, force: &[c64]) -> Vec<c64> {
        Arch::new().dispatch(ContactLoad { part: self, force })
    }
}

/// The arguments of [`ModalPart::contact_load`], for the instruction set that is found at run time.
struct ContactLoad<'a> {
    part: &'a ModalPart,
    force: &'a [c64],
}

impl WithSimd for ContactLoad<'_> {
    type Output = Vec<c64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<c64> {
        let Self { part, force } = self;
        let [real, imaginary] =
            [|f: &c64| f.re, |f: &c64| f.im].map(|of| force.iter().map(of).collect::<Vec<f64>>());
        // a loop: the code of a closure would not use the instruction set found at run time
        let mut load = Vec::with_capacity(part.n_coordinates());
        for j in 0..part.n_coordinates() {
            load.push(part.contact.adjoint_times(j, [&real, &imaginary]) * part.multiplicity);
        }
        load
    }
}

impl Structure {
    /// Whether it can move as a rigid body.
    pub(in crate::hb) fn floats(&self) -> bool {
        let lambda = &self.lambda;
        let round_off = 10.0 * f64::EPSILON * lambda.len() as f64;
        lambda.first() <= lambda.last().map(|l| round_off * l).as_ref()
    }

    /// Ĉ η.
    #[must_use]
    pub fn damp(&self, eta: &[c64]) -> Vec<c64> {
        let diagonal = eta.iter().zip(&self.damping);
        let mut damped: Vec<c64> = diagonal.map(|(eta, c)| eta * *c).collect();
        (self.coupling).add_product(c64::new(1.0, 0.0), eta, &mut damped);
        damped
    }
}

impl Coupling {
    /// Classical damping.
    pub(in crate::hb) fn none() -> Self {
        Self {
            modes: Vec::new(),
            damping: Mat::<f64>::zeros(0, 0).into(),
        }
    }

    /// The entries beside the diagonal of Ĉ that are more than round-off.
    pub(in crate::hb) fn of(full: &SplitMat) -> Self {
        let n = full.nrows();
        let diagonal = |i: usize| full.real[(i, i)];
        let largest = (0..n).map(diagonal).fold(0.0, f64::max);
        let floor = largest * f64::EPSILON * n as f64;
        let counts = |i: usize, j: usize| {
            let neighbours = (diagonal(i).abs() * diagonal(j).abs()).sqrt();
            i != j && full.entry(i, j).norm() > ROUND_OFF * neighbours + floor
        };
        let modes: Vec<usize> = (0..n).filter(|&i| (0..n).any(|j| counts(i, j))).collect();
        let among = |part: &Mat<f64>| {
            Mat::from_fn(modes.len(), modes.len(), |a, b| match a == b {
                true => 0.0,
                false => part[(modes[a], modes[b])],
            })
        };
        let damping = SplitMat {
            real: among(&full.real),
            imaginary: full.imaginary.as_ref().map(among),
        };
        Self { modes, damping }
    }

    /// y += factor (Ĉ − diag Ĉ) η.
    pub(in crate::hb) fn add_product(&self, factor: c64, eta: &[c64], y: &mut [c64]) {
        let coupled: Vec<c64> = self.modes.iter().map(|&j| eta[j]).collect();
        for (&i, c_eta) in self.modes.iter().zip(self.damping.times(&coupled)) {
            y[i] += factor * c_eta;
        }
    }
}

/// Λ + `multiplicity` Bᴴ K B: the stiffness in coordinates with the diagonal stiffness Λ, with springs `k` (N/m) between the
/// contacts, whose relative displacements are B (`contact`).
pub(in crate::hb) fn held_stiffness<E: Scalar>(
    lambda: &[f64],
    contact: &Mat<E>,
    multiplicity: f64,
    k: &[f64],
) -> Mat<E> {
    let springs = Mat::from_fn(k.len(), lambda.len(), |i, j| {
        contact[(i, j)] * (multiplicity * k[i])
    });
    let mut stiffness = contact.adjoint() * springs;
    for (i, lambda) in lambda.iter().enumerate() {
        stiffness[(i, i)] = E::from(*lambda) + stiffness[(i, i)];
    }
    stiffness
}

/// The linear forms t1 of every pair, t2, n.
pub(super) fn rows_of_pairs(pairs: &[ContactPair]) -> [Vec<&SparseRow>; 3] {
    [
        pairs.iter().map(|p| &p.t1).collect(),
        pairs.iter().map(|p| &p.t2).collect(),
        pairs.iter().map(|p| &p.n).collect(),
    ]
}

fn rows_times(rows: &[&SparseRow], phi: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(rows.len(), phi.ncols(), |i, j| {
        rows[i]
            .iter()
            .map(|&(dof, weight)| weight * phi[(dof, j)])
            .sum()
    })
}
