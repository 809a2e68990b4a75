//! A mistuned disk: blades whose stiffness differs, by a component-mode model.
//!
//! The frequency of blade j alone deviates by the share δ from the nominal one, so that its stiffness has the factor (1 + δ)². In the
//! modes of the tuned ring (`ring`) that is
//!
//! ```text
//! Λ + Σⱼ (2δⱼ + δⱼ²) Φⱼᵀ K_blade Φⱼ
//! ```
//!
//! where Φⱼ are the displacements of sector j: the blade takes part in a mode of the disk by its own modes, held where it meets the
//! disk. Where sectors are coupled and the ring has more than [`MOST_COMBINED`] modes, only a subset of the nominal modes may combine, those
//! with frequencies up to [`NOMINAL`] times the highest one of interest; the others stay those of the tuned disk, and keep its compliance
//! at the contacts. Else nothing is left out. Contacts stay as they are, one set of unknowns for every gap.
//!
//! Sources: Yang & Griffin 2001 (subset of nominal modes), Lim, Bladh, Castanier & Pierre 2007 (component mode mistuning).

use super::linear::{Coupling, LinearModel, ModalPart, Structure};
use super::resonance::Band;
use super::ring::{Coordinate, RingModes};
use crate::hb::ProblemError;
use crate::linalg::{LinalgError, symmetric_eigen};
use crate::model::disk::Disk;
use faer::prelude::*;

/// Highest frequency of the nominal modes that mistuning may combine, over the highest one of interest.
pub const NOMINAL: f64 = 2.0;
/// Most modes of a ring all of which may combine.
pub const MOST_COMBINED: usize = 400;
/// A mode whose stiffness is the blade's by less than this share of the largest one does not combine.
const TAKES_PART: f64 = 1e-14;

/// A ring of sectors whose blades may differ.
#[derive(Debug, Clone)]
pub struct MistunedRing {
    /// The tuned ring.
    part: ModalPart,
    /// Ĉ of the tuned ring.
    damping: Mat<f64>,
    groups: Vec<Group>,
    n_sectors: usize,
}

/// Modes that mistuning may combine with each other.
#[derive(Debug, Clone)]
struct Group {
    /// Their numbers.
    modes: Vec<usize>,
    /// The stiffness of a blade in them, by the number of the blade.
    blades: Vec<(usize, Mat<f64>)>,
}

impl MistunedRing {
    /// All sectors of `disk` under an engine order; `highest` is the highest frequency of interest (rad/s).
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub fn new(disk: &Disk, engine_order: usize, highest: f64) -> Result<Self, ProblemError> {
        let ring = RingModes::new(disk)?;
        let all = ring.coordinates([f64::NEG_INFINITY, f64::INFINITY]);
        let damping = ring.damping(&all);
        let lambda: Vec<f64> = all.iter().map(|&c| ring.lambda(c)).collect();
        let load = |force: &[f64]| -> Vec<f64> {
            let on_each = |_, dof: usize| c64::new(force[dof], 0.0);
            let load = ring.force(disk, &all, on_each);
            load.iter().map(|f| f.re).collect()
        };
        let part = ModalPart {
            structure: Structure {
                damping: (0..lambda.len()).map(|i| damping[(i, i)]).collect(),
                coupling: Coupling::none(),
                lambda,
            },
            retention: ring.retention(&all).map(Into::into),
            contact: ring.contacts(disk, &all).into(),
            multiplicity: 1.0,
            response: ring.responses(disk, &all).into(),
            static_force: load(&disk.static_force),
            loads: disk.loads.iter().map(|force| load(force)).collect(),
            force: ring.excitation(disk, engine_order, &all),
        };
        let limit = match disk.is_uncoupled() {
            true => f64::INFINITY,
            false => (NOMINAL * highest).powi(2),
        };
        Ok(Self {
            groups: Group::of(disk, &ring, &all, limit),
            part,
            damping,
            n_sectors: disk.n_sectors,
        })
    }

