//! Whether a periodic solution is stable, by its largest Floquet multiplier.

use super::period_map::{PeriodMap, PeriodicMotion};
use super::ring_map::RingMap;
use crate::hb::equations::problem::Problem;
use crate::linalg::krylov::{Krylov, Ritz};
use faer::prelude::c64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Steps of the march per period.
pub const STEPS: usize = 256;

/// A disturbance that grows by less than this share per period is not told from one that stays.
pub const MARGIN: f64 = 1e-2;

/// Multipliers this close to 1 belong to neutral directions, such as the mean position of a strip in gross slip.
const NEUTRAL: f64 = 1e-6;

/// Up to so many unknowns of a ring all multipliers are computed, by a dense matrix; of others the largest in a Krylov space.
const DENSE: usize = 400;

/// Vectors of the Krylov space per period, at least, where a period has so many laps.
const PER_PERIOD: usize = 8;

/// Periods after which a Krylov space is asked for the first time, and those after which it ends.
const PERIODS: [usize; 2] = [6, 24];

/// Error of the largest multiplier, as the residual states it, with which the search for it ends.
const ACCURACY: f64 = 1e-3;

/// Stability of a periodic solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// The Floquet multiplier of the largest modulus, with Im ≥ 0: what one period makes of the disturbance that lasts longest.
    /// Neutral directions are left out.
    pub multiplier: c64,
    /// Number of multipliers whose modulus is above 1 + [`MARGIN`].
    pub n_unstable: usize,
}

/// How a stable solution becomes unstable, by where its multiplier leaves the unit circle.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Instability {
    /// At +1: the vibration leaves for another one of the same period, beyond a fold or with another symmetry.
    Fold,
    /// At −1: every second period becomes alike.
    PeriodDoubling,
    /// Elsewhere: the vibration gets a second frequency.
    NeimarkSacker,
}

impl Stability {
    /// Whether every small disturbance dies out.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.n_unstable == 0
    }

    /// Share by which the most lasting disturbance grows in one period; negative where it decays.
    #[must_use]
    pub fn growth(&self) -> f64 {
        self.multiplier.norm() - 1.0
    }

    /// What kind of instability it is; `None` if it is stable.
    #[must_use]
    pub fn instability(&self) -> Option<Instability> {
        let multiplier = self.multiplier;
        match self.is_stable() {
            true => None,
            false if multiplier.im != 0.0 => Some(Instability::NeimarkSacker),
            false if multiplier.re > 0.0 => Some(Instability::Fold),
            false => Some(Instability::PeriodDoubling),
        }
    }

    /// The largest of all multipliers; `None` without any.
    fn of(multipliers: impl Iterator<Item = c64>) -> Option<Self> {
        let mut largest: Option<c64> = None;
        let mut n_unstable = 0;
        for multiplier in multipliers.filter(|m| (m - 1.0).norm() > NEUTRAL) {
            n_unstable += usize::from(multiplier.norm() > 1.0 + MARGIN);
            if largest.is_none_or(|m| multiplier.norm_sqr() > m.norm_sqr()) {
                largest = Some(multiplier);
            }
        }
        largest.map(|m| Self {
            multiplier: c64::new(m.re, m.im.abs()),
            n_unstable,
        })
    }
}

/// Stability of `motion`, a solution of `problem`. `None` for a structure that needs too many coordinates, and if the eigenvalues
/// were not found.
#[must_use]
pub fn assess(problem: &Problem<'_>, motion: &PeriodicMotion<'_>) -> Option<Stability> {
    assess_with(problem, motion, STEPS)
}

/// The same with `n_steps` steps per period, an even number; of a disk at least so many.
#[must_use]
pub fn assess_with(
    problem: &Problem<'_>,
    motion: &PeriodicMotion<'_>,
    n_steps: usize,
) -> Option<Stability> {
    if let Some(ring) = &problem.model.ring {
        let map = RingMap::new(problem, ring, motion, n_steps)?;
        return match map.size() <= DENSE {
            true => Stability::of(map.multipliers()?.into_iter()),
            false => leading(&map),
        };
    }
    let maps = PeriodMap::all(problem, motion, n_steps)?;
    let multipliers: Vec<Vec<c64>> =
        (maps.iter().map(PeriodMap::multipliers)).collect::<Option<_>>()?;
    Stability::of(multipliers.into_iter().flatten())
}

/// Stability by the largest multipliers of a ring, from one disturbance of all sectors and what becomes of it. `None` where what seems to
/// grow has not become a multiplier until the end.
#[must_use]
pub fn leading(map: &RingMap) -> Option<Stability> {
    let laps = map.laps();
    // laps between two vectors: the most that divide a period and leave it enough vectors
    let between = (1..=laps)
        .rev()
        .find(|n| laps.is_multiple_of(*n) && (laps / n >= PER_PERIOD || *n == 1))?;
    let per_period = laps / between;
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let start = (0..map.size()).map(|_| random.random::<f64>() - 0.5);
    let mut space = Krylov::new(start.collect());
    let [first, last] = PERIODS.map(|periods| periods * per_period);
    let mut dimension = first;
    loop {
        space.grow(dimension, |x| {
            (0..between).fold(x.to_vec(), |x, _| map.lap(&x))
        });
        let (found, error) = largest(map, &space, per_period)?;
        if error <= ACCURACY || dimension == last || space.is_exhausted() {
            let known = found.is_stable() || error <= MARGIN;
            return known.then_some(found);
        }
        dimension = (dimension + dimension / 2).min(last);
    }
}

/// The largest multiplier in a Krylov space that is not neutral, and its error.
fn largest(map: &RingMap, space: &Krylov, per_period: usize) -> Option<(Stability, f64)> {
    let mut largest: Option<(c64, f64)> = None;
    let mut n_unstable = 0;
    for ritz in space.eigenvalues()? {
        let (multiplier, error) = multiplier_of(map, space, &ritz, per_period);
        let neutral = (multiplier - 1.0).norm() <= NEUTRAL;
        if !neutral && largest.is_none() {
            largest = Some((multiplier, error));
        }
        let grows = multiplier.norm() > 1.0 + MARGIN;
        n_unstable += usize::from(grows && (error <= MARGIN || n_unstable == 0));
        if !grows && largest.is_some() {
            break;
        }
    }
    largest.map(|(m, error)| {
        let multiplier = c64::new(m.re, m.im.abs());
        let found = Stability {
            multiplier,
            n_unstable,
        };
        (found, error)
    })
}

/// The multiplier of an eigenvalue of the map between two vectors, and its error.
fn multiplier_of(map: &RingMap, space: &Krylov, ritz: &Ritz, per_period: usize) -> (c64, f64) {
    let power = per_period as i32;
    let multiplier = ritz.value.powi(power) * map.turn_of_class(&space.vector(ritz));
    let error = multiplier.norm() * f64::from(power) * ritz.residual / ritz.value.norm();
    (multiplier, error)
}
