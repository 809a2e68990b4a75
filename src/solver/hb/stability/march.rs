//! The march of all unit disturbances through one lap.
//!
//! Over one step the contact has the constant derivatives D (forces by displacements) and E (tractions by sliders). In the modes q of the
//! structure with stuck contacts only those have a force g that do not stick, or whose sliders are disturbed:
//!
//! ```text
//! q̈ + C q̇ + Λ q = Bᵀ g,   g = Δ B q − E w,   Δ = D_stuck − D
//! ```
//!
//! Without damping the step is a linear system with constant coefficients,
//!
//! ```text
//! y' = A y + b,   y = (q, q̇),   A = [0, I; Bᵀ Δ B − Λ, 0],   b = −(0, Bᵀ E w)
//! y₁ = y₀ + h (I − h A/2 + h² A²/12)⁻¹ (A y₀ + b)
//! ```
//!
//! by Gauss' method with two stages. The polynomial has the roots a, ā = 3 ± i√3, so that a step takes one solve at the complex
//! frequency s = a/h, and the diagonal Y = (Λ + s²)⁻¹ leaves only the forces g as unknowns of it:
//!
//! ```text
//! (1 − Δ X) g = Δ B Y (s² q₀ + s q̇₀) − E w,   X = B Y Bᵀ
//! p = Y (Λ q₀ − s q̇₀ − Bᵀ g)
//! q₁ = q₀ + 4√3 Im p,   q̇₁ = q̇₀ + 4√3 Im (a p)/h
//! ```
//!
//! Damping acts before and after each step, by exp(−C h/2). So split, the step still takes from a mode what damping takes:
//! the determinant of the map is exact.
//!
//! Source of the splitting: Strang, SIAM J. Numer. Anal. 5, 506–517, 1968.

use super::contact_steps::{PairStep, PairSteps};
use super::march_step::MarchStep;
use super::structure::Disturbed;
use crate::linalg::symmetric_eigen;
use faer::linalg::matmul::matmul;
use faer::prelude::*;
use faer::{Accum, Par};
use std::f64::consts::TAU;

/// Re and Im of the root a.
pub(super) const ROOT: [f64; 2] = [3.0, 1.732_050_807_568_877_2];

/// All disturbances during the march through a lap.
pub(super) struct March<'a> {
    structure: &'a Disturbed,
    pairs: &'a [PairSteps],
    n_steps: usize,
    stuck: StuckStep,
    /// Sliders that remember: pair and direction.
    pub(super) sliders: Vec<[usize; 2]>,
    /// Disturbances, one column each: q, q̇ and the sliders `[direction][pair]`.
    q: Mat<f64>,
    rate: Mat<f64>,
    slider: Mat<f64>,
    /// Y (s² q + s q̇), later Bᵀ g: real parts of all disturbances, then imaginary ones. Shape: n × 2 · disturbances.
    stage: Mat<f64>,
}

/// A step of the structure with stuck contacts: what its modes do alone.
struct StuckStep {
    /// h (s).
    length: f64,
    /// Y, real and imaginary part.
    receptance: [Vec<f64>; 2],
    /// a Y.
    turned: [Vec<f64>; 2],
    /// s² Y and s Y.
    by_q: [Vec<f64>; 2],
    by_rate: [Vec<f64>; 2],
    /// X. Shape: 3 · pairs square.
    compliance: Mat<c64>,
    /// exp(−C h/2) and exp(−C h), part by part.
    half_decay: Vec<Mat<f64>>,
    decay: Vec<Mat<f64>>,
}

impl StuckStep {
    fn new(structure: &Disturbed, length: f64) -> Option<Self> {
        let a = c64::new(ROOT[0], ROOT[1]);
        let s = a / length;
        let y: Vec<c64> = (structure.lambda.iter())
            .map(|lambda| 1.0 / (s * s + *lambda))
            .collect();
        let parts = |factor: c64| -> [Vec<f64>; 2] {
            let product = y.iter().map(|y| factor * y);
            [
                product.clone().map(|z| z.re).collect(),
                product.map(|z| z.im).collect(),
            ]
        };
        let b = &structure.contact;
        let moved = Mat::from_fn(b.ncols(), b.nrows(), |j, i| {
            structure.factor * b[(i, j)] * y[j]
        });
        let complex = Mat::from_fn(b.nrows(), b.ncols(), |i, j| c64::new(b[(i, j)], 0.0));
        let half_decay: Vec<Mat<f64>> = (structure.damping.iter())
            .map(|damping| decay(damping, length / 2.0))
            .collect::<Option<_>>()?;
        Some(Self {
            length,
            receptance: parts(c64::new(1.0, 0.0)),
            turned: parts(a),
            by_q: parts(s * s),
            by_rate: parts(s),
            compliance: complex * moved,
            decay: half_decay.iter().map(|half| half * half).collect(),
            half_decay,
        })
    }
}

