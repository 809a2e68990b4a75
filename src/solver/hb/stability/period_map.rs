//! What one period makes of a small disturbance.
//!
//! Over one step the contact has the constant derivatives D (forces by displacements) and E (tractions by sliders), so that
//! f = D B η + E w. A step is a linear system with constant coefficients,
//!
//! ```text
//! y' = A y + b,   y = (η, η̇),   A = [0, I; −K, −Ĉ],   K = Λ + Bᵀ D B,   b = −(0, Bᵀ E w)
//! y₁ = y₀ + h (I − h A/2 + h² A²/12)⁻¹ (A y₀ + b)
//! ```
//!
//! by Gauss' method with two stages. The polynomial has the roots a, ā = 3 ± i√3, so that a step takes one solve with the dynamic
//! stiffness at the complex frequency s = a/h:
//!
//! ```text
//! p = Z⁻¹ (K η₀ + Bᵀ E w − s η̇₀)/h,   Z = K + s Ĉ + s² I
//! η₁ = η₀ + 4√3 h Im p,   η̇₁ = η̇₀ + 4√3 Im (a p)
//! ```

use super::contact_steps::{Displacement, PairStep, PairSteps, SAMPLES};
use super::structure::Disturbed;
use crate::contact::FrictionLaw;
use crate::harmonics::{HarmonicSet, phases};
use crate::hb::equations::problem::Problem;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use std::f64::consts::TAU;

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
    /// Disturbance at the end of the lap by the one at its start, of η, η̇ and `sliders`.
    pub matrix: Mat<f64>,
    /// Number of coordinates η.
    pub n_modes: usize,
    /// Shapes of the coordinates in the modes of the linear model's parts, part by part. Shape: modes × coordinates of the part.
    pub shapes: Vec<Mat<f64>>,
    /// Sliders that remember: pair and direction.
    pub sliders: Vec<[usize; 2]>,
    /// Laps in one period: 2 where the pairs of both sides are marched over half a period and then change their sides.
    pub laps: usize,
}

/// Re and Im of the root a.
pub(super) const ROOT: [f64; 2] = [3.0, 1.732_050_807_568_877_2];

impl PeriodMap {
    /// The maps of `motion` of `problem`, one for each symmetry, with `n_steps` steps per period; `None` for travelling waves,
    /// and for a structure that needs too many coordinates.
    #[must_use]
    pub fn all(
        problem: &Problem<'_>,
        motion: &PeriodicMotion<'_>,
        n_steps: usize,
    ) -> Option<Vec<Self>> {
        let structures = Disturbed::all(problem, motion.omega)?;
        let pairs = pair_steps(problem, motion, n_steps);
        let map = |structure: &Disturbed| March::new(structure, &pairs, motion.omega).lap();
        Some(structures.iter().map(map).collect())
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

/// The march of all unit disturbances through one lap.
struct March<'a> {
    structure: &'a Disturbed,
    pairs: &'a [PairSteps],
    /// h (s).
    step: f64,
    n_steps: usize,
    sliders: Vec<[usize; 2]>,
    /// Disturbances, one column each: η, η̇ and the sliders `[direction][pair]`.
    eta: Mat<f64>,
    rate: Mat<f64>,
    slider: Mat<f64>,
    /// B η now.
    relative: Mat<f64>,
}

/// A step with the contact derivatives in it.
struct Prepared {
    /// K, and `factor` Bᵀ E.
    stiffness: Mat<f64>,
    slider_load: Mat<f64>,
    /// Factors of Z.
    dynamic: PartialPivLu<c64>,
}

impl<'a> March<'a> {
    fn new(structure: &'a Disturbed, pairs: &'a [PairSteps], omega: f64) -> Self {
        let n_steps = pairs.first().map_or(0, |pair| pair.steps.len());
        let n_pairs = structure.n_pairs();
        let mut march = Self {
            structure,
            pairs,
            step: TAU / omega / n_steps as f64,
            n_steps,
            sliders: Vec::new(),
            eta: Mat::new(),
            rate: Mat::new(),
            slider: Mat::new(),
            relative: Mat::new(),
        };
        let remembers = |pair: usize, d: usize| {
            let first = march.at(0, pair);
            let moves = pairs[pair % pairs.len()].moves[d];
            let kept = (0..2).any(|row| first.memory[row][d] != 0.0 || first.kept[row][d] != 0.0);
            moves && kept
        };
        let all = (0..n_pairs).flat_map(|pair| [[pair, 0], [pair, 1]]);
        let sliders: Vec<_> = all.filter(|&[pair, d]| remembers(pair, d)).collect();
        let n = structure.lambda.len();
        let width = 2 * n + sliders.len();
        let unit = |first: usize| move |i: usize, j: usize| f64::from(u8::from(j == first + i));
        march.eta = Mat::from_fn(n, width, unit(0));
        march.rate = Mat::from_fn(n, width, unit(n));
        march.relative = &structure.contact * &march.eta;
        march.slider = Mat::zeros(2 * n_pairs, width);
        for (i, &[pair, d]) in sliders.iter().enumerate() {
            march.slider[(d * n_pairs + pair, 2 * n + i)] = 1.0;
        }
        march.sliders = sliders;
        march
    }

