//! What one period makes of a small disturbance.

use super::contact_steps::{Displacement, PairSteps, SAMPLES};
use super::march::March;
use super::structure::Disturbed;
use crate::contact::FrictionLaw;
use crate::harmonics::{HarmonicSet, phases};
use crate::hb::equations::problem::Problem;
use faer::prelude::*;

/// A periodic motion of the contacts.
#[derive(Debug, Clone, Copy)]
pub struct PeriodicMotion<'a> {
    /// Harmonics of the displacements.
    pub harmonics: &'a HarmonicSet,
    /// Relative displacements (m). Shape: `[n_coefficients][3·n_contacts]`.
    pub relative: &'a [f64],
    /// Frequency (rad/s).
    pub omega: f64,
    /// Friction law.
    pub law: FrictionLaw,
}

/// The monodromy matrix for disturbances of one symmetry.
#[derive(Debug)]
pub struct PeriodMap {
    /// Disturbance at the end of the lap by the one at its start, of q, q̇ and `sliders`.
    pub matrix: Mat<f64>,
    /// Number of coordinates q.
    pub n_modes: usize,
    /// Shapes of the coordinates in the modes of the linear model's parts, part by part. Shape: modes × coordinates of the part.
    pub shapes: Vec<Mat<f64>>,
    /// Sliders that remember: pair and direction.
    pub sliders: Vec<[usize; 2]>,
    /// Laps in one period: 2 where the pairs of both sides are marched over half a period and then change their sides.
    pub laps: usize,
}

impl PeriodMap {
    /// The maps of `motion` of `problem`, one for each symmetry, with `n_steps` steps per period; `None` for travelling waves,
    /// for a structure that needs too many coordinates, and if eigenvalues of it were not found.
    #[must_use]
    pub fn all(
        problem: &Problem<'_>,
        motion: &PeriodicMotion<'_>,
        n_steps: usize,
    ) -> Option<Vec<Self>> {
        let structures = Disturbed::all(problem, motion.omega)?;
        let pairs = pair_steps(problem, motion, n_steps);
        let map = |structure: Disturbed| {
            let march = March::new(&structure, &pairs, motion.omega)?;
            let sliders = march.sliders.clone();
            Some(Self {
                matrix: march.lap(),
                n_modes: structure.lambda.len(),
                laps: structure.sides,
                shapes: structure.shapes,
                sliders,
            })
        };
        structures.into_iter().map(map).collect()
    }

    /// Floquet multipliers, in no order; `None` if the eigenvalues were not found.
    #[must_use]
    pub fn multipliers(&self) -> Option<Vec<c64>> {
        let of_lap = self.matrix.eigenvalues().ok()?;
        let power = |m: c64| if self.laps == 2 { m * m } else { m };
        Some(of_lap.into_iter().map(power).collect())
    }
}

/// The linearised law of every pair over the period.
pub(super) fn pair_steps(
    problem: &Problem<'_>,
    motion: &PeriodicMotion<'_>,
    n_steps: usize,
) -> Vec<PairSteps> {
    let n_pairs = problem.contacts.len();
    let samples = displacements(motion, n_steps * SAMPLES, 3 * n_pairs);
    (problem.contacts.iter().enumerate())
        .map(|(pair, contact)| {
            let of_pair =
                |r: &[f64]| -> Displacement { [r[pair], r[n_pairs + pair], r[2 * n_pairs + pair]] };
            let displacement: Vec<_> = samples.chunks_exact(3 * n_pairs).map(of_pair).collect();
            PairSteps::new(contact, motion.law, &displacement)
        })
        .collect()
}

/// Displacements at `n` equidistant phases. Shape: `[n][width]`.
fn displacements(motion: &PeriodicMotion<'_>, n: usize, width: usize) -> Vec<f64> {
    let circle: Vec<(f64, f64)> = phases(n).into_iter().map(libm::sincos).collect();
    let mut out = Vec::with_capacity(n * width);
    for i in 0..n {
        let first = out.len();
        out.extend_from_slice(&motion.relative[..width]);
        let now = &mut out[first..];
        let dynamic = motion.relative[width..].chunks_exact(2 * width);
        for (&k, both) in motion.harmonics.orders()[1..].iter().zip(dynamic) {
            let (sin, cos) = circle[k * i % n];
            let (cosine, sine) = both.split_at(width);
            for ((x, c), s) in now.iter_mut().zip(cosine).zip(sine) {
                *x += c * cos + s * sin;
            }
        }
    }
    out
}