/// exp(−C t); `None` if the eigenvalues of C are not found.
fn decay(damping: &Mat<f64>, time: f64) -> Option<Mat<f64>> {
    let (rates, shapes) = symmetric_eigen(damping.as_ref()).ok()?;
    let decayed = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, j| {
        shapes[(i, j)] * libm::exp(-rates[j] * time)
    });
    Some(decayed * shapes.transpose())
}

impl<'a> March<'a> {
    /// All unit disturbances at the start of a lap; `None` if eigenvalues of the damping are not found.
    pub(super) fn new(
        structure: &'a Disturbed,
        pairs: &'a [PairSteps],
        omega: f64,
    ) -> Option<Self> {
        let n_steps = pairs.first().map_or(0, |pair| pair.steps.len());
        let stuck = StuckStep::new(structure, TAU / omega / n_steps as f64)?;
        let n_pairs = structure.n_pairs();
        let remembers = |pair: usize, d: usize| {
            let first = at(pairs, 0, pair);
            let moves = pairs[pair % pairs.len()].moves[d];
            let kept = (0..2).any(|row| first.memory[row][d] != 0.0 || first.kept[row][d] != 0.0);
            moves && kept
        };
        let all = (0..n_pairs).flat_map(|pair| [[pair, 0], [pair, 1]]);
        let sliders: Vec<_> = all.filter(|&[pair, d]| remembers(pair, d)).collect();
        let n = structure.lambda.len();
        let width = 2 * n + sliders.len();
        let unit = |first: usize| move |i: usize, j: usize| f64::from(u8::from(j == first + i));
        let mut slider = Mat::zeros(2 * n_pairs, width);
        for (i, &[pair, d]) in sliders.iter().enumerate() {
            slider[(d * n_pairs + pair, 2 * n + i)] = 1.0;
        }
        let mut march = Self {
            structure,
            pairs,
            n_steps,
            stuck,
            sliders,
            q: Mat::from_fn(n, width, unit(0)),
            rate: Mat::from_fn(n, width, unit(n)),
            slider,
            stage: Mat::zeros(n, 2 * width),
        };
        march.rate = damped(&march.stuck.half_decay, &march.rate);
        Some(march)
    }

    /// What a lap makes of them: the matrix of the map.
    pub(super) fn lap(mut self) -> Mat<f64> {
        let n_steps = self.n_steps / self.structure.sides;
        let mut before: Option<(Vec<&PairStep>, MarchStep)> = None;
        for step in 0..n_steps {
            let pairs = 0..self.structure.n_pairs();
            let now: Vec<_> = pairs.map(|pair| at(self.pairs, step, pair)).collect();
            let (_, derivatives) = match before.take() {
                Some(same) if same.0 == now => before.insert(same),
                _ => {
                    let compliance = self.stuck.compliance.as_ref();
                    let new = MarchStep::new(self.structure, &now, compliance);
                    before.insert((now, new))
                }
            };
            self.advance(derivatives);
            let decay = match step + 1 == n_steps {
                true => &self.stuck.half_decay,
                false => &self.stuck.decay,
            };
            self.rate = damped(decay, &self.rate);
        }
        self.matrix()
    }

    /// One step without damping.
    fn advance(&mut self, step: &MarchStep) {
        let mut slid = &step.slides.by_start * &self.q;
        self.pull(step);
        self.move_structure();
        slid += &step.slides.by_end * &self.q;
        for (i, moved) in step.slides.moved.iter().enumerate() {
            for (row, kept) in moved.kept.into_iter().filter(|(_, kept)| *kept != 0.0) {
                (0..slid.ncols()).for_each(|j| slid[(i, j)] += kept * self.slider[(row, j)]);
            }
        }
        for (i, moved) in step.slides.moved.iter().enumerate() {
            (0..slid.ncols()).for_each(|j| self.slider[(moved.row, j)] = slid[(i, j)]);
        }
    }

