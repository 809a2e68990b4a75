//! The inverse Jacobian of the free form at one solution, in single precision: a preconditioner for solutions of samples close
//! by. What differs between their Jacobians is little: a resonance that is detuned, and some contact states.

use super::balance::ContactResponse;
use super::free::{FreeBalance, FreeMotion};
use crate::hb::structure::linear::ModalPart;
use crate::linalg::single::round;
use crate::linalg::split::SplitMat;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::DenseSolveCore;
use faer::prelude::*;
use faer::{Accum, Par};
use pulp::{Arch, Simd, WithSimd};

/// Rows that are multiplied together: they lie side by side in memory, column by column.
const PANEL: usize = 64;
/// Vector registers of one sum.
const REGISTERS: usize = 4;

/// J⁻¹ of one point.
#[derive(Debug)]
pub struct InverseJacobian {
    size: usize,
    /// Shape: `[panel][column][PANEL]`.
    panels: Vec<f32>,
}

impl InverseJacobian {
    /// The inverse at a point with these contact forces and this motion; none if it is not finite.
    #[must_use]
    pub fn new(
        free: &FreeBalance<'_>,
        contact: &ContactResponse,
        motion: &FreeMotion,
    ) -> Option<Self> {
        let inverse = jacobian(free, contact, motion).partial_piv_lu().inverse();
        let size = inverse.nrows();
        let mut panels = vec![0.0; size.div_ceil(PANEL) * PANEL * size];
        for (p, panel) in panels.chunks_exact_mut(PANEL * size).enumerate() {
            let rows = p * PANEL..size.min((p + 1) * PANEL);
            for (j, column) in panel.chunks_exact_mut(PANEL).enumerate() {
                round(&inverse.col_as_slice(j)[rows.clone()], column);
            }
        }
        let is_finite = panels.iter().all(|x| x.is_finite());
        is_finite.then_some(Self { size, panels })
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// Writes all entries, column by column.
    #[cfg(feature = "gpu")]
    pub(crate) fn columns(&self, out: &mut [f32]) {
        for (p, panel) in self.panels.chunks_exact(PANEL * self.size).enumerate() {
            let columns = out.chunks_exact_mut(self.size);
            for (column, rows) in columns.zip(panel.chunks_exact(PANEL)) {
                let column = &mut column[p * PANEL..];
                let n = column.len().min(PANEL);
                column[..n].copy_from_slice(&rows[..n]);
            }
        }
    }

    /// J⁻¹ x for each `x`. Two together read the matrix once.
    #[must_use]
    pub fn times(&self, x: &[Vec<f32>]) -> Vec<Vec<f32>> {
        let pairs = x.chunks(2).map(|x| match x {
            [a, b] => Vec::from(Arch::new().dispatch(Times {
                inverse: self,
                x: [a, b],
            })),
            [a] => Vec::from(Arch::new().dispatch(Times {
                inverse: self,
                x: [a],
            })),
            _ => Vec::new(),
        });
        pairs.flatten().collect()
    }
}

/// The arguments of [`InverseJacobian::times`], for the instruction set that is found at run time.
struct Times<'a, const K: usize> {
    inverse: &'a InverseJacobian,
    x: [&'a [f32]; K],
}

impl<const K: usize> WithSimd for Times<'_, K> {
    type Output = [Vec<f32>; K];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Vec<f32>; K] {
        let Self { inverse, x } = self;
        let size = inverse.size;
        let mut y: [Vec<f32>; K] = std::array::from_fn(|_| vec![0.0; size.next_multiple_of(PANEL)]);
        let width = PANEL / (size_of::<S::f32s>() / size_of::<f32>());
        for (p, panel) in inverse.panels.chunks_exact(PANEL * size).enumerate() {
            let panel = S::as_simd_f32s(panel).0;
            for first in (0..width).step_by(REGISTERS) {
                let mut sums = [[simd.splat_f32s(0.0); REGISTERS]; K];
                for (j, column) in panel.chunks_exact(width).enumerate() {
                    let column = &column[first..][..REGISTERS];
                    for (sums, x) in sums.iter_mut().zip(&x) {
                        let x = simd.splat_f32s(x[j]);
                        for (sum, a) in sums.iter_mut().zip(column) {
                            *sum = simd.mul_add_f32s(*a, x, *sum);
                        }
                    }
                }
                for (y, sums) in y.iter_mut().zip(&sums) {
                    let y = S::as_mut_simd_f32s(&mut y[p * PANEL..(p + 1) * PANEL]).0;
                    y[first..][..REGISTERS].copy_from_slice(sums);
                }
            }
        }
        for y in &mut y {
            y.truncate(size);
        }
        y
    }
}

