//! A tuned disk under an engine order: each harmonic is a travelling wave, and one sector has all of it.
//!
//! The excitation of engine order r reaches the next sector later by 2π r/N of its phase. The balance equations then have
//! solutions in which all sectors do the same, one after the other: harmonic k is the wave k r mod N
//! ([`crate::model::disk`]). The contacts of one sector are the only unknowns. Their law is evaluated in time as ever; the
//! phase to the next sector is a factor of each harmonic, and so exact for any N and r.
//!
//! Waves of the same nodal diameter in opposite directions have the same frequencies and conjugate modes. Solutions in which
//! sectors differ by more than their phase are not found.

use super::linear::{Coupling, LinearModel, ModalPart, Structure};
use crate::hb::ProblemError;
use crate::linalg::symmetric_generalized_eigen;
use crate::model::disk::{Disk, WaveModel};
use faer::prelude::*;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

impl LinearModel {
    /// One sector of `disk` under an engine order, at least 1.
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub fn travelling_wave(disk: &Disk, engine_order: usize) -> Result<Self, ProblemError> {
        assert!(engine_order > 0, "engine order 0 is no vibration");
        // harmonics k and k + period have the same wave
        let period = (1..=disk.n_sectors).find(|&k| disk.wave_of(engine_order, k) == 0);
        let mut found: BTreeMap<usize, WaveModes> = BTreeMap::new();
        let mut parts = Vec::new();
        for harmonic in 0..period.unwrap_or(1) {
            let wave = disk.wave_of(engine_order, harmonic);
            if disk.stands(wave) {
                parts.push(ModalPart::new(&disk.standing(wave), 1.0)?.0);
                continue;
            }
            let forward = disk.nodal_diameter(wave);
            // where only contacts couple the sectors, every wave has the same modes
            let same = if disk.is_uncoupled() { 1 } else { forward };
            let modes = match found.entry(same) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => entry.insert(WaveModes::new(&disk.wave(same))?),
            };
            let model = disk.wave(wave);
            let excited = harmonic == 1;
            parts.push(match wave == forward {
                true => modes.part(&model, excited),
                false => modes.conjugate().part(&model, excited),
            });
        }
        Ok(Self {
            floats: parts.iter().any(|part| part.structure.floats()),
            parts,
            breaking: None,
            sector: true,
            pairs: (0..disk.contacts.len()).collect(),
            alternates: false,
        })
    }
}

/// The modes of a wave.
struct WaveModes {
    structure: Structure,
    /// Φ.
    phi: Mat<c64>,
}

impl WaveModes {
    fn new(model: &WaveModel) -> Result<Self, ProblemError> {
        let (lambda, phi) =
            symmetric_generalized_eigen(model.stiffness.as_ref(), model.mass.as_ref())?;
        let damping: Mat<c64> = phi.adjoint() * &model.damping * &phi;
        let n = lambda.len();
        // differences between the triangles are round-off of the largest entries
        let damping = Mat::from_fn(n, n, |i, j| {
            (damping[(i, j)] + damping[(j, i)].conj()) * 0.5
        });
        let structure = Structure {
            damping: (0..n).map(|i| damping[(i, i)].re).collect(),
            coupling: Coupling::of(&damping.into()),
            lambda,
        };
        Ok(Self { structure, phi })
    }

    /// Those of the wave in the other direction.
    fn conjugate(&self) -> Self {
        let mut structure = self.structure.clone();
        if let Some(imaginary) = &mut structure.coupling.damping.imaginary {
            *imaginary *= Scale(-1.0);
        }
        Self {
            structure,
            phi: self.phi.conjugate().to_owned(),
        }
    }

    /// A sector in these modes. What holds it at rest is left out of a wave that the excitation is not in.
    fn part(&self, model: &WaveModel, excited: bool) -> ModalPart {
        let phi = &self.phi;
        let force = phi.adjoint() * Col::from_fn(phi.nrows(), |i| model.force[i]);
        let retention = model.retention.as_ref().filter(|_| excited);
        ModalPart {
            structure: self.structure.clone(),
            retention: retention.map(|k| (phi.adjoint() * k * phi).into()),
            contact: rows_times(&model.contacts, phi).into(),
            multiplicity: 1.0,
            response: rows_times(&model.responses, phi).into(),
            static_force: Vec::new(),
            loads: Vec::new(),
            force: force.iter().copied().collect(),
        }
    }
}

fn rows_times(rows: &[Vec<(usize, c64)>], phi: &Mat<c64>) -> Mat<c64> {
    Mat::from_fn(rows.len(), phi.ncols(), |i, j| {
        let products = rows[i].iter().map(|&(dof, weight)| weight * phi[(dof, j)]);
        products.sum::<c64>()
    })
}