    /// Bᵀ g into the stage.
    fn pull(&mut self, step: &MarchStep) {
        let width = self.q.ncols();
        let [q_re, q_im] = &self.stuck.by_q;
        let [rate_re, rate_im] = &self.stuck.by_rate;
        for j in 0..width {
            let (q, rate) = (self.q.col_as_slice(j), self.rate.col_as_slice(j));
            weighted([q_re, rate_re], [q, rate], self.stage.col_as_slice_mut(j));
            let imaginary = self.stage.col_as_slice_mut(width + j);
            weighted([q_im, rate_im], [q, rate], imaginary);
        }
        let (first, all) = (step.released.nrows(), step.load.ncols());
        let released = &step.released * &self.stage;
        let mut real = Mat::zeros(all, width);
        for &(i, slider, derivative) in &step.memory {
            (0..width).for_each(|j| real[(i, j)] -= derivative * self.slider[(slider, j)]);
        }
        let by_others = &step.by_others * real.subrows(first, all - first);
        let mut free = Mat::zeros(first, width);
        for j in 0..width {
            let own = real.col_as_slice(j);
            let others = by_others.col_as_slice(j);
            let [re, im] = [j, width + j].map(|j| released.col_as_slice(j));
            for (i, g) in free.col_as_slice_mut(j).iter_mut().enumerate() {
                *g = c64::new(own[i] + re[i] + others[i], im[i] + others[first + i]);
            }
        }
        step.coupled.solve_in_place(&mut free);
        let mut imaginary = Mat::zeros(first, width);
        for j in 0..width {
            let [re, im] = [&mut real, &mut imaginary].map(|of| of.col_as_slice_mut(j));
            for (i, g) in free.col_as_slice(j).iter().enumerate() {
                (re[i], im[i]) = (g.re, g.im);
            }
        }
        let (re, im) = self.stage.as_mut().split_at_col_mut(width);
        let load = step.load.as_ref();
        matmul(re, Accum::Replace, load, real.as_ref(), 1.0, Par::Seq);
        let load = load.subcols(0, first);
        matmul(im, Accum::Replace, load, imaginary.as_ref(), 1.0, Par::Seq);
    }

    /// The step of the structure under the forces in the stage.
    fn move_structure(&mut self) {
        let StuckStep {
            length,
            receptance: [y_re, y_im],
            turned: [turned_re, turned_im],
            ..
        } = &self.stuck;
        let [s_re, s_im] = ROOT.map(|part| part / length);
        let factor = 4.0 * ROOT[1];
        let (n, width) = (self.q.nrows(), self.q.ncols());
        let lambda = &self.structure.lambda[..n];
        let [y_re, y_im, turned_re, turned_im] =
            [y_re, y_im, turned_re, turned_im].map(|all| &all[..n]);
        for j in 0..width {
            let q = &mut self.q.col_as_slice_mut(j)[..n];
            let rate = &mut self.rate.col_as_slice_mut(j)[..n];
            let real = &self.stage.col_as_slice(j)[..n];
            let imaginary = &self.stage.col_as_slice(width + j)[..n];
            for i in 0..n {
                let re = lambda[i] * q[i] - s_re * rate[i] - real[i];
                let im = -s_im * rate[i] - imaginary[i];
                q[i] += factor * (y_re[i] * im + y_im[i] * re);
                rate[i] += factor / length * (turned_re[i] * im + turned_im[i] * re);
            }
        }
    }

    /// The disturbances at the end of a lap; after half a period the sides change.
    fn matrix(&self) -> Mat<f64> {
        let Disturbed {
            sides, first_odd, ..
        } = *self.structure;
        let (n, n_pairs) = (self.q.nrows(), self.structure.n_pairs());
        let sign = |i: usize| if i < first_odd { 1.0 } else { -1.0 };
        let width = self.q.ncols();
        Mat::from_fn(width, width, |i, j| match i.checked_sub(2 * n) {
            None if i < n => sign(i) * self.q[(i, j)],
            None => sign(i - n) * self.rate[(i - n, j)],
            Some(i) => {
                let [pair, d] = self.sliders[i];
                let before = (pair + (sides - 1) * self.pairs.len()) % n_pairs;
                self.slider[(d * n_pairs + before, j)]
            }
        })
    }
}

/// Rates after damping alone.
fn damped(decay: &[Mat<f64>], rate: &Mat<f64>) -> Mat<f64> {
    let mut after = Mat::zeros(rate.nrows(), rate.ncols());
    let mut first = 0;
    for of_part in decay {
        let n = of_part.nrows();
        let to = after.as_mut().subrows_mut(first, n);
        let from = rate.subrows(first, n);
        matmul(to, Accum::Replace, of_part.as_ref(), from, 1.0, Par::Seq);
        first += n;
    }
    after
}

/// Derivatives of a pair in a step; a pair of the other side is half a period ahead.
fn at(pairs: &[PairSteps], step: usize, pair: usize) -> &PairStep {
    let steps = &pairs[pair % pairs.len()].steps;
    let ahead = pair / pairs.len() * (steps.len() / 2);
    &steps[(step + ahead) % steps.len()]
}

/// Σ weights · of, entry by entry.
fn weighted(weights: [&[f64]; 2], of: [&[f64]; 2], to: &mut [f64]) {
    let n = to.len();
    let [a, b] = weights.map(|all| &all[..n]);
    let [x, y] = of.map(|all| &all[..n]);
    for i in 0..n {
        to[i] = a[i] * x[i] + b[i] * y[i];
    }
}
