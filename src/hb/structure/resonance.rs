//! Resonance of the structure with linear springs at the contacts: stuck, the start of every nonlinear one; open, its
//! limit at large excitation.

use super::compliance::Compliance;
use super::linear::{LinearModel, ModalPart};
use crate::linalg::{LinalgError, symmetric_generalized_eigen};
use faer::prelude::*;

/// Damping ratios below this count as this much when modes are ranked.
const UNDAMPED: f64 = 1e-12;

/// The peak of a mode outside the band may lie this far beyond the frequency of the mode, relative.
const BEYOND: f64 = 0.02;

/// A resonance.
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

    /// This band, or from a little beyond `omega` on if that is outside.
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

/// The same for all whose amplitude is at least `least` (m per unit level), largest first.
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

/// An undamped mode of a linear structure with its damping.
#[derive(Debug, Clone)]
struct LinearMode {
    /// Natural frequency (rad/s).
    omega: f64,
    /// Damping constant (rad/s).
    half_bandwidth: f64,
    /// Product of its force and its response 0, per unit level (m rad²/s²).
    residue: f64,
    /// Amplitude of response 0 at resonance per unit level, by this mode alone (m).
    amplitude: f64,
    /// Shape in the modes of the free structure, of unit modal mass: its squares are shares of the free modes.
    shape: Vec<f64>,
}

impl LinearMode {
    /// The modes of `part` with springs `k` between the contacts, ascending in frequency.
    fn all(part: &ModalPart, k: &[f64]) -> Result<Vec<Self>, LinalgError> {
        let stiffness = part.stiffness_with_springs(k);
        let unit = Mat::identity(stiffness.nrows(), stiffness.ncols());
        let (lambda, modes) = symmetric_generalized_eigen(stiffness.as_ref(), unit.as_ref())?;
        let mode = |(j, l): (usize, &f64)| {
            Self::new(part, l.max(0.0).sqrt(), modes.col_as_slice(j).to_vec())
        };
        Ok(lambda.iter().enumerate().map(mode).collect())
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
        let unit = |j: usize| (0..n).map(|i| f64::from(u8::from(i == j))).collect();
        (part.structure.lambda.iter().enumerate())
            .map(|(j, l)| Self::new(part, l.max(0.0).sqrt(), unit(j)))
            .collect()
    }

    fn new(part: &ModalPart, omega: f64, shape: Vec<f64>) -> Self {
        let mode: Vec<c64> = shape.iter().map(|x| c64::new(*x, 0.0)).collect();
        let force: c64 = shape.iter().zip(&part.force).map(|(x, f)| x * f).sum();
        let half_bandwidth = 0.5 * damping_of(part, &mode);
        let residue = (force * part.responses(&mode)[0]).norm();
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

/// Modes whose residue is below this part of the largest one are not excited: by symmetry, up to round-off.
const EXCITED: f64 = 1e-6;
/// Share of a free mode in a stuck one from which its amplitude bounds that of the stuck one.
const SHARE: f64 = 0.1;

/// A mode of the stuck structure from which a maximum may grow.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Number of the mode in the stuck structure that the first harmonic sees, 0 for the lowest.
    pub mode: usize,
    /// Its natural frequency (rad/s).
    pub omega: f64,
    /// Largest amplitude of response 0 per unit level (m): of this mode, and of the free modes that it turns into.
    pub reach: f64,
    /// Frequencies that its peak may have while the level is raised: the band, widened to the frequency of the mode.
    pub path: Band,
}

/// The modes of the stuck structure from which the maxima inside `band` grow, highest reach first: those with their
/// frequency in the band, and for each free mode in the band the stuck one that it has the largest share in.
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
    let share = |mode: usize, free: usize| stuck[mode].shape[free].powi(2);
    let heirs = (0..free.len()).filter(|&f| band.contains(free[f].omega));
    let heir = |f: usize| (0..stuck.len()).max_by(|&a, &b| share(a, f).total_cmp(&share(b, f)));
    let mut modes: Vec<usize> = heirs.filter_map(heir).collect();
    modes.extend((0..stuck.len()).filter(|&mode| band.contains(stuck[mode].omega)));
    modes.sort_unstable();
    modes.dedup();
    // free modes of one frequency are any mixture, so that these bound the amplitude, but do not tell who is excited
    let reach = |mode: usize| {
        (free.iter().enumerate())
            .filter(|(f, of_free)| of_free.omega > 0.5 * band.low && share(mode, *f) >= SHARE)
            .map(|(_, of_free)| of_free.amplitude)
            .fold(stuck[mode].amplitude, f64::max)
    };
    let residues = modes.iter().map(|&mode| stuck[mode].residue);
    let most = residues.fold(0.0, f64::max);
    let mut found: Vec<Candidate> = (modes.into_iter())
        .filter(|&mode| stuck[mode].residue > EXCITED * most)
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

/// First harmonic of response 0 at `omega` per unit level (m) with linear springs `k` between the contacts.
#[must_use]
pub fn linear_response(model: &LinearModel, k: &[f64], omega: f64) -> c64 {
    let at = Compliance::new(model, k, &[0, 1], omega);
    let first = &at.harmonics[0];
    first.part.responses(&first.solve(&first.part.force))[0]
}

fn damping_of(part: &ModalPart, mode: &[c64]) -> f64 {
    (part.structure.damp(mode).iter().zip(mode))
        .map(|(c, x)| (c * x.conj()).re)
        .sum()
}
