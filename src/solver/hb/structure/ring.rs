//! All sectors of a disk together, in real coordinates: the modes of its waves, each as one or two patterns over the sectors.
//!
//! A travelling wave with the mode φ moves sector j by Re(f φ e^(−iθj)). Its cosine and its sine pattern, f = √(2/N) and −i √(2/N),
//! have unit modal mass and are orthogonal to each other and to those of other waves; a wave that stands has one pattern, √(1/N).
//! Where only contacts couple the sectors, all waves have the same modes, and each sector is a pattern of its own: the contact rows then
//! have few entries.

use super::linear::rows_of_pairs;
use crate::hb::ProblemError;
use crate::linalg::{Scalar, symmetric_generalized_eigen};
use crate::model::SparseRow;
use crate::model::disk::Disk;
use faer::prelude::*;
use std::f64::consts::TAU;

/// The modes of some waves that have the same matrices.
#[derive(Debug, Clone)]
struct Family {
    /// Squared natural frequencies, ascending.
    lambda: Vec<f64>,
    /// Φ of one sector.
    phi: Mat<c64>,
    /// Φᴴ C Φ.
    damping: Mat<c64>,
    /// Φᴴ K₀ Φ.
    retention: Option<Mat<c64>>,
    patterns: Vec<Pattern>,
}

/// How the sectors share in a mode.
#[derive(Debug, Clone)]
struct Pattern {
    /// What the patterns of one wave differ by; zero where patterns have no sector in common.
    phase: Option<c64>,
    /// Factor f of each sector: it moves by Re(f φ).
    at: Vec<c64>,
}

/// A coordinate of the ring: a mode of a family in one of its patterns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Coordinate {
    family: usize,
    pattern: usize,
    mode: usize,
}

/// The modes of the whole ring.
#[derive(Debug, Clone)]
pub(super) struct RingModes {
    families: Vec<Family>,
}

impl RingModes {
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub(super) fn new(disk: &Disk) -> Result<Self, ProblemError> {
        let n = disk.n_sectors;
        let families = match disk.is_uncoupled() {
            true => vec![Family::standing(disk, 0, Pattern::of_sectors(n))?],
            false => (0..=n / 2)
                .map(|wave| match disk.stands(wave) {
                    true => Family::standing(disk, wave, vec![Pattern::of_wave(n, wave, 1.0, 1.0)]),
                    false => Family::travelling(disk, wave),
                })
                .collect::<Result<_, ProblemError>>()?,
        };
        Ok(Self { families })
    }

    /// Its coordinates of modes with squared frequencies from `low` to `high`.
    pub(super) fn coordinates(&self, [low, high]: [f64; 2]) -> Vec<Coordinate> {
        let mut found = Vec::new();
        for (family, of) in self.families.iter().enumerate() {
            for pattern in 0..of.patterns.len() {
                let modes = (0..of.lambda.len()).filter(|&m| (low..=high).contains(&of.lambda[m]));
                found.extend(modes.map(|mode| Coordinate {
                    family,
                    pattern,
                    mode,
                }));
            }
        }
        found
    }

    /// Squared natural frequency of a coordinate.
    pub(super) fn lambda(&self, of: Coordinate) -> f64 {
        self.families[of.family].lambda[of.mode]
    }

    /// Displacement of a degree of freedom of a sector per unit of a coordinate.
    pub(super) fn displacement(&self, of: Coordinate, sector: usize, dof: usize) -> f64 {
        let family = &self.families[of.family];
        (family.patterns[of.pattern].at[sector] * family.phi[(dof, of.mode)]).re
    }

    /// Whether a coordinate moves a sector.
    pub(super) fn moves(&self, of: Coordinate, sector: usize) -> bool {
        self.families[of.family].patterns[of.pattern].at[sector].norm_sqr() > 0.0
    }

