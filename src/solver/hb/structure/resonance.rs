//! Resonances of the structure with linear springs at the contacts. Stuck contacts give the limit at small excitation, where
//! searches start; open contacts give the limit at large excitation.

use super::compliance::Compliance;
use super::linear::{LinearModel, ModalPart};
use crate::linalg::{LinalgError, Scalar, symmetric_generalized_eigen};
use faer::prelude::*;

/// Least damping ratio assumed when modes are ranked: an undamped mode would have an infinite amplitude.
const UNDAMPED: f64 = 1e-12;

/// Distance, over the frequency of a mode outside the band, by which its path is extended beyond this frequency.
const BEYOND: f64 = 0.02;

/// A resonance of the linear structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearResonance {
    /// Undamped natural frequency (rad/s).
    pub omega: f64,
    /// Half bandwidth, damping constant of the mode (rad/s).
    pub half_bandwidth: f64,
    /// First harmonic of response 0 per unit level (m).
    pub response: c64,
}

/// Frequency band of the search (rad/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lower edge.
    pub low: f64,
    /// Upper edge.
    pub high: f64,
}

impl Band {
    /// Width (rad/s).
    #[must_use]
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// This band; if `omega` lies outside, extended to a little beyond it.
    #[must_use]
    fn widened_to(self, omega: f64) -> Self {
        match self.contains(omega) {
            true => self,
            false => Self {
                low: self.low.min(omega * (1.0 - BEYOND)),
                high: self.high.max(omega * (1.0 + BEYOND)),
            },
        }
    }

    /// Whether `omega` lies inside.
    #[must_use]
    pub fn contains(self, omega: f64) -> bool {
        (self.low..=self.high).contains(&omega)
    }
}

/// The resonance of the structure with linear springs `k` (N/m, shape `[3·n_contacts]`) between the contacts whose
/// modal amplitude of response 0 is largest inside `band`.
///
/// # Errors
/// [`LinalgError`] if the eigensolver fails. `Ok(None)` if no natural frequency lies in the band.
pub fn linear_resonance(
    model: &LinearModel,
    k: &[f64],
    band: Band,
) -> Result<Option<LinearResonance>, LinalgError> {
    let strongest = LinearMode::strongest(model, k, band)?.into_iter().next();
    Ok(strongest.map(|mode| mode.resonance(model, k)))
}

/// All resonances inside `band` with an amplitude of at least `least` (m per unit level), largest first.
///
/// # Errors
/// [`LinalgError`] if the eigensolver fails.
pub(in crate::hb) fn linear_resonances(
    model: &LinearModel,
    k: &[f64],
    band: Band,
    least: f64,
) -> Result<Vec<LinearResonance>, LinalgError> {
    let modes = LinearMode::strongest(model, k, band)?.into_iter();
    let large = modes.filter(|mode| mode.amplitude >= least);
    Ok(large.map(|mode| mode.resonance(model, k)).collect())
}

/// An undamped mode of the structure with linear springs, and its damping.
#[derive(Debug, Clone)]
pub(in crate::hb) struct LinearMode {
    /// Natural frequency (rad/s).
    omega: f64,
    /// Damping constant (rad/s).
    half_bandwidth: f64,
    /// Product of its modal force and its modal response 0, per unit level (m rad²/s²).
    residue: f64,
    /// Amplitude of response 0 at resonance per unit level, by this mode alone (m).
    amplitude: f64,
    /// Its components in the modes of the free structure, of unit modal mass: the squares of their sizes sum to 1.
    pub(in crate::hb) shape: Vec<c64>,
}

