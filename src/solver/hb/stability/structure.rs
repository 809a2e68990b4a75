//! The structure that disturbances move in: one set of coordinates for each symmetry that disturbances may have.
//!
//! Its shapes are the low modes of the free structure, and of the high modes what they do together under static forces of the
//! contacts, each with its mass (component modes with residual inertia). A static compliance without mass will not do: where friction
//! slips under a normal force which moves with it, such contacts let disturbances grow that die out once all modes have their
//! mass, on the rig by up to 1e6 per period.
//!
//! Source: Rubin, AIAA J. 13, 995–1006, 1975 (residual modes with their inertia).

use crate::hb::equations::problem::Problem;
use crate::hb::structure::linear::{ModalPart, held_stiffness};
use crate::linalg::{Scalar, symmetric_eigen, symmetric_generalized_eigen};
use faer::Side;
use faer::prelude::*;

/// Modes of the free structure up to this multiple of the excitation frequency are coordinates of their own.
const HIGHEST: f64 = 20.0;

/// A pattern of contact forces that moves the higher modes by more than this share of what it deforms the stuck contacts becomes a
/// coordinate.
const SOFT: f64 = 0.1;

/// Most coordinates; a structure that needs more is not assessed.
const MOST_COORDINATES: usize = 1500;

/// The structure for disturbances of one symmetry, in its modes q with stuck contacts: q̈ + C q̇ + Λ q = −`factor` Bᵀ (f − D_stuck r), r = B q,
/// with the stiffness D_stuck of stuck contacts, which Λ has in it.
#[derive(Debug)]
pub(super) struct Disturbed {
    /// Λ, diagonal (1/s²). Shape: `[n]`.
    pub(super) lambda: Vec<f64>,
    /// C (1/s), part by part. Shape: square, coordinates of the part.
    pub(super) damping: Vec<Mat<f64>>,
    /// B. Shape: 3 · pairs × n, rows ordered t1 of every pair, t2, n; pairs of the other side after those of this one.
    pub(super) contact: Mat<f64>,
    /// D_stuck, diagonal (N/m). Shape: `[3 · pairs]`.
    pub(super) stuck: Vec<f64>,
    /// Contacts that one of the pairs stands for.
    pub(super) factor: f64,
    /// 2 if the pairs are those of both sides, and the motion of the other side is that of this one half a period later; else 1.
    pub(super) sides: usize,
    /// Coordinates from this one on change their sign under the mirror.
    pub(super) first_odd: usize,
    /// Shapes of the coordinates in the modes of the parts, part by part.
    pub(super) shapes: Vec<Mat<f64>>,
}

impl Disturbed {
    /// The structure for every symmetry that disturbances of a solution of `problem` may have; `None` for a sector of a
    /// disk, where they belong to all nodal diameters, and for a structure that needs too many coordinates.
    pub(super) fn all(problem: &Problem<'_>, omega: f64) -> Option<Vec<Self>> {
        let model = problem.model;
        let stuck = &problem.stuck_stiffness;
        if model.alternates {
            let both = Self::new(&[&model.parts[0], &model.parts[1]], stuck, omega);
            return Some(vec![both?]);
        }
        let [part] = &model.parts[..] else {
            return None;
        };
        if model.ring.is_some() {
            return None;
        }
        let parts = [part].into_iter().chain(&model.breaking);
        parts.map(|part| Self::new(&[part], stuck, omega)).collect()
    }

    /// Both parities with the pairs of both sides, or one part alone, with contacts of the stiffness `stuck` (N/m).
    fn new(parts: &[&ModalPart], stuck: &[f64], omega: f64) -> Option<Self> {
        let sides = parts.len();
        let cut = (HIGHEST * omega).powi(2);
        let shapes: Vec<(Vec<f64>, Mat<f64>)> = (parts.iter())
            .map(|part| stuck_shapes(part, stuck, cut))
            .collect::<Option<_>>()?;
        let n = shapes.iter().map(|(lambda, _)| lambda.len()).sum();
        if n > MOST_COORDINATES {
            return None;
        }
        let rows = sides * parts[0].contact.nrows();
        let mut disturbed = Self {
            lambda: Vec::with_capacity(n),
            damping: Vec::with_capacity(sides),
            contact: Mat::zeros(rows, n),
            stuck: (stuck.chunks_exact((stuck.len() / 3).max(1)))
                .flat_map(|component| component.repeat(sides))
                .collect(),
            factor: parts[0].multiplicity / sides as f64,
            sides,
            first_odd: if sides == 2 { shapes[0].0.len() } else { n },
            shapes: Vec::with_capacity(sides),
        };
        for (parity, (part, (lambda, shapes))) in parts.iter().zip(shapes).enumerate() {
            disturbed.add(part, &lambda, shapes, parity == 1);
        }
        Some(disturbed)
    }