/// J, harmonic by harmonic: I + H ∂F/∂r, H = L D Lᴴ.
fn jacobian(free: &FreeBalance<'_>, contact: &ContactResponse, motion: &FreeMotion) -> Mat<f64> {
    let (n, size) = (
        free.balance.layout.n_relative(),
        free.balance.layout.n_unknowns(),
    );
    let rate = contact_derivative(free, contact);
    let mut jacobian = Mat::<f64>::identity(size, size);
    let mut add = |row: usize, factor: f64, left: &Mat<f64>, right: MatRef<'_, f64>| {
        let to = jacobian.as_mut().subrows_mut(row, n);
        matmul(to, Accum::Add, left.as_ref(), right, factor, Par::Seq);
    };
    let mut at_rest = rate.subrows(0, n).to_owned();
    for (i, k) in free.reference.stiffness.iter().enumerate() {
        at_rest[(i, i)] -= k;
    }
    add(0, 1.0, &free.reference.compliance, at_rest.as_ref());
    for (part, of_part) in free.groups() {
        let part = &free.balance.problem.model.parts[*part];
        for &i in of_part {
            let [real, imaginary] = compliance(part, &motion.receptance[i]);
            let [c, s] = [(2 * i + 1) * n, (2 * i + 2) * n];
            let [cosine, sine] = [c, s].map(|row| rate.subrows(row, n));
            // (re + i im) (x_c − i x_s)
            add(c, 1.0, &real, cosine);
            add(c, 1.0, &imaginary, sine);
            add(s, 1.0, &real, sine);
            add(s, -1.0, &imaginary, cosine);
        }
    }
    jacobian
}

/// Real and imaginary part of L D Lᴴ.
fn compliance(part: &ModalPart, receptance: &[c64]) -> [Mat<f64>; 2] {
    let (n, images) = (part.contact.nrows(), part.multiplicity);
    if part.is_real() {
        let shapes = &part.contact.real;
        let of = |value: fn(&c64) -> f64| {
            let scaled = Mat::from_fn(n, receptance.len(), |a, j| {
                shapes[(a, j)] * value(&receptance[j]) * images
            });
            scaled * shapes.transpose()
        };
        return [of(|d| d.re), of(|d| d.im)];
    }
    let shapes = part.contact.complex();
    let scaled = Mat::from_fn(n, receptance.len(), |a, j| {
        shapes[(a, j)] * receptance[j] * images
    });
    let SplitMat { real, imaginary } = (scaled * shapes.adjoint()).into();
    [real, imaginary.unwrap_or_else(|| Mat::zeros(n, n))]
}

/// ∂F/∂r.
fn contact_derivative(free: &FreeBalance<'_>, contact: &ContactResponse) -> Mat<f64> {
    let layout = free.balance.layout;
    let (n_c, n, m) = (layout.n_pairs, layout.n_relative(), layout.n_coefficients);
    let springs = &free.balance.problem.stuck_stiffness;
    let mut rate = Mat::zeros(n * m, n * m);
    for i in 0..n * m {
        rate[(i, i)] = springs[i % n];
    }
    for tangent in &contact.active {
        for (row, column, block) in &tangent.blocks {
            let [row, column] = [row, column].map(|component| component * n_c + tangent.pair);
            for (a, entries) in block.chunks_exact(m).enumerate() {
                for (b, entry) in entries.iter().enumerate() {
                    rate[(a * n + row, b * n + column)] += entry;
                }
            }
        }
    }
    rate
}