impl LinearMode {
    /// The modes of `part` with springs `k` between the contacts, ascending in frequency.
    pub(in crate::hb) fn all(part: &ModalPart, k: &[f64]) -> Result<Vec<Self>, LinalgError> {
        let (lambda, shapes) = match part.is_real() {
            true => {
                let (lambda, modes) = eigen(&part.stiffness_with_springs(k))?;
                let complex = |x: &f64| c64::new(*x, 0.0);
                let shape = |j| modes.col_as_slice(j).iter().map(complex).collect();
                let shapes: Vec<Vec<c64>> = (0..lambda.len()).map(shape).collect();
                (lambda, shapes)
            }
            false => {
                let (lambda, modes) = eigen(&part.wave_stiffness_with_springs(k))?;
                let shape = |j| modes.col_as_slice(j).to_vec();
                let shapes = (0..lambda.len()).map(shape).collect();
                (lambda, shapes)
            }
        };
        let mode = |(shape, l): (Vec<c64>, &f64)| Self::new(part, l.max(0.0).sqrt(), shape);
        Ok(shapes.into_iter().zip(&lambda).map(mode).collect())
    }

    /// The modes inside `band` with springs `k`, largest amplitude first.
    fn strongest(model: &LinearModel, k: &[f64], band: Band) -> Result<Vec<Self>, LinalgError> {
        let mut modes = Self::all(model.part(1), k)?;
        modes.retain(|mode| band.contains(mode.omega));
        modes.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
        modes.reverse();
        Ok(modes)
    }

    /// The free modes of `part`.
    fn free(part: &ModalPart) -> Vec<Self> {
        let n = part.n_coordinates();
        let unit = |j: usize| {
            (0..n)
                .map(|i| c64::from(f64::from(u8::from(i == j))))
                .collect()
        };
        (part.structure.lambda.iter().enumerate())
            .map(|(j, l)| Self::new(part, l.max(0.0).sqrt(), unit(j)))
            .collect()
    }

    fn new(part: &ModalPart, omega: f64, shape: Vec<c64>) -> Self {
        let force: c64 = (shape.iter().zip(&part.force))
            .map(|(x, f)| x.conj() * f)
            .sum();
        let half_bandwidth = 0.5 * damping_of(part, &shape);
        let residue = (force * part.responses(&shape)[0]).norm();
        Self {
            omega,
            half_bandwidth,
            residue,
            amplitude: residue / (2.0 * omega * half_bandwidth.max(UNDAMPED * omega)),
            shape,
        }
    }

    fn resonance(&self, model: &LinearModel, k: &[f64]) -> LinearResonance {
        LinearResonance {
            omega: self.omega,
            half_bandwidth: self.half_bandwidth,
            response: linear_response(model, k, self.omega),
        }
    }
}

/// A mode counts as not excited if its residue is below this share of the largest one: by symmetry, up to round-off.
const EXCITED: f64 = 1e-6;
/// Least share of a free mode in a stuck one, from which the amplitude of the free mode counts in the reach of the stuck one.
const SHARE: f64 = 0.1;

/// A mode of the stuck structure from which a maximum may grow.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Index of the mode of the stuck structure (the part for harmonic 1), 0 for the lowest frequency.
    pub mode: usize,
    /// Its natural frequency (rad/s).
    pub omega: f64,
    /// Largest amplitude of response 0 per unit level (m): of this mode, and of the free modes that have a share in it.
    pub reach: f64,
    /// Frequencies that its peak may have while the level is raised: the band, extended to the frequency of the mode.
    pub path: Band,
}