    /// Adds coordinates with these `shapes` in the modes of a part.
    fn add(&mut self, part: &ModalPart, lambda: &[f64], shapes: Mat<f64>, odd: bool) {
        let (first, n) = (self.lambda.len(), lambda.len());
        let structure = &part.structure;
        let mut damped = Mat::from_fn(shapes.nrows(), n, |i, j| {
            structure.damping[i] * shapes[(i, j)]
        });
        let coupled = &structure.coupling;
        for (a, &i) in coupled.modes.iter().enumerate() {
            for (b, &k) in coupled.modes.iter().enumerate() {
                let c = coupled.damping.real[(a, b)];
                (0..n).for_each(|j| damped[(i, j)] += c * shapes[(k, j)]);
            }
        }
        self.damping.push(shapes.transpose() * damped);
        let contact = both_sides(&(&part.contact.real * &shapes), self.sides, odd);
        (0..n).for_each(|j| self.contact.col_mut(first + j).copy_from(contact.col(j)));
        self.lambda.extend(lambda);
        self.shapes.push(shapes);
    }

    /// Number of pairs, of both sides where there are two.
    pub(super) fn n_pairs(&self) -> usize {
        self.contact.nrows() / 3
    }
}

/// A wave of a disk for disturbances, in coordinates η: η̈ + Ĉ η̇ + Λ η = −Bᴴ f, r = B η.
#[derive(Debug)]
pub(super) struct DisturbedWave {
    /// Λ, diagonal (1/s²). Shape: `[n]`.
    pub(super) lambda: Vec<f64>,
    /// Ĉ (1/s), Hermitian. Shape: n × n.
    pub(super) damping: Mat<c64>,
    /// B of one sector. Shape: 3 · pairs × n, rows ordered t1 of every pair, t2, n.
    pub(super) contact: Mat<c64>,
}

/// Coordinates of a wave whose squares add up to its energy with stuck contacts: √(Λ_s + ω²) Uᴴ η, with the stuck modes U.
#[derive(Debug)]
pub(super) struct EnergyNorm {
    /// U. Shape: n × n.
    pub(super) modes: Mat<c64>,
    /// √(Λ_s + ω²) (1/s). Shape: `[n]`.
    pub(super) scales: Vec<f64>,
}

impl EnergyNorm {
    /// The energy coordinates of each column of η.
    pub(super) fn energy_coordinates(&self, eta: &Mat<c64>) -> Mat<c64> {
        let mut along = self.modes.adjoint() * eta;
        for j in 0..along.ncols() {
            let scaled = along.col_as_slice_mut(j).iter_mut().zip(&self.scales);
            scaled.for_each(|(x, scale)| *x *= *scale);
        }
        along
    }

    /// η of each column of energy coordinates.
    pub(super) fn eta(&self, x: &Mat<c64>) -> Mat<c64> {
        let along = Mat::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] / self.scales[i]);
        &self.modes * along
    }
}

impl DisturbedWave {
    /// Its energy with contacts of the stiffness `stuck` (N/m); `None` if the eigenvalue iteration fails.
    pub(super) fn energy_norm(&self, stuck: &[f64], omega: f64) -> Option<EnergyNorm> {
        let n = self.lambda.len();
        let stiffness = held_stiffness(&self.lambda, &self.contact, 1.0, stuck);
        let real = |z: &c64| z.im == 0.0;
        let all_real = (0..n).all(|j| stiffness.col(j).iter().all(real));
        // a wave that stands keeps real coordinates
        let (lambda, modes) = match all_real {
            true => {
                let part = Mat::from_fn(n, n, |i, j| stiffness[(i, j)].re);
                let (lambda, modes) = symmetric_eigen(part.as_ref()).ok()?;
                (
                    lambda,
                    Mat::from_fn(n, n, |i, j| c64::new(modes[(i, j)], 0.0)),
                )
            }
            false => symmetric_eigen(stiffness.as_ref()).ok()?,
        };
        let scale = |l: &f64| (l.max(0.0) + omega * omega).sqrt();
        Some(EnergyNorm {
            scales: lambda.iter().map(scale).collect(),
            modes,
        })
    }

