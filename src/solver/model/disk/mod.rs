//! A tuned disk by one of its sectors: a blade, what belongs to it of the disk, and the strip towards the next blade.
//!
//! All N sectors are equal. In a travelling wave every sector does what the one before it did, later by θ = 2π w/N of the
//! excitation's phase: q̂⁽ʲ⁺¹⁾ = e^(−iθ) q̂⁽ʲ⁾. Harmonic k of the engine order r is such a wave, with w = k r mod N. It has the nodal
//! diameter w, or N − w and travels the other way round. So what acts between a sector and the next one is a matter of the sector alone:
//!
//! ```text
//! K(θ) = own + next e^(−iθ) + nextᵀ e^(iθ),   likewise M, C
//! r̂ = (B_own + B_next e^(−iθ)) q̂              relative displacements of the contact pairs
//! ```
//!
//! Displacements are those along the radius, the axis and the circumference at the sector itself, so that no sector is turned
//! against another. Source: Petrov 2004, J. Turbomach. 126, 175–183, doi 10.1115/1.1644558.

mod nodal_matrices;
mod sector_matrices;

pub use sector_matrices::SectorMatrices;

use super::{ContactPair, ReducedModel, Response, SparseRow};
use crate::contact::ContactParameters;
use crate::linalg::{LinalgError, symmetric_generalized_eigen};
use faer::prelude::*;
use std::f64::consts::TAU;

/// A matrix of the sectors of a disk.
#[derive(Debug, Clone)]
pub enum CyclicMatrix {
    /// Rows of a sector, and its columns (`own`) or those of the next sector (`next`). Shape: n × n, own symmetric.
    Neighbours {
        /// What couples a sector with itself.
        own: Mat<f64>,
        /// What couples a sector with the next one.
        next: Mat<f64>,
    },
    /// Hermitian matrices for the nodal diameters 0 to N/2, reduced for each of them; those for 0 and N/2 are real.
    Nodal(Vec<Mat<c64>>),
}

/// One sector of a disk, with what loads it and looks at it. Units as in [`ReducedModel`].
#[derive(Debug, Clone)]
pub struct Disk {
    /// What the model is, for reports.
    pub name: String,
    /// N.
    pub n_sectors: usize,
    /// One name per degree of freedom that contacts, forces and responses act on: the first ones of the matrices.
    pub dof_names: Vec<String>,
    /// M, positive definite.
    pub mass: CyclicMatrix,
    /// C, positive semidefinite.
    pub damping: CyclicMatrix,
    /// K, positive semidefinite.
    pub stiffness: CyclicMatrix,
    /// Stiffness added in the 0th harmonic only. Shape: as the names.
    pub retention: Option<Mat<f64>>,
    /// Stiffness of the blade alone, held where it meets the rest, in the degrees of freedom of a sector: what deviates from blade to
    /// blade in a mistuned disk. None where it is not known which they are. Shape: as the matrices.
    pub blade_stiffness: Option<Mat<f64>>,
    /// Contact pairs of a sector. The degree of freedom i of the next sector has the number i plus that of the names.
    pub contacts: Vec<ContactPair>,
    /// f₀. Shape: `[names]`.
    pub static_force: Vec<f64>,
    /// Further static forces, each added to f₀ times an input of the sample. Shape: loads × names.
    pub loads: Vec<Vec<f64>>,
    /// f_c per unit level, on sector 0. Shape: `[names]`.
    pub cosine_force: Vec<f64>,
    /// f_s per unit level, on sector 0. Shape: `[names]`.
    pub sine_force: Vec<f64>,
    /// Response coordinates of a sector, numbered as in the contacts; the amplitude of the first one defines resonance.
    pub responses: Vec<Response>,
}

/// A travelling wave: what one sector is in it.
#[derive(Debug, Clone)]
pub struct WaveModel {
    /// M(θ), Hermitian and positive definite. Shape: n × n.
    pub mass: Mat<c64>,
    /// C(θ), Hermitian.
    pub damping: Mat<c64>,
    /// K(θ), Hermitian.
    pub stiffness: Mat<c64>,
    /// Stiffness of the 0th harmonic.
    pub retention: Option<Mat<c64>>,
    /// B(θ): relative contact displacements, t1 of every pair, t2, n.
    pub contacts: Vec<Vec<(usize, c64)>>,
    /// Response coordinates.
    pub responses: Vec<Vec<(usize, c64)>>,
    /// f_c − i f_s. Shape: `[n]`.
    pub force: Vec<c64>,
}

impl Disk {
    /// Number of degrees of freedom of a sector.
    #[must_use]
    pub fn n_dofs(&self) -> usize {
        match &self.mass {
            CyclicMatrix::Neighbours { own, .. } => own.nrows(),
            CyclicMatrix::Nodal(matrices) => matrices.first().map_or(0, Mat::nrows),
        }
    }