    /// Number of sectors, and of blades.
    #[must_use]
    pub fn n_sectors(&self) -> usize {
        self.n_sectors
    }

    /// The ring with these relative deviations of the blades' frequencies. Response i is the first one of blade i; contact pairs stand sector
    /// by sector. Shape: `[sectors]`.
    ///
    /// # Errors
    /// [`LinalgError`] if the eigensolver fails: a deviation is no finite number.
    pub fn linear(&self, deviations: &[f64]) -> Result<LinearModel, LinalgError> {
        assert_eq!(deviations.len(), self.n_sectors, "one deviation per blade");
        let mut part = self.part.clone();
        let mut damping = self.damping.clone();
        for group in &self.groups {
            let (lambda, turned) =
                symmetric_eigen(group.stiffness(&self.part, deviations).as_ref())?;
            for (&mode, lambda) in group.modes.iter().zip(lambda) {
                part.structure.lambda[mode] = lambda;
            }
            turn_columns(&mut part.contact.real, &group.modes, &turned);
            turn_columns(&mut part.response.real, &group.modes, &turned);
            turn_both(&mut damping, &group.modes, &turned);
            if let Some(retention) = &mut part.retention {
                turn_both(&mut retention.real, &group.modes, &turned);
            }
            turn_vector(&mut part.static_force, &group.modes, &turned);
            part.loads
                .iter_mut()
                .for_each(|load| turn_vector(load, &group.modes, &turned));
            turn_vector(&mut part.force, &group.modes, &turned);
        }
        let part = ascending(part, &damping);
        Ok(LinearModel {
            floats: part.structure.floats(),
            pairs: (0..part.contact.nrows() / 3).collect(),
            parts: vec![part],
            breaking: None,
            ring: None,
            alternates: false,
        })
    }
}

impl Group {
    /// The modes with squared frequencies up to `limit` in which a blade takes part, where sectors are coupled; else those of each
    /// sector.
    fn of(disk: &Disk, ring: &RingModes, all: &[Coordinate], limit: f64) -> Vec<Self> {
        let Some(stiffness) = &disk.blade_stiffness else {
            return Vec::new();
        };
        let nominal: Vec<usize> = (0..all.len())
            .filter(|&i| ring.lambda(all[i]) <= limit)
            .collect();
        let group = |modes: Vec<usize>, blades: &mut dyn Iterator<Item = usize>| {
            let coordinates: Vec<Coordinate> = modes.iter().map(|&i| all[i]).collect();
            let of_blade = |blade| (blade, ring.of_sector(&coordinates, blade, stiffness));
            let blades: Vec<(usize, Mat<f64>)> = blades.map(of_blade).collect();
            Self { modes, blades }.without_idle_modes()
        };
        let mut sectors = 0..disk.n_sectors;
        if !disk.is_uncoupled() {
            return vec![group(nominal, &mut sectors)];
        }
        let of_sector = |sector| {
            let modes = nominal
                .iter()
                .copied()
                .filter(|&i| ring.moves(all[i], sector));
            group(modes.collect(), &mut std::iter::once(sector))
        };
        sectors.map(of_sector).collect()
    }

    /// The same without the modes that no blade takes part in.
    fn without_idle_modes(self) -> Self {
        let share = |i: usize| self.blades.iter().map(|(_, a)| a[(i, i)]).sum::<f64>();
        let largest = (0..self.modes.len()).map(share).fold(0.0, f64::max);
        let kept: Vec<usize> = (0..self.modes.len())
            .filter(|&i| share(i) > TAKES_PART * largest)
            .collect();
        let among =
            |a: &Mat<f64>| Mat::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
        Self {
            modes: kept.iter().map(|&i| self.modes[i]).collect(),
            blades: self
                .blades
                .iter()
                .map(|(blade, a)| (*blade, among(a)))
                .collect(),
        }
    }

