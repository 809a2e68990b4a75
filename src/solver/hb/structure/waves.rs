//! A tuned disk under an engine order: each harmonic is a travelling wave, and one sector has all of it.
//!
//! The excitation of engine order r reaches the next sector later by 2π r/N of its phase. The balance equations then have
//! solutions in which all sectors do the same, one after the other: harmonic k is the wave k r mod N
//! ([`crate::model::disk`]). The contacts of one sector are the only unknowns. Their law is evaluated in time as ever; the
//! phase to the next sector is a factor of each harmonic, and so exact for any N and r.
//!
//! Waves of the same nodal diameter in opposite directions have the same frequencies and conjugate modes. Solutions in which
//! sectors differ by more than their phase are not found. Disturbances of a solution may be any waves: [`TunedRing`] has them all.

use super::linear::{Coupling, LinearModel, ModalPart, Structure, TunedRing};
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
        let mut found = BTreeMap::new();
        let parts = (0..period.unwrap_or(1)).map(|harmonic| {
            let wave = disk.wave_of(engine_order, harmonic);
            part_of_wave(disk, wave, harmonic == 1, &mut found)
        });
        let parts: Vec<ModalPart> = parts.collect::<Result<_, _>>()?;
        Ok(Self {
            floats: parts.iter().any(|part| part.structure.floats()),
            parts,
            breaking: None,
            ring: Some(TunedRing::new(disk, engine_order)),
            pairs: (0..disk.contacts.len()).collect(),
            alternates: false,
        })
    }
}

/// A sector in a wave; `found` are the modes of waves so far. What holds the sector at rest is left out of a wave that travels and that the
/// excitation is not in.
fn part_of_wave(
    disk: &Disk,
    wave: usize,
    excited: bool,
    found: &mut BTreeMap<usize, WaveModes>,
) -> Result<ModalPart, ProblemError> {
    if disk.stands(wave) {
        return Ok(ModalPart::new(&disk.standing(wave), 1.0)?.0);
    }
    let forward = disk.nodal_diameter(wave);
    // where only contacts couple the sectors, every wave has the same modes
    let same = if disk.is_uncoupled() { 1 } else { forward };
    let modes = match found.entry(same) {
        Entry::Occupied(entry) => entry.into_mut(),
        Entry::Vacant(entry) => entry.insert(WaveModes::new(&disk.wave(same))?),
    };
    let model = disk.wave(wave);
    Ok(match wave == forward {
        true => modes.part(&model, excited),
        false => modes.conjugate().part(&model, excited),
    })
}

impl TunedRing {
    /// A sector in the waves 0 to N/2; `None` if an eigenvalue iteration fails.
    #[must_use]
    pub fn waves(&self) -> Option<Vec<ModalPart>> {
        let parts = self.waves.get_or_init(|| {
            let mut found = BTreeMap::new();
            let waves = 0..=self.disk.n_sectors / 2;
            let parts = waves.map(|wave| part_of_wave(&self.disk, wave, false, &mut found));
            parts.collect::<Result<_, _>>().ok()
        });
        let mut parts = parts.clone()?;
        for part in &mut parts {
            part.scale_damping(self.damping);
        }
        Some(parts)
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