    /// The wave `part` at the frequency `omega` (rad/s), with contacts of the stiffness `stuck` (N/m).
    pub(super) fn new(part: &ModalPart, stuck: &[f64], omega: f64) -> Option<Self> {
        let cut = (HIGHEST * omega).powi(2);
        let contact = part.contact.complex();
        // a wave that stands has real shapes, so that disturbances keep real coordinates
        let (lambda, shapes) = match part.is_real() {
            false => shapes(part, &contact, stuck, cut)?,
            true => {
                let (lambda, shapes) = shapes(part, &part.contact.real, stuck, cut)?;
                let complex = |i, j| c64::new(shapes[(i, j)], 0.0);
                (
                    lambda,
                    Mat::from_fn(shapes.nrows(), shapes.ncols(), complex),
                )
            }
        };
        let n = lambda.len();
        let mut damped = Mat::zeros(shapes.nrows(), n);
        for j in 0..n {
            let eta: Vec<c64> = shapes.col(j).iter().copied().collect();
            let column = part.structure.damp(&eta);
            (column.iter().enumerate()).for_each(|(i, c)| damped[(i, j)] = *c);
        }
        Some(Self {
            lambda,
            damping: shapes.adjoint() * damped,
            contact: contact * shapes,
        })
    }
}

/// Λ of the modes with contacts of the stiffness `stuck` (N/m) among the [`shapes`] of a part, and their shapes in its modes.
fn stuck_shapes(part: &ModalPart, stuck: &[f64], cut: f64) -> Option<(Vec<f64>, Mat<f64>)> {
    let (lambda, shapes) = shapes(part, &part.contact.real, stuck, cut)?;
    let contact = &part.contact.real * &shapes;
    let stiffness = held_stiffness(&lambda, &contact, part.multiplicity, stuck);
    let (lambda, turned) = symmetric_eigen(stiffness.as_ref()).ok()?;
    Some((lambda, shapes * turned))
}

/// Λ of the coordinates, and their shapes in the modes of the part: its modes up to `cut` (1/s²), and of the others those
/// deflections under patterns of contact forces that are soft beside contacts of the stiffness `stuck` (N/m). `contact` are the
/// relative displacements of the part's modes. `None` if an eigenvalue iteration fails.
fn shapes<E: Scalar>(
    part: &ModalPart,
    contact: &Mat<E>,
    stuck: &[f64],
    cut: f64,
) -> Option<(Vec<f64>, Mat<E>)> {
    let lambda = &part.structure.lambda;
    let low = lambda.partition_point(|&l| l <= cut);
    let n = lambda.len();
    // forces of the contacts on the higher modes, as large as the contacts are stiff: F = Bᴴ K^½, and what they move: Λ⁻¹ F
    let reached = contact.adjoint().to_owned();
    let forces = Mat::from_fn(n - low, stuck.len(), |j, i| {
        reached[(low + j, i)] * (part.multiplicity * stuck[i]).sqrt()
    });
    let moved = Mat::from_fn(n - low, stuck.len(), |j, i| {
        forces[(j, i)] / lambda[low + j]
    });
    let compliance = forces.adjoint() * &moved;
    let patterns = compliance.self_adjoint_eigen(Side::Lower).ok()?;
    let soft: Vec<usize> = (0..stuck.len())
        .filter(|&k| patterns.S()[k].real_part() > SOFT)
        .collect();
    let soft = Mat::from_fn(stuck.len(), soft.len(), |i, k| patterns.U()[(i, soft[k])]);
    let moved = moved * soft;
    let pushed = Mat::from_fn(moved.nrows(), moved.ncols(), |j, k| {
        moved[(j, k)] * lambda[low + j]
    });
    let (stiffness, mass) = (moved.adjoint() * pushed, moved.adjoint() * &moved);
    let (high, turned) = symmetric_generalized_eigen(stiffness.as_ref(), mass.as_ref()).ok()?;
    let high_shapes = moved * turned;
    let shapes = Mat::from_fn(n, low + high.len(), |i, j| {
        match (i.checked_sub(low), j.checked_sub(low)) {
            (Some(i), Some(j)) => high_shapes[(i, j)],
            (None, None) if i == j => E::from(1.0),
            _ => E::from(0.0),
        }
    });
    Some((lambda[..low].iter().copied().chain(high).collect(), shapes))
}

/// Rows of one side, followed component by component by those of the other side where there are two.
fn both_sides(contact: &Mat<f64>, sides: usize, odd: bool) -> Mat<f64> {
    let pairs = contact.nrows() / 3;
    let sign = if odd { -1.0 } else { 1.0 };
    Mat::from_fn(sides * contact.nrows(), contact.ncols(), |i, j| {
        let (component, pair) = (i / (sides * pairs), i % (sides * pairs));
        let value = contact[(component * pairs + pair % pairs, j)];
        if pair < pairs { value } else { sign * value }
    })
}