    /// Λ + Σⱼ (2δⱼ + δⱼ²) Φⱼᵀ K Φⱼ.
    fn stiffness(&self, tuned: &ModalPart, deviations: &[f64]) -> Mat<f64> {
        let n = self.modes.len();
        let lambda = &tuned.structure.lambda;
        let mut stiffness = Mat::from_fn(n, n, |i, j| match i == j {
            true => lambda[self.modes[i]],
            false => 0.0,
        });
        for (blade, of_blade) in &self.blades {
            let deviation = deviations[*blade];
            if deviation != 0.0 {
                stiffness += of_blade * Scale(deviation * (2.0 + deviation));
            }
        }
        stiffness
    }
}

/// Columns `modes` of `a` times `turned`.
fn turn_columns(a: &mut Mat<f64>, modes: &[usize], turned: &Mat<f64>) {
    let gathered = Mat::from_fn(a.nrows(), modes.len(), |i, k| a[(i, modes[k])]);
    let product = gathered * turned;
    for (k, &mode) in modes.iter().enumerate() {
        a.col_as_slice_mut(mode)
            .copy_from_slice(product.col_as_slice(k));
    }
}

/// Rows and columns of a symmetric matrix.
fn turn_both(a: &mut Mat<f64>, modes: &[usize], turned: &Mat<f64>) {
    let idle = modes
        .iter()
        .all(|&mode| a.col_as_slice(mode).iter().all(|x| *x == 0.0));
    if idle {
        return;
    }
    turn_columns(a, modes, turned);
    let gathered = Mat::from_fn(modes.len(), a.ncols(), |k, j| a[(modes[k], j)]);
    let product = turned.transpose() * gathered;
    for (k, &mode) in modes.iter().enumerate() {
        (0..a.ncols()).for_each(|j| a[(mode, j)] = product[(k, j)]);
    }
}

/// Entries `modes` of a vector.
fn turn_vector<T>(f: &mut [T], modes: &[usize], turned: &Mat<f64>)
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum,
{
    let gathered: Vec<T> = modes.iter().map(|&mode| f[mode]).collect();
    for (k, &mode) in modes.iter().enumerate() {
        let column = turned.col_as_slice(k);
        f[mode] = gathered.iter().zip(column).map(|(f, v)| *f * *v).sum();
    }
}

/// The part with its modes in the order of their frequencies; `damping` is Ĉ.
fn ascending(part: ModalPart, damping: &Mat<f64>) -> ModalPart {
    let lambda = &part.structure.lambda;
    let mut order: Vec<usize> = (0..lambda.len()).collect();
    order.sort_by(|&a, &b| lambda[a].total_cmp(&lambda[b]));
    let columns = |a: &Mat<f64>| Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, order[j])]);
    let both = |a: &Mat<f64>| Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(order[i], order[j])]);
    let reals = |f: &Vec<f64>| order.iter().map(|&i| f[i]).collect::<Vec<f64>>();
    let damping = both(damping);
    ModalPart {
        structure: Structure {
            lambda: reals(lambda),
            damping: (0..order.len()).map(|i| damping[(i, i)]).collect(),
            coupling: Coupling::of(&damping.into()),
        },
        retention: part.retention.as_ref().map(|k| both(&k.real).into()),
        contact: columns(&part.contact.real).into(),
        multiplicity: part.multiplicity,
        response: columns(&part.response.real).into(),
        static_force: reals(&part.static_force),
        loads: part.loads.iter().map(reals).collect(),
        force: order.iter().map(|&i| part.force[i]).collect(),
    }
}

/// A mistuned disk without contacts, or with springs in their place: linear, in its nominal modes.
#[derive(Debug, Clone)]
pub struct LinearRing {
    lambda: Vec<f64>,
    damping: Mat<f64>,
    force: Vec<c64>,
    /// Response of every blade. Shape: sectors × modes.
    response: Mat<f64>,
    /// The stiffness of each blade.
    blades: Vec<Mat<f64>>,
    band: Band,
}

/// The largest amplitude of a linear disk in its band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearLargest {
    /// Where (rad/s).
    pub omega: f64,
    /// First response of the blade, per unit level (m).
    pub amplitude: f64,
    /// Which blade, from 0.
    pub blade: usize,
}