    /// What a matrix of the sectors has among the coordinates; `of` gives it in the modes of a family.
    fn among(
        &self,
        coordinates: &[Coordinate],
        of: impl Fn(&Family) -> Option<&Mat<c64>>,
    ) -> Mat<f64> {
        let n = coordinates.len();
        Mat::from_fn(n, n, |i, j| {
            let (a, b) = (coordinates[i], coordinates[j]);
            if a.family != b.family {
                return 0.0;
            }
            let family = &self.families[a.family];
            let phases = [a, b].map(|c| family.patterns[c.pattern].phase);
            let turn = match phases {
                [Some(a), Some(b)] => a.conj() * b,
                _ if a.pattern == b.pattern => c64::new(1.0, 0.0),
                _ => return 0.0,
            };
            of(family).map_or(0.0, |matrix| (turn * matrix[(a.mode, b.mode)]).re)
        })
    }

    /// Ĉ among the coordinates.
    pub(super) fn damping(&self, coordinates: &[Coordinate]) -> Mat<f64> {
        let damping = self.among(coordinates, |family| Some(&family.damping));
        // differences between the triangles are round-off of the largest entries
        Scale(0.5) * (damping.transpose() + &damping)
    }

    /// Φᵀ K₀ Φ among the coordinates.
    pub(super) fn retention(&self, coordinates: &[Coordinate]) -> Option<Mat<f64>> {
        let held = self
            .families
            .iter()
            .any(|family| family.retention.is_some());
        held.then(|| self.among(coordinates, |family| family.retention.as_ref()))
    }

    /// What a matrix of sector `sector` alone has among the coordinates.
    pub(super) fn of_sector(
        &self,
        coordinates: &[Coordinate],
        sector: usize,
        matrix: &Mat<f64>,
    ) -> Mat<f64> {
        let shapes = Mat::from_fn(matrix.nrows(), coordinates.len(), |dof, j| {
            self.displacement(coordinates[j], sector, dof)
        });
        shapes.transpose() * (matrix * &shapes)
    }

    /// Linear forms on the displacements of every sector and the next one, sector by sector. Shape: N·rows × coordinates.
    fn rows(&self, disk: &Disk, coordinates: &[Coordinate], rows: &[&SparseRow]) -> Mat<f64> {
        let (n, named) = (disk.n_sectors, disk.dof_names.len());
        Mat::from_fn(n * rows.len(), coordinates.len(), |i, j| {
            let sector = i / rows.len();
            let entry = |&(dof, weight): &(usize, f64)| match dof < named {
                true => weight * self.displacement(coordinates[j], sector, dof),
                false => weight * self.displacement(coordinates[j], (sector + 1) % n, dof - named),
            };
            rows[i % rows.len()].iter().map(entry).sum()
        })
    }

    /// Relative displacements of all pairs, sector by sector: t1 of every pair, t2, n.
    pub(super) fn contacts(&self, disk: &Disk, coordinates: &[Coordinate]) -> Mat<f64> {
        let [t1, t2, n] =
            rows_of_pairs(&disk.contacts).map(|rows| self.rows(disk, coordinates, &rows));
        let each = t1.nrows();
        Mat::from_fn(3 * each, coordinates.len(), |i, j| match i / each {
            0 => t1[(i, j)],
            1 => t2[(i - each, j)],
            _ => n[(i - 2 * each, j)],
        })
    }

    /// The first response of every sector.
    pub(super) fn responses(&self, disk: &Disk, coordinates: &[Coordinate]) -> Mat<f64> {
        let first: Vec<&SparseRow> = disk.responses.iter().take(1).map(|r| &r.row).collect();
        self.rows(disk, coordinates, &first)
    }

