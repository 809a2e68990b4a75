//! Whether a periodic solution is stable, by its largest Floquet multiplier.

use super::leading::{Multiplier, leading};
use super::period_map::{PeriodMap, PeriodicMotion};
use super::ring_map::RingMap;
use crate::hb::equations::problem::Problem;
use faer::prelude::c64;

/// Steps of the march per period.
pub const STEPS: usize = 256;

/// Most steps per period where the first ones are too long: a stiff contact that slips or opens turns a high mode far in one step.
const MOST_STEPS: usize = 2048;

/// Growth per period from which on a multiplier is found again with twice the steps: half of [`MARGIN`].
const DOUBTFUL: f64 = 0.5 * MARGIN;

/// Growth per period from which on shorter steps change no verdict: they change such multipliers by large factors, but far above 1.
const PLAIN: f64 = 99.0;

/// The steps are short enough where twice as many change the growth by less than this share of it, or of [`MARGIN`].
const AGREEMENT: f64 = 0.2;

/// A disturbance that grows by less than this share per period is not told from one that stays.
pub const MARGIN: f64 = 1e-2;

/// Multipliers this close to 1 belong to neutral directions, such as the mean position of a strip in gross slip.
const NEUTRAL: f64 = 1e-6;

/// Up to so many unknowns of a ring all multipliers are computed, by a dense matrix; of others the largest alone.
const DENSE: usize = 400;

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

    /// Whether both say the same of the growth, as far as it matters.
    fn agrees_with(&self, other: &Self) -> bool {
        let apart = (self.growth() - other.growth()).abs();
        apart <= AGREEMENT * self.growth().max(MARGIN)
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
    fn of(multipliers: impl Iterator<Item = Multiplier>) -> Option<Self> {
        let mut largest: Option<c64> = None;
        let mut n_unstable = 0;
        let lasting = multipliers.filter(|m| (m.value - 1.0).norm() > NEUTRAL + m.error);
        for multiplier in lasting.map(|m| m.value) {
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

/// Stability of `motion`, a solution of `problem`, with [`STEPS`] steps per period; where a disturbance grows or nearly does, but less than
/// a hundredfold in a period, with twice as many until that changes its growth no more. `None` for a structure that needs too many coordinates, and if the
/// eigenvalues were not found.
#[must_use]
pub fn assess(problem: &Problem<'_>, motion: &PeriodicMotion<'_>) -> Option<Stability> {
    let mut found = assess_with(problem, motion, STEPS)?;
    let mut n_steps = STEPS;
    while (DOUBTFUL..PLAIN).contains(&found.growth()) && n_steps < MOST_STEPS {
        n_steps *= 2;
        // a ring may need more memory than it may take, or leave its multipliers unknown
        let Some(finer) = assess_with(problem, motion, n_steps) else {
            break;
        };
        let agrees = finer.agrees_with(&found);
        found = finer;
        if agrees {
            break;
        }
    }
    Some(found)
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
            true => Stability::of(map.multipliers()?.into_iter().map(Multiplier::exact)),
            false => by_leading(&map),
        };
    }
    let maps = PeriodMap::all(problem, motion, n_steps)?;
    let multipliers: Vec<Vec<c64>> =
        (maps.iter().map(PeriodMap::multipliers)).collect::<Option<_>>()?;
    Stability::of(multipliers.into_iter().flatten().map(Multiplier::exact))
}

/// Stability by the largest multipliers of a ring, from what becomes of a few disturbances. `None` where not all of the largest are known, and
/// none of the known ones is unstable.
#[must_use]
pub fn by_leading(map: &RingMap) -> Option<Stability> {
    let found = leading(map)?;
    let known = found.multipliers.iter().filter(|m| m.is_known());
    let stability = Stability::of(known.copied())?;
    (found.settled || !stability.is_stable()).then_some(stability)
}