/// Distances from the frequency of a mode at which the response is computed first, over the half bandwidth of the mode.
const PLACES: [f64; 9] = [-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0];
/// Of these places the highest ones are refined.
const REFINED: usize = 4;
/// A maximum closer to an end of the band than this share of the narrowest half bandwidth lies at the end.
const AT_END: f64 = 1e-3;
/// Sections of the golden ratio of one refinement: the amplitude at a maximum is then exact to about 1e-12.
const SECTIONS: usize = 40;

/// `highest` (rad/s), or infinity where the disk has so few modes that all may combine.
#[must_use]
pub fn highest_combined(disk: &Disk, highest: f64) -> f64 {
    match disk.n_dofs() * disk.n_sectors <= MOST_COMBINED {
        true => f64::INFINITY,
        false => highest,
    }
}

impl LinearRing {
    /// All sectors of `disk` under an engine order, whose largest amplitude in `band` is wanted. Contacts of the disk are left out.
    ///
    /// # Errors
    /// [`ProblemError::Linalg`] if M is not positive definite or the eigensolver fails.
    pub fn new(disk: &Disk, engine_order: usize, band: Band) -> Result<Self, ProblemError> {
        let ring = RingModes::new(disk)?;
        let highest = highest_combined(disk, band.high);
        let modes = ring.coordinates([f64::NEG_INFINITY, (NOMINAL * highest).powi(2)]);
        let blades = disk.blade_stiffness.iter().flat_map(|stiffness| {
            (0..disk.n_sectors).map(|blade| ring.of_sector(&modes, blade, stiffness))
        });
        Ok(Self {
            lambda: modes.iter().map(|&c| ring.lambda(c)).collect(),
            damping: ring.damping(&modes),
            force: ring.excitation(disk, engine_order, &modes),
            response: ring.responses(disk, &modes),
            blades: blades.collect(),
            band,
        })
    }

    /// Multiplies the damping matrix by `factor`.
    pub fn scale_damping(&mut self, factor: f64) {
        self.damping *= Scale(factor);
    }

    /// Its largest amplitude with these relative deviations of the blades' frequencies, over all blades and frequencies of the band. None
    /// where no mode is near the band, and where the amplitude is largest at an end of the band: then it is no maximum.
    ///
    /// # Errors
    /// [`LinalgError`] if the eigensolver fails.
    pub fn largest(&self, deviations: &[f64]) -> Result<Option<LinearLargest>, LinalgError> {
        let n = self.lambda.len();
        let mut stiffness = Mat::from_fn(n, n, |i, j| if i == j { self.lambda[i] } else { 0.0 });
        for (of_blade, deviation) in self.blades.iter().zip(deviations) {
            if *deviation != 0.0 {
                stiffness += of_blade * Scale(deviation * (2.0 + deviation));
            }
        }
        let modes = MistunedModes::new(self, &stiffness)?;
        // each with the half-power half-width of its mode
        let mut places: Vec<(f64, f64)> = Vec::new();
        for (mode, lambda) in modes.lambda.iter().enumerate() {
            let (omega, half) = (lambda.max(0.0).sqrt(), 0.5 * modes.damping[(mode, mode)]);
            let inside = PLACES.iter().map(|at| (omega + at * half, half));
            places.extend(inside.filter(|(omega, _)| self.band.contains(*omega)));
        }
        let narrowest = places
            .iter()
            .fold(self.band.width(), |least, (_, half)| least.min(*half));
        places.extend([self.band.low, self.band.high].map(|end| (end, narrowest)));
        let mut found: Vec<(LinearLargest, f64)> = places
            .iter()
            .map(|&(omega, half)| (modes.at(omega), half))
            .collect();
        found.sort_by(|(a, _), (b, _)| b.amplitude.total_cmp(&a.amplitude));
        found.truncate(REFINED);
        let refined = found
            .iter()
            .map(|(at, half)| modes.refined(*at, *half, self.band));
        let highest = refined.reduce(|a, b| if b.amplitude > a.amplitude { b } else { a });
        // towards an end of the band the amplitude grows to a resonance outside it
        let inside = |at: &LinearLargest| {
            let ends = [self.band.low, self.band.high];
            ends.iter()
                .all(|end| (at.omega - end).abs() > AT_END * narrowest)
        };
        Ok(highest.filter(|at| n > 0 && inside(at)))
    }
}