    /// The wave of harmonic `k` of an engine order: its phase from one sector to the next is 2π/N times this number, 0 to N − 1.
    #[must_use]
    pub fn wave_of(&self, engine_order: usize, k: usize) -> usize {
        (k % self.n_sectors) * (engine_order % self.n_sectors) % self.n_sectors
    }

    /// Nodal diameter of a wave: 0 to N/2.
    #[must_use]
    pub fn nodal_diameter(&self, wave: usize) -> usize {
        wave.min(self.n_sectors - wave)
    }

    /// Whether the nodal pattern of a wave stands still: all sectors together, or each against its neighbours.
    #[must_use]
    pub fn stands(&self, wave: usize) -> bool {
        (2 * wave).is_multiple_of(self.n_sectors)
    }

    /// Whether only contacts couple the sectors.
    #[must_use]
    pub fn is_uncoupled(&self) -> bool {
        [&self.mass, &self.damping, &self.stiffness]
            .iter()
            .all(|matrix| matrix.is_uncoupled())
    }

    /// A sector in a wave that stands ([`Disk::stands`]): an ordinary model.
    #[must_use]
    pub fn standing(&self, wave: usize) -> ReducedModel {
        assert!(
            self.stands(wave),
            "wave {wave} of {} travels",
            self.n_sectors
        );
        let real = |a: &CyclicMatrix| {
            let a = a.at(wave, self.n_sectors);
            Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].re)
        };
        let mass = real(&self.mass);
        let n = mass.nrows();
        let padded = |f: &Vec<f64>| (0..n).map(|i| f.get(i).copied().unwrap_or(0.0)).collect();
        let row = |row: &SparseRow| -> SparseRow {
            let turned = self.row(row, wave).into_iter();
            turned.map(|(i, weight)| (i, weight.re)).collect()
        };
        let named = self.dof_names.len();
        let modes = (named..n).map(|i| format!("mode{}", i - named));
        ReducedModel {
            name: self.name.clone(),
            dof_names: self.dof_names.iter().cloned().chain(modes).collect(),
            damping: real(&self.damping),
            stiffness: real(&self.stiffness),
            retention: self
                .retention
                .as_ref()
                .map(|k| Mat::from_fn(n, n, |i, j| if i.max(j) < named { k[(i, j)] } else { 0.0 })),
            contacts: (self.contacts.iter())
                .map(|pair| ContactPair {
                    t1: row(&pair.t1),
                    t2: row(&pair.t2),
                    n: row(&pair.n),
                    ..pair.clone()
                })
                .collect(),
            static_force: padded(&self.static_force),
            loads: self.loads.iter().map(padded).collect(),
            cosine_force: padded(&self.cosine_force),
            sine_force: padded(&self.sine_force),
            responses: (self.responses.iter())
                .map(|response| Response {
                    name: response.name.clone(),
                    row: row(&response.row),
                })
                .collect(),
            mirror: None,
            mass,
        }
    }

    /// A sector in a wave.
    #[must_use]
    pub fn wave(&self, wave: usize) -> WaveModel {
        let at = |a: &CyclicMatrix| a.at(wave, self.n_sectors);
        let mass = at(&self.mass);
        let (n, named) = (mass.nrows(), self.dof_names.len());
        let rows = |of: fn(&ContactPair) -> &SparseRow| {
            self.contacts
                .iter()
                .map(move |pair| self.row(of(pair), wave))
        };
        let force = |i: usize| match i < named {
            true => c64::new(self.cosine_force[i], -self.sine_force[i]),
            false => c64::from(0.0),
        };
        WaveModel {
            damping: at(&self.damping),
            stiffness: at(&self.stiffness),
            retention: self.retention.as_ref().map(|k| {
                let entry = |i, j| {
                    if i < named && j < named {
                        k[(i, j)]
                    } else {
                        0.0
                    }
                };
                Mat::from_fn(n, n, |i, j| c64::from(entry(i, j)))
            }),
            contacts: (rows(|pair| &pair.t1).chain(rows(|pair| &pair.t2)))
                .chain(rows(|pair| &pair.n))
                .collect(),
            responses: (self.responses.iter())
                .map(|response| self.row(&response.row, wave))
                .collect(),
            force: (0..n).map(force).collect(),
            mass,
        }
    }

    /// Natural angular frequencies (rad/s) of a wave, ascending: without contact forces, or with contacts that stick. Shape:
    /// `stuck` `[contacts]`.
    ///
    /// # Errors
    /// [`LinalgError`] if the matrices are not what the model promises.
    pub fn frequencies(
        &self,
        wave: usize,
        stuck: Option<&[ContactParameters<f64>]>,
    ) -> Result<Vec<f64>, LinalgError> {
        let WaveModel {
            mass,
            mut stiffness,
            contacts,
            ..
        } = self.wave(wave);
        let constants = stuck.unwrap_or(&[]);
        let springs = (constants.iter().map(|c| c.k_t[0]))
            .chain(constants.iter().map(|c| c.k_t[1]))
            .chain(constants.iter().map(|c| c.k_n));
        for (row, k) in contacts.iter().zip(springs) {
            for &(i, a) in row {
                row.iter()
                    .for_each(|&(j, b)| stiffness[(i, j)] += a.conj() * b * k);
            }
        }
        let (lambda, _) = symmetric_generalized_eigen(stiffness.as_ref(), mass.as_ref())?;
        Ok(lambda.iter().map(|l| l.max(0.0).sqrt()).collect())
    }

    /// The disk with all contacts stuck: springs take their place. Shape: `stuck` `[contacts]`.
    #[must_use]
    pub fn with_stuck_contacts(&self, stuck: &[ContactParameters<f64>]) -> Self {
        let mut disk = self.clone();
        let springs = |of: fn(&ContactPair) -> &SparseRow,
                       k: fn(&ContactParameters<f64>) -> f64| {
            let rows = self.contacts.iter().map(of);
            rows.zip(stuck.iter().map(k))
        };
        let rows = springs(|pair| &pair.t1, |c| c.k_t[0])
            .chain(springs(|pair| &pair.t2, |c| c.k_t[1]))
            .chain(springs(|pair| &pair.n, |c| c.k_n));
        for (row, k) in rows {
            disk.stiffness.add_spring(row, k, self);
        }
        disk.contacts.clear();
        disk
    }

    /// A linear form in a wave: the next sector's displacements are those of this one, later.
    fn row(&self, row: &SparseRow, wave: usize) -> Vec<(usize, c64)> {
        let (named, turn) = (self.dof_names.len(), turn(wave, self.n_sectors));
        let mut entries: Vec<(usize, c64)> = Vec::with_capacity(row.len());
        for &(dof, weight) in row {
            let (dof, weight) = match dof < named {
                true => (dof, c64::from(weight)),
                false => (dof - named, turn * weight),
            };
            match entries.iter_mut().find(|(other, _)| *other == dof) {
                Some((_, sum)) => *sum += weight,
                None => entries.push((dof, weight)),
            }
        }
        entries
    }
}