    /// Derivatives of a pair in a step; a pair of the other side is half a period ahead.
    fn at(&self, step: usize, pair: usize) -> &'a PairStep {
        let ahead = pair / self.pairs.len() * (self.n_steps / 2);
        &self.pairs[pair % self.pairs.len()].steps[(step + ahead) % self.n_steps]
    }

    fn lap(mut self) -> PeriodMap {
        let sides = self.structure.sides;
        let mut prepared = None;
        for step in 0..self.n_steps / sides {
            let same = |pair| step > 0 && self.at(step, pair) == self.at(step - 1, pair);
            if !(0..self.structure.n_pairs()).all(same) {
                prepared = None;
            }
            let prepared = prepared.get_or_insert_with(|| self.prepare(step));
            self.advance(step, prepared);
        }
        let (n, n_pairs) = (self.eta.nrows(), self.structure.n_pairs());
        let sign = |i: usize| {
            if i < self.structure.first_odd {
                1.0
            } else {
                -1.0
            }
        };
        let width = self.eta.ncols();
        let matrix = Mat::from_fn(width, width, |i, j| match i.checked_sub(2 * n) {
            None if i < n => sign(i) * self.eta[(i, j)],
            None => sign(i - n) * self.rate[(i - n, j)],
            Some(i) => {
                let [pair, d] = self.sliders[i];
                let before = (pair + (sides - 1) * self.pairs.len()) % n_pairs;
                self.slider[(d * n_pairs + before, j)]
            }
        });
        PeriodMap {
            matrix,
            n_modes: n,
            shapes: self.structure.shapes.clone(),
            sliders: self.sliders,
            laps: sides,
        }
    }

    fn prepare(&self, step: usize) -> Prepared {
        let structure = self.structure;
        let (n, n_pairs) = (structure.lambda.len(), structure.n_pairs());
        let b = &structure.contact;
        let mut by_eta = Mat::<f64>::zeros(3 * n_pairs, n);
        let mut by_slider = Mat::<f64>::zeros(3 * n_pairs, 2 * n_pairs);
        for pair in 0..n_pairs {
            let at = self.at(step, pair);
            for (row, stiffness) in at.stiffness.iter().enumerate() {
                let i = row * n_pairs + pair;
                for (column, &d) in stiffness.iter().enumerate().filter(|(_, d)| **d != 0.0) {
                    let from = column * n_pairs + pair;
                    (0..n).for_each(|j| by_eta[(i, j)] += d * b[(from, j)]);
                }
            }
            for (row, memory) in at.memory.iter().enumerate() {
                for (column, &e) in memory.iter().enumerate() {
                    by_slider[(row * n_pairs + pair, column * n_pairs + pair)] = e;
                }
            }
        }
        let load = b.transpose() * Scale(structure.factor);
        let mut stiffness = &load * &by_eta;
        (0..n).for_each(|i| stiffness[(i, i)] += structure.lambda[i]);
        let s = c64::new(ROOT[0], ROOT[1]) / self.step;
        let dynamic = Mat::from_fn(n, n, |i, j| {
            let inertia = if i == j { s * s } else { c64::new(0.0, 0.0) };
            inertia + s * structure.damping[(i, j)] + stiffness[(i, j)]
        });
        Prepared {
            slider_load: &load * &by_slider,
            stiffness,
            dynamic: dynamic.partial_piv_lu(),
        }
    }

    fn advance(&mut self, step: usize, prepared: &Prepared) {
        let h = self.step;
        let pull = &prepared.stiffness * &self.eta + &prepared.slider_load * &self.slider;
        let a = c64::new(ROOT[0], ROOT[1]);
        let s = a / h;
        let (n, width) = (self.eta.nrows(), self.eta.ncols());
        let mut p = Mat::from_fn(n, width, |i, j| {
            (s * self.rate[(i, j)] - pull[(i, j)]) * (-1.0 / h)
        });
        prepared.dynamic.solve_in_place(&mut p);
        let factor = 4.0 * ROOT[1];
        for j in 0..width {
            for i in 0..n {
                self.eta[(i, j)] += factor * h * p[(i, j)].im;
                self.rate[(i, j)] += factor * (a * p[(i, j)]).im;
            }
        }
        let after = &self.structure.contact * &self.eta;
        let before = std::mem::replace(&mut self.relative, after);
        self.move_sliders(step, &before);
    }

    /// Moves the sliders through a step that began at the displacements `before`.
    fn move_sliders(&mut self, step: usize, before: &Mat<f64>) {
        let n_pairs = self.structure.n_pairs();
        for pair in 0..n_pairs {
            let at = self.at(step, pair);
            for j in 0..self.slider.ncols() {
                let old = [self.slider[(pair, j)], self.slider[(n_pairs + pair, j)]];
                for d in 0..2 {
                    let mut moved = at.kept[d][0] * old[0] + at.kept[d][1] * old[1];
                    for c in 0..3 {
                        let row = c * n_pairs + pair;
                        moved += at.by_start[d][c] * before[(row, j)];
                        moved += at.by_end[d][c] * self.relative[(row, j)];
                    }
                    self.slider[(d * n_pairs + pair, j)] = moved;
                }
            }
        }
    }
}