/// A linear disk in the modes that it has with its deviations.
struct MistunedModes {
    /// Squared frequencies ((rad/s)²), ascending.
    lambda: Vec<f64>,
    damping: Mat<f64>,
    force: Vec<c64>,
    /// Response of every blade. Shape: sectors × modes.
    response: Mat<f64>,
    /// So many modes, the lowest ones, are coupled by the damping; it takes the others each for itself.
    coupled: usize,
}

impl MistunedModes {
    fn new(of: &LinearRing, stiffness: &Mat<f64>) -> Result<Self, LinalgError> {
        let (lambda, shapes) = symmetric_eigen(stiffness.as_ref())?;
        let limit = (NOMINAL * of.band.high).powi(2);
        let force = |mode: usize| -> c64 {
            let shape = shapes.col_as_slice(mode).iter();
            shape.zip(&of.force).map(|(x, f)| *f * *x).sum()
        };
        Ok(Self {
            coupled: lambda.iter().filter(|l| **l <= limit).count(),
            damping: shapes.transpose() * &of.damping * &shapes,
            force: (0..lambda.len()).map(force).collect(),
            response: &of.response * &shapes,
            lambda,
        })
    }

    /// The largest amplitude at one frequency.
    fn at(&self, omega: f64) -> LinearLargest {
        let n = self.lambda.len();
        let stiffness = |i: usize, j: usize| {
            let elastic = if i == j {
                self.lambda[i] - omega * omega
            } else {
                0.0
            };
            c64::new(elastic, omega * self.damping[(i, j)])
        };
        let low = Mat::from_fn(self.coupled, self.coupled, stiffness);
        let low = low
            .partial_piv_lu()
            .solve(Col::from_fn(self.coupled, |i| self.force[i]));
        let high = (self.coupled..n).map(|i| self.force[i] / stiffness(i, i));
        let moved: Vec<c64> = low.iter().copied().chain(high).collect();
        let amplitude = |blade: usize| {
            let modes = (0..n).map(|j| moved[j] * self.response[(blade, j)]);
            modes.sum::<c64>().norm()
        };
        let none = LinearLargest {
            omega,
            amplitude: 0.0,
            blade: 0,
        };
        (0..self.response.nrows()).fold(none, |largest, blade| {
            let amplitude = amplitude(blade);
            match amplitude > largest.amplitude {
                true => LinearLargest {
                    omega,
                    amplitude,
                    blade,
                },
                false => largest,
            }
        })
    }

    /// The maximum within `reach` of a frequency and in `band`, by golden sections.
    fn refined(&self, at: LinearLargest, reach: f64, band: Band) -> LinearLargest {
        let ratio = 0.5 * (5_f64.sqrt() - 1.0);
        let mut low = (at.omega - reach).max(band.low);
        let mut high = (at.omega + reach).min(band.high);
        let mut inner = [high - ratio * (high - low), low + ratio * (high - low)];
        let mut values = inner.map(|omega| self.at(omega));
        for _ in 0..SECTIONS {
            if values[0].amplitude > values[1].amplitude {
                high = inner[1];
                inner = [high - ratio * (high - low), inner[0]];
                values = [self.at(inner[0]), values[0]];
            } else {
                low = inner[0];
                inner = [inner[1], low + ratio * (high - low)];
                values = [values[1], self.at(inner[1])];
            }
        }
        let best = values[usize::from(values[1].amplitude > values[0].amplitude)];
        match best.amplitude > at.amplitude {
            true => best,
            false => at,
        }
    }
}