/// The modes of the stuck structure from which maxima inside `band` may develop, largest reach first: those with their
/// frequency in the band, and for each free mode with its frequency in the band the stuck mode in which its share is largest.
///
/// # Errors
/// [`LinalgError`] if the eigensolver fails.
pub fn candidates(
    model: &LinearModel,
    stuck_stiffness: &[f64],
    band: Band,
) -> Result<Vec<Candidate>, LinalgError> {
    let part = model.part(1);
    let stuck = LinearMode::all(part, stuck_stiffness)?;
    let free = LinearMode::free(part);
    let share = |mode: usize, free: usize| stuck[mode].shape[free].norm_sqr();
    let heirs = (0..free.len()).filter(|&f| band.contains(free[f].omega));
    let heir = |f: usize| (0..stuck.len()).max_by(|&a, &b| share(a, f).total_cmp(&share(b, f)));
    let mut modes: Vec<usize> = heirs.filter_map(heir).collect();
    modes.extend((0..stuck.len()).filter(|&mode| band.contains(stuck[mode].omega)));
    modes.sort_unstable();
    modes.dedup();
    // free modes of equal frequency may be mixed in any way: they bound the amplitude, but do not say which one is excited
    let reach = |mode: usize| {
        (free.iter().enumerate())
            .filter(|(f, of_free)| of_free.omega > 0.5 * band.low && share(mode, *f) >= SHARE)
            .map(|(_, of_free)| of_free.amplitude)
            .fold(stuck[mode].amplitude, f64::max)
    };
    let residues = modes.iter().map(|&mode| stuck[mode].residue);
    let most = residues.fold(0.0, f64::max);
    // where damping alone leads from the excitation to the response, no mode has a part of its own
    let by_damping =
        |mode: usize| linear_response(model, stuck_stiffness, stuck[mode].omega).norm();
    let reach = |mode: usize| match most > 0.0 {
        true => reach(mode),
        false => by_damping(mode),
    };
    let mut found: Vec<Candidate> = (modes.into_iter())
        .filter(|&mode| most == 0.0 || stuck[mode].residue > EXCITED * most)
        .map(|mode| Candidate {
            mode,
            omega: stuck[mode].omega,
            reach: reach(mode),
            path: band.widened_to(stuck[mode].omega),
        })
        .collect();
    found.sort_by(|a, b| b.reach.total_cmp(&a.reach));
    Ok(found)
}

/// Natural frequencies (rad/s) with linear springs `k` (N/m, shape `[3·n_contacts]`) between the contacts of what harmonic 1 excites,
/// ascending: those of the modes that [`Candidate::mode`] counts.
///
/// # Errors
/// [`LinalgError`] if the eigensolver fails.
pub fn natural_frequencies(model: &LinearModel, k: &[f64]) -> Result<Vec<f64>, LinalgError> {
    let modes = LinearMode::all(model.part(1), k)?;
    Ok(modes.iter().map(|mode| mode.omega).collect())
}

/// Damping ratio below which a mode counts as undamped when a user is told of it: no structure has as little.
const WITHOUT_DAMPING: f64 = 1e-6;

/// Natural frequencies (rad/s) inside `band` of the modes of the free structure that are excited and have no damping: once contacts slip or
/// open, nothing bounds their amplitude.
#[must_use]
pub fn undamped_frequencies(model: &LinearModel, band: Band) -> Vec<f64> {
    let modes = LinearMode::free(model.part(1));
    let undamped = |mode: &LinearMode| mode.half_bandwidth < WITHOUT_DAMPING * mode.omega;
    (excited(&modes).map(|mode| &modes[mode]))
        .filter(|mode| band.contains(mode.omega) && undamped(mode))
        .map(|mode| mode.omega)
        .collect()
}

/// Those of the `modes` that the excitation moves and the response shows, by their numbers.
pub(in crate::hb) fn excited(modes: &[LinearMode]) -> impl Iterator<Item = usize> + Clone {
    let most = modes.iter().map(|mode| mode.residue).fold(0.0, f64::max);
    let is_excited = move |&mode: &usize| modes[mode].residue > EXCITED * most;
    (0..modes.len()).filter(is_excited)
}

/// First harmonic of response 0 at `omega` per unit level (m) with linear springs `k` between the contacts.
#[must_use]
pub fn linear_response(model: &LinearModel, k: &[f64], omega: f64) -> c64 {
    let at = Compliance::new(model, k, &[0, 1], omega);
    let first = &at.harmonics[0];
    first.part.responses(&first.solve(&first.part.force))[0]
}

/// Eigenpairs of a stiffness in coordinates of unit mass.
fn eigen<E: Scalar>(stiffness: &Mat<E>) -> Result<(Vec<f64>, Mat<E>), LinalgError> {
    let unit: Mat<E> = Mat::identity(stiffness.nrows(), stiffness.ncols());
    symmetric_generalized_eigen(stiffness.as_ref(), unit.as_ref())
}

fn damping_of(part: &ModalPart, mode: &[c64]) -> f64 {
    (part.structure.damp(mode).iter().zip(mode))
        .map(|(c, x)| (c * x.conj()).re)
        .sum()
}