    /// A force on the sectors in the coordinates; `of` gives that on sector `j` at a degree of freedom.
    pub(super) fn force(
        &self,
        disk: &Disk,
        coordinates: &[Coordinate],
        of: impl Fn(usize, usize) -> c64,
    ) -> Vec<c64> {
        let named = disk.dof_names.len();
        let sectors = 0..disk.n_sectors;
        let loaded: Vec<(usize, usize, c64)> = sectors
            .flat_map(|sector| (0..named).map(move |dof| (sector, dof)))
            .map(|(sector, dof)| (sector, dof, of(sector, dof)))
            .filter(|(.., force)| force.norm_sqr() > 0.0)
            .collect();
        let along = |&c: &Coordinate| {
            let works = loaded.iter();
            let works = works.map(|&(sector, dof, f)| f * self.displacement(c, sector, dof));
            works.sum::<c64>()
        };
        coordinates.iter().map(along).collect()
    }

    /// The excitation by an engine order, per unit level.
    pub(super) fn excitation(
        &self,
        disk: &Disk,
        engine_order: usize,
        coordinates: &[Coordinate],
    ) -> Vec<c64> {
        self.force(disk, coordinates, |sector, dof| {
            let unit = c64::new(disk.cosine_force[dof], -disk.sine_force[dof]);
            unit * turn(disk.n_sectors, engine_order, sector)
        })
    }
}

impl Family {
    /// A wave that stands, in these patterns.
    fn standing(disk: &Disk, wave: usize, patterns: Vec<Pattern>) -> Result<Self, ProblemError> {
        let model = disk.standing(wave);
        let matrices = [&model.stiffness, &model.mass, &model.damping];
        Self::new(matrices, model.retention.as_ref(), patterns)
    }

    /// A wave that travels: in its cosine and its sine pattern it does so in both directions.
    fn travelling(disk: &Disk, wave: usize) -> Result<Self, ProblemError> {
        let model = disk.wave(wave);
        let n = disk.n_sectors;
        let root = std::f64::consts::SQRT_2;
        let cosine = Pattern::of_wave(n, wave, root, c64::new(1.0, 0.0));
        let sine = Pattern::of_wave(n, wave, root, c64::new(0.0, -1.0));
        let matrices = [&model.stiffness, &model.mass, &model.damping];
        Self::new(matrices, model.retention.as_ref(), vec![cosine, sine])
    }

    fn new<E: Scalar>(
        [stiffness, mass, damping]: [&Mat<E>; 3],
        retention: Option<&Mat<E>>,
        patterns: Vec<Pattern>,
    ) -> Result<Self, ProblemError>
    where
        c64: From<E>,
    {
        let (lambda, phi) = symmetric_generalized_eigen(stiffness.as_ref(), mass.as_ref())?;
        let complex = |a: &Mat<E>| Mat::from_fn(a.nrows(), a.ncols(), |i, j| c64::from(a[(i, j)]));
        let phi = complex(&phi);
        let projected = |a: &Mat<E>| phi.adjoint() * complex(a) * &phi;
        Ok(Self {
            damping: projected(damping),
            retention: retention.map(projected),
            lambda,
            phi,
            patterns,
        })
    }
}

impl Pattern {
    /// One for each sector.
    fn of_sectors(n: usize) -> Vec<Self> {
        let at = |i: usize| {
            (0..n)
                .map(|j| c64::from(f64::from(u8::from(i == j))))
                .collect()
        };
        let pattern = |i| Self {
            phase: None,
            at: at(i),
        };
        (0..n).map(pattern).collect()
    }

    /// A wave, `scale`/√N of it.
    fn of_wave(n: usize, wave: usize, scale: f64, phase: impl Into<c64>) -> Self {
        let phase = phase.into();
        let size = scale / (n as f64).sqrt();
        Self {
            at: (0..n).map(|j| phase * turn(n, wave, j) * size).collect(),
            phase: Some(phase),
        }
    }
}

/// e^(−2πi w j/N).
fn turn(n: usize, wave: usize, sector: usize) -> c64 {
    let steps = (wave % n) * sector % n;
    let (sin, cos) = libm::sincos(TAU * steps as f64 / n as f64);
    match (4 * steps).is_multiple_of(n) {
        // exact zeros where the angle is a multiple of a quarter turn
        true => c64::new(cos.round(), -sin.round()),
        false => c64::new(cos, -sin),
    }
}