impl CyclicMatrix {
    /// A matrix of sectors that nothing but contacts couples.
    #[must_use]
    pub fn uncoupled(own: Mat<f64>) -> Self {
        let next = Mat::zeros(own.nrows(), own.ncols());
        Self::Neighbours { own, next }
    }

    /// Whether it couples no sector with another. Matrices of nodal diameters, which are reduced, always count as coupling.
    fn is_uncoupled(&self) -> bool {
        match self {
            Self::Neighbours { next, .. } => next.norm_max() == 0.0,
            Self::Nodal(_) => false,
        }
    }

    /// Adds the spring `k` (N/m) against a linear form on the displacements of a sector of `disk` and the next one.
    fn add_spring(&mut self, row: &SparseRow, k: f64, disk: &Disk) {
        let named = disk.dof_names.len();
        match self {
            Self::Neighbours { own, next } => {
                for &(i, a) in row {
                    for &(j, b) in row {
                        match (i < named, j < named) {
                            (true, true) => own[(i, j)] += k * a * b,
                            (false, false) => own[(i - named, j - named)] += k * a * b,
                            (true, false) => next[(i, j - named)] += k * a * b,
                            // the transpose of the case before
                            (false, true) => {}
                        }
                    }
                }
            }
            Self::Nodal(matrices) => {
                for (wave, matrix) in matrices.iter_mut().enumerate() {
                    let row = disk.row(row, wave);
                    for &(i, a) in &row {
                        (row.iter()).for_each(|&(j, b)| matrix[(i, j)] += a.conj() * b * k);
                    }
                }
            }
        }
    }

    /// The matrix in a wave of `n_sectors`.
    fn at(&self, wave: usize, n_sectors: usize) -> Mat<c64> {
        match self {
            Self::Neighbours { own, next } => {
                let turn = turn(wave, n_sectors);
                Mat::from_fn(own.nrows(), own.ncols(), |i, j| {
                    turn * next[(i, j)] + turn.conj() * next[(j, i)] + own[(i, j)]
                })
            }
            Self::Nodal(matrices) if 2 * wave > n_sectors => {
                let mirrored = &matrices[n_sectors - wave];
                Mat::from_fn(mirrored.nrows(), mirrored.ncols(), |i, j| {
                    mirrored[(i, j)].conj()
                })
            }
            Self::Nodal(matrices) => matrices[wave].clone(),
        }
    }
}

/// e^(−iθ) from a sector to the next.
fn turn(wave: usize, n_sectors: usize) -> c64 {
    if wave == 0 {
        return c64::new(1.0, 0.0);
    }
    if 2 * wave == n_sectors {
        return c64::new(-1.0, 0.0);
    }
    let (sin, cos) = libm::sincos(TAU * wave as f64 / n_sectors as f64);
    c64::new(cos, -sin)
}
